//! Checks that go beyond the types of TOML: ranges, finiteness, keys that exclude each other, the formula, the start.

use std::ops::Range;

use super::{Case, DEFAULT_GAMMA_F, Decimal, Form, PotentialSpec, SbpName, System};
use crate::formula::{is_identifier, is_reserved};
use crate::geometry::{Geometry, Start};
use crate::number::{Extended, Real};
use crate::solve::Status;

/// More nodes than this would exhaust the memory.
const MOST_POINTS: usize = 100_000_000;

/// A value that is not acceptable.
pub(super) struct Invalid {
    /// Dotted key.
    pub(super) path: String,
    /// The part of a string value that is wrong, as a range of bytes.
    pub(super) within: Option<Range<usize>>,
    pub(super) message: String,
    pub(super) help: Option<String>,
}

fn invalid(path: &str, message: impl Into<String>) -> Invalid {
    Invalid { path: path.to_owned(), within: None, message: message.into(), help: None }
}

impl Invalid {
    fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }
}

/// Messages on an accuracy or a tolerance.
pub(super) const ACCURACY_AND_TOLERANCE: &str = "both solver.accuracy and solver.tolerance are given";
pub(super) const ONE_OF_THEM: &str =
    "keep accuracy for an error of the whole run, or tolerance for a run that goes on whatever errors grow to";
pub(super) const CHOSEN_WINDOWS: &str =
    "the program chooses operator and windows itself: leave n_gamma and windows out";
pub(super) const IN_F64: &str = "windows are chosen in double precision; for more digits give scheme and grid";

impl Case {
    /// The case with its conditional defaults filled in, if everything about it is acceptable.
    pub(super) fn validated(mut self) -> Result<Self, Invalid> {
        if self.title.as_ref().is_some_and(|title| title.contains(char::is_control)) {
            return Err(invalid("title", "the title must be one line without control characters"));
        }
        self.check_finite()?;
        self.check_potential()?;
        self.check_choices()?;
        if self.grid.gamma_f.is_none() && self.grid.t_f.is_none() {
            self.grid.gamma_f = Some(Decimal::from(DEFAULT_GAMMA_F));
        }
        if !self.solver.chooses_windows() && self.grid.n_gamma == 0 {
            let nodes = self.scheme.sbp.fixed_points();
            self.grid.n_gamma = nodes.ok_or_else(|| invalid("grid", "missing field `n_gamma` (or it is 0)"))?;
        }
        self.check_grid()?;
        self.check_start()?;
        self.check_expectations()?;
        Ok(self)
    }

    fn check_finite(&mut self) -> Result<(), Invalid> {
        let mut numbers = self.numbers_mut().into_iter().map(|(path, number)| (path, number.value()));
        match numbers.find(|(_, value)| !value.is_finite()) {
            Some((path, value)) => Err(invalid(&path, format!("{path} must be a finite number, got {value}"))),
            None => Ok(()),
        }
    }

    fn check_potential(&self) -> Result<(), Invalid> {
        let PotentialSpec::Formula(spec) = &self.potential else { return Ok(()) };
        for name in spec.parameters.keys() {
            let path = format!("potential.formula.parameters.{name}");
            if name == "x" || is_reserved(name) {
                return Err(invalid(&path, format!("the parameter name '{name}' already has a meaning in a formula")));
            }
            if !is_identifier(name) {
                return Err(invalid(&path, format!("the parameter name '{name}' cannot be written in a formula"))
                    .help("a name is a letter or underscore, then letters, digits and underscores"));
            }
        }
        match spec.check() {
            Ok(()) => Ok(()),
            Err(error) => {
                let rest = &error.expression[error.offset..];
                let length = rest.chars().next().map_or(0, char::len_utf8);
                let names: Vec<&str> = spec.parameters.keys().map(String::as_str).collect();
                let parameters = if names.is_empty() { "none".to_owned() } else { names.join(", ") };
                Err(Invalid {
                    path: "potential.formula.expression".to_owned(),
                    within: Some(error.offset..error.offset + length),
                    message: format!("{} (character {} of the expression)", error.message, error.character()),
                    help: error.hint.or_else(|| {
                        Some(format!(
                            "known are x, pi, the parameters ({parameters}), + - * / ^, parentheses and sin cos tan \
                             sinh cosh tanh asin acos atan exp ln log10 sqrt abs"
                        ))
                    }),
                })
            }
        }
    }

