//! The mistakes that keys and their values have by themselves: unknown keys, wrong kinds, numbers out of range. All of
//! them are found at once; what a case means is only looked at where there is none.

use super::check::title;
use super::initial::{self, norm_value};
use super::keys::{self, Kind, Words};
use super::observables::direction;
use super::potential::{self, law};
use super::reader::Field;
use super::settings::{at_least_one, chosen, digits};
use super::{CaseError, Form, SbpName, System, names, tables};
use crate::geometry::{Law, Preset, Tau};
use crate::solve::Status;

/// Refuses a value that is not of a kind.
fn check(field: &Field<'_>, kind: Kind) -> Result<(), CaseError> {
    match kind {
        Kind::Line => title(field).map(drop),
        Kind::Text | Kind::Expression | Kind::Word(Words::Preset | Words::Sign) => field.string().map(drop),
        Kind::Names | Kind::Keys => field.strings().map(drop),
        Kind::Number => field.number().map(drop),
        Kind::Numbers => field.numbers().map(drop),
        Kind::Start => field.number_of_start().map(drop),
        Kind::Value | Kind::Positive | Kind::Formula => field.formula().map(drop),
        Kind::Values | Kind::Formulas => field.formulas().map(drop),
        Kind::Whole => field.whole().map(drop),
        Kind::Count => at_least_one(field).map(drop),
        Kind::Digits => digits(field).map(drop),
        Kind::Share => chosen(field).map(drop),
        Kind::Flag => field.is_true().map(drop),
        Kind::Norm => norm_value(field).map(drop),
        Kind::Word(Words::Law) => law(field).map(drop),
        Kind::Word(Words::Operator) => field.word::<SbpName>().map(drop),
        Kind::Word(Words::Form) => field.word::<Form>().map(drop),
        Kind::Word(Words::System) => field.word::<System>().map(drop),
        Kind::Word(Words::Status) => field.word::<Status>().map(drop),
        Kind::Word(Words::Direction) => direction(field).map(drop),
        Kind::Word(Words::Spline) => tables::kind(field).map(drop),
        Kind::Word(Words::Outside) => tables::outside(field).map(drop),
        Kind::Column | Kind::Table | Kind::Named(_) => Ok(()),
    }
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
            let law = root.table("particle").given("law", law).unwrap_or_default();
            let lift = (law == Law::Newtonian).then(|| "s".to_owned());
            let names = potential::coordinates(root, law).ok()??;
            let start: Vec<String> = std::iter::once("t".to_owned()).chain(names).chain(lift).collect();
            (start, table)
        }
    };
    let tau = table.get("conformal").map(|_| Tau::NAME.to_owned());
    Some([start.clone(), start.into_iter().chain(tau).collect()])
}

/// Looks at the keys of a table, which is called `path` in the table of keys.
fn look(table: &Field<'_>, path: &str, names: Option<&Names>, found: &mut Found) {
    let (named, open) = keys::named_and_open(path);
    let of_coordinates = match (names, path) {
        (Some([start, _]), "initial") => initial::own_keys(start),
        (Some([_, end]), "expect") => end.iter().map(|name| format!("{name}_final")).collect(),
        _ => Vec::new(),
    };
    let known = keys::named_in(path, &of_coordinates);
    let is_open = open.is_some() && of_coordinates.is_empty();
    if !is_open {
        let unknown = table.unknown(&known).into_iter();
        match (names, path) {
            (Some(_), "initial" | "expect") => found.all.extend(unknown),
            (_, "potential") => found.add(unknown.map(tables::explain_table)),
            _ => found.add(unknown),
        }
    }
    let is_looked_at = |field: &Field<'_>| is_open || known.contains(&&*field.key) || keys::is_former(&field.path);
    for field in table.fields().into_iter().filter(is_looked_at) {
        let name = named.iter().find(|name| **name == field.key).copied().or(open).unwrap_or_default();
        let path = match keys::replaced(&field.path) {
            Some((_, now)) => now,
            None if path.is_empty() => name.to_owned(),
            None => format!("{path}.{name}"),
        };
        let kind = keys::named(&path).map_or(Kind::Table, |key| key.kind);
        let has_keys = field.is_table() && !keys::below(&path).is_empty();
        match field.tables(path == "body") {
            _ if !has_keys && !matches!(kind, Kind::Table | Kind::Named(_)) => found.add(check(&field, kind).err()),
            Err(error) => found.add([error]),
            Ok(tables) => match kind {
                Kind::Named(&each) => found.add(field.fields().iter().filter_map(|field| check(field, each).err())),
                _ => tables.iter().for_each(|table| look(table, &path, names, found)),
            },
        }
    }
}
