//! Reads text and overrides into a valid [`Case`], or into an error with its place in the text.

use std::ops::Range;

use toml_edit::{Document, DocumentMut, Item, Key, Table, TableLike, Value};

use super::hint::{self, Missing};
use super::{Case, CaseError, Decimal, scene};

impl Case {
    /// Reads a case from TOML `text` after applying `overrides` of the form `dotted.key=value`.
    ///
    /// The value of an override is a TOML value; a word that is not one is taken as a string. With overrides, errors
    /// refer to the text as the overrides have changed it.
    ///
    /// # Errors
    /// [`CaseError`] for anything that is not a complete, valid case: syntax, an unknown or missing key, a wrong type,
    /// a number that is not finite or out of range, a formula that does not parse, a start outside the domain.
    pub fn parse(source_name: &str, text: &str, overrides: &[String]) -> Result<Self, CaseError> {
        Self::from_source(&Source::new(source_name, text, overrides)?)
    }

    /// Reads a case from its text.
    pub(super) fn from_source(source: &Source) -> Result<Self, CaseError> {
        source.check_structure()?;
        let read = toml::from_str(&source.text);
        if read.as_ref().is_ok() || read.as_ref().is_err_and(|error| error.message().starts_with("missing field")) {
            source.check_presence()?;
        }
        let mut case: Case = read.map_err(|error| {
            let message = readable(error.message());
            let help = hint::for_unknown(&message);
            source.error(error.span(), message, help)
        })?;
        source.restore_digits(case.numbers_mut());
        case.validated().map_err(|invalid| {
            let span = source.locate(&invalid.path, invalid.within.clone());
            source.error(span, invalid.message, invalid.help)
        })
    }
}

const POTENTIALS: &str = "give exactly one of free = {}, linear = { alpha }, quartic = { kappa }, \
                          polynomial = { coefficients }, formula = \"expression\" or { expression, parameters }";

/// The message of serde with the names of TOML's types, which a user knows, in place of Rust's.
pub(super) fn readable(message: &str) -> String {
    let rust_to_toml = [
        ("expected f64", "expected a number"),
        ("expected usize", "expected a whole number, 0 or more"),
        ("expected u32", "expected a whole number, 0 or more"),
    ];
    rust_to_toml.iter().fold(message.trim_end().to_owned(), |message, (rust, toml)| message.replace(rust, toml))
}

/// The text of a case and its name, to which errors refer.
pub(super) struct Source {
    name: String,
    pub(super) text: String,
}

impl Source {
    /// The text as the overrides change it.
    pub(super) fn new(name: &str, text: &str, overrides: &[String]) -> Result<Self, CaseError> {
        let plain = Self { name: name.to_owned(), text: text.to_owned() };
        if overrides.is_empty() { Ok(plain) } else { plain.with_overrides(overrides) }
    }

    /// The keys and values of the text with their places.
    pub(super) fn document(&self) -> Result<Document<&str>, CaseError> {
        Document::parse(self.text.as_str()).map_err(|error| self.error(error.span(), readable(error.message()), None))
    }

    pub(super) fn error(&self, span: Option<Range<usize>>, message: String, help: Option<String>) -> CaseError {
        CaseError { source_name: self.name.clone(), text: self.text.clone(), span, message, help }
    }

    fn with_overrides(self, overrides: &[String]) -> Result<Self, CaseError> {
        let mut document: DocumentMut = self
            .text
            .parse()
            .map_err(|error: toml_edit::TomlError| self.error(error.span(), readable(error.message()), None))?;
        let given: Vec<String> = overrides.iter().filter_map(|setting| dotted(setting)).collect();
        given.iter().filter_map(|key| other_rate(key)).filter(|other| !given.contains(other)).for_each(|other| {
            if scene::is_scene_table(document.as_table()) {
                remove(document.as_table_mut(), &other);
            }
        });
        for (one, others) in EXCLUSIVE {
            if given.iter().any(|key| key == one) {
                let free = |other: &&&str| !given.iter().any(|key| is_within(key, other));
                others.iter().filter(free).for_each(|other| remove(document.as_table_mut(), other));
            }
        }
        for setting in overrides {
            set(document.as_table_mut(), setting)
                .map_err(|message| self.error(None, format!("--set {setting}: {message}"), None))?;
        }
        let name = format!("{} with --set {}", self.name, overrides.join(" --set "));
        Ok(Self { name, text: document.to_string() })
    }

