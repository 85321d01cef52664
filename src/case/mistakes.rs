//! The mistakes that keys and their values have by themselves: unknown keys, wrong kinds, numbers out of range. All of
//! them are found at once; what a case means is only looked at where there is none.

use super::check::title;
use super::initial::{self, norm_value};
use super::observables::direction;
use super::potential::{KINDS as KINDS_OF_POTENTIAL, law};
use super::reader::{Field, Section};
use super::settings::{at_least_one, chosen, digits};
use super::tables::{explain_table, kind, outside};
use super::{CaseError, Form, SbpName, System, names};
use crate::geometry::{Preset, Tau};
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
    ("body", ANY),
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

/// The mistakes that were found.
pub(super) struct Found {
    all: Vec<CaseError>,
    /// True if they may have one cause, a mistake in the coordinates: all of them are unknown names of these.
    are_names: bool,
}

impl Found {
    /// Looks at all keys.
    pub(super) fn new<'t>(root: impl Fn() -> Section<'t>) -> Self {
        let mut found = Self { all: Vec::new(), are_names: true };
        look(root(), "", names_of(root()).as_ref(), &mut found);
        found
    }

    fn add(&mut self, errors: impl IntoIterator<Item = CaseError>) {
        let before = self.all.len();
        self.all.extend(errors);
        self.are_names &= self.all.len() == before;
    }

    /// The first mistake in the text, with the others; `None` if there is none. Where they may have one cause, the
    /// mistake at which `read` stops is one of them.
    pub(super) fn first(self, read: impl FnOnce() -> Option<CaseError>) -> Option<CaseError> {
        let Self { mut all, are_names } = self;
        if are_names && !all.is_empty() {
            let more = read().filter(|more| all.iter().all(|error| error.span != more.span));
            all.extend(more);
        }
        all.sort_by_key(|error| error.span.as_ref().map(|span| span.start));
        CaseError::first_of(all)
    }
}

/// The coordinates at the start and those at the end, among which may be tau.
type Names = [Vec<String>; 2];

/// The names of the coordinates, as far as the text says them without a mistake.
fn names_of(mut root: Section<'_>) -> Option<Names> {
    let [metric, potential, force] = ["metric", "potential", "force"].map(|key| root.take(key));
    let (start, factor) = match (metric, potential) {
        (Some(metric), None) => {
            let mut metric = metric.section().ok()?;
            let start = match metric.take("preset") {
                Some(preset) => Preset::from_name(preset.item.as_str()?)?.text().coordinates,
                None => names::coordinates(&metric.take("coordinates")?, &[]).ok()?,
            };
            (start, metric.take("conformal"))
        }
        (None, potential) => {
            let mut potential = potential.map_or_else(|| root.section("potential"), |field| field.section()).ok()?;
            let is_given = KINDS_OF_POTENTIAL.iter().any(|kind| potential.take(kind).is_some());
            let force = force.or_else(|| potential.take("force")).filter(|_| !is_given);
            let law = root.section("particle").ok()?.take("law");
            let is_newtonian = law.is_some_and(|law| law.item.as_str() == Some("newtonian"));
            let others: &[&str] = if is_newtonian { &["t", "s"] } else { &["t"] };
            let mut start = match (potential.take("coordinates"), force) {
                (Some(coordinates), _) => names::coordinates(&coordinates, others).ok()?,
                (None, Some(force)) => names::keys(&force, others).ok()?,
                (None, None) if is_given => vec!["x".to_owned()],
                (None, None) => return None,
            };
            start.insert(0, "t".to_owned());
            start.extend(is_newtonian.then(|| "s".to_owned()));
            (start, potential.take("conformal"))
        }
        (Some(_), Some(_)) => return None,
    };
    let end = start.iter().cloned().chain(factor.map(|_| Tau::NAME.to_owned())).collect();
    Some([start, end])
}

/// Looks at the keys of a table, which is called `path` in [`KINDS`].
fn look(mut section: Section<'_>, path: &str, names: Option<&Names>, found: &mut Found) {
    let mut keys: Vec<&str> = Vec::new();
    for key in KINDS.iter().filter_map(|(key, _)| below(key, path)?.split('.').next()) {
        if !keys.contains(&key) {
            keys.push(key);
        }
    }
    keys.iter().filter(|name| !["", "*"].contains(name)).for_each(|name| drop(section.take(name)));
    let of_coordinates = names.and_then(|[start, end]| match path {
        "initial" => Some(initial::keys(start, section.source.is_of_x)),
        "expect" => Some(end.iter().map(|name| format!("{name}_final")).collect()),
        _ => None,
    });
    of_coordinates.iter().flatten().for_each(|key| drop(section.take(key)));
    let is_open = of_coordinates.is_none() && keys.contains(&"*");
    if !is_open {
        let unknown = section.unknown().into_iter();
        match (names, path) {
            (Some([start, _]), "initial") => {
                found.all.extend(unknown.map(|error| initial::explain_velocity(error, start)));
            }
            (Some(_), "expect") => found.all.extend(unknown),
            (_, "potential") => found.add(unknown.map(explain_table)),
            _ => found.add(unknown),
        }
    }
    for field in section.fields().into_iter().filter(|field| is_open || section.knows(&field.key)) {
        let name = if keys.contains(&field.key.as_str()) { &field.key } else { "*" };
        let path = if path.is_empty() { name.to_owned() } else { format!("{path}.{name}") };
        let check = KINDS.iter().find(|(key, _)| *key == path).map(|(_, check)| check);
        let has_keys = KINDS.iter().any(|(key, _)| below(key, &path).is_some());
        match check.filter(|_| !(has_keys && field.item.is_table_like())) {
            Some(check) => found.add(check(&field).err()),
            None => match field.section() {
                Ok(section) => look(section, &path, names, found),
                Err(error) => found.add([error]),
            },
        }
    }
}
