//! `[grid]`, `[scheme]`, `[solver]` and `[expect]`.

use super::initial::check_number;
use super::limits::{
    ACCURACY_AND_TOLERANCE, CARRIED_ON_WINDOWS, CHOSEN_WINDOWS, IN_F64, ONE_OF_THEM, SENSITIVITY, check_nodes,
    check_spacing,
};
use super::names;
use super::observables::Formulas;
use super::quantity::Quantity;
use super::reader::{Field, Section};
use super::source::Source;
use super::{CaseError, DEFAULT_GAMMA_F, MAX_ITERATIONS};
use crate::action::Form;
use crate::engine::{Accuracy, POINTS};
use crate::geometry::Start;
use crate::number::{Extended, Real};
use crate::sbp::SbpName;
use crate::solve::{Status, System};

/// `[grid]`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Grid {
    /// First value of γ.
    pub gamma_i: Quantity,
    /// Last value of γ, unless `t_f` is given.
    pub gamma_f: Option<Quantity>,
    /// The value of the coordinate t at which the run ends.
    pub t_f: Option<Quantity>,
    /// Number of nodes of each window.
    pub n_gamma: usize,
    /// Number of windows.
    pub windows: usize,
    /// A formula of positions and velocities: the run ends where it changes its sign, if that is before the end.
    pub until: Option<String>,
}

/// `[scheme]`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Scheme {
    /// The SBP operator.
    pub sbp: SbpName,
    /// The form of the action.
    pub form: Form,
    /// True if the action has the regularised operator D̄ or, to show what that is for, D.
    pub regularised: bool,
}

/// `[solver]`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Solver {
    /// The system that is solved.
    pub system: System,
    /// Significant decimal digits of the results.
    pub digits: u32,
    /// Largest number of iterations in a window.
    pub max_iterations: usize,
    /// The accuracy of the run for which operator and windows are chosen.
    pub accuracy: Option<Quantity>,
    /// The tolerance of each window for which they are chosen. At most one of the two is given.
    pub tolerance: Option<Quantity>,
    /// Sizes of coordinates, by their index, below which either of them is absolute.
    pub floor: Vec<(usize, Quantity)>,
    /// True if small changes of the start are carried along the run.
    pub sensitivity: bool,
}

impl Solver {
    /// True if the program chooses operator and windows.
    pub fn chooses_windows(&self) -> bool {
        self.chosen_by().is_some()
    }

    /// The accuracy that it chooses them for; `value` gives the value of a number.
    pub(super) fn wanted(&self, value: impl Fn(&Quantity) -> f64) -> Option<Accuracy> {
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
    pub gamma_final: Option<Quantity>,
    /// Coordinates, by their index, at the last node.
    pub finals: Vec<(usize, Quantity)>,
    /// Largest absolute difference allowed in all of these.
    pub tolerance: Option<Quantity>,
}

/// The parts of a case that its settings are checked against.
pub(super) struct Context<'c> {
    /// γ at the start, unless the case gives it.
    pub(super) gamma_i: String,
    pub(super) source: &'c Source,
    pub(super) names: &'c [String],
    pub(super) parameters: &'c [(String, String)],
    pub(super) formulas: &'c Formulas<'c>,
    pub(super) start: &'c Start,
}

impl Context<'_> {
    /// A number, checked, as it is written and as it is.
    fn number(&self, field: Option<&Field<'_>>, default: &str) -> Result<(Quantity, f64), CaseError> {
        let quantity = field.map_or_else(|| Ok(Quantity::new(default)), Field::quantity)?;
        check_number(&quantity, field, self.parameters)?;
        let value = quantity.value(self.parameters).unwrap_or(f64::NAN);
        Ok((quantity, value))
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
            let message = "regularised = false is not possible with form = \"weak\"";
            return Err(field.error(message).with_help(help.to_owned()));
        }
        if solver.system != System::Doubled {
            let help = "the physical limit exists only for the regularised operator";
            let message = "regularised = false needs solver.system = \"doubled\"";
            return Err(field.error(message).with_help(help.to_owned()));
        }
    }
    if solver.chooses_windows() {
        return Ok(CHOSEN);
    }
    let sbp = name.ok_or_else(|| {
        let help = "give scheme.sbp, for example \"GLL16\", and, unless it is a spectral element, grid.n_gamma";
        section.error("missing field `sbp`").with_help(help.to_owned())
    })?;
    Ok(Scheme { sbp, form, regularised: is_regularised })
}