    fn check_choices(&self) -> Result<(), Invalid> {
        match (&self.initial.x_dot, &self.initial.velocity) {
            (Some(_), Some(_)) => Err(invalid("initial.velocity", "both x_dot and velocity are given")
                .help("keep exactly one of initial.x_dot (dx/dgamma) and initial.velocity (dx/dt)")),
            (None, None) => Err(invalid("initial", "neither x_dot nor velocity is given")
                .help("give exactly one of initial.x_dot (dx/dgamma) and initial.velocity (dx/dt)")),
            _ => Ok(()),
        }?;
        if self.grid.gamma_f.is_some() && self.grid.t_f.is_some() {
            return Err(invalid("grid.t_f", "both gamma_f and t_f are given")
                .help("keep exactly one of grid.gamma_f and grid.t_f"));
        }
        if !self.scheme.regularised && self.scheme.form == Form::Weak {
            return Err(invalid("scheme.regularised", "regularised = false is not possible with form = \"weak\"")
                .help("the weak form is made of the regularised operator; the ablation is one of form = \"strong\""));
        }
        if !self.scheme.regularised && self.solver.system != System::Doubled {
            return Err(invalid("scheme.regularised", "regularised = false needs solver.system = \"doubled\"")
                .help("the physical limit exists only for the regularised operator"));
        }
        if self.grid.windows == 0 {
            return Err(invalid("grid.windows", "windows must be at least 1"));
        }
        check_digits(self.solver.digits)?;
        self.check_accuracy()?;
        if self.solver.max_iterations == 0 {
            return Err(invalid("solver.max_iterations", "max_iterations must be at least 1"));
        }
        Ok(())
    }

    /// With an accuracy or a tolerance the program chooses the whole scheme, so none of its keys may be given.
    fn check_accuracy(&self) -> Result<(), Invalid> {
        let (name, number) = match (&self.solver.accuracy, &self.solver.tolerance) {
            (None, None) => return Ok(()),
            (Some(number), None) => ("accuracy", number.value()),
            (None, Some(number)) => ("tolerance", number.value()),
            (Some(_), Some(_)) => {
                return Err(invalid("solver.tolerance", ACCURACY_AND_TOLERANCE).help(ONE_OF_THEM));
            }
        };
        if !(number > 0.0 && number < 1.0) {
            let message = format!("{name} must lie between 0 and 1, got {number}");
            return Err(invalid(&format!("solver.{name}"), message).help("for example 1e-10"));
        }
        let both = |path: &str, what: &str| {
            invalid(path, format!("both solver.{name} and {what} are given")).help(CHOSEN_WINDOWS)
        };
        if self.grid.n_gamma > 0 {
            return Err(both("grid.n_gamma", "grid.n_gamma"));
        }
        if self.grid.windows != 1 {
            return Err(both("grid.windows", "grid.windows"));
        }
        if self.solver.system != System::PhysicalLimit {
            return Err(invalid("solver.system", format!("solver.{name} needs system = \"physical-limit\"")));
        }
        if self.solver.digits != f64::MOST_DIGITS {
            let message = format!("solver.{name} and solver.digits exclude each other");
            return Err(invalid("solver.digits", message).help(IN_F64));
        }
        Ok(())
    }

    fn check_grid(&self) -> Result<(), Invalid> {
        let n_gamma = self.grid.n_gamma;
        let value = |number: &Option<Decimal>| number.as_ref().map(Decimal::value);
        let (gamma_i, gamma_f, t_f) = (self.grid.gamma_i.value(), value(&self.grid.gamma_f), value(&self.grid.t_f));
        let [t, t_dot] = [&self.initial.t, &self.initial.t_dot].map(Decimal::value);
        let sbp = self.scheme.sbp;
        let chosen = self.solver.chooses_windows();
        check_nodes((!chosen).then_some(sbp), n_gamma, self.grid.windows)?;
        if let Some(gamma_f) = gamma_f {
            if gamma_f <= gamma_i {
                let message = format!("gamma_f = {gamma_f} must be greater than gamma_i = {gamma_i}");
                return Err(invalid("grid.gamma_f", message).help("gamma_f is 1 if it is not given"));
            }
            self.check_spacing("grid.gamma_f", gamma_f - gamma_i)?;
        }
        if let Some(t_f) = t_f {
            if t_dot <= 0.0 {
                return Err(invalid("grid.t_f", "t_f needs t_dot > 0: otherwise t does not increase with gamma"));
            }
            if t_f <= t {
                let message = format!("t_f = {t_f} must be later than the initial t = {}", t);
                return Err(invalid("grid.t_f", message));
            }
            self.check_spacing("grid.t_f", (t_f - t) / t_dot)?;
        }
        Ok(())
    }

    fn check_spacing(&self, path: &str, length: f64) -> Result<(), Invalid> {
        let intervals = (self.grid.n_gamma.max(2) - 1) * self.grid.windows;
        check_spacing(path, self.grid.gamma_i.value(), intervals, length)
    }

