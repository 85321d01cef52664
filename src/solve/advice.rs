//! The remedy to try next where there is no critical point.

use super::failure::{Domain, NoSolution};
use super::status::Status;

/// The remedy where windows are shortest at one place.
const NARROW: &str = concat!(
    "a close encounter or a collision: conformal = a formula that grows there as the force does, such as a sum of ",
    "1/distance, makes steps even and loses fewer digits; after a collision there is no motion; at a pole, choose ",
    "coordinates without one (the preset kerr-schild has none); or ask for a larger solver.accuracy, or for ",
    "solver.tolerance in its place, which goes to the end",
);

/// No unit makes a coordinate so small that a user means it.
const AS_NOTHING: f64 = 1e-100;

/// A residual below this is rounding where units are of the order of 1.
const AT_ROUNDING: f64 = 1e-13;

impl NoSolution {
    /// Returns the remedy to try next.
    pub fn advice(&self) -> &'static str {
        use Status::*;
        match self.status {
            Converged => "",
            _ if self.reasons.off_table.is_some() => {
                "end the run before, give the table more points, or outside = \"linear\": then the function goes on as \
                 its tangent"
            }
            OutsideDomain if matches!(self.domain, Domain::G00(g00) if g00.is_nan()) => {
                "V is not a number there, as a root, a logarithm or a fractional power of a negative number is none: \
                 write the formula so that V exists everywhere (abs(x)), or end the run before"
            }
            OutsideDomain if matches!(self.domain, Domain::Overflow(_)) => {
                "end the run before this gamma, or choose units in which t, x, V and their rates are nearer to 1"
            }
            AccuracyNotReached | EvaluationLimit | TooManyNodes | EventsPileUp | EventsRest => {
                self.advice_to_an_accuracy()
            }
            _ if self.adaptive => self.advice_to_an_accuracy(),
            _ => self.advice_on_a_grid(),
        }
    }

    /// True if a coordinate has begun to move, and is as good as 0 yet.
    fn begins_as_nothing(&self) -> bool {
        self.point.iter().any(|(_, value)| value.abs() < AS_NOTHING && *value != 0.0)
    }

    /// The remedy where the program chooses the windows, so that there is no n_gamma to raise.
    fn advice_to_an_accuracy(&self) -> &'static str {
        use Status::*;
        let (is_of_x, reasons) = (self.domain.is_of_x(), &self.reasons);
        match self.status {
            _ if reasons.lost.as_ref().is_some_and(|lost| lost.is_far) => {
                "count that coordinate from a value near its start, or ask for a larger accuracy"
            }
            _ if reasons.lost.is_some() => "write that formula so that nothing cancels, or ask for a larger accuracy",
            _ if !reasons.towards_zero.is_empty() => {
                "end the run before, at an earlier gamma or by grid.until: no motion follows from the formulas there"
            }
            AccuracyNotReached | Stalled if !reasons.of_rounding.is_empty() => {
                "where such motions grow, as from an unstable rest, no digit follows from the start: begin beside it, \
                 or end the run earlier; where they do not matter, solver.floor gives a size below which the accuracy \
                 of a coordinate is absolute"
            }
            OutsideDomain if is_of_x => {
                "g00 = c^2 + 2V/m must stay positive: end the run before this gamma, choose initial data that stay \
                 away from the horizon, or raise c"
            }
            OutsideDomain if reasons.event.is_some() => "look at the formulas of its set there",
            OutsideDomain => {
                "end the run before this gamma, choose initial data that stay away from the place, or coordinates in \
                 which the metric is regular there"
            }
            EndTimeNotReached if is_of_x => "give gamma_f or an earlier t_f: t hardly grows any more, or jumps over it",
            EndTimeNotReached => "give gamma_f or an end that is reached earlier",
            AccuracyNotReached | TooManyNodes | EvaluationLimit if self.begins_as_nothing() => {
                "what begins to move there, as by the tail of a pulse, is nothing to what it may grow to: solver.floor \
                 gives a size below which the accuracy of a coordinate is absolute"
            }
            AccuracyNotReached if reasons.narrow.is_some() => NARROW,
            AccuracyNotReached => {
                "ask for a larger solver.accuracy, or a shorter run; solver.tolerance in its place goes to the end, \
                 and says until where positions are good"
            }
            EventsPileUp | EventsRest => {
                "end the run before, at an earlier gamma or by an event with until = true, where what remains of the \
                 motion counts as rest"
            }
            TooManyNodes if is_of_x => {
                "take samples in place of the tables (run --sample-t or --sample-gamma with --samples-only), or end \
                 the run earlier"
            }
            TooManyNodes => "end the run earlier, or ask for a larger solver.accuracy",
            EvaluationLimit if is_of_x => {
                "end the run before this gamma, or look at V there: it changes on a scale that steps cannot resolve"
            }
            PrecisionNotReached => "ask for fewer digits, or a shorter run",
            _ if is_of_x => {
                "end the run before this gamma, or look at V there: it is not smooth enough for an accuracy; far from \
                 1, choose units nearer to it"
            }
            _ => {
                "end the run before this gamma, or look at the scene there: it is not smooth enough for an accuracy, \
                 or a jump of a force holds it, as friction does (an event with until ends the run at rest); far from \
                 1, choose units nearer to it"
            }
        }
    }

    /// The remedy where the case gives the grid.
    fn advice_on_a_grid(&self) -> &'static str {
        use Status::*;
        let is_of_x = self.domain.is_of_x();
        match self.status {
            MaxIterations | Stalled if self.residual < AT_ROUNDING => {
                "the residual is at the level of rounding, so more iterations would not help: the grid hardly \
                 determines the motion; raise n_gamma or windows, or give solver.accuracy in place of [scheme] and \
                 n_gamma"
            }
            OutsideDomain if is_of_x => {
                "g00 = c^2 + 2V/m must stay positive: end the run before this gamma, choose initial data that stay \
                 away from the horizon, or raise c; if the potential is harmless there, the step is too coarse: raise \
                 n_gamma or windows"
            }
            OutsideDomain => {
                "end the run before this gamma, choose initial data that stay away from the place, or coordinates in \
                 which the metric is regular there; if the geometry is harmless there, the step is too coarse: raise \
                 n_gamma or windows"
            }
            EndTimeNotReached if is_of_x => {
                "raise n_gamma or windows, so that every turn of the motion is resolved, or give gamma_f or an \
                 earlier t_f"
            }
            EndTimeNotReached => "give gamma_f or an end that is reached earlier, or raise n_gamma or windows",
            PrecisionNotReached => {
                "ask for fewer solver.digits; if f64 is in difficulties too (solver.digits = 16), raise n_gamma or \
                 windows so that every turn of the motion is resolved"
            }
            MaxIterations => {
                "raise solver.max_iterations, or n_gamma or windows so that every turn of the motion is resolved"
            }
            _ => {
                "raise n_gamma or windows (or shorten gamma_f) so that every turn of the motion is resolved, or try \
                 another operator; far from 1, choose units nearer to it"
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Geometry, GeometryText};

    /// An overflow is no matter of the sign of g00, and neither is a V that is no number.
    #[test]
    fn an_overflow_is_said_to_be_one() {
        let of_x = |expression| -> Geometry { Geometry::of_x(&GeometryText::of_x(expression, 1.0, 1.0)).unwrap() };
        for (adaptive, expression) in [false, true].into_iter().flat_map(|is| [(is, "1"), (is, "exp(1000*x)")]) {
            let failure = NoSolution { adaptive, ..NoSolution::overflow(&of_x(expression), 1.0, &[0.0, 2.0]) };
            let advice = failure.advice();
            assert_eq!(
                failure.to_string(),
                "a number is beyond the range of numbers at gamma = 1.000000, x = 2.000000"
            );
            assert!(advice.contains("units") && !advice.contains("g00"), "{advice}");
        }
        let failure = NoSolution::overflow(&of_x("ln(-x)"), 1.0, &[0.0, 2.0]);
        assert!(failure.advice().starts_with("V is not a number there"), "{failure}");
    }

    #[test]
    fn advice_speaks_of_what_the_case_has() {
        let free: Geometry = Geometry::of_x(&GeometryText::of_x("0", 1.0, 1.0)).unwrap();
        let advice = |status, adaptive, domain| {
            NoSolution { adaptive, domain, ..NoSolution::new(status, &free, 1.0, &[0.0, 2.0]) }.advice()
        };
        use Status::*;
        let stalled = |residual| NoSolution { residual, ..NoSolution::new(Stalled, &free, 1.0, &[0.0, 2.0]) }.advice();
        assert!(stalled(1e-14).contains("level of rounding") && !stalled(1e-3).contains("level of rounding"));
        for (status, adaptive) in [(OutsideDomain, false), (OutsideDomain, true), (EndTimeNotReached, false)]
            .into_iter()
            .chain([EndTimeNotReached, TooManyNodes, EvaluationLimit, Stalled].map(|status| (status, true)))
        {
            let [of_x, of_scene] = [Domain::G00(-1.0), Domain::Scene].map(|domain| advice(status, adaptive, domain));
            assert!(!["metric", "scene", "accuracy,"].iter().any(|word| of_x.contains(word)), "{status:?}: {of_x}");
            assert!(
                !["g00", "V", "t_f", "samples"].iter().any(|word| of_scene.contains(word)),
                "{status:?}: {of_scene}"
            );
            assert_ne!(of_x, of_scene, "{status:?}");
        }
    }
}
