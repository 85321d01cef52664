//! The mistakes that keys and their values have by themselves: unknown keys, wrong kinds, numbers out of range. All of
//! them are found at once; what a case means is only looked at where there is none.

use super::check::title;
use super::initial::{self, norm_value};
use super::observables::direction;
use super::potential::{self, law};
use super::reader::Field;
use super::settings::{at_least_one, chosen, digits};
use super::tables::{explain_table, kind, outside};
use super::{CaseError, Form, SbpName, System, names};
use crate::geometry::{Law, Preset, Tau};
use crate::solve::Status;

/// Refuses a value that a key does not take.
type Check = fn(&Field<'_>) -> Result<(), CaseError>;

const TEXT: Check = |field| field.string().map(drop);
const TEXTS: Check = |field| field.strings().map(drop);
const NUMBER: Check = |field| field.number().map(drop);
const NUMBERS: Check = |field| field.numbers().map(drop);
const FORMULAS: Check = |field| field.formulas().map(drop);
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
    ("body.name", TEXT),
    ("body.mass", FORMULA),
    ("body.position", FORMULAS),
    ("body.velocity", FORMULAS),
    ("pair.formula", TEXT),
    ("pair.parameters.*", FORMULA),
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
    ("solver.accuracy", |field| chosen(field).map(drop)),
    ("solver.tolerance", |field| chosen(field).map(drop)),
    ("solver.floor.*", FORMULA),
    ("solver.sensitivity", FLAG),
    ("solver.error", FLAG),
    ("solver.proof", FLAG),
    ("expect.status", |field| field.word::<Status>().map(drop)),
    ("expect.gamma_final", FORMULA),
    ("expect.tolerance", FORMULA),
    ("expect.*", FORMULA),
    ("invariants.*", FORMULA),
    ("events.*.when", FORMULA),
    ("events.*.direction", |field| direction(field).map(drop)),
    ("events.*.until", FLAG),
    ("events.*.set.*", FORMULA),
    ("plot.x", FORMULA),
    ("plot.y", FORMULA),
    ("tables.*.file", TEXT),
    ("tables.*.x", ANY),
    ("tables.*.y", ANY),
    ("tables.*.spline", |field| kind(field).map(drop)),
    ("tables.*.outside", |field| outside(field).map(drop)),
];

/// The part of a dotted key below the table `path`, if it is there.
fn below<'k>(key: &'k str, path: &str) -> Option<&'k str> {
    if path.is_empty() { Some(key) } else { key.strip_prefix(path)?.strip_prefix('.') }
}

/// The first mistake in the text, with the others; `None` if there is none. Where they may have one cause, the mistake
/// at which `read` stops is one of them.
pub(super) fn first(root: &Field<'_>, read: impl FnOnce() -> Option<CaseError>) -> Option<CaseError> {
    let mut found = Found { all: Vec::new(), are_names: true };
    look(root, "", names_of(root).as_ref(), &mut found);
    let Found { mut all, are_names } = found;
    if are_names && !all.is_empty() {
        let more = read().filter(|more| all.iter().all(|error| error.span != more.span));
        all.extend(more);
    }
    all.sort_by_key(|error| error.span.as_ref().map(|span| span.start));
    CaseError::first_of(all)
}

/// The mistakes that were found.
struct Found {
    all: Vec<CaseError>,
    /// True if they may have one cause, a mistake in the coordinates: all of them are unknown names of these.
    are_names: bool,
}

impl Found {
    fn add(&mut self, errors: impl IntoIterator<Item = CaseError>) {
        let before = self.all.len();
        self.all.extend(errors);
        self.are_names &= self.all.len() == before;
    }
}

/// The coordinates at the start and those at the end, among which may be tau.
type Names = [Vec<String>; 2];

/// The names of the coordinates, as far as the text says them without a mistake.
fn names_of(root: &Field<'_>) -> Option<Names> {
    let table = root.table("potential");
    let (start, table) = match root.get("metric") {
        Some(_) if table.is_table() => return None,
        Some(metric) => match metric.get("preset") {
            Some(preset) => (Preset::from_name(preset.as_str()?)?.text().coordinates, metric),
            None => (names::coordinates(&metric.get("coordinates")?, &[]).ok()?, metric),
        },
        None => {
            let law = root.table("particle").read("law", law).ok().flatten().unwrap_or_default();
            let lift = (law == Law::Newtonian).then(|| "s".to_owned());
            let names = potential::coordinates(root, law).ok()??;
            let start: Vec<String> = std::iter::once("t".to_owned()).chain(names).chain(lift).collect();
            (start, table)
        }
    };
    let tau = table.get("conformal").map(|_| Tau::NAME.to_owned());
    Some([start.clone(), start.into_iter().chain(tau).collect()])
}

/// Looks at the keys of a table, which is called `path` in [`KINDS`].
fn look(table: &Field<'_>, path: &str, names: Option<&Names>, found: &mut Found) {
    let mut keys: Vec<String> = Vec::new();
    for key in KINDS.iter().filter_map(|(key, _)| below(key, path)?.split('.').next()) {
        if !key.is_empty() && !keys.iter().any(|other| other == key) {
            keys.push(key.to_owned());
        }
    }
    let has_star = keys.iter().any(|key| key == "*");
    keys.retain(|key| key != "*");
    let named = keys.clone();
    match (names, path) {
        (Some([start, _]), "initial") => keys.extend(initial::keys(start, table.source.is_of_x)),
        (Some([_, end]), "expect") => keys.extend(end.iter().map(|name| format!("{name}_final"))),
        _ => {}
    }
    let is_open = has_star && keys.len() == named.len();
    if !is_open {
        let unknown = table.unknown(&keys).into_iter();
        match (names, path) {
            (Some([start, _]), "initial") => {
                found.all.extend(unknown.map(|error| initial::explain_velocity(error, start)));
            }
            (Some(_), "expect") => found.all.extend(unknown),
            (_, "potential") => found.add(unknown.map(explain_table)),
            _ => found.add(unknown),
        }
    }
    for field in table.fields().into_iter().filter(|field| is_open || keys.contains(&field.key)) {
        let name = if named.contains(&field.key) { &field.key } else { "*" };
        let path = if path.is_empty() { name.to_owned() } else { format!("{path}.{name}") };
        let check = KINDS.iter().find(|(key, _)| *key == path).map(|(_, check)| check);
        let has_keys = KINDS.iter().any(|(key, _)| below(key, &path).is_some());
        match check.filter(|_| !(has_keys && field.is_table())) {
            Some(check) => found.add(check(&field).err()),
            None => match field.tables(path == "body") {
                Ok(tables) => tables.iter().for_each(|table| look(table, &path, names, found)),
                Err(error) => found.add([error]),
            },
        }
    }
}
