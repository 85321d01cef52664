//! `[grid]`, `[scheme]`, `[solver]` and `[expect]`.

use super::limits::{check_nodes, check_spacing};
use super::observables::Formulas;
use super::reader::{Field, default};
use super::{CaseError, keys, names};
use crate::action::Form;
use crate::engine::{Accuracy, POINTS};
use crate::geometry::{Start, value_of};
use crate::number::{Extended, Real};
use crate::sbp::SbpName;
use crate::solve::{Settings, Status, System};

/// `[grid]`, but for nodes and windows. Numbers are decimals with all their digits, or formulas in the parameters of
/// the scene.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Grid {
    /// First value of γ.
    pub gamma_i: String,
    /// Last value of γ, unless `t_f` is given.
    pub gamma_f: Option<String>,
    /// The value of the coordinate t at which the run ends.
    pub t_f: Option<String>,
    /// A formula of positions and velocities: the run ends where it changes its sign, if that is before the end.
    pub until: Option<String>,
}

/// `[expect]`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Expect {
    /// The status with which the run must end.
    pub status: Status,
    /// γ of the last node.
    pub gamma_final: Option<String>,
    /// Coordinates, by their index, at the last node.
    pub finals: Vec<(usize, String)>,
    /// Largest absolute difference allowed in all of these.
    pub tolerance: Option<String>,
}

/// The ways to say how a case is solved.
pub(super) const SCHEME: &str = "the simple way is solver.accuracy = 1e-10, the error allowed: the program chooses all \
                                 else then. For a grid of your own give scheme.sbp, for example \"GLL16\", and, unless \
                                 it is a spectral element, grid.n_gamma";

/// Reads `[solver]` and `[scheme]`, but for `solver.floor`, which needs the coordinates: the settings, without the
/// numbers of nodes and of windows. With an accuracy `[scheme]` is not used.
pub(super) fn solver(root: &Field<'_>) -> Result<Settings, CaseError> {
    let (solver, scheme) = (root.table("solver"), root.table("scheme"));
    let promised = solver.read("accuracy", chosen)?.map(Accuracy::Promised);
    let accuracy = promised.or(solver.read("tolerance", chosen)?.map(Accuracy::Estimated));
    let is_judged = solver.given("error", Field::is_true)?;
    let mut settings = Settings {
        sbp: SbpName::Gll(POINTS as u8),
        form: Form::Weak,
        regularised: true,
        n_gamma: POINTS,
        windows: 1,
        system: solver.given("system", Field::word)?,
        digits: solver.given("digits", digits)?,
        max_iterations: solver.given("max_iterations", at_least_one)?,
        accuracy: if is_judged { accuracy } else { accuracy.map(Accuracy::alone) },
        sensitivity: solver.given("sensitivity", Field::is_true)?,
        is_judged,
    };
    let chosen_by = solver.get("accuracy").or_else(|| solver.get("tolerance")).map(|field| field.path);
    let refused = match chosen_by {
        Some(name) if settings.system != System::PhysicalLimit => {
            Some(("system", format!("{name} needs system = \"physical-limit\""), "leave solver.system out"))
        }
        Some(name) if settings.digits != 16 => {
            let help = "windows are chosen in double precision; for more digits give scheme and grid";
            Some(("digits", format!("{name} and solver.digits exclude each other"), help))
        }
        None if settings.sensitivity => {
            let help = "small changes are carried on windows that the program chooses: give solver.tolerance in place \
                        of scheme and grid";
            Some(("sensitivity", "solver.sensitivity needs solver.accuracy or solver.tolerance".to_owned(), help))
        }
        _ => None,
    };
    if let Some((key, message, help)) = refused {
        return Err(solver.at(key).error(message).with_help(help));
    }
    let form = scheme.given("form", Field::word)?;
    let regularised = scheme.given("regularised", Field::is_true)?;
    let refused = if form == Form::Weak {
        let help = "the weak form is made of the regularised operator; the ablation is one of form = \"strong\"";
        Some(("regularised = false is not possible with form = \"weak\"", help))
    } else if settings.system != System::Doubled {
        let help = "the physical limit exists only for the regularised operator";
        Some(("regularised = false needs solver.system = \"doubled\"", help))
    } else {
        None
    };
    if let Some((message, help)) = refused.filter(|_| !regularised) {
        return Err(scheme.at("regularised").error(message).with_help(help));
    }
    if accuracy.is_none() {
        (settings.form, settings.regularised) = (form, regularised);
        settings.sbp =
            scheme.read("sbp", Field::word)?.ok_or_else(|| scheme.error("missing field `sbp`").with_help(SCHEME))?;
    }
    Ok(settings)
}

