//! The text of a case with its overrides, and the places of mistakes in it.

use std::borrow::Cow;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use toml_edit::{Document, DocumentMut, Item, Table, TableLike, TomlError, Value};

use super::CaseError;
use super::dotted::{found, remove};
use super::keys::{self, EXCLUSIVE, KEYS, Key};
use super::parameters;
use crate::geometry::uses;

/// The text of a case and its name, to which errors refer.
pub(super) struct Source {
    name: String,
    pub(super) text: String,
    /// The folder of the case; empty if it is no file.
    pub(super) folder: PathBuf,
    /// True if it is a potential of x alone, as the paper has it.
    pub(super) is_of_x: bool,
    /// The former tables of parameters in it and in the overrides.
    pub(super) former: Vec<&'static str>,
}

/// The value that a case has without a key, for every key that has a default.
pub(super) static DEFAULTS: LazyLock<Source> = LazyLock::new(|| {
    let line = |key: &Key| Some(format!("{} = {}\n", key.name, key.written_default()?));
    let text = KEYS.iter().filter_map(line).collect();
    Source { name: "defaults".to_owned(), text, folder: PathBuf::new(), is_of_x: false, former: Vec::new() }
});

impl Source {
    /// The text as the overrides change it.
    pub(super) fn new(name: &str, text: &str, overrides: &[String]) -> Result<Self, CaseError> {
        let folder = Path::new(name).parent().filter(|folder| folder.is_dir()).unwrap_or(Path::new("")).to_owned();
        let (name, text) = (name.to_owned(), text.to_owned());
        let plain = Self { name, text, folder, is_of_x: false, former: Vec::new() };
        if !overrides.is_empty() {
            return plain.with_overrides(overrides);
        }
        let document = plain.document()?;
        let (is_of_x, former) = (is_of_x(document.as_table()), parameters::former(document.as_table()));
        drop(document);
        Ok(Self { is_of_x, former, ..plain })
    }

    /// The keys and values of the text with their places.
    pub(super) fn document(&self) -> Result<Document<&str>, CaseError> {
        Document::parse(self.text.as_str()).map_err(|error| self.syntax(&error))
    }

    pub(super) fn error(&self, span: Option<Range<usize>>, message: String, help: Option<String>) -> CaseError {
        let (source_name, text) = (self.name.as_str().into(), self.text.as_str().into());
        CaseError { source_name, text, span, message, help, further: Box::default() }
    }

    fn syntax(&self, error: &TomlError) -> CaseError {
        self.error(error.span(), error.message().trim_end().to_owned(), None)
    }

    fn with_overrides(self, overrides: &[String]) -> Result<Self, CaseError> {
        let mut document: DocumentMut = self.text.parse().map_err(|error| self.syntax(&error))?;
        let mut former = parameters::gather(document.as_table_mut(), false);
        let given: Vec<String> = overrides.iter().filter_map(|setting| dotted(setting)).collect();
        let pairs = EXCLUSIVE.iter().filter(|pair| pair.one.contains('.') && pair.other.contains('.'));
        let pairs = pairs.flat_map(|pair| [(pair.one, pair.other), (pair.other, pair.one)]);
        let pairs = pairs.chain([("solver.accuracy", "scheme"), ("solver.tolerance", "scheme")]);
        let replaced = pairs.filter(|(one, _)| given.iter().any(|key| key == one)).map(|(_, other)| other.to_owned());
        let rates = given.iter().flat_map(|key| other_rates(document.as_table(), key)).collect::<Vec<_>>();
        let solved = overrides.iter().flat_map(|setting| solved_rates(setting));
        for other in replaced.chain(rates).chain(solved) {
            if !given.iter().any(|key| is_within(key, &other)) {
                remove(document.as_table_mut(), &other);
            }
        }
        if given.iter().any(|key| key == "initial.from") {
            remove(document.as_table_mut(), "initial");
        }
        for setting in overrides {
            let (place, now) = renamed(setting);
            set(document.as_table_mut(), &now)
                .map_err(|message| self.error(None, format!("--set {setting}: {message}"), None))?;
            former.extend(place.into_iter().chain(parameters::gather(document.as_table_mut(), true)));
        }
        let name = format!("{} with --set {}", self.name, overrides.join(" --set "));
        former.extend(parameters::former(document.as_table()));
        former.dedup();
        Ok(Self { name, text: document.to_string(), is_of_x: is_of_x(document.as_table()), former, ..self })
    }
}

