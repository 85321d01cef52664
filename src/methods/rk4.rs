//! The classical Runge–Kutta method of order 4.

use super::force::{Force, WithForce, dispatch};
use super::{Failure, Output, Problem, State, Trajectory, walk};

/// The world-line with so many steps in each interval of `output`.
///
/// # Errors
/// [`Failure`].
pub fn rk4(problem: &Problem, output: &Output, steps: usize) -> Result<Trajectory, Failure> {
    dispatch(&problem.metric, problem.q_t(), March { problem, output, steps })
}

struct March<'a> {
    problem: &'a Problem,
    output: &'a Output,
    steps: usize,
}

impl WithForce for March<'_> {
    type Output = Result<Trajectory, Failure>;

    #[inline(always)]
    fn with(self, mut force: impl Force) -> Self::Output {
        let Self { problem, output, steps } = self;
        let h = problem.length / (output.intervals * steps) as f64;
        let State { elapsed: mut t, mut x, mut w } = problem.start();
        let mut done = 0;
        let states = walk(
            problem,
            output,
            #[inline(always)]
            |parts| {
                for _ in 0..parts * steps {
                    let (u1, a1) = force.at(x);
                    let w2 = w + 0.5 * h * a1;
                    let (u2, a2) = force.at(x + 0.5 * h * w);
                    let w3 = w + 0.5 * h * a2;
                    let (u3, a3) = force.at(x + 0.5 * h * w2);
                    let w4 = w + h * a3;
                    let (u4, a4) = force.at(x + h * w3);
                    x += h / 6.0 * ((w + w4) + 2.0 * (w2 + w3));
                    w += h / 6.0 * ((a1 + a4) + 2.0 * (a2 + a3));
                    t += h / 6.0 * ((u1 + u4) + 2.0 * (u2 + u3));
                }
                done += parts * steps;
                Ok(State { elapsed: t, x, w })
            },
        )?;
        Ok(Trajectory { states, evaluations: 4 * done, steps: done })
    }
}
