//! Why there is no critical point, in one coordinate and in scenes.

use std::fmt;

use super::accuracy::MOST_SWEEPS;
use super::narrow::{self, Reasons};
use super::newton::Failure;
use super::point::Point;
use super::status::{InitialGuess, Iterations, MOST_NODES, Status};
use crate::number::norm::rounded_up;

/// The reason why there is no critical point, and where the solve stood.
#[derive(Debug, Clone, PartialEq)]
pub struct NoSolution {
    /// Any status but [`Status::Converged`].
    pub status: Status,
    /// γ of the node where it failed: of the point outside the domain, otherwise of the largest residual entry.
    pub gamma: f64,
    /// The names of the active coordinates with their values there, where they are known. In one coordinate it is x.
    pub point: Vec<(String, f64)>,
    /// The metric there.
    pub domain: Domain,
    /// Largest residual entry at the last accepted iterate (infinite if none was accepted); the estimated error where
    /// an accuracy is not reached.
    pub residual: f64,
    /// The need of a run beyond a limit: nodes, or evaluations of the force. Where an accuracy is not reached, the
    /// one for which rounding leaves room. It is 0 for every other status.
    pub needed: f64,
    /// The accuracy that was asked for and is not reached; 0 for every other status.
    pub asked: f64,
    /// True if an accuracy was asked for, so that windows and operator were not the user's to choose.
    pub adaptive: bool,
    /// The reasons for which a run to an accuracy may have failed.
    pub reasons: Box<Reasons>,
    /// The iterations done.
    pub iterations: Box<Iterations>,
}

/// The number that says whether a point is inside the domain of a metric.
#[derive(Debug, Clone, PartialEq)]
pub enum Domain {
    /// In one coordinate g00, which must be positive.
    G00(f64),
    /// In one coordinate, where a number is beyond the range of numbers: g00 there.
    Overflow(f64),
    /// In a scene the determinant that has the wrong sign.
    Determinant {
        /// The names of the coordinates in its block of the metric.
        coordinates: Vec<String>,
        /// The determinant.
        value: f64,
    },
    /// In a scene, where no determinant has the wrong sign. Outside the domain another number is not finite.
    Scene,
}

/// A place where a solve can fail.
pub(super) struct At {
    pub(super) gamma: f64,
    pub(super) point: Vec<(String, f64)>,
    pub(super) domain: Domain,
}

impl At {
    /// A place in one coordinate.
    pub(super) fn x(gamma: f64, x: f64, g00: f64) -> Self {
        let domain = if g00 == f64::INFINITY { Domain::Overflow(g00) } else { Domain::G00(g00) };
        Self { gamma, point: vec![("x".to_owned(), x)], domain }
    }

    /// A place in one coordinate where a number, maybe another than g00, is not finite. Where g00 has no value, that is
    /// the reason.
    pub(super) fn overflow(gamma: f64, x: f64, g00: f64) -> Self {
        let at = Self::x(gamma, x, g00);
        if g00.is_nan() { at } else { Self { domain: Domain::Overflow(g00), ..at } }
    }

    /// A place in a scene.
    pub(super) fn scene(gamma: f64, point: Vec<(String, f64)>) -> Self {
        Self { gamma, point, domain: Domain::Scene }
    }
}

impl NoSolution {
    /// A failure that has nothing but a status and a place.
    pub(super) fn new(status: Status, At { gamma, point, domain }: At) -> Self {
        Self {
            status,
            gamma,
            point,
            domain,
            residual: f64::INFINITY,
            needed: 0.0,
            asked: 0.0,
            adaptive: false,
            reasons: Box::default(),
            iterations: Box::new(Iterations::from(InitialGuess::None)),
        }
    }

    /// A march that ended without a result.
    pub(super) fn marched(status: Status, at: At) -> Self {
        Self { iterations: Box::new(Iterations::from(InitialGuess::Extrapolation)), ..Self::new(status, at) }
    }

    /// A march to an accuracy that ended without a result.
    pub(super) fn adaptive(status: Status, at: At) -> Self {
        Self { adaptive: true, ..Self::marched(status, at) }
    }

    /// The same after so many evaluations of the force.
    pub(super) fn after(mut self, evaluations: usize) -> Self {
        self.iterations.count = evaluations;
        self
    }

