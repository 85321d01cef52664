//! The series of the reference trajectory as a method of its own.

use super::{About, Failure, Output, Peer, Problem, Setting, States, Step, Trajectory};
use crate::geometry::Start;
use crate::reference::{EndReason, ReferenceTrajectory};

/// The world-line in `f64` by series whose last terms are below the first by the tolerance, at the order that is
/// cheapest for it, and by their polynomials between the ends of steps.
///
/// This is the program's reference, written for any number of digits and not for speed: heyoka, in
/// `scripts/work-precision.py`, shows what a Taylor method can achieve.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Taylor;

/// The digits that a tolerance stands for, and the order that is cheapest for them.
fn digits_and_order(tolerance: f64) -> (u32, usize) {
    let digits = (-tolerance.log10()).round().max(1.0) as u32;
    (digits, (1.15 * f64::from(digits)).ceil() as usize + 2)
}

impl Peer for Taylor {
    fn about(&self) -> About {
        About::new("Taylor", "Taylor", Step::Adaptive, "Jorba, Zou, Exp. Math. 14 (2005) 99")
    }

    fn label(&self, setting: Setting) -> String {
        let Setting { tolerance, .. } = setting;
        format!("order={} tol={tolerance:e}", digits_and_order(tolerance).1)
    }

    fn run(&self, problem: &Problem, output: &Output, setting: Setting) -> Result<Trajectory, Failure> {
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
}