    /// The place of the value of a dotted key, or of the nearest table around it if the key itself is missing. `within`
    /// narrows the place to a part of a string value, if that is written without escapes.
    pub(super) fn locate(&self, path: &str, within: Option<Range<usize>>) -> Option<Range<usize>> {
        let document = Document::parse(self.text.as_str()).ok()?;
        let (span, string) = find(document.as_item(), path);
        let (Some(span), Some(within), Some(string)) = (span.clone(), within, string) else { return span };
        match self.text[span.clone()].find(string) {
            Some(offset) => Some(span.start + offset + within.start..span.start + offset + within.end),
            None => Some(span),
        }
    }

    /// Restores the digits that the deserialiser rounded away.
    fn restore_digits(&self, numbers: Vec<(String, &mut Decimal)>) {
        let Ok(document) = Document::parse(self.text.as_str()) else { return };
        for (path, number) in numbers {
            if let (Some(span), _) = find(document.as_item(), &path) {
                number.set_literal(&self.text[span]);
            }
        }
    }

    /// Refuses what the deserialiser would accept, or explain badly: tables written as arrays, and none or several
    /// potentials.
    fn check_structure(&self) -> Result<(), CaseError> {
        let document = self.document()?;
        let root = document.as_table();
        for key in ["potential", "particle", "initial", "grid", "scheme", "solver", "expect"] {
            if let Some(item) = root.get(key).filter(|item| !item.is_table_like()) {
                return Err(self.error(
                    item.span(),
                    format!("'{key}' must be a table, found {}", item.type_name()),
                    None,
                ));
            }
        }
        for (table, key) in [("solver", "system"), ("expect", "status")] {
            let item = root.get(table).and_then(Item::as_table_like).and_then(|table| table.get(key));
            if let Some(item) = item.filter(|item| !item.is_str()) {
                let message = format!("'{table}.{key}' must be a string, found {}", item.type_name());
                return Err(self.error(item.span(), message, None));
            }
        }
        root.get("potential").map_or(Ok(()), |potential| self.check_potential(potential))
    }

    /// Refuses a case that lacks required keys, and names all of them at once.
    fn check_presence(&self) -> Result<(), CaseError> {
        let Ok(document) = Document::parse(self.text.as_str()) else { return Ok(()) };
        let Some(missing) = Missing::in_case(document.as_table()) else { return Ok(()) };
        let span = missing.item.map_or(Some(0..0), Item::span);
        Err(self.error(span, missing.message(), missing.help(POTENTIALS)))
    }

    fn check_potential(&self, potential: &Item) -> Result<(), CaseError> {
        let kinds: Vec<(&str, &Item)> = potential.as_table_like().into_iter().flat_map(|table| table.iter()).collect();
        let one = || Some(POTENTIALS.to_owned());
        match kinds.as_slice() {
            [(_, item)] if item.is_table_like() => Ok(()),
            [("formula", item)] if item.is_str() => Ok(()),
            [(kind, item)] => {
                let message = format!("'potential.{kind}' must be a table, found {}", item.type_name());
                Err(self.error(item.span(), message, one()))
            }
            [] => Err(self.error(potential.span(), "no potential is given".to_owned(), one())),
            [.., ("parameters", item)] | [("parameters", item), ..] => {
                let message = "'potential.parameters' is not a potential".to_owned();
                let help = "parameters belong to their formula: potential.formula.parameters".to_owned();
                Err(self.error(item.span(), message, Some(help)))
            }
            [(first, _), (second, item), ..] => {
                let message = format!("more than one potential is given: {first} and {second}");
                Err(self.error(item.span(), message, one()))
            }
        }
    }
}

/// The place of the value of a dotted key, or of the nearest table or array around it if it is missing; and the value
/// if it is a string.
fn find<'i>(root: &'i Item, path: &str) -> (Option<Range<usize>>, Option<&'i str>) {
    let mut span = None;
    let mut item = root;
    for key in path.split('.') {
        if let Some(inner) = item.as_table_like().and_then(|table| table.get(key)) {
            item = inner;
            span = item.span().or(span);
        } else {
            // A formula without parameters may be written as a string, which is its expression.
            if item.is_str() {
                break;
            }
            let element = item.as_array().zip(key.parse().ok()).and_then(|(array, k): (_, usize)| array.get(k));
            return (element.and_then(Value::span).or(span), element.and_then(Value::as_str));
        }
    }
    (span, item.as_str())
}