    /// A failed iteration. `locate` finds its place from the point that left the domain, if that is why it failed, the
    /// largest entry of the residual, and the last iterate.
    pub(super) fn iterated<O>(
        failure: Failure<O>,
        initial_guess: InitialGuess,
        locate: impl FnOnce(Option<O>, Option<usize>, &[f64]) -> At,
    ) -> Self {
        let Failure { status, unknowns, residual, outside, history } = failure;
        let worst = (0..residual.len()).max_by(|&a, &b| residual[a].abs().total_cmp(&residual[b].abs()));
        let at = locate(outside.filter(|_| status == Status::OutsideDomain), worst, &unknowns);
        Self {
            residual: worst.map_or(f64::INFINITY, |index| residual[index].abs()),
            iterations: Box::new(Iterations::of(initial_guess, history)),
            ..Self::new(status, at)
        }
    }
}

/// Says what the pace of a run beyond the limit of evaluations means for it.
fn pace(needed: f64) -> String {
    if needed.is_finite() {
        format!("at this pace the run needs {needed:.1e} of them, above the limit of {MOST_SWEEPS:.0e}")
    } else {
        "the run makes no progress".to_owned()
    }
}

impl fmt::Display for NoSolution {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.message(f)?;
        match self.reasons.towards_zero.as_slice() {
            [] => Ok(()),
            names => write!(f, "; {} → 0, where the formulas have no value", names.join(", ")),
        }
    }
}

impl NoSolution {
    fn message(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { status, residual, needed, .. } = self;
        let count = self.iterations.count;
        let place = Point { gamma: self.gamma, point: &self.point };
        if let Some(event) = &self.reasons.event {
            return event.message(f, self, &place);
        }
        match (status, &self.domain) {
            (Status::OutsideDomain, Domain::G00(g00)) => {
                write!(f, "the geodesic leaves the domain at {place}: g00 = {g00:.3e} (iteration {count}")?;
                // Where the equations are explicit, or the first guess already leaves, there is no residual.
                if residual.is_finite() { write!(f, ", residual {residual:.2e})") } else { write!(f, ")") }
            }
            (Status::OutsideDomain, Domain::Overflow(_)) => {
                write!(f, "a number is beyond the range of numbers at {place}")
            }
            (Status::OutsideDomain, Domain::Determinant { coordinates, value }) => write!(
                f,
                "the geodesic leaves the domain at {place}: the determinant of the metric in ({}) is {value:.3e}",
                coordinates.join(", ")
            ),
            (Status::OutsideDomain, Domain::Scene) => {
                write!(f, "the geodesic leaves the domain at {place}: a number is not finite")
            }
            (Status::EndTimeNotReached, domain) => {
                let end = if matches!(domain, Domain::G00(_) | Domain::Overflow(_)) {
                    "the physical time t_f"
                } else {
                    "the end"
                };
                write!(f, "{end} is not reached: the search ended at {place}")
            }
            (Status::AccuracyNotReached, _) => {
                write!(
                    f,
                    "the accuracy {:e} is not reached: at {place} the error is estimated at {residual:.1e}, and \
                     rounding leaves room for {:.0e}",
                    self.asked,
                    rounded_up(*needed)
                )?;
                self.reasons.narrow.iter().try_for_each(|narrow| write!(f, "; {narrow}"))
            }
            (Status::EvaluationLimit, _) => {
                write!(f, "stopped after {count} evaluations of the force at {place}: {}", pace(*needed))
            }
            (Status::TooManyNodes, _) => write!(
                f,
                "stopped at {place}: the run would have {needed:.1e} nodes, above the limit of {MOST_NODES:.0e} that \
                 are kept in memory"
            ),
            _ if self.adaptive => {
                write!(f, "no critical point found ({status}): no window, however short, converges at {place}")
            }
            _ => write!(
                f,
                "no critical point found ({status}) after {count} iterations: largest residual {residual:.2e} at \
                 {place}"
            ),
        }
    }
}

impl std::error::Error for NoSolution {}

/// The remedy where g00 is NaN.
const V_IS_NO_NUMBER: &str = "V is not a number there, as a root, a logarithm or a fractional power of a negative \
                              number is none: write the formula so that V exists everywhere (abs(x)), or end the run \
                              before";

/// The remedy where a number is beyond the range of numbers.
const OVERFLOW: &str =
    "end the run before this gamma, or choose units in which t, x, V and their rates are nearer to 1";

