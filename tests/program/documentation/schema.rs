//! The schema has every key, and what is in the built-in cases.

use geodesic_ivp::case::KEYS;
use geodesic_ivp::case::builtin::ALL;
use serde_json::Value;
use toml_edit::{DocumentMut, Item, TableLike};

use crate::common::Folder;

fn schema() -> Value {
    serde_json::from_str(&Folder::new().succeeds("schema")).unwrap()
}

/// What the schema of a table, or of an array of tables, says of a key.
fn of_key<'s>(schema: &'s Value, key: &str) -> Option<&'s Value> {
    let choices = schema["anyOf"].as_array();
    if let Some(found) = choices.and_then(|choices| choices.iter().find_map(|choice| of_key(choice, key))) {
        return Some(found);
    }
    let table = if schema["items"].is_object() { &schema["items"] } else { schema };
    let is_name = !key.is_empty() && key.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
    let is_like = |pattern: &str| match pattern {
        "_final$" => key.ends_with("_final"),
        "_dot$" => key.ends_with("_dot"),
        "^p_" => key.starts_with("p_"),
        "^sigma_" => key.starts_with("sigma_"),
        "^[A-Za-z_][A-Za-z0-9_]*$" => is_name && !key.starts_with(|c: char| c.is_ascii_digit()),
        _ => panic!("another pattern: {pattern}"),
    };
    let named = table["properties"].get(key);
    let open = || table["patternProperties"].as_object()?.iter().rev().find(|(pattern, _)| is_like(pattern));
    let other = Some(&table["additionalProperties"]).filter(|other| other.is_object());
    named.or_else(|| open().map(|(_, value)| value)).or(other)
}

#[test]
fn the_schema_lists_every_key() {
    let schema = schema();
    assert_eq!(schema["$schema"], "http://json-schema.org/draft-07/schema#");
    for key in KEYS {
        let name = key.name.replace("NAME", "own");
        let found = name.split('.').try_fold(&schema, of_key).unwrap_or_else(|| panic!("{name} is missing"));
        assert_eq!(found["description"], key.meaning, "{name}");
    }
    let count = schema.to_string().matches("\"description\"").count();
    // The schema itself has one.
    assert_eq!(count, KEYS.len() + 1);
}

/// Refuses keys of a table that the schema does not have.
fn look(table: &dyn TableLike, schema: &Value, path: &str) {
    for (key, item) in table.iter() {
        let dotted = format!("{path}.{key}");
        let schema = of_key(schema, key).unwrap_or_else(|| panic!("{dotted} is not in the schema"));
        match item {
            Item::ArrayOfTables(tables) => tables.iter().for_each(|table| look(table, schema, &dotted)),
            _ => item.as_table_like().into_iter().for_each(|table| look(table, schema, &dotted)),
        }
    }
}

#[test]
fn built_in_cases_have_no_other_keys() {
    let schema = schema();
    for case in ALL.iter() {
        look(case.text.parse::<DocumentMut>().unwrap().as_table(), &schema, case.name);
    }
}

#[test]
fn a_case_may_name_its_schema() {
    let folder = Folder::new();
    let text = geodesic_ivp::case::builtin::text("quartic").unwrap();
    folder.write("case.toml", format!("#:schema ./case.schema.json\n{text}"));
    assert_eq!(folder.succeeds("check case.toml --quiet"), "");
}