/// Returns true if the motion is that of the paper's particle. What looks at it, or ends it, is another matter.
fn is_of_x(root: &Table) -> bool {
    let table = |name: &str| root.get(name).and_then(Item::as_table_like);
    let has = |path: &str| match path.split_once('.') {
        Some((name, key)) => table(name).is_some_and(|table| table.contains_key(key)),
        None => root.contains_key(path),
    };
    !(keys::OF_SCENES.iter().any(|path| has(path)) || table("potential").is_some_and(is_of_time))
}

/// Returns true if V is a formula with t in it.
fn is_of_time(potential: &dyn TableLike) -> bool {
    let formula = potential.get("formula");
    let inner = formula.and_then(Item::as_table_like).and_then(|table| table.get("expression"));
    inner.or(formula).and_then(Item::as_str).is_some_and(|text| uses(text, "t"))
}

/// The rates of `[initial]` in whose place that of a key is given.
fn other_rates(root: &Table, key: &str) -> Vec<String> {
    let coordinate = |key: &str| key.strip_prefix("p_").or(key.strip_suffix("_dot")).map(str::to_owned);
    let Some(key) = key.strip_prefix("initial.") else { return Vec::new() };
    let is_added = |name: &str| ["t", "s"].contains(&name);
    let rates: Vec<String> = match coordinate(key) {
        // A rate that followed from K is given now.
        Some(name) if found(root, &format!("initial.solve.{name}_dot")).is_some() => {
            vec!["solve".to_owned(), "norm".to_owned()]
        }
        Some(name) if is_added(&name) => vec![format!("p_{name}"), format!("{name}_dot")],
        Some(name) => vec![format!("p_{name}"), format!("{name}_dot"), "velocity".to_owned()],
        None if key == "velocity" => {
            let initial = root.get("initial").and_then(Item::as_table_like);
            let keys = initial.into_iter().flat_map(|table| table.iter()).map(|(key, _)| key.to_owned());
            keys.filter(|key| coordinate(key).is_some_and(|name| !is_added(&name))).collect()
        }
        None => Vec::new(),
    };
    rates.into_iter().filter(|rate| rate != key).map(|rate| format!("initial.{rate}")).collect()
}

/// The rates that an override lets follow from K.
fn solved_rates(setting: &str) -> Vec<String> {
    let Some((key, value)) = setting.split_once('=') else { return Vec::new() };
    let names: Vec<String> = match key.trim().strip_prefix("initial.solve") {
        Some("") => {
            let table = value.trim().parse::<Value>().ok().and_then(|value| value.as_inline_table().cloned());
            table.iter().flat_map(|table| table.iter()).map(|(name, _)| name.to_owned()).collect()
        }
        Some(name) => name.strip_prefix('.').map(str::to_owned).into_iter().collect(),
        None => Vec::new(),
    };
    let rates = |name: &String| name.strip_suffix("_dot").map(|name| [format!("p_{name}"), format!("{name}_dot")]);
    names.iter().filter_map(rates).flatten().map(|rate| format!("initial.{rate}")).collect()
}

/// The text of a case as `overrides` change it, without what it expects if there are any: that holds for the case as it
/// is in its file.
///
/// # Errors
/// [`CaseError`] for an override that is none, or a text that is not TOML.
pub fn overridden(source_name: &str, text: &str, overrides: &[String]) -> Result<String, CaseError> {
    let source = Source::new(source_name, text, overrides)?;
    let Ok(mut document) = source.text.parse::<DocumentMut>() else { return Ok(source.text) };
    if overrides.is_empty() {
        return Ok(source.text);
    }
    document.remove("expect");
    Ok(document.to_string())
}

/// The key of an override `KEY=VALUE`, its parts without quotes and joined by dots; `None` if it has none.
pub fn key_of(setting: &str) -> Option<String> {
    dotted(setting).filter(|key| !key.is_empty())
}

