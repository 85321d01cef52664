//! One way of JSON: keys stay in their order, and numbers have all their digits.

use std::collections::BTreeMap;

use serde::Serialize;
use serde_json::{Map, Number, Value, json};

use crate::number::Real;

/// A number for each of several names.
pub(super) type ByName = BTreeMap<String, Value>;

/// A number with so many significant digits; an `f64` keeps all of its digits. It is null if it is not finite.
pub(super) fn number<S: Real>(value: S, digits: u32) -> Value {
    if S::IS_EXTENDED && value.is_finite() {
        Value::Number(Number::from_string_unchecked(value.to_decimal(digits)))
    } else {
        value.to_f64().into()
    }
}

/// The object without the members that are null or empty.
pub(super) fn present(mut object: Value) -> Value {
    let is_empty = |value: &Value| value.is_null() || value.as_object().is_some_and(|members| members.is_empty());
    object.as_object_mut().expect("it is an object").retain(|_, value| !is_empty(value));
    object
}

/// One object with the members of all of these, in their order. What is null has none.
pub(super) fn merged(objects: impl IntoIterator<Item = Value>) -> Value {
    let members = |object| if let Value::Object(members) = object { members } else { Map::new() };
    Value::Object(objects.into_iter().flat_map(members).collect())
}

/// Indented JSON with a final newline.
pub(super) fn json(summary: &impl Serialize) -> String {
    let mut text = serde_json::to_string_pretty(summary).expect("a summary has string keys only");
    text.push('\n');
    text
}

/// The summary of a study: what all have in common, and what it found.
pub(super) fn study_json(is_interrupted: bool, title: Option<&str>, found: Value) -> String {
    let status = if is_interrupted { "interrupted" } else { "complete" };
    let head = json!({"status": status, "version": env!("CARGO_PKG_VERSION")});
    json(&merged([head, present(json!({"title": title})), found]))
}

/// One indented JSON object, with a final newline, from several JSON texts and their names.
pub fn json_object(members: &[(&str, String)]) -> String {
    // Strings of JSON contain no line breaks, so all lines can be indented.
    let member = |(name, text): &(&str, String)| format!("  \"{name}\": {}", text.trim_end().replace('\n', "\n  "));
    format!("{{\n{}\n}}\n", members.iter().map(member).collect::<Vec<_>>().join(",\n"))
}
