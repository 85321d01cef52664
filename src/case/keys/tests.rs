//! What readers read is in the table, and the reverse.

use std::collections::BTreeSet;

use super::{KEYS, Key, of, stands_for};
use crate::case::builtin::ALL;
use crate::case::reader::ASKED;
use crate::case::{Case, Cases};

/// Returns true if a dotted name of a case is that of a key, or of a table around one.
fn is_in_table(dotted: &str) -> bool {
    let is_around = |key: &Key| {
        let mut parts = key.name.split('.');
        dotted.split('.').all(|own| parts.next().is_some_and(|part| stands_for(part, own)))
    };
    KEYS.iter().any(is_around) || of(dotted).is_some()
}

/// Every name that readers of the built-in cases ask for, a body as if it were the only one.
fn asked() -> BTreeSet<String> {
    for case in ALL.iter() {
        Case::parse(case.name, case.text, &[]).unwrap();
    }
    let no_number = |part: &&str| part.parse::<usize>().is_err();
    let joined = |name: &String| name.split('.').filter(no_number).collect::<Vec<_>>().join(".");
    ASKED.with_borrow(|asked| asked.iter().map(joined).collect())
}

#[test]
fn every_key_that_is_read_is_in_the_table_and_every_key_of_the_table_is_read() {
    let asked = asked();
    let unknown: Vec<&String> = asked.iter().filter(|name| !is_in_table(name)).collect();
    assert!(unknown.is_empty(), "they are read, and the table lacks them: {unknown:?}");
    let is_read = |key: &&Key| match key.name {
        // Their tables are read name by name, whatever the names are.
        "force.q" | "invariants.NAME" => asked.contains(key.fixed()),
        name if key.is_fixed() => asked.contains(name),
        _ => asked.iter().any(|name| of(name) == Some(key)),
    };
    let unread: Vec<&str> = KEYS.iter().filter(|key| !is_read(key)).map(|key| key.name).collect();
    assert!(unread.is_empty(), "they are in the table, and nothing reads them: {unread:?}");
}

#[test]
fn names_stand_once_and_defaults_are_values() {
    let names: BTreeSet<&str> = KEYS.iter().map(|key| key.name).collect();
    assert_eq!(names.len(), KEYS.len());
    for key in KEYS {
        assert!(!key.meaning.is_empty() && !key.meaning.contains("  "), "{}: {}", key.name, key.meaning);
        let default = key.written_default().map(str::parse::<toml_edit::Value>);
        assert!(default.is_none_or(|default| default.is_ok()), "{}: {}", key.name, key.default);
    }
    assert_eq!(KEYS.iter().filter(|key| key.cases == Cases::OfX).count(), 6);
}