/// Reads `solver.floor`.
pub(super) fn floor(
    root: &Field<'_>,
    settings: &Settings,
    formulas: &Formulas<'_>,
) -> Result<Vec<(usize, String)>, CaseError> {
    let Some(floor) = root.table("solver").get("floor") else { return Ok(Vec::new()) };
    if settings.accuracy.is_none() {
        let help = "give solver.accuracy or solver.tolerance, which are relative to the sizes of coordinates";
        return Err(floor.error("a floor needs an accuracy").with_help(help));
    }
    let read =
        |field: &Field<'_>| Ok((names::index(field, formulas.coordinates)?, formulas.positive("a size", field)?));
    floor.fields().iter().map(read).collect()
}

/// A number of digits that an arithmetic has.
pub(super) fn digits(field: &Field<'_>) -> Result<u32, CaseError> {
    let (least, most) = (f64::MOST_DIGITS, Extended::MOST_DIGITS);
    let digits = u32::try_from(field.whole()?).unwrap_or(u32::MAX);
    if (least..=most).contains(&digits) {
        return Ok(digits);
    }
    let help = "16 is double precision; more makes every number of the result exact to that many digits";
    Err(field.error(format!("digits must be from {least} to {most}, got {digits}")).with_help(help))
}

/// The most Newton iterations of a window, where a case does not say.
pub fn default_iterations() -> usize {
    default("solver.max_iterations").whole().expect("it is a whole number")
}

/// A whole number that is not 0.
pub(super) fn at_least_one(field: &Field<'_>) -> Result<usize, CaseError> {
    match field.whole()? {
        0 => Err(field.error(format!("{} must be at least 1", field.key))),
        count => Ok(count),
    }
}

/// An accuracy or a tolerance between 0 and 1.
pub(super) fn chosen(field: &Field<'_>) -> Result<f64, CaseError> {
    let value = value_of(&field.number()?, &[]).unwrap_or(f64::NAN);
    if value > 0.0 && value < 1.0 {
        return Ok(value);
    }
    let message = format!("{} must lie between 0 and 1, got {value}", field.key);
    Err(field.error(message).with_help("for example 1e-10"))
}

/// Reads the numbers of nodes and of windows, unless the program chooses them.
fn nodes(grid: &Field<'_>, settings: &mut Settings) -> Result<(), CaseError> {
    if settings.accuracy.is_some() {
        return Ok(());
    }
    let n_gamma = grid.read("n_gamma", Field::whole)?.or(settings.sbp.fixed_points());
    settings.n_gamma = n_gamma.ok_or_else(|| grid.error("missing field `n_gamma`").with_help(SCHEME))?;
    settings.windows = grid.given("windows", at_least_one)?;
    let checked = check_nodes(settings.sbp, settings.n_gamma, settings.windows);
    checked.map_err(|invalid| invalid.error(grid))
}

/// The words for a case that nothing ends for sure.
pub(super) const NO_END: &str = "neither gamma_f nor t_f is given: the run has no end";

/// The end that a case must have. An event, or `until`, may never be met.
pub(super) const END: &str = "give grid.gamma_f, the last value of gamma, or grid.t_f, the time at which to end; until \
                              and events end a run before that";

