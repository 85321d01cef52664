//! `[grid]`, `[scheme]`, `[solver]` and `[expect]`.

use super::initial::check_number;
use super::limits::{check_nodes, check_spacing};
use super::names;
use super::observables::Formulas;
use super::reader::{Field, Section};
use super::source::Source;
use super::{CaseError, DEFAULT_GAMMA_F, MAX_ITERATIONS};
use crate::action::Form;
use crate::engine::{Accuracy, POINTS};
use crate::geometry::{Start, value_of};
use crate::number::{Extended, Real};
use crate::sbp::SbpName;
use crate::solve::{Status, System};

/// `[grid]`. Numbers are decimals with all their digits, or formulas in the parameters of the scene.
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

/// `[scheme]`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Scheme {
    /// The SBP operator.
    pub sbp: SbpName,
    /// The form of the action.
    pub form: Form,
    /// True if the action has the regularised operator D̄ or, to show what that is for, D.
    pub regularised: bool,
}

/// `[solver]`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Solver {
    /// The system that is solved.
    pub system: System,
    /// Significant decimal digits of the results.
    pub digits: u32,
    /// Largest number of iterations in a window.
    pub max_iterations: usize,
    /// The accuracy of the run for which operator and windows are chosen.
    pub accuracy: Option<String>,
    /// The tolerance of each window for which they are chosen. At most one of the two is given.
    pub tolerance: Option<String>,
    /// Sizes of coordinates, by their index, below which either of them is absolute.
    pub floor: Vec<(usize, String)>,
    /// True if small changes of the start are carried along the run.
    pub sensitivity: bool,
}

impl Solver {
    /// True if the program chooses operator and windows.
    pub(super) fn chooses_windows(&self) -> bool {
        self.chosen_by().is_some()
    }

    /// The accuracy that it chooses them for; `value` gives the value of a number.
    pub(super) fn wanted(&self, value: impl Fn(&str) -> f64) -> Option<Accuracy> {
        let promised = self.accuracy.as_ref().map(|number| Accuracy::Promised(value(number)));
        promised.or_else(|| self.tolerance.as_ref().map(|number| Accuracy::Estimated(value(number))))
    }

    /// The key for which it does.
    pub(super) fn chosen_by(&self) -> Option<&'static str> {
        self.accuracy.as_ref().map(|_| "accuracy").or(self.tolerance.as_ref().map(|_| "tolerance"))
    }
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

/// The parts of a case that its settings are checked against.
pub(super) struct Context<'c> {
    /// γ at the start, unless the case gives it.
    pub(super) gamma_i: String,
    pub(super) source: &'c Source,
    pub(super) formulas: &'c Formulas<'c>,
    pub(super) start: &'c Start,
}

impl Context<'_> {
    /// A number, checked, as it is written and as it is.
    fn number(&self, field: Option<&Field<'_>>, default: &str) -> Result<(String, f64), CaseError> {
        let text = field.map_or_else(|| Ok(default.to_owned()), Field::formula)?;
        let parameters = self.formulas.scene.parameters();
        check_number(&text, field, parameters)?;
        let value = value_of(&text, parameters).unwrap_or(f64::NAN);
        Ok((text, value))
    }

    /// A positive number; `name` is the one of messages.
    fn positive(&self, name: &str, field: &Field<'_>) -> Result<String, CaseError> {
        match self.number(Some(field), "0")? {
            (_, value) if value <= 0.0 => Err(field.error(format!("{name} must be positive, got {value}"))),
            (text, _) => Ok(text),
        }
    }
}

/// The scheme of a solve that chooses its windows.
const CHOSEN: Scheme = Scheme { sbp: SbpName::Gll(POINTS as u8), form: Form::Weak, regularised: true };

/// Reads `[scheme]`; with an accuracy what it says is not used.
pub(super) fn scheme(mut section: Section<'_>, solver: &Solver) -> Result<Scheme, CaseError> {
    let (sbp, form, regularised) = (section.take("sbp"), section.take("form"), section.take("regularised"));
    let name = sbp.map(|sbp| sbp.word()).transpose()?;
    let form = form.map_or(Ok(Form::default()), |form| form.word())?;
    let is_regularised = regularised.as_ref().map_or(Ok(true), Field::is_true)?;
    if let Some(field) = regularised.filter(|_| !is_regularised) {
        if form == Form::Weak {
            let help = "the weak form is made of the regularised operator; the ablation is one of form = \"strong\"";
            return Err(field.error("regularised = false is not possible with form = \"weak\"").with_help(help));
        }
        if solver.system != System::Doubled {
            let help = "the physical limit exists only for the regularised operator";
            return Err(field.error("regularised = false needs solver.system = \"doubled\"").with_help(help));
        }
    }
    if solver.chooses_windows() {
        return Ok(CHOSEN);
    }
    let sbp = name.ok_or_else(|| {
        let help = "give scheme.sbp, for example \"GLL16\", and, unless it is a spectral element, grid.n_gamma";
        section.error("missing field `sbp`").with_help(help)
    })?;
    Ok(Scheme { sbp, form, regularised: is_regularised })
}

