//! `[find]`: the numbers of a case that a search is to find, and what they have to meet.

use toml_edit::DocumentMut;

use super::condition::Condition;
use super::keys::{self, Kind};
use super::observables::Formulas;
use super::reader::Field;
use super::source::is_in_equations;
use super::{Case, CaseError, names, tables};
use crate::geometry::value_of;
use crate::number::{Extended, Real};

/// `[find]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Find {
    /// The numbers to be found.
    pub unknowns: Vec<Unknown>,
    /// The conditions on them.
    pub goal: Goal,
}

/// A number of the case that is to be found.
#[derive(Debug, Clone, PartialEq)]
pub struct Unknown {
    /// Its dotted key.
    pub key: String,
    /// The value that the search begins with.
    pub value: f64,
    /// True if the equations of motion may depend on it, and not the start and the end of the run alone.
    pub is_in_equations: bool,
}

/// The conditions on what is to be found.
#[derive(Debug, Clone, PartialEq)]
pub enum Goal {
    /// These formulas are 0.
    Meet(Vec<Condition>),
    /// All active coordinates but the time, and their velocities, return.
    Periodic,
    /// The run lies as near to these data as it can.
    Data(Data),
}

/// Observations of coordinates along a run, in the order of their places.
#[derive(Debug, Clone, PartialEq)]
pub struct Data {
    /// The coordinate that says where each was made, by its index: t. Without it that is γ.
    pub by: Option<usize>,
    /// Its values, ascending.
    pub places: Vec<f64>,
    /// The observed coordinates.
    pub series: Vec<Series>,
}

/// The observations of one coordinate.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// Its index.
    pub coordinate: usize,
    /// A value for each place.
    pub values: Vec<f64>,
    /// Their standard deviations; none if they are not known, and then equal.
    pub sigmas: Option<Vec<f64>>,
}

/// Tables whose numbers do not change the motion, its start or its end.
const NOT_OF_THE_RUN: [&str; 4] = ["solver", "expect", "scheme", "find"];

/// Reads `[find]`, if there is one.
pub(super) fn read(root: &Field<'_>, formulas: &Formulas<'_>) -> Result<Option<Find>, CaseError> {
    let Some(find) = root.get("find") else { return Ok(None) };
    // The start of a run that goes on from another one is the end of that: there is nothing to find in it.
    if root.table("initial").get("from").is_some() {
        return Ok(None);
    }
    let keys = find.get("unknowns").ok_or_else(|| {
        let help = "name the numbers that are to be found: unknowns = [\"initial.x_dot\"]";
        find.error("missing field `unknowns`").with_help(help)
    })?;
    let mut unknowns: Vec<Unknown> = Vec::new();
    for (key, span) in keys.strings()? {
        let wrong = |(message, help): (String, &str)| keys.error_at(span.clone(), message).with_help(help);
        if unknowns.iter().any(|other| other.key == key) {
            return Err(wrong((format!("{key} is named twice"), "name every unknown once")));
        }
        unknowns.push(unknown(root, key, formulas).map_err(wrong)?);
    }
    if unknowns.is_empty() {
        return Err(keys.error("nothing is to be found").with_help("for example unknowns = [\"initial.x_dot\"]"));
    }
    let meet = find.read("meet", |field| conditions(field, formulas))?;
    let is_periodic = find.given("periodic", Field::is_true)?;
    let data = find.read("data", |field| data(field, formulas))?;
    let goal = match (meet, data, is_periodic) {
        (Some(meet), None, false) => Goal::Meet(meet),
        (None, Some(data), false) => Goal::Data(data),
        (None, None, true) => Goal::Periodic,
        _ => {
            let help =
                "give exactly one of meet = [\"x - 1\"], periodic = true and data = { t = [numbers], x = [numbers] }";
            return Err(find.error("it is not said what is to be met").with_help(help));
        }
    };
    Ok(Some(Find { unknowns, goal }))
}

/// The number of that dotted key.
fn unknown(root: &Field<'_>, key: &str, formulas: &Formulas<'_>) -> Result<Unknown, (String, &'static str)> {
    let key = &keys::replaced(key).map_or_else(|| key.to_owned(), |(_, now)| now);
    let parameter = key.strip_prefix(keys::PARAMETERS).and_then(|rest| rest.strip_prefix('.'));
    let top = key.split('.').next().unwrap_or_default();
    let is_number = |kind: Kind| {
        matches!(kind, Kind::Value | Kind::Start | Kind::Positive | Kind::Number | Kind::Norm)
            || matches!(kind, Kind::Named(&(Kind::Formula | Kind::Value | Kind::Start)))
    };
    if NOT_OF_THE_RUN.contains(&top) || !keys::of(key).is_some_and(|known| is_number(known.kind)) {
        let help = "an unknown is a number of the motion, its start or its end: \"initial.x_dot\", \"grid.t_f\", \
                    \"parameters.k\"; elements of arrays are found by parameters that stand there";
        return Err((format!("{key} is no number that can be found"), help));
    }
    let field = key.split('.').try_fold(root.clone(), |table, part| table.get(part));
    let text = parameter.map(str::to_owned).or_else(|| field?.formula().ok());
    let value = text.and_then(|text| value_of::<f64>(&text, &formulas.scene.parameters).ok());
    let Some(value) = value.filter(|value| value.is_finite()) else {
        return Err((format!("the case gives {key} no number"), "give it the value that the search begins with"));
    };
    let is_in_equations = match parameter {
        // The text has no formulas of a preset.
        Some(name) => {
            is_in_equations(&root.source.text, name) || formulas.scene.parameters_in_use().iter().any(|it| it == name)
        }
        None => !["initial", "grid"].contains(&top),
    };
    Ok(Unknown { key: key.to_owned(), value, is_in_equations })
}