/// The key of an override, its parts without quotes and joined by dots.
fn dotted(setting: &str) -> Option<String> {
    let keys = toml_edit::Key::parse(setting.split_once('=')?.0.trim()).ok()?;
    Some(keys.iter().map(toml_edit::Key::get).collect::<Vec<_>>().join("."))
}

/// Returns true if `key` is `path`, lies inside it, or contains it.
fn is_within(key: &str, path: &str) -> bool {
    let below = |long: &str, short: &str| long.strip_prefix(short).is_some_and(|rest| rest.starts_with('.'));
    key == path || below(key, path) || below(path, key)
}

/// An override as it is written today, and the former table that its key lies in.
fn renamed(setting: &str) -> (Option<&'static str>, Cow<'_, str>) {
    let value = setting.split_once('=').map_or("", |(_, value)| value);
    match dotted(setting).as_deref().and_then(keys::replaced) {
        Some((place, now)) => (Some(place), format!("{now}={value}").into()),
        None => (None, setting.into()),
    }
}

/// Applies one `dotted.key=value`.
fn set(root: &mut Table, setting: &str) -> Result<(), String> {
    let (key, value) = setting.split_once('=').ok_or("expected KEY=VALUE, for example grid.n_gamma=64")?;
    let keys = toml_edit::Key::parse(key.trim()).map_err(|_| format!("'{}' is not a dotted key", key.trim()))?;
    let value = value.trim();
    if value.is_empty() {
        return Err("the value is missing".to_owned());
    }
    // A word, and a formula, need no quotes where they cannot be another kind of value.
    let is_quoted = value.starts_with(['"', '\'', '[', '{']);
    let may_be_formula = || dotted(setting).and_then(|key| keys::of(&key)).is_some_and(|key| key.kind.has_names());
    let is_sign = ["+", "-"].contains(&value);
    let bare_word = is_sign || value.starts_with(|c: char| c.is_ascii_alphabetic()) || (!is_quoted && may_be_formula());
    let value: Value = match value.parse() {
        Ok(value) => value,
        Err(_) if bare_word => Value::from(value),
        Err(_) => return Err(format!("'{value}' is not a TOML value (a string needs quotes)")),
    };
    let (last, tables) = keys.split_last().ok_or("the key is missing")?;
    let mut table: &mut dyn TableLike = root;
    for key in tables {
        table = table
            .entry(key.get())
            .or_insert_with(|| Item::Table(Table::new()))
            .as_table_like_mut()
            .ok_or_else(|| format!("'{}' is not a table", key.get()))?;
    }
    table.insert(last.get(), Item::Value(value));
    Ok(())
}

/// Returns true if a formula in the text of a valid case mentions a name.
pub(super) fn is_used(text: &str, name: &str) -> bool {
    let document = Document::parse(text);
    document.is_ok_and(|document| is_mentioned(name, "", document.as_item()))
}

/// Returns true if the equations of motion may depend on a parameter: if a formula mentions it that is not one of the
/// start, of the end, or of what is only looked at.
pub(super) fn is_in_equations(text: &str, name: &str) -> bool {
    let Ok(mut document) = text.parse::<DocumentMut>() else { return true };
    for table in ["initial", "grid", "find", "invariants", "plot", "expect"] {
        document.remove(table);
    }
    if let Some(bodies) = document.get_mut("body").and_then(Item::as_array_of_tables_mut) {
        for body in bodies.iter_mut() {
            body.remove("position");
            body.remove("velocity");
        }
    }
    is_used(&document.to_string(), name)
}

/// Returns true if a formula in the item of that dotted key mentions a name.
fn is_mentioned(name: &str, path: &str, item: &Item) -> bool {
    let dotted = |key: &str| if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") };
    let within = |table: &dyn TableLike| table.iter().any(|(key, item)| is_mentioned(name, &dotted(key), item));
    match item {
        Item::ArrayOfTables(tables) => tables.iter().any(|table| within(table)),
        Item::Value(Value::Array(array)) => {
            array.iter().any(|value| is_mentioned(name, path, &Item::Value(value.clone())))
        }
        Item::Value(Value::String(text)) => {
            keys::of(path).is_some_and(|key| key.kind.has_names()) && uses(text.value(), name)
        }
        _ => item.as_table_like().is_some_and(within),
    }
}