    fn check_start(&self) -> Result<(), Invalid> {
        for (path, value) in [("particle.mass", &self.particle.mass), ("particle.c", &self.particle.c)] {
            if value.value() <= 0.0 {
                return Err(invalid(path, format!("{path} must be positive, got {value}")));
            }
        }
        let x = self.initial.x.value();
        let geometry: Option<Geometry> = self.compiled().ok();
        let [g00, slope] = geometry.as_ref().map_or([0.0; 2], |geometry| {
            let (samples, [g00, slope, _]) = (geometry.at(&[0.0, x]), geometry.sources_of_g00());
            [g00, slope].map(|source| samples.at(source, 0))
        });
        let is_inside = g00 > 0.0 && g00.is_finite() && slope.is_finite();
        let Some(geometry) = geometry.filter(|_| is_inside) else {
            let message = if g00 > 0.0 && g00.is_finite() {
                format!("V' is not finite at the start, x = {x:?}")
            } else {
                format!("g00 = c^2 + 2V/m must be positive and finite at the start, got g00({x:?}) = {g00:?}")
            };
            return Err(
                invalid("initial.x", message).help("choose another initial x, a weaker potential or a larger c")
            );
        };
        let Start { q, q_dot, p } = self.start_in(&geometry);
        if !q_dot[1].is_finite() {
            return Err(invalid("initial.velocity", "velocity * t_dot is not a finite number"));
        }
        if q_dot[0] == 0.0 && q_dot[1] == 0.0 {
            return Err(invalid("initial.t_dot", "t_dot and x_dot are both zero: the world-line would be a point"));
        }
        if !(p[0].is_finite() && geometry.norm(&q, &q_dot).is_finite()) {
            let message = "Q_t = g00 t_dot or K = g00 t_dot^2 - x_dot^2 overflows: choose units nearer to 1";
            return Err(invalid("initial.t_dot", message));
        }
        Ok(())
    }

    fn check_expectations(&self) -> Result<(), Invalid> {
        let Some(expect) = &self.expect else { return Ok(()) };
        let numbers = expect.t_final.is_some() || expect.x_final.is_some();
        if numbers && expect.status != Status::Converged {
            return Err(invalid(
                "expect.status",
                format!("a case that ends {} has no t_final or x_final", expect.status),
            ));
        }
        match expect.tolerance.as_ref().map(Decimal::value) {
            Some(tolerance) if tolerance <= 0.0 => {
                Err(invalid("expect.tolerance", format!("tolerance must be positive, got {tolerance}")))
            }
            None if numbers => Err(invalid("expect", "t_final and x_final need a tolerance")),
            _ => Ok(()),
        }
    }
}

/// Refuses a number of digits that no arithmetic has.
pub(super) fn check_digits(digits: u32) -> Result<(), Invalid> {
    let (least, most) = (f64::MOST_DIGITS, Extended::MOST_DIGITS);
    if (least..=most).contains(&digits) {
        return Ok(());
    }
    let message = format!("digits must be from {least} to {most}, got {digits}");
    Err(invalid("solver.digits", message)
        .help("16 is double precision; more makes every number of the result exact to that many digits"))
}

/// Refuses numbers of nodes that do not fit the operator (if it is given) or the memory.
pub(super) fn check_nodes(sbp: Option<SbpName>, n_gamma: usize, windows: usize) -> Result<(), Invalid> {
    if let Some(sbp) = sbp {
        if let Some(nodes) = sbp.fixed_points().filter(|&nodes| nodes != n_gamma) {
            let message = format!("{sbp} has {nodes} nodes, got n_gamma = {n_gamma}");
            return Err(invalid("grid.n_gamma", message)
                .help("leave n_gamma out, or choose the spectral element of that many nodes"));
        }
        if n_gamma < sbp.minimum_points() {
            let message = format!("{sbp} needs at least {} points, got n_gamma = {n_gamma}", sbp.minimum_points());
            return Err(invalid("grid.n_gamma", message));
        }
    }
    if n_gamma > MOST_POINTS {
        let message = format!("n_gamma = {n_gamma} is above the limit of {MOST_POINTS} points");
        return Err(invalid("grid.n_gamma", message));
    }
    if n_gamma.saturating_mul(windows) > MOST_POINTS {
        let message = format!("{windows} windows of {n_gamma} points are above the limit of {MOST_POINTS}");
        return Err(invalid("grid.windows", message));
    }
    Ok(())
}

/// Refuses nodes so close together, over a range of γ of this length, that rounding makes them equal, also when γ_i is
/// added to them.
pub(super) fn check_spacing(path: &str, gamma_i: f64, intervals: usize, length: f64) -> Result<(), Invalid> {
    let spacing = length / intervals as f64;
    let largest = gamma_i.abs().max((gamma_i + length).abs());
    if spacing.is_finite() && spacing >= f64::MIN_POSITIVE && spacing > 4.0 * f64::EPSILON * largest {
        return Ok(());
    }
    let message = format!("the spacing {spacing:e} is too small or too large to tell neighbouring nodes apart");
    Err(invalid(path, message).help("shift gamma_i towards 0, or take fewer points or windows"))
}