/// Reads `[solver]`, but for `solver.floor`, which needs the coordinates.
pub(super) fn solver(mut section: Section<'_>) -> Result<(Solver, Section<'_>), CaseError> {
    let floor = section.section("floor")?;
    let [system, digits, max_iterations] = ["system", "digits", "max_iterations"].map(|key| section.take(key));
    let [accuracy, tolerance, sensitivity] = ["accuracy", "tolerance", "sensitivity"].map(|key| section.take(key));
    if let (Some(_), Some(tolerance)) = (&accuracy, &tolerance) {
        let help =
            "keep accuracy for an error of the whole run, or tolerance for a run that goes on whatever errors grow to";
        return Err(tolerance.key_error("both solver.accuracy and solver.tolerance are given").with_help(help));
    }
    let solver = Solver {
        accuracy: accuracy.as_ref().map(chosen).transpose()?,
        tolerance: tolerance.as_ref().map(chosen).transpose()?,
        system: system.as_ref().map_or(Ok(System::default()), Field::word)?,
        digits: digits.as_ref().map_or(Ok(16), self::digits)?,
        max_iterations: max_iterations.as_ref().map_or(Ok(MAX_ITERATIONS), at_least_one)?,
        floor: Vec::new(),
        sensitivity: sensitivity.as_ref().map_or(Ok(false), Field::is_true)?,
    };
    let (field, message, help) = match solver.chosen_by() {
        Some(name) if solver.system != System::PhysicalLimit => {
            (system, format!("solver.{name} needs system = \"physical-limit\""), "leave solver.system out")
        }
        Some(name) if solver.digits != 16 => {
            let help = "windows are chosen in double precision; for more digits give scheme and grid";
            (digits, format!("solver.{name} and solver.digits exclude each other"), help)
        }
        None if solver.sensitivity => {
            let help = "small changes are carried on windows that the program chooses: give solver.tolerance in place \
                        of scheme and grid";
            (sensitivity, "solver.sensitivity needs solver.accuracy or solver.tolerance".to_owned(), help)
        }
        _ => return Ok((solver, floor)),
    };
    Err(field.expect("what differs from its default is given").error(message).with_help(help))
}

/// Reads `solver.floor`.
pub(super) fn floor(
    section: &Section<'_>,
    solver: &Solver,
    context: &Context<'_>,
) -> Result<Vec<(usize, String)>, CaseError> {
    if section.is_given() && !solver.chooses_windows() {
        let help = "give solver.accuracy or solver.tolerance, which are relative to the sizes of coordinates";
        return Err(section.error("a floor needs an accuracy").with_help(help));
    }
    let read = |field: &Field<'_>| {
        Ok((names::index(field, context.formulas.coordinates)?, context.positive("a size", field)?))
    };
    section.fields().iter().map(read).collect()
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

/// A whole number that is not 0.
pub(super) fn at_least_one(field: &Field<'_>) -> Result<usize, CaseError> {
    match field.whole()? {
        0 => Err(field.error(format!("{} must be at least 1", field.key))),
        count => Ok(count),
    }
}

/// An accuracy or a tolerance between 0 and 1.
pub(super) fn chosen(field: &Field<'_>) -> Result<String, CaseError> {
    let number = field.number()?;
    let value = value_of(&number, &[]).unwrap_or(f64::NAN);
    if value > 0.0 && value < 1.0 {
        return Ok(number);
    }
    let message = format!("{} must lie between 0 and 1, got {value}", field.key);
    Err(field.error(message).with_help("for example 1e-10"))
}

