//! The series of the reference trajectory as a method of its own.

use super::{Failure, Output, Problem, State, Trajectory, check};
use crate::reference::{EndReason, ReferenceTrajectory};

/// The world-line in `f64` by series of `order` whose last terms are `digits` decimal digits below the first; the
/// cheapest order is about 1.15 · digits. The polynomials are stored and evaluated where output is wanted.
///
/// This is the program's reference, written for any number of digits and not for speed: heyoka, in
/// `scripts/work-precision.py`, shows what a Taylor method can achieve.
///
/// # Errors
/// [`Failure`].
pub fn taylor(problem: &Problem, output: &Output, order: usize, digits: u32) -> Result<Trajectory, Failure> {
    let Problem { metric, initial, length } = problem;
    let trajectory = ReferenceTrajectory::unchecked(metric, *initial, *length, order, digits);
    let trajectory = trajectory.map_err(|end| match end.reason {
        EndReason::OutsideDomain => Failure::OutsideDomain,
        EndReason::Singular | EndReason::TimeNotReached | EndReason::TooLong { .. } => Failure::TooManySteps,
    })?;
    let at = |gamma: f64| {
        let point = trajectory.at(gamma);
        let state = State { elapsed: point.elapsed, x: point.x, w: point.x_dot };
        check(metric, state).map(|()| state)
    };
    let states = output.gamma(*length).map(at).collect::<Result<_, _>>()?;
    let steps = trajectory.steps();
    Ok(Trajectory { states, evaluations: steps * order, steps })
}
