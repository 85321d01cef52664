//! A case with every default filled in.

use std::path::Path;

use toml_edit::{Array, DocumentMut, InlineTable, Item, Value, value};

use super::keys::PARAMETERS;
use super::tables::absolute;
use super::{Case, Goal, Key, Rate, keys, parameters};
use crate::geometry::Law;

impl Case {
    /// The case as it was written, with its overrides and with every default filled in. Reading that text gives the
    /// same case.
    pub fn to_toml(&self) -> String {
        let mut document = document(&self.text);
        parameters::gather(document.as_table_mut(), false);
        let root = document.as_item_mut();
        let text = &self.geometry_text;
        if self.preset.is_some() {
            fill_formulas(root, &["metric", "definitions"], &text.definitions);
            fill_formulas(root, &[PARAMETERS], &text.parameters);
        }
        if let Some(law) = text.law().filter(|_| self.bodies.is_empty()) {
            let is_relativistic = law == Law::Relativistic;
            if !has(table(root, "particle"), "masses") {
                fill_defaults(root, ["particle.mass"]);
            }
            if is_relativistic {
                fill_defaults(root, ["particle.c"]);
            }
            if is_relativistic && !self.is_of_x {
                fill_defaults(root, ["particle.law"]);
            }
        }
        for (name, _) in &text.tables {
            // A path that is counted from the folder of the case would lead elsewhere from another folder.
            let entry = table(table(root, "tables"), name);
            if let Some(file) = entry.get("file").and_then(Item::as_str).map(|file| absolute(&self.folder, file)) {
                entry["file"] = value(file.display().to_string());
            }
        }
        self.fill_find(root);
        let chooses_windows = self.settings.accuracy.is_some();
        if let Some(summary) = &self.continues {
            // All that it begins with stands there.
            table(root, "initial")["from"] = value(absolute(Path::new(""), summary).display().to_string());
        } else {
            self.fill_initial(table(root, "initial"));
            fill(root, &["grid", "gamma_i"], formula(&self.grid.gamma_i));
        }
        if let Some(gamma_f) = &self.grid.gamma_f {
            fill(root, &["grid", "gamma_f"], formula(gamma_f));
        }
        if !chooses_windows {
            fill(root, &["grid", "n_gamma"], self.settings.n_gamma as i64);
            fill_defaults(root, ["grid.windows", "scheme.form", "scheme.regularised"]);
        }
        fill_defaults(root, ["solver.system", "solver.digits", "solver.max_iterations"]);
        if chooses_windows {
            fill_defaults(root, ["solver.sensitivity"]);
        }
        fill_defaults(root, ["solver.error"]);
        for event in &self.events {
            fill_defaults(root, ["direction", "until"].map(|key| format!("events.{}.{key}", event.name)));
        }
        if self.expect.is_some() {
            fill_defaults(root, ["expect.status"]);
        }
        document.to_string()
    }

    /// Writes paths and names of parameters in `[find]` so that they mean the same in the effective case.
    fn fill_find(&self, root: &mut Item) {
        if let Some(find) = self.find.as_ref().filter(|_| !self.former.is_empty()) {
            let keys: Array = find.unknowns.iter().map(|unknown| unknown.key.as_str()).collect();
            table(root, "find")["unknowns"] = value(keys);
        }
        if self.find.as_ref().is_some_and(|find| matches!(find.goal, Goal::Data(_))) {
            let data = table(table(root, "find"), "data");
            if let Some(file) = data.get("file").and_then(Item::as_str).map(|file| absolute(&self.folder, file)) {
                data["file"] = value(file.display().to_string());
            }
        }
    }

    /// The same without its `[expect]` table.
    pub fn without_expectations(&self) -> Self {
        let mut document = document(&self.text);
        document.remove("expect");
        Self { expect: None, text: document.to_string(), ..self.clone() }
    }

    fn fill_initial(&self, initial: &mut Item) {
        let mut names = self.coordinates();
        if !self.bodies.is_empty() {
            // All but the time stands in the tables of the bodies.
            names.truncate(1);
        }
        for (name, q) in names.iter().zip(&self.initial.q) {
            fill(initial, &[name], formula(q));
        }
        for (name, rate) in names.iter().zip(&self.initial.rates).filter(|_| self.bodies.is_empty()) {
            let is_velocity = name != "t" && has(initial, "velocity");
            match rate {
                Rate::Velocity(value) if !is_velocity => fill(initial, &[&format!("{name}_dot")], formula(value)),
                Rate::Momentum(value) => fill(initial, &[&format!("p_{name}")], formula(value)),
                // This rate follows from K, from `velocity`, or from the table of a body, and has no key of its own.
                _ => {}
            }
        }
    }
}

fn document(text: &str) -> DocumentMut {
    text.parse().expect("a case that was read can be read again")
}

/// The table of that key, an empty one if there was none.
fn table<'t>(within: &'t mut Item, key: &str) -> &'t mut Item {
    within.as_table_like_mut().expect("a valid case has a table there").entry(key).or_insert_with(toml_edit::table)
}

fn has(table: &Item, key: &str) -> bool {
    table.as_table_like().is_some_and(|table| table.contains_key(key))
}

/// Gives a key, which is a path of keys, its default if it has no value.
fn fill(root: &mut Item, path: &[&str], default: impl Into<Value>) {
    let (last, tables) = path.split_last().expect("a path has a last key");
    let within = tables.iter().fold(root, |within, key| table(within, key));
    if has(within, last) {
        return;
    }
    within.as_table_like_mut().expect("a valid case has a table there").insert(last, value(default));
    if let Some(inline) = within.as_inline_table_mut() {
        inline.fmt();
    }
}

/// Gives these keys what holds without them.
fn fill_defaults<const N: usize>(root: &mut Item, keys: [impl AsRef<str>; N]) {
    for dotted in keys.each_ref().map(AsRef::as_ref) {
        let default = keys::of(dotted).and_then(Key::written_default).and_then(|text| text.parse::<Value>().ok());
        let path: Vec<&str> = dotted.split('.').collect();
        fill(root, &path, default.expect("what may be left out has a default"));
    }
}

/// Gives the table at a path those of these formulas that it lacks.
fn fill_formulas(root: &mut Item, path: &[&str], formulas: &[(String, String)]) {
    if let ([.., last], false) = (path, formulas.is_empty()) {
        let around = path[..path.len() - 1].iter().fold(&mut *root, |within, key| table(within, key));
        let around = around.as_table_like_mut().expect("a valid case has a table there");
        around.entry(last).or_insert_with(|| value(InlineTable::new()));
    }
    formulas.iter().for_each(|(name, text)| fill(root, &[path, &[name]].concat(), formula(text)));
}

/// A number as it is written, or a formula as a string.
fn formula(text: &str) -> Value {
    let is_decimal = text.starts_with(|c: char| c.is_ascii_digit() || c == '-');
    let number = text.parse::<Value>().ok().filter(|_| is_decimal && !text.contains(['_', 'x', 'o', 'b', ' ']));
    let number = number.filter(|value| value.is_integer() || value.as_float().is_some_and(f64::is_finite));
    number.unwrap_or_else(|| Value::from(text))
}
