//! The series of the reference trajectory as a method of its own.

use super::driver::Task;
use super::{Failure, Problem, States, Trajectory};
use crate::geometry::Start;
use crate::reference::{EndReason, ReferenceTrajectory};

/// The digits that a tolerance stands for, and the order that is cheapest for them.
pub(super) fn digits_and_order(tolerance: f64) -> (u32, usize) {
    let digits = (-tolerance.log10()).round().max(1.0) as u32;
    (digits, (1.15 * f64::from(digits)).ceil() as usize + 2)
}

pub(super) fn run(Task { problem, output, setting }: &Task<'_>) -> Result<Trajectory, Failure> {
    let Problem { space, start, length, .. } = problem;
    let (digits, order) = digits_and_order(setting.tolerance);
    let trajectory = ReferenceTrajectory::unchecked(space, start, *length, order, digits);
    let trajectory = trajectory.map_err(|end| match end.reason {
        EndReason::OutsideDomain => Failure::OutsideDomain,
        EndReason::Singular | EndReason::TimeNotReached | EndReason::TooLong { .. } => Failure::TooManySteps,
    })?;
    let mut states = States::new(start.q.len(), output.marks.len());
    for gamma in output.gamma(*length) {
        let Start { q, p, .. } = trajectory.at(gamma);
        if !q.iter().chain(&p).all(|value| value.is_finite()) {
            return Err(Failure::Diverged);
        }
        states.push(&q, &p);
    }
    let steps = trajectory.steps();
    Ok(Trajectory { states, evaluations: steps * order, steps })
}
