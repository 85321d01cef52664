//! A case with every default filled in.

use toml_edit::{DocumentMut, InlineTable, Item, Value, value};

use super::{Case, Rate};
use crate::geometry::{GeometryText, Law};

impl Case {
    /// The case as it was written, with its overrides and with every default filled in. Reading that text gives the
    /// same case.
    pub fn to_toml(&self) -> String {
        let mut document = document(&self.text);
        let root = document.as_item_mut();
        match &self.geometry_text {
            GeometryText::Metric(metric) if self.preset.is_some() => {
                let table = table(root, "metric");
                fill_formulas(table, "definitions", &metric.definitions);
                fill_formulas(table, "parameters", &metric.parameters);
            }
            GeometryText::Metric(_) => {}
            GeometryText::Potential(_) if !self.bodies.is_empty() => {}
            GeometryText::Potential(potential) => {
                let is_relativistic = potential.law == Law::Relativistic;
                let particle = table(root, "particle");
                if !has(particle, "masses") {
                    fill(particle, "mass", 1.0);
                }
                if is_relativistic {
                    fill(particle, "c", 1.0);
                }
                if is_relativistic && !self.is_of_x {
                    fill(particle, "law", "relativistic");
                }
            }
        }
        for (name, file) in &self.tables {
            let entry = table(table(root, "tables"), name);
            // A path that is counted from the folder of the case would lead elsewhere from another folder.
            entry["file"] = value(file.display().to_string());
        }
        self.fill_initial(root);
        self.fill_grid(root);
        if self.settings.accuracy.is_none() {
            let scheme = table(root, "scheme");
            fill(scheme, "form", self.settings.form.as_str());
            fill(scheme, "regularised", true);
        }
        let solver = table(root, "solver");
        fill(solver, "system", "physical-limit");
        fill(solver, "digits", i64::from(self.settings.digits));
        fill(solver, "max_iterations", self.settings.max_iterations as i64);
        if self.settings.accuracy.is_some() {
            fill(solver, "sensitivity", false);
        }
        for event in &self.events {
            let events = table(root, "events");
            let entry = table(events, &event.name);
            fill(entry, "direction", event.direction.as_str());
            fill(entry, "until", event.until);
        }
        if self.expect.is_some() {
            fill(table(root, "expect"), "status", "converged");
        }
        document.to_string()
    }

    /// The same without its `[expect]` table.
    pub fn without_expectations(&self) -> Self {
        let mut document = document(&self.text);
        document.remove("expect");
        Self { expect: None, text: document.to_string(), ..self.clone() }
    }

    fn fill_initial(&self, root: &mut Item) {
        let initial = table(root, "initial");
        let mut names = self.coordinates();
        if !self.bodies.is_empty() {
            // All but the time stands in the tables of the bodies.
            names.truncate(1);
        }
        for (name, q) in names.iter().zip(&self.initial.q) {
            fill(initial, name, formula(q));
        }
        for (name, rate) in names.iter().zip(&self.initial.rates).filter(|_| self.bodies.is_empty()) {
            let is_velocity = name == "x" && has(initial, "velocity");
            match rate {
                Rate::Velocity(value) if !is_velocity => fill(initial, &format!("{name}_dot"), formula(value)),
                Rate::Momentum(value) => fill(initial, &format!("p_{name}"), formula(value)),
                // It follows from another one, or from what the case gives.
                _ => {}
            }
        }
    }

    fn fill_grid(&self, root: &mut Item) {
        let grid = table(root, "grid");
        fill(grid, "gamma_i", formula(&self.grid.gamma_i));
        if let (None, Some(gamma_f)) = (&self.grid.t_f, &self.grid.gamma_f) {
            fill(grid, "gamma_f", formula(gamma_f));
        }
        if self.settings.accuracy.is_none() {
            fill(grid, "n_gamma", self.settings.n_gamma as i64);
            fill(grid, "windows", self.settings.windows as i64);
        }
    }
}

fn document(text: &str) -> DocumentMut {
    text.parse().expect("a case that was read can be read again")
}

/// The table of that key, an empty one if there was none.
fn table<'t>(within: &'t mut Item, key: &str) -> &'t mut Item {
    table_or(within, key, toml_edit::table)
}

fn table_or<'t>(within: &'t mut Item, key: &str, empty: fn() -> Item) -> &'t mut Item {
    within.as_table_like_mut().expect("a valid case has a table there").entry(key).or_insert_with(empty)
}

fn has(table: &Item, key: &str) -> bool {
    table.as_table_like().is_some_and(|table| table.contains_key(key))
}

/// Gives a key its default if it has no value.
fn fill(table: &mut Item, key: &str, default: impl Into<Value>) {
    if has(table, key) {
        return;
    }
    table.as_table_like_mut().expect("a valid case has a table there").insert(key, value(default));
    if let Some(inline) = table.as_inline_table_mut() {
        inline.fmt();
    }
}

fn fill_formulas(within: &mut Item, key: &str, formulas: &[(String, String)]) {
    if formulas.is_empty() {
        return;
    }
    let table = table_or(within, key, || value(InlineTable::new()));
    formulas.iter().for_each(|(name, text)| fill(table, name, formula(text)));
}

/// A number as it is written, or a formula as a string.
fn formula(text: &str) -> Value {
    let is_decimal = text.starts_with(|c: char| c.is_ascii_digit() || c == '-');
    let number = text.parse::<Value>().ok().filter(|_| is_decimal && !text.contains(['_', 'x', 'o', 'b', ' ']));
    let number = number.filter(|value| value.is_integer() || value.as_float().is_some_and(f64::is_finite));
    number.unwrap_or_else(|| Value::from(text))
}