/// The number of nodes and of windows; with an accuracy there is no operator, and neither may be given.
fn nodes(
    section: &Section<'_>,
    sbp: Result<SbpName, &str>,
    [n_gamma, windows]: [Option<Field<'_>>; 2],
) -> Result<(usize, usize), CaseError> {
    match sbp {
        Ok(sbp) => {
            let n_gamma = n_gamma.as_ref().map(Field::whole).transpose()?.or(sbp.fixed_points());
            let n_gamma = n_gamma.ok_or_else(|| section.error("missing field `n_gamma`"))?;
            Ok((n_gamma, windows.as_ref().map_or(Ok(1), at_least_one)?))
        }
        Err(chosen) => n_gamma.or(windows).map_or(Ok((POINTS, 1)), |field| {
            let help = "the program chooses operator and windows itself: leave n_gamma and windows out";
            Err(field.key_error(format!("both solver.{chosen} and {} are given", field.path)).with_help(help))
        }),
    }
}

/// Reads `[grid]`; `sbp` is the operator, or the key for which the program is to choose one.
pub(super) fn grid(
    mut section: Section<'_>,
    sbp: Result<SbpName, &str>,
    context: &Context<'_>,
) -> Result<(Grid, usize, usize), CaseError> {
    let [gamma_i, gamma_f, t_f] = ["gamma_i", "gamma_f", "t_f"].map(|key| section.take(key));
    let given = ["n_gamma", "windows"].map(|key| section.take(key));
    if let (Some(_), Some(t_f)) = (&gamma_f, &t_f) {
        let help = "keep exactly one of grid.gamma_f and grid.t_f";
        return Err(t_f.key_error("both gamma_f and t_f are given").with_help(help));
    }
    let (n_gamma, windows) = nodes(&section, sbp, given)?;
    check_nodes(sbp.ok(), n_gamma, windows).map_err(|invalid| context.source.invalid(invalid))?;
    let (gamma_i, first) = context.number(gamma_i.as_ref(), &context.gamma_i)?;
    let mut grid = Grid { gamma_i, gamma_f: None, t_f: None, until: None };
    let (path, length) = match t_f {
        Some(field) => {
            let (t_f, duration, rate) = end_time(&field, context)?;
            grid.t_f = Some(t_f);
            ("grid.t_f", duration / rate)
        }
        None => {
            let (text, last) = context.number(gamma_f.as_ref(), &DEFAULT_GAMMA_F.to_string())?;
            if last == first {
                let message = format!("gamma_f = {last} must be another value than gamma_i = {first}");
                let error = match gamma_f {
                    Some(field) => field.error(message),
                    None => section.error(message),
                };
                return Err(error.with_help("gamma_f is 1 if it is not given"));
            }
            grid.gamma_f = Some(text);
            ("grid.gamma_f", (last - first).abs())
        }
    };
    check_spacing(path, first, (n_gamma.max(2) - 1) * windows, length)
        .map_err(|invalid| context.source.invalid(invalid))?;
    grid.until = section.take("until").map(|field| context.formulas.of_velocities(&field)).transpose()?;
    Ok((grid, n_gamma, windows))
}

/// t_f, the time from the start to it, and dt/dγ.
fn end_time(field: &Field<'_>, context: &Context<'_>) -> Result<(String, f64, f64), CaseError> {
    let Some(t) = context.formulas.coordinates.iter().position(|name| name == "t") else {
        let help = "end at grid.gamma_f, or at grid.until";
        return Err(field.key_error("t_f needs a coordinate t, and there is none").with_help(help));
    };
    let (t_f, last) = context.number(Some(field), "0")?;
    let (first, rate) = (context.start.q[t], context.start.q_dot[t]);
    if rate == 0.0 {
        return Err(field.error("t_f needs a t_dot at the start, and it is 0"));
    }
    if last == first {
        return Err(field.error(format!("t_f = {last} must be another time than the initial t = {first}")));
    }
    Ok((t_f, (last - first).abs(), rate.abs()))
}

/// Reads `[expect]`.
pub(super) fn expect(mut section: Section<'_>, context: &Context<'_>) -> Result<Option<Expect>, CaseError> {
    let [status, gamma_final] = ["status", "gamma_final"].map(|key| section.take(key));
    let coordinates = context.formulas.coordinates.iter();
    let given: Vec<_> = coordinates.map(|name| section.take(&format!("{name}_final"))).collect();
    let tolerance = section.take("tolerance");
    section.finish()?;
    if !section.is_given() {
        return Ok(None);
    }
    let ends = status.as_ref().map_or(Ok(Status::Converged), Field::word)?;
    let number = |field: Field<'_>| context.number(Some(&field), "0").map(|(text, _)| text);
    let given = given.into_iter().enumerate().filter_map(|(a, field)| Some((a, field?)));
    let finals = given.map(|(a, field)| Ok((a, number(field)?))).collect::<Result<Vec<_>, CaseError>>()?;
    let gamma_final = gamma_final.map(number).transpose()?;
    let has_numbers = !finals.is_empty() || gamma_final.is_some();
    if let Some(status) = status.filter(|_| ends != Status::Converged && has_numbers) {
        return Err(status.error(format!("a case that ends {ends} has no final coordinates")));
    }
    if tolerance.is_none() && has_numbers {
        return Err(section.error("final coordinates need a tolerance"));
    }
    let tolerance = tolerance.map(|field| context.positive("tolerance", &field)).transpose()?;
    Ok(Some(Expect { status: ends, gamma_final, finals, tolerance }))
}