/// Reads `[solver]`, but for `solver.floor`, which needs the coordinates.
pub(super) fn solver(mut section: Section<'_>) -> Result<(Solver, Section<'_>), CaseError> {
    let floor = section.section("floor")?;
    let (system, digits) = (section.take("system"), section.take("digits"));
    let [max_iterations, accuracy, tolerance, sensitivity] =
        ["max_iterations", "accuracy", "tolerance", "sensitivity"].map(|key| section.take(key));
    let needs = |field: &Option<Field<'_>>, message: &str, help: &str| match field {
        Some(field) => Err(field.error(message).with_help(help.to_owned())),
        None => Err(section.error(message).with_help(help.to_owned())),
    };
    if let (Some(_), Some(tolerance)) = (&accuracy, &tolerance) {
        return Err(tolerance.key_error(ACCURACY_AND_TOLERANCE).with_help(ONE_OF_THEM.to_owned()));
    }
    let name = if tolerance.is_some() { "tolerance" } else { "accuracy" };
    let is_chosen = accuracy.is_some() || tolerance.is_some();
    let [accuracy, tolerance] = [accuracy, tolerance].map(|field| field.map(|field| chosen(name, &field)).transpose());
    let (accuracy, tolerance) = (accuracy?, tolerance?);
    let system_field = system;
    let system = system_field.as_ref().map_or(Ok(System::default()), Field::word)?;
    if is_chosen && system != System::PhysicalLimit {
        let message = format!("solver.{name} needs system = \"physical-limit\"");
        return needs(&system_field, &message, "leave solver.system out");
    }
    let digits_field = digits;
    let digits = digits_field.as_ref().map_or(Ok(16), self::digits)?;
    if is_chosen && digits != 16 {
        return needs(&digits_field, &format!("solver.{name} and solver.digits exclude each other"), IN_F64);
    }
    let max_iterations = max_iterations.as_ref().map_or(Ok(MAX_ITERATIONS), at_least_one)?;
    let sensitivity_field = sensitivity;
    let sensitivity = sensitivity_field.as_ref().map_or(Ok(false), Field::is_true)?;
    if sensitivity && !is_chosen {
        return needs(&sensitivity_field, SENSITIVITY, CARRIED_ON_WINDOWS);
    }
    let solver = Solver { system, digits, max_iterations, accuracy, tolerance, floor: Vec::new(), sensitivity };
    Ok((solver, floor))
}

/// Reads `solver.floor`.
pub(super) fn floor(
    section: &Section<'_>,
    solver: &Solver,
    context: &Context<'_>,
) -> Result<Vec<(usize, Quantity)>, CaseError> {
    if section.is_given() && !solver.chooses_windows() {
        let help = "give solver.accuracy or solver.tolerance, which are relative to the sizes of coordinates";
        return Err(section.error("a floor needs an accuracy").with_help(help.to_owned()));
    }
    let read = |field: Field<'_>| {
        let a = names::index(&field, context.names)?;
        let (quantity, value) = context.number(Some(&field), "0")?;
        if value <= 0.0 {
            return Err(field.error(format!("a size must be positive, got {value}")));
        }
        Ok((a, quantity))
    };
    section.fields().into_iter().map(read).collect()
}

/// A number of digits that an arithmetic has.
pub(super) fn digits(field: &Field<'_>) -> Result<u32, CaseError> {
    let (least, most) = (f64::MOST_DIGITS, Extended::MOST_DIGITS);
    let digits = u32::try_from(field.whole()?).unwrap_or(u32::MAX);
    if (least..=most).contains(&digits) {
        return Ok(digits);
    }
    let help = "16 is double precision; more makes every number of the result exact to that many digits";
    let message = format!("digits must be from {least} to {most}, got {digits}");
    Err(field.error(message).with_help(help.to_owned()))
}

/// A whole number that is not 0.
pub(super) fn at_least_one(field: &Field<'_>) -> Result<usize, CaseError> {
    match field.whole()? {
        0 => Err(field.error(format!("{} must be at least 1", field.key))),
        count => Ok(count),
    }
}

/// An accuracy or a tolerance between 0 and 1.
pub(super) fn chosen(name: &str, field: &Field<'_>) -> Result<Quantity, CaseError> {
    let number = Quantity::new(field.number()?);
    let value = number.value(&[]).unwrap_or(f64::NAN);
    if value > 0.0 && value < 1.0 {
        return Ok(number);
    }
    let message = format!("{name} must lie between 0 and 1, got {value}");
    Err(field.error(message).with_help("for example 1e-10".to_owned()))
}

