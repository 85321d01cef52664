//! The names of a case: coordinates, parameters, definitions and invariants.

use std::collections::BTreeMap;
use std::ops::Range;

use super::CaseError;
use super::reader::Field;
use crate::formula::similar::nearest;
use crate::formula::{is_identifier, is_reserved};

/// More coordinates than this are a mistake.
const MOST_COORDINATES: usize = 512;
/// Names of columns and keys that stand beside those of the coordinates.
const COLUMNS: [&str; 5] = ["gamma", "window", "event", "norm", "solve"];
/// Prefixes of the columns and keys that are made of names.
const PREFIXES: [&str; 6] = ["p_", "delta_", "eps_", "error_", "norm_", "hull_"];
const IDENTIFIER: &str = "a name is a letter or underscore, then letters, digits and underscores";

/// The names that have a meaning already, and what they mean.
#[derive(Default)]
pub(super) struct NameTable(BTreeMap<String, &'static str>);

impl NameTable {
    /// Takes the names that the coordinates give a meaning to.
    pub(super) fn new(coordinates: &[String]) -> Self {
        let mut taken = BTreeMap::from([("norm".to_owned(), "the norm K")]);
        for name in coordinates {
            taken.insert(name.clone(), "a coordinate");
            taken.insert(format!("{name}_dot"), "a velocity");
            taken.insert(format!("p_{name}"), "a momentum");
        }
        Self(taken)
    }

    /// The same of a potential, which adds the coordinates `others`.
    pub(super) fn of_potential(coordinates: &[String], others: &[&str]) -> Self {
        let others: Vec<String> = others.iter().map(|&name| name.to_owned()).collect();
        let mut table = Self::new(&[&others, coordinates].concat());
        table.0.extend(others.into_iter().map(|name| (name, "a coordinate that the scene adds itself")));
        table
    }

    /// Takes names that were checked before.
    pub(super) fn extend(&mut self, named: &[(String, String)], kind: &'static str) {
        self.0.extend(named.iter().map(|(name, _)| (name.clone(), kind)));
    }

    /// Takes the name of a field, which becomes a `kind`.
    pub(super) fn take(&mut self, field: &Field<'_>, kind: &'static str) -> Result<(), CaseError> {
        let name = &field.key;
        let noun = kind.rsplit(' ').next().unwrap_or(kind);
        if is_reserved(name) {
            return Err(field.key_error(format!("the {noun} name '{name}' already has a meaning in a formula")));
        }
        check_identifier(field, noun, "cannot be written in a formula")?;
        match self.0.insert(name.clone(), kind) {
            Some(other) => {
                let message = format!("the {noun} name '{name}' is already that of {other}");
                Err(field.key_error(message).with_help("every name may have one meaning only"))
            }
            None => Ok(()),
        }
    }
}

/// The coordinates that an array or the keys of a table name; `others` are names that the scene has besides.
pub(super) fn coordinates(field: &Field<'_>, others: &[&str]) -> Result<Vec<String>, CaseError> {
    if field.is_table() {
        return checked(field, field.fields().into_iter().map(|field| (field.key, field.key_span)), others);
    }
    checked(field, field.strings()?.into_iter().map(|(name, span)| (name.to_owned(), span)), others)
}

/// The names, if all of them may be those of coordinates.
pub(super) fn checked(
    field: &Field<'_>,
    given: impl IntoIterator<Item = (String, Range<usize>)>,
    others: &[&str],
) -> Result<Vec<String>, CaseError> {
    let mut names: Vec<String> = Vec::new();
    for (name, span) in given {
        let meaning = |what: &str| format!("a coordinate cannot have the name '{name}': {what}");
        let prefix = PREFIXES.into_iter().find(|prefix| name.starts_with(prefix));
        let (message, help) = if is_reserved(&name) {
            (meaning("it has a meaning in formulas"), None)
        } else if !is_identifier(&name) {
            (format!("the coordinate name '{name}' cannot be written in a formula"), Some(IDENTIFIER))
        } else if COLUMNS.contains(&name.as_str()) {
            (meaning("it is reserved, for a column or a key"), None)
        } else if name.ends_with("_dot") {
            (meaning("names that end in _dot are those of velocities"), None)
        } else if let Some(prefix) = prefix {
            (meaning(&format!("names that begin with {prefix} are reserved")), None)
        } else if others.contains(&name.as_str()) {
            (meaning("the scene adds a coordinate of that name itself"), None)
        } else if names.contains(&name) {
            (format!("the coordinate '{name}' is given twice"), None)
        } else {
            names.push(name);
            continue;
        };
        return Err(field.error_at(span, message).with_hint(help.map(str::to_owned)));
    }
    if names.is_empty() {
        return Err(field.error("a scene needs at least one coordinate"));
    }
    if names.len() > MOST_COORDINATES {
        let message = format!("{} coordinates are above the limit of {MOST_COORDINATES}", names.len());
        return Err(field.error(message));
    }
    Ok(names)
}

/// The index of the coordinate that the key of a field names.
pub(super) fn index(field: &Field<'_>, coordinates: &[String]) -> Result<usize, CaseError> {
    index_of(&field.key, field, coordinates)
}

/// The index of the coordinate `name`, which the key of a field mentions.
pub(super) fn index_of(name: &str, field: &Field<'_>, coordinates: &[String]) -> Result<usize, CaseError> {
    coordinates.iter().position(|other| other == name).ok_or_else(|| {
        let meant = nearest(name, coordinates.iter().map(String::as_str));
        let list = || format!("the coordinates are {}", coordinates.join(", "));
        let help = meant.map_or_else(list, |meant| format!("did you mean '{meant}'?"));
        field.key_error(format!("unknown coordinate '{name}' in '{}'", field.path)).with_help(help)
    })
}

/// Refuses a name of an invariant that cannot head its column `delta_<name>`.
pub(super) fn check_invariant(field: &Field<'_>) -> Result<(), CaseError> {
    let name = &field.key;
    check_identifier(field, "invariant", "cannot head a column")?;
    if ["k", "energy"].contains(&name.as_str()) || name.starts_with("q_") || name.starts_with("g_") {
        return Err(field.key_error(format!("the column delta_{name} has a meaning already: choose another name")));
    }
    Ok(())
}

/// Refuses a name of an event that cannot be one in a table, or that is one of its columns.
pub(super) fn check_event(field: &Field<'_>) -> Result<(), CaseError> {
    let name = &field.key;
    check_identifier(field, "event", "cannot be a name in a table")?;
    if COLUMNS.contains(&name.as_str()) {
        let message = format!("an event cannot have the name '{name}': it is reserved, for a column or a key");
        return Err(field.key_error(message).with_help("choose another name"));
    }
    Ok(())
}

/// Refuses a name that is none in formulas.
fn check_identifier(field: &Field<'_>, noun: &str, refused: &str) -> Result<(), CaseError> {
    if is_identifier(&field.key) {
        return Ok(());
    }
    Err(field.key_error(format!("the {noun} name '{}' {refused}", field.key)).with_help(IDENTIFIER))
}