/// `text`, which is a valid case, with its numbers as they were written and without the keys in `removed`.
pub(super) fn with_literals(text: &str, numbers: &[(String, &mut Decimal)], removed: &[&str]) -> String {
    let mut document: DocumentMut = text.parse().expect("a written case can be read");
    removed.iter().for_each(|path| remove(document.as_table_mut(), path));
    for (path, number) in numbers {
        let literal: Value = number.literal().parse().expect("a decimal is a TOML value");
        let mut item = document.as_item_mut();
        for key in path.split('.') {
            item = match key.parse::<usize>() {
                Ok(place) => &mut item[place],
                Err(_) => &mut item[key],
            };
        }
        *item = Item::Value(literal);
    }
    document.to_string()
}

/// An override of the first key removes the other keys, which it replaces, unless they are overridden too.
const EXCLUSIVE: [(&str, &[&str]); 11] = [
    ("grid.t_f", &["grid.gamma_f"]),
    ("grid.gamma_f", &["grid.t_f"]),
    ("initial.velocity", &["initial.x_dot"]),
    ("initial.x_dot", &["initial.velocity"]),
    ("solver.accuracy", &["solver.tolerance", "grid.n_gamma", "grid.windows", "scheme"]),
    ("solver.tolerance", &["solver.accuracy", "grid.n_gamma", "grid.windows", "scheme"]),
    ("grid.n_gamma", &["solver.accuracy", "solver.tolerance"]),
    ("grid.windows", &["solver.accuracy", "solver.tolerance"]),
    ("metric.preset", &["metric.coordinates", "metric.components"]),
    ("metric.coordinates", &["metric.preset"]),
    ("metric.components", &["metric.preset"]),
];

/// In a scene, the momentum in whose place a velocity is given, or the other way round.
fn other_rate(key: &str) -> Option<String> {
    let key = key.strip_prefix("initial.")?;
    let velocity = || Some(format!("initial.p_{}", key.strip_suffix("_dot")?));
    key.strip_prefix("p_").map(|name| format!("initial.{name}_dot")).or_else(velocity)
}

/// Whether the values of a dotted key are formulas, so that what is no TOML value needs no quotes.
fn is_formula(key: &str) -> bool {
    let tables = ["metric.", "invariants.", "potential.one_form.", "potential.force.", "potential.parameters."];
    ["potential.formula", "potential.formula.expression", "grid.until"].contains(&key)
        || tables.iter().any(|table| key.starts_with(table))
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
    let keys = Key::parse(setting.split_once('=')?.0.trim()).ok()?;
    Some(keys.iter().map(Key::get).collect::<Vec<_>>().join("."))
}

/// Whether `key` is `path`, lies inside it, or contains it.
fn is_within(key: &str, path: &str) -> bool {
    let below = |long: &str, short: &str| long.strip_prefix(short).is_some_and(|rest| rest.starts_with('.'));
    key == path || below(key, path) || below(path, key)
}

/// Removes a dotted key.
fn remove(root: &mut Table, path: &str) {
    let (tables, last) = path.rsplit_once('.').unwrap_or(("", path));
    let mut table: &mut dyn TableLike = root;
    for key in tables.split('.').filter(|key| !key.is_empty()) {
        let Some(inner) = table.get_mut(key).and_then(Item::as_table_like_mut) else { return };
        table = inner;
    }
    table.remove(last);
}

/// Applies one `dotted.key=value`.
fn set(root: &mut Table, setting: &str) -> Result<(), String> {
    let (key, value) = setting.split_once('=').ok_or("expected KEY=VALUE, for example grid.n_gamma=64")?;
    let keys = Key::parse(key.trim()).map_err(|_| format!("'{}' is not a dotted key", key.trim()))?;
    let value = value.trim();
    if value.is_empty() {
        return Err("the value is missing".to_owned());
    }
    // What cannot be another kind of value needs no quotes: a word, and a formula.
    let is_quoted = value.starts_with(['"', '\'', '[', '{']);
    let bare_word = value.starts_with(|c: char| c.is_ascii_alphabetic()) || (is_formula(key.trim()) && !is_quoted);
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