/// The number of nodes and of windows; with an accuracy there is no operator, and neither may be given.
fn nodes(
    section: &Section<'_>,
    sbp: Result<SbpName, &str>,
    n_gamma: &Option<Field<'_>>,
    windows: &Option<Field<'_>>,
) -> Result<(usize, usize), CaseError> {
    let sbp = match sbp {
        Ok(sbp) => sbp,
        Err(chosen) => {
            for (name, field) in [("n_gamma", n_gamma), ("windows", windows)] {
                if let Some(field) = field {
                    let message = format!("both solver.{chosen} and grid.{name} are given");
                    return Err(field.key_error(&message).with_help(CHOSEN_WINDOWS.to_owned()));
                }
            }
            return Ok((POINTS, 1));
        }
    };
    let n_gamma = n_gamma.as_ref().map(Field::whole).transpose()?.or(sbp.fixed_points());
    let n_gamma = n_gamma.ok_or_else(|| section.error("missing field `n_gamma`"))?;
    Ok((n_gamma, windows.as_ref().map_or(Ok(1), at_least_one)?))
}

/// Reads `[grid]`; `sbp` is the operator, or the key for which the program is to choose one.
pub(super) fn grid(
    mut section: Section<'_>,
    sbp: Result<SbpName, &str>,
    context: &Context<'_>,
) -> Result<Grid, CaseError> {
    let [gamma_i, gamma_f, t_f] = ["gamma_i", "gamma_f", "t_f"].map(|key| section.take(key));
    let [n_gamma, windows, until] = ["n_gamma", "windows", "until"].map(|key| section.take(key));
    if let (Some(_), Some(t_f)) = (&gamma_f, &t_f) {
        let help = "keep exactly one of grid.gamma_f and grid.t_f".to_owned();
        return Err(t_f.key_error("both gamma_f and t_f are given").with_help(help));
    }
    let (n_gamma, windows) = nodes(&section, sbp, &n_gamma, &windows)?;
    check_nodes(sbp.ok(), n_gamma, windows).map_err(|invalid| context.source.invalid(invalid))?;
    let intervals = (n_gamma.max(2) - 1) * windows;
    let (gamma_i, first) = context.number(gamma_i.as_ref(), &context.gamma_i)?;
    let spaced = |path: &str, length: f64| {
        check_spacing(path, first, intervals, length).map_err(|invalid| context.source.invalid(invalid))
    };
    let mut grid = Grid { gamma_i, gamma_f: None, t_f: None, n_gamma, windows, until: None };
    match t_f {
        Some(field) => {
            let (t_f, duration, rate) = end_time(&field, context)?;
            spaced("grid.t_f", duration / rate)?;
            grid.t_f = Some(t_f);
        }
        None => {
            let (quantity, last) = context.number(gamma_f.as_ref(), &DEFAULT_GAMMA_F.to_string())?;
            if last == first {
                let message = format!("gamma_f = {last} must be another value than gamma_i = {first}");
                let error =
                    gamma_f.map_or_else(|| section.error(message.clone()), |field| field.error(message.clone()));
                return Err(error.with_help("gamma_f is 1 if it is not given".to_owned()));
            }
            spaced("grid.gamma_f", (last - first).abs())?;
            grid.gamma_f = Some(quantity);
        }
    }
    grid.until = until.map(|field| context.formulas.of_velocities(&field)).transpose()?;
    Ok(grid)
}

/// t_f, the time from the start to it, and dt/dγ.
fn end_time(field: &Field<'_>, context: &Context<'_>) -> Result<(Quantity, f64, f64), CaseError> {
    let Some(t) = context.names.iter().position(|name| name == "t") else {
        let help = "end at grid.gamma_f, or at grid.until".to_owned();
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
    let (status, gamma_final) = (section.take("status"), section.take("gamma_final"));
    let finals: Vec<_> = context.names.iter().map(|name| section.take(&format!("{name}_final"))).collect();
    let tolerance = section.take("tolerance");
    section.finish()?;
    if !section.is_given() {
        return Ok(None);
    }
    let ends = status.as_ref().map_or(Ok(Status::Converged), Field::word)?;
    let mut numbers = Vec::new();
    for (a, field) in finals.iter().enumerate().filter_map(|(a, field)| Some((a, field.as_ref()?))) {
        numbers.push((a, context.number(Some(field), "0")?.0));
    }
    let gamma_final = gamma_final.map(|field| context.number(Some(&field), "0")).transpose()?.map(|(gamma, _)| gamma);
    let has_numbers = !numbers.is_empty() || gamma_final.is_some();
    if let Some(status) = status.filter(|_| ends != Status::Converged && has_numbers) {
        return Err(status.error(format!("a case that ends {ends} has no final coordinates")));
    }
    let tolerance = match tolerance {
        Some(field) => {
            let (quantity, value) = context.number(Some(&field), "0")?;
            if value <= 0.0 {
                return Err(field.error(format!("tolerance must be positive, got {value}")));
            }
            Some(quantity)
        }
        None if has_numbers => return Err(section.error("final coordinates need a tolerance")),
        None => None,
    };
    Ok(Some(Expect { status: ends, gamma_final, finals: numbers, tolerance }))
}
