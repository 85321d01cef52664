//! The JSON schema of a case, for editors. It is of draft 7, the newest one that taplo knows, and with it Even Better
//! TOML.
//!
//! What a schema cannot say, or only at length, it leaves to the program: whether names are those of coordinates, and
//! which keys a case needs because of others.

use serde_json::{Map, Value, json};

use super::keys::{self, EXCLUSIVE, Key, Kind, Words};
use super::observables::DIRECTIONS;
use super::potential::LAWS;
use super::reader::words_of;
use super::tables::{OUTSIDE, SPLINES};
use super::{Form, SbpName, System};
use crate::geometry::{Direction, PRESETS};
use crate::number::{Extended, Real};
use crate::solve::Status;

/// A name that can be written in a formula.
const NAME: &str = "^[A-Za-z_][A-Za-z0-9_]*$";

/// The schema, as JSON.
pub fn schema() -> String {
    let mut schema = Map::new();
    schema.insert("$schema".to_owned(), json!("http://json-schema.org/draft-07/schema#"));
    schema.insert("title".to_owned(), json!("A case of geodesic-ivp"));
    schema.insert("description".to_owned(), json!("A case of `geodesic-ivp`: a motion, its start, and where it ends."));
    schema.extend(table(""));
    schema.insert("dependencies".to_owned(), exclusions());
    serde_json::to_string_pretty(&schema).expect("a schema is JSON") + "\n"
}

/// Exclusions below the table or the key at the top that has them: there an editor finds the place of a mistake.
fn exclusions() -> Value {
    let kinds: Vec<String> = keys::potentials().map(|kind| format!("potential.{kind}")).collect();
    let of_kinds = kinds.iter().enumerate().flat_map(|(k, one)| kinds[..k].iter().map(move |other| (&**other, &**one)));
    let mut tables: Map<String, Value> = Map::new();
    for (one, other) in EXCLUSIVE.iter().map(|pair| (pair.one, pair.other)).chain(of_kinds) {
        let top = one.split('.').next().unwrap_or_default();
        let rules = &mut tables.entry(top).or_insert_with(|| json!({ "allOf": [] }))["allOf"];
        rules.as_array_mut().expect("it was made").push(json!({ "if": with(one), "then": without(other) }));
    }
    Value::Object(tables)
}

/// An object that has the key of that dotted name.
fn with(dotted: &str) -> Value {
    match dotted.split_once('.') {
        Some((table, key)) => json!({ "required": [table], "properties": { table: with(key) } }),
        None => json!({ "required": [dotted] }),
    }
}

/// An object without it.
fn without(dotted: &str) -> Value {
    let (first, rest) = dotted.split_once('.').map_or((dotted, None), |(first, rest)| (first, Some(rest)));
    json!({ "properties": { first: rest.map_or(json!(false), without) } })
}

/// The pattern of the names that a part of a dotted name stands for, if they have one.
fn pattern(part: &str) -> Option<&'static str> {
    match part {
        "q_dot" => Some("_dot$"),
        "p_q" => Some("^p_"),
        "q_final" => Some("_final$"),
        "sigma_q" => Some("^sigma_"),
        "NAME" => Some(NAME),
        _ => None,
    }
}

/// A table: the keys below that dotted name.
fn table(path: &str) -> Map<String, Value> {
    let (mut named, mut open, mut other, mut required) = (Map::new(), Map::new(), json!(false), Vec::new());
    for &name in keys::below(path) {
        let dotted = if path.is_empty() { name.to_owned() } else { format!("{path}.{name}") };
        let below = below(&dotted);
        match pattern(name) {
            Some(pattern) => drop(open.insert(pattern.to_owned(), below)),
            // A pattern would be one for the names beside it, too.
            None if name == "q" => other = below,
            None => drop(named.insert(name.to_owned(), below)),
        }
        if keys::named(&dotted).is_some_and(|key| key.default == keys::REQUIRED) {
            required.push(json!(name));
        }
    }
    let mut table = Map::new();
    table.insert("type".to_owned(), json!("object"));
    for (word, keys) in [("properties", named), ("patternProperties", open)] {
        if !keys.is_empty() {
            table.insert(word.to_owned(), json!(keys));
        }
    }
    table.insert("additionalProperties".to_owned(), other);
    if !required.is_empty() {
        table.insert("required".to_owned(), json!(required));
    }
    table
}

