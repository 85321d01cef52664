//! The classical Runge–Kutta method of order 4.

use super::force::{Force, WithForce, dispatch};
use super::{Failure, Marks, Output, Problem, State, Trajectory, check};

/// The world-line in so many `steps` of equal length, and between them on the cubics that fit states and derivatives at
/// their ends.
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

/// The cubic on [0, 1] with the values `v` and the derivatives `d` at its ends.
#[inline(always)]
fn cubic(s: f64, v: [f64; 2], d: [f64; 2]) -> f64 {
    let rise = v[1] - v[0];
    v[0] + s * (rise + (1.0 - s) * ((1.0 - s) * (d[0] - rise) + s * (rise - d[1])))
}

impl WithForce for March<'_> {
    type Output = Result<Trajectory, Failure>;

    #[inline(always)]
    fn with(self, mut force: impl Force) -> Self::Output {
        let Self { problem, output, steps } = self;
        let h = problem.length / steps as f64;
        let mut marks = Marks::new(output, steps);
        let mut states = Vec::with_capacity(output.marks.len());
        let State { elapsed: mut t, mut x, mut w } = problem.start();
        let (mut first, mut evaluations) = (None, 0);
        let last = Marks::last(output, steps);
        for step in 0..last {
            let (t0, x0, w0) = (t, x, w);
            let (u1, a1) = first.take().unwrap_or_else(
                #[inline(always)]
                || force.at(x),
            );
            let w2 = w + 0.5 * h * a1;
            let (u2, a2) = force.at(x + 0.5 * h * w);
            let w3 = w + 0.5 * h * a2;
            let (u3, a3) = force.at(x + 0.5 * h * w2);
            let w4 = w + h * a3;
            let (u4, a4) = force.at(x + h * w3);
            x += h / 6.0 * ((w + w4) + 2.0 * (w2 + w3));
            w += h / 6.0 * ((a1 + a4) + 2.0 * (a2 + a3));
            t += h / 6.0 * ((u1 + u4) + 2.0 * (u2 + u3));
            evaluations += 4;
            while let Some(fraction) = marks.within(step) {
                let mut state = State { elapsed: t, x, w };
                if fraction < 1.0 {
                    // It is the first stage of the next step; after the last step it is not used.
                    let (u, a) = *first.get_or_insert_with(
                        #[inline(always)]
                        || {
                            evaluations += usize::from(step + 1 == last);
                            force.at(x)
                        },
                    );
                    state = State {
                        elapsed: cubic(fraction, [t0, t], [h * u1, h * u]),
                        x: cubic(fraction, [x0, x], [h * w0, h * w]),
                        w: cubic(fraction, [w0, w], [h * a1, h * a]),
                    };
                }
                check(&problem.metric, state)?;
                states.push(state);
            }
        }
        Ok(Trajectory { states, evaluations, steps: last })
    }
}