/// A residual below this is rounding where units are of the order of 1.
const AT_ROUNDING: f64 = 1e-13;

impl NoSolution {
    /// Returns the remedy to try next.
    pub fn advice(&self) -> &'static str {
        if self.adaptive {
            return self.advice_to_an_accuracy();
        }
        match (self.status, &self.domain) {
            (Status::Converged, _) => "",
            (Status::MaxIterations | Status::Stalled, _) if self.residual < AT_ROUNDING => {
                "the residual is at the level of rounding, so more iterations would not help: the grid hardly \
                 determines the motion; raise n_gamma or windows, or give solver.accuracy in place of [scheme] and \
                 n_gamma"
            }
            (Status::OutsideDomain, Domain::G00(g00)) if g00.is_nan() => V_IS_NO_NUMBER,
            (Status::OutsideDomain, Domain::Overflow(_)) => OVERFLOW,
            (Status::OutsideDomain, Domain::G00(_)) => {
                "g00 = c^2 + 2V/m must stay positive: end the run before this gamma, choose initial data that stay \
                 away from the horizon, or raise c; if the potential is harmless there, the step is too coarse: raise \
                 n_gamma or windows"
            }
            (Status::OutsideDomain, _) => {
                "end the run before this gamma, choose initial data that stay away from the place, or coordinates in \
                 which the metric is regular there; if the geometry is harmless there, the step is too coarse: raise \
                 n_gamma or windows"
            }
            (Status::EndTimeNotReached, Domain::G00(_) | Domain::Overflow(_)) => {
                "raise n_gamma or windows, so that every turn of the motion is resolved, or give gamma_f or an \
                 earlier t_f"
            }
            (Status::EndTimeNotReached, _) => {
                "give gamma_f or an end that is reached earlier, or raise n_gamma or windows"
            }
            (Status::MaxIterations, _) => {
                "raise solver.max_iterations, or n_gamma or windows so that every turn of the motion is resolved"
            }
            (Status::PrecisionNotReached, _) => {
                "ask for fewer solver.digits; if f64 is in difficulties too (solver.digits = 16), raise n_gamma or \
                 windows so that every turn of the motion is resolved"
            }
            (Status::AccuracyNotReached | Status::EvaluationLimit | Status::TooManyNodes | Status::EventsPileUp, _) => {
                self.advice_to_an_accuracy()
            }
            (Status::Stalled | Status::Singular, _) => {
                "raise n_gamma or windows (or shorten gamma_f) so that every turn of the motion is resolved, or try \
                 another operator; far from 1, choose units nearer to it"
            }
        }
    }

    /// The same where the program chooses the windows: there is no n_gamma to raise.
    fn advice_to_an_accuracy(&self) -> &'static str {
        if !self.reasons.towards_zero.is_empty() {
            return "end the run before, at an earlier gamma or by grid.until: no motion follows from the formulas \
                    there";
        }
        if self.status == Status::AccuracyNotReached && self.reasons.narrow.is_some() {
            return narrow::ADVICE;
        }
        match (self.status, &self.domain) {
            (Status::Converged, _) => "",
            (Status::OutsideDomain, Domain::G00(g00)) if g00.is_nan() => V_IS_NO_NUMBER,
            (Status::OutsideDomain, Domain::Overflow(_)) => OVERFLOW,
            (Status::OutsideDomain, Domain::G00(_)) => {
                "g00 = c^2 + 2V/m must stay positive: end the run before this gamma, choose initial data that stay \
                 away from the horizon, or raise c"
            }
            (Status::OutsideDomain, _) if self.reasons.event.is_some() => "look at the formulas of its set there",
            (Status::OutsideDomain, _) => {
                "end the run before this gamma, choose initial data that stay away from the place, or coordinates in \
                 which the metric is regular there"
            }
            (Status::EventsPileUp, _) => {
                "end the run before, at an earlier gamma or by an event with until = true, where what remains of the \
                 motion counts as rest"
            }
            (Status::EndTimeNotReached, Domain::G00(_) | Domain::Overflow(_)) => {
                "give gamma_f or an earlier t_f: t hardly grows any more, or jumps over it"
            }
            (Status::EndTimeNotReached, _) => "give gamma_f or an end that is reached earlier",
            (Status::EvaluationLimit, Domain::G00(_) | Domain::Overflow(_)) => {
                "end the run before this gamma, or look at V there: it changes on a scale that windows cannot resolve"
            }
            (Status::TooManyNodes, Domain::G00(_) | Domain::Overflow(_)) => {
                "take samples in place of the tables (run --sample-t or --sample-gamma with --samples-only), or end \
                 the run earlier"
            }
            (Status::TooManyNodes, _) => "end the run earlier, or ask for a larger solver.accuracy",
            (Status::AccuracyNotReached, _) => {
                "ask for a larger solver.accuracy, or a shorter run; solver.tolerance in its place goes to the end, \
                 and says until where positions are good"
            }
            (Status::PrecisionNotReached, _) => "ask for fewer digits, or a shorter run",
            (Status::MaxIterations | Status::Stalled | Status::Singular, Domain::G00(_) | Domain::Overflow(_)) => {
                "end the run before this gamma, or look at V there: it is not smooth enough for an accuracy; far from \
                 1, choose units nearer to it"
            }
            (Status::EvaluationLimit | Status::MaxIterations | Status::Stalled | Status::Singular, _) => {
                "end the run before this gamma, or look at the scene there: it is not smooth enough for an accuracy, \
                 or a jump of a force holds it, as friction does (an event with until ends the run at rest); far from \
                 1, choose units nearer to it"
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_say_what_would_be_needed_in_scenes_too() {
        let places = [At::x(1.0, 2.0, 3.0), At::scene(1.0, vec![("r".to_owned(), 2.0)])];
        for (at, name) in places.into_iter().zip(["x", "r"]) {
            let adaptive = NoSolution::adaptive(Status::TooManyNodes, at).after(7);
            let at = |status, needed| NoSolution { status, needed, ..adaptive.clone() }.to_string();
            let place = format!("at gamma = 1.000000, {name} = 2.000000: ");
            let nodes = format!("stopped {place}the run would have 6.0e7 nodes, above the limit of 5e7 that");
            assert!(at(Status::TooManyNodes, 6e7).starts_with(&nodes), "{}", at(Status::TooManyNodes, 6e7));
            let pace = format!("evaluations of the force {place}at this pace the run needs 2.0e12 of them, above");
            assert!(at(Status::EvaluationLimit, 2e12).contains(&pace), "{}", at(Status::EvaluationLimit, 2e12));
            let stuck = at(Status::EvaluationLimit, f64::INFINITY);
            assert!(stuck.ends_with("the run makes no progress"), "{stuck}");
        }
    }

    /// An overflow is no matter of the sign of g00.
    #[test]
    fn an_overflow_is_said_to_be_one() {
        for at in [At::overflow(1.0, 2.0, 3.0), At::x(1.0, 2.0, f64::INFINITY)] {
            let failure = NoSolution::new(Status::OutsideDomain, at);
            assert_eq!(
                failure.to_string(),
                "a number is beyond the range of numbers at gamma = 1.000000, x = 2.000000"
            );
            for adaptive in [false, true] {
                let advice = NoSolution { adaptive, ..failure.clone() }.advice();
                assert!(advice.contains("units") && !advice.contains("g00"), "{advice}");
            }
        }
        let at = At::overflow(1.0, 2.0, f64::NAN);
        assert_eq!(NoSolution::new(Status::OutsideDomain, at).advice(), V_IS_NO_NUMBER);
    }

    #[test]
    fn advice_is_that_of_the_kind_of_run() {
        let places = [At::x(1.0, 2.0, 3.0), At::scene(1.0, Vec::new())];
        let [one, scene] = places.map(|at| NoSolution::new(Status::OutsideDomain, at));
        for status in [Status::OutsideDomain, Status::EndTimeNotReached, Status::TooManyNodes] {
            let advice = |failure: &NoSolution, adaptive| NoSolution { status, adaptive, ..failure.clone() }.advice();
            for adaptive in [false, true] {
                assert_ne!(advice(&one, adaptive), advice(&scene, adaptive), "{status}");
                assert!(!["g00", "t_f"].iter().any(|word| advice(&scene, true).contains(word)), "{status}");
            }
        }
        let at_rounding = NoSolution { status: Status::Stalled, residual: 1e-15, ..scene };
        assert!(at_rounding.advice().contains("at the level of rounding"));
    }
}