/// Reads `[grid]`; γ begins at `gamma_i`, if that is known, unless it says something else.
pub(super) fn grid(
    root: &Field<'_>,
    settings: &mut Settings,
    formulas: &Formulas<'_>,
    start: &Start,
    gamma_i: Option<String>,
) -> Result<Grid, CaseError> {
    let grid = root.table("grid");
    nodes(&grid, settings)?;
    let until = grid.read("until", |field| formulas.of_velocities(field))?;
    let (gamma_i, first) = match gamma_i.filter(|_| grid.get("gamma_i").is_none()) {
        Some(text) => {
            let value = value_of(&text, &[]).unwrap_or(f64::NAN);
            (text, value)
        }
        None => grid.given("gamma_i", |field| formulas.number(field))?,
    };
    let (key, t_f, gamma_f, length) = match grid.get("t_f") {
        Some(field) => {
            let (t_f, length) = end_time(&field, formulas, start)?;
            ("t_f", Some(t_f), None, length)
        }
        None => {
            let field = grid.get("gamma_f").ok_or_else(|| grid.error(NO_END).with_help(END))?;
            let (text, last) = formulas.number(&field)?;
            if last == first {
                let message = format!("gamma_f = {last} must be another value than gamma_i = {first}");
                return Err(field.error(message));
            }
            ("gamma_f", None, Some(text), (last - first).abs())
        }
    };
    check_spacing(key, first, (settings.n_gamma.max(2) - 1) * settings.windows, length)
        .map_err(|invalid| invalid.error(&grid))?;
    Ok(Grid { gamma_i, gamma_f, t_f, until })
}

/// t_f, and the length of γ in which t gets there at its first pace.
fn end_time(field: &Field<'_>, formulas: &Formulas<'_>, start: &Start) -> Result<(String, f64), CaseError> {
    let Some(t) = formulas.coordinates.iter().position(|name| name == "t") else {
        let help = "end at grid.gamma_f, or at grid.until";
        return Err(field.key_error("t_f needs a coordinate t, and there is none").with_help(help));
    };
    let (t_f, last) = formulas.number(field)?;
    let (first, rate) = (start.q[t], start.q_dot[t]);
    if rate == 0.0 {
        return Err(field.error("t_f needs a t_dot at the start, and it is 0"));
    }
    if last == first {
        return Err(field.error(format!("t_f = {last} must be another time than the initial t = {first}")));
    }
    Ok((t_f, (last - first).abs() / rate.abs()))
}

/// Reads `[expect]`.
pub(super) fn expect(root: &Field<'_>, formulas: &Formulas<'_>) -> Result<Option<Expect>, CaseError> {
    let Some(section) = root.get("expect") else { return Ok(None) };
    let finals: Vec<String> = formulas.coordinates.iter().map(|name| format!("{name}_final")).collect();
    section.finish(&keys::named_in("expect", &finals))?;
    let status = section.given("status", Field::word)?;
    let number = |field: &Field<'_>| formulas.number(field).map(|(text, _)| text);
    let gamma_final = section.read("gamma_final", number)?;
    let given = finals.iter().enumerate().filter_map(|(a, key)| Some((a, section.get(key)?)));
    let finals = given.map(|(a, field)| Ok((a, number(&field)?))).collect::<Result<Vec<_>, CaseError>>()?;
    let tolerance = section.read("tolerance", |field| formulas.positive("tolerance", field))?;
    let has_numbers = !finals.is_empty() || gamma_final.is_some();
    if status != Status::Converged && has_numbers {
        return Err(section.at("status").error(format!("a case that ends {status} has no final coordinates")));
    }
    if tolerance.is_none() && has_numbers {
        return Err(section.error("final coordinates need a tolerance"));
    }
    Ok(Some(Expect { status, gamma_final, finals, tolerance }))
}