fn conditions(field: &Field<'_>, formulas: &Formulas<'_>) -> Result<Vec<Condition>, CaseError> {
    let texts = field.formulas()?;
    if texts.is_empty() {
        return Err(field.error("nothing is to be met").with_help("for example meet = [\"x - 1\"]"));
    }
    let read =
        |text: &String| Condition::read(text, formulas).map_err(|(message, help)| field.error(message).with_help(help));
    texts.iter().map(read).collect()
}

/// Reads `find.data` and its file.
fn data(field: &Field<'_>, formulas: &Formulas<'_>) -> Result<Data, CaseError> {
    let file = field.get("file");
    let (coordinates, results) = (formulas.coordinates, formulas.scene.positions());
    let gamma = field.get("gamma");
    let by = coordinates.iter().position(|name| name == "t").filter(|_| gamma.is_none());
    let place = gamma.or_else(|| by.and_then(|_| field.get("t"))).ok_or_else(|| {
        let help = "give the times, t = [numbers], or values of gamma, gamma = [numbers]; with file = \"obs.csv\" \
                    the names of columns, t = \"…\"";
        field.error("it is not said where the observations were made").with_help(help)
    })?;
    let (mut columns, mut observed) = (vec![place], Vec::new());
    for observation in field.fields() {
        let (key, sigma) = (observation.key.clone(), format!("sigma_{}", observation.key));
        let is_other = |key: &str| key == "file" || Some(key) == columns.first().map(|place| &*place.key);
        let has_observation = |name: &str| results.iter().any(|q| q == name) && field.get(name).is_some();
        if is_other(&key) || key.strip_prefix("sigma_").is_some_and(has_observation) {
            continue;
        }
        let a = names::index(&observation, &results)?;
        let sigma = field.get(&sigma);
        observed.push((a, sigma.is_some()));
        columns.extend([Some(observation), sigma].into_iter().flatten());
    }
    if observed.is_empty() {
        let help = "give values of a coordinate, as x = [numbers], or with a file the name of a column";
        return Err(field.error("nothing is observed").with_help(help));
    }
    if observed.iter().any(|(_, has_sigma)| *has_sigma != observed[0].1) {
        let help = "give standard deviations, as sigma_x, for each of them or for none";
        return Err(field.error("only some of the observed coordinates have standard deviations").with_help(help));
    }
    let mut rows = tables::rows(file.as_ref(), &columns.iter().collect::<Vec<_>>())?;
    rows.sort_by(|a, b| a[0].partial_cmp(&b[0]).expect("numbers of a table are finite"));
    arranged(&file.unwrap_or_else(|| field.clone()), by, &observed, &rows)
}

/// The rows of a table, by the place of each, as observations of coordinates.
fn arranged(
    table: &Field<'_>,
    by: Option<usize>,
    observed: &[(usize, bool)],
    rows: &[Vec<Extended>],
) -> Result<Data, CaseError> {
    let column = |k: usize| rows.iter().map(|row| row[k].to_f64()).collect::<Vec<f64>>();
    let mut next = 1;
    let mut series = Vec::new();
    for &(coordinate, has_sigma) in observed {
        let sigmas = has_sigma.then(|| column(next + 1));
        if sigmas.iter().flatten().any(|sigma| *sigma <= 0.0) {
            return Err(table.error("a standard deviation is not positive").with_help("leave that row out"));
        }
        series.push(Series { coordinate, values: column(next), sigmas });
        next += 1 + usize::from(has_sigma);
    }
    if rows.is_empty() {
        return Err(table.error("there are no observations"));
    }
    Ok(Data { by, places: column(0), series })
}

impl Case {
    /// The text of this case with every default, and without what a search has to meet and what a run is expected to
    /// give: it is valid wherever it lies, and with other numbers.
    pub fn text_of_run(&self) -> String {
        let mut document: DocumentMut = self.to_toml().parse().expect("a case that was read can be read again");
        document.remove("find");
        document.remove("expect");
        document.to_string()
    }
}
