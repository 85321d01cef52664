//! The remedy to try next where there is no critical point.

use super::failure::{Domain, NoSolution};
use super::status::Status;

/// The remedy where windows are shortest at one place.
const NARROW: &str = concat!(
    "a close encounter or a collision: conformal = a formula that grows there as the force does, such as a sum of ",
    "1/distance, makes windows even and loses fewer digits; after a collision there is no motion; at a pole, choose ",
    "coordinates without one (the preset kerr-schild has none); or ask for a larger solver.accuracy, or for ",
    "solver.tolerance in its place, which goes to the end",
);

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
        match (self.status, &self.domain) {
            (Status::Converged, _) => "",
            (Status::OutsideDomain, Domain::G00(g00)) if g00.is_nan() => V_IS_NO_NUMBER,
            (Status::OutsideDomain, Domain::Overflow(_)) => OVERFLOW,
            _ if self.adaptive => self.advice_to_an_accuracy(),
            (Status::MaxIterations | Status::Stalled, _) if self.residual < AT_ROUNDING => {
                "the residual is at the level of rounding, so more iterations would not help: the grid hardly \
                 determines the motion; raise n_gamma or windows, or give solver.accuracy in place of [scheme] and \
                 n_gamma"
            }
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
            return NARROW;
        }
        match (self.status, &self.domain) {
            (Status::Converged, _) => "",
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
    use crate::solve::failure::At;

    /// An overflow is no matter of the sign of g00.
    #[test]
    fn an_overflow_is_said_to_be_one() {
        for at in [At::x(1.0, 2.0, 3.0).overflowing(), At::x(1.0, 2.0, f64::INFINITY)] {
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
        let at = At::x(1.0, 2.0, f64::NAN).overflowing();
        assert_eq!(NoSolution::new(Status::OutsideDomain, at).advice(), V_IS_NO_NUMBER);
    }

    #[test]
    fn advice_is_that_of_the_kind_of_run() {
        let places = [At::x(1.0, 2.0, 3.0), At { gamma: 1.0, point: Vec::new(), domain: Domain::Scene }];
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