/// The schema below a dotted name, with its meaning and its default.
fn below(dotted: &str) -> Value {
    let key = keys::named(dotted);
    let kind = key.map_or(Kind::Table, |key| key.kind);
    let is_table = !keys::below(dotted).is_empty();
    let mut schema = match kind {
        Kind::Table if dotted == "body" => value_map(json!({ "type": "array", "items": table(dotted) })),
        Kind::Table => table(dotted),
        _ if is_table => value_map(json!({ "anyOf": [leaf(kind), table(dotted)] })),
        _ => value_map(leaf(kind)),
    };
    if let Some(key) = key {
        schema.insert("description".to_owned(), json!(key.meaning));
        // What is written for a number, a word or a truth value is the same in TOML and in JSON.
        if let Some(default) = key.written_default().and_then(|text| serde_json::from_str::<Value>(text).ok()) {
            schema.insert("default".to_owned(), default);
        }
    }
    Value::Object(schema)
}

fn value_map(value: Value) -> Map<String, Value> {
    match value {
        Value::Object(map) => map,
        _ => Map::new(),
    }
}

/// The values of a kind that is no table of keys.
fn leaf(kind: Kind) -> Value {
    let array = |items: Value| json!({ "type": "array", "items": items });
    match kind {
        Kind::Line | Kind::Text | Kind::Expression => json!({ "type": "string" }),
        Kind::Keys => array(json!({ "type": "string" })),
        Kind::Names => array(json!({ "type": "string", "pattern": NAME })),
        Kind::Number => json!({ "type": "number" }),
        Kind::Numbers => array(leaf(Kind::Number)),
        Kind::Value | Kind::Formula => json!({ "type": ["number", "string"] }),
        Kind::Start => {
            let mut ends = array(leaf(Kind::Value));
            ends["minItems"] = 2.into();
            ends["maxItems"] = 2.into();
            json!({ "anyOf": [leaf(Kind::Value), ends] })
        }
        Kind::Positive => json!({ "type": ["number", "string"], "exclusiveMinimum": 0 }),
        Kind::Values | Kind::Formulas => array(leaf(Kind::Value)),
        Kind::Whole => json!({ "type": "integer", "minimum": 0 }),
        Kind::Count => json!({ "type": "integer", "minimum": 1 }),
        Kind::Digits => json!({ "type": "integer", "minimum": f64::MOST_DIGITS, "maximum": Extended::MOST_DIGITS }),
        Kind::Share => json!({ "type": "number", "exclusiveMinimum": 0, "exclusiveMaximum": 1 }),
        Kind::Flag => json!({ "type": "boolean" }),
        Kind::Word(words) => json!({ "type": "string", "enum": known(words) }),
        Kind::Norm => json!({ "anyOf": [{ "enum": ["timelike", "null"] }, leaf(Kind::Value)] }),
        Kind::Column => json!({ "anyOf": [leaf(Kind::Numbers), leaf(Kind::Text)] }),
        Kind::Table => json!({ "type": "object" }),
        Kind::Named(&each) => json!({ "type": "object", "additionalProperties": leaf(each) }),
    }
}

/// The words that a key takes, if it takes nothing else.
pub fn choices(key: &Key) -> Vec<String> {
    match key.kind {
        Kind::Word(words) => known(words),
        Kind::Flag => ["true", "false"].map(str::to_owned).to_vec(),
        _ => Vec::new(),
    }
}

/// All words of a kind.
fn known(words: Words) -> Vec<String> {
    let owned = |words: &[&str]| words.iter().map(|&word| word.to_owned()).collect();
    match words {
        Words::Preset => owned(&PRESETS.each_ref().map(|preset| preset.name)),
        Words::Law => owned(&LAWS.map(|(word, _)| word)),
        Words::Sign => owned(&["+", "-"]),
        Words::Operator => SbpName::all().map(|name| name.to_string()).collect(),
        Words::Form => owned(&[Form::Strong, Form::Weak].map(Form::as_str)),
        Words::System => words_of::<System>(),
        Words::Status => words_of::<Status>(),
        Words::Direction => owned(&DIRECTIONS.map(Direction::as_str)),
        Words::Spline => owned(&SPLINES.map(|(word, _)| word)),
        Words::Outside => owned(&OUTSIDE.map(|(word, _)| word)),
    }
}
