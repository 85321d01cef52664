//! The mistakes that keys and their values have by themselves: unknown keys, wrong kinds, numbers out of range. They are
//! all found at once; what a case means is only looked at where there is none.

use super::check::title;
use super::initial::{self, norm_value};
use super::observables::direction;
use super::potential::law;
use super::reader::{Field, Section};
use super::settings::{at_least_one, chosen, digits};
use super::{CaseError, Form, SbpName, System};
use crate::geometry::Preset;
use crate::solve::Status;

/// Refuses a value that a key does not take.
type Check = fn(&Field<'_>) -> Result<(), CaseError>;

const TEXT: Check = |field| field.string().map(drop);
const TEXTS: Check = |field| field.strings().map(drop);
const NUMBER: Check = |field| field.number().map(drop);
const NUMBERS: Check = |field| field.numbers().map(drop);
const FORMULA: Check = |field| field.formula().map(drop);
const WHOLE: Check = |field| field.whole().map(drop);
const FLAG: Check = |field| field.is_true().map(drop);
const ANY: Check = |_| Ok(());

/// The keys and what they take, in the order in which messages list them. A star stands for any name.
const KINDS: &[(&str, Check)] = &[
    ("title", |field| title(field).map(drop)),
    ("metric.coordinates", TEXTS),
    ("metric.components.*", FORMULA),
    ("metric.definitions.*", FORMULA),
    ("metric.parameters.*", FORMULA),
    ("metric.one_form.*", FORMULA),
    ("metric.force.*", FORMULA),
    ("metric.conformal", FORMULA),
    ("metric.preset", TEXT),
    ("potential.coordinates", TEXTS),
    ("potential.free.", ANY),
    ("potential.linear.alpha", NUMBER),
    ("potential.quartic.kappa", NUMBER),
    ("potential.polynomial.coefficients", NUMBERS),
    ("potential.formula", TEXT),
    ("potential.formula.expression", TEXT),
    ("potential.formula.parameters.*", FORMULA),
    ("potential.one_form.*", FORMULA),
    ("potential.definitions.*", FORMULA),
    ("potential.force.*", FORMULA),
    ("potential.conformal", FORMULA),
    ("potential.parameters.*", FORMULA),
    ("force.*", FORMULA),
    ("particle.mass", FORMULA),
    ("particle.masses.*", FORMULA),
    ("particle.c", FORMULA),
    ("particle.law", |field| law(field).map(drop)),
    ("initial.from", TEXT),
    ("initial.norm", |field| norm_value(field).map(drop)),
    ("initial.solve.*", TEXT),
    ("initial.*", FORMULA),
    ("grid.gamma_i", FORMULA),
    ("grid.gamma_f", FORMULA),
    ("grid.t_f", FORMULA),
    ("grid.n_gamma", WHOLE),
    ("grid.windows", |field| at_least_one(field).map(drop)),
    ("grid.until", FORMULA),
    ("scheme.sbp", |field| field.word::<SbpName>().map(drop)),
    ("scheme.form", |field| field.word::<Form>().map(drop)),
    ("scheme.regularised", FLAG),
    ("solver.system", |field| field.word::<System>().map(drop)),
    ("solver.digits", |field| digits(field).map(drop)),
    ("solver.max_iterations", |field| at_least_one(field).map(drop)),
    ("solver.accuracy", |field| chosen("accuracy", field).map(drop)),
    ("solver.tolerance", |field| chosen("tolerance", field).map(drop)),
    ("expect.status", |field| field.word::<Status>().map(drop)),
    ("expect.gamma_final", FORMULA),
    ("expect.tolerance", FORMULA),
    ("expect.*", FORMULA),
    ("invariants.*", FORMULA),
    ("events.*.when", FORMULA),
    ("events.*.direction", |field| direction(field).map(drop)),
    ("events.*.until", FLAG),
    ("plot.x", FORMULA),
    ("plot.y", FORMULA),
];

/// The part of a dotted key below the table `path`, if it is there.
fn below<'k>(key: &'k str, path: &str) -> Option<&'k str> {
    if path.is_empty() { Some(key) } else { key.strip_prefix(path)?.strip_prefix('.') }
}

/// All mistakes, in the order of the text.
pub(super) fn all<'t>(root: impl Fn() -> Section<'t>) -> Vec<CaseError> {
    let mut found = Vec::new();
    look(root(), "", coordinates(root()).as_deref(), &mut found);
    found.sort_by_key(|error| error.span.as_ref().map(|span| span.start));
    found
}

/// The names of the coordinates, as far as the text says so without a mistake.
fn coordinates(mut root: Section<'_>) -> Option<Vec<String>> {
    let names = |field: &Field<'_>| -> Option<Vec<String>> {
        Some(field.strings().ok()?.into_iter().map(|(name, _)| name).collect())
    };
    match (root.take("metric"), root.take("potential")) {
        (Some(metric), None) => {
            let mut metric = metric.section().ok()?;
            match metric.take("preset") {
                Some(preset) => Some(Preset::from_name(preset.as_str()?)?.text().coordinates),
                None => names(&metric.take("coordinates")?),
            }
        }
        (None, Some(potential)) => {
            let given = potential.section().ok()?.take("coordinates");
            let places = given.map_or_else(|| Some(vec!["x".to_owned()]), |field| names(&field))?;
            let law = root.section("particle").ok()?.take("law");
            let lift = law.filter(|law| law.as_str() == Some("newtonian")).map(|_| "s".to_owned());
            Some(["t".to_owned()].into_iter().chain(places).chain(lift).collect())
        }
        _ => None,
    }
}

/// Looks at the keys of a table, which is called `path` in [`KINDS`].
fn look(mut section: Section<'_>, path: &str, coordinates: Option<&[String]>, found: &mut Vec<CaseError>) {
    let mut names: Vec<&str> = Vec::new();
    for name in KINDS.iter().filter_map(|(key, _)| below(key, path)?.split('.').next()) {
        if !names.contains(&name) {
            names.push(name);
        }
    }
    names.iter().filter(|name| !["", "*"].contains(name)).for_each(|name| drop(section.take(name)));
    let of_coordinates = coordinates.and_then(|coordinates| match path {
        "initial" => Some(initial::keys(coordinates, section.is_of_x())),
        "expect" => Some(coordinates.iter().map(|name| format!("{name}_final")).collect()),
        _ => None,
    });
    of_coordinates.iter().flatten().for_each(|key| drop(section.take(key)));
    let is_open = of_coordinates.is_none() && names.contains(&"*");
    if !is_open {
        let explained = |error| match coordinates.filter(|_| path == "initial") {
            Some(coordinates) => initial::explain_velocity(error, coordinates),
            None => error,
        };
        found.extend(section.unknown().into_iter().map(explained));
    }
    for field in section.fields().into_iter().filter(|field| is_open || section.knows(&field.key)) {
        let name = if names.contains(&field.key.as_str()) { &field.key } else { "*" };
        let path = if path.is_empty() { name.to_owned() } else { format!("{path}.{name}") };
        let check = KINDS.iter().find(|(key, _)| *key == path).map(|(_, check)| check);
        let has_keys = KINDS.iter().any(|(key, _)| below(key, &path).is_some());
        match check.filter(|_| !(has_keys && field.is_table())) {
            Some(check) => found.extend(check(&field).err()),
            None => match field.section() {
                Ok(section) => look(section, &path, coordinates, found),
                Err(error) => found.push(error),
            },
        }
    }
}
