//! The classical Runge–Kutta method of order 4.

use super::driver::{Counted, EqualSteps, Walker, equal_steps};
use super::force::Force;
use super::{About, Failure, Output, Peer, Problem, Setting, State, Step, Trajectory};

/// The classical Runge–Kutta method; between the ends of its steps the cubics that fit states and derivatives there.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Rk4;

impl Peer for Rk4 {
    fn about(&self) -> About {
        About {
            name: "RK4".to_owned(),
            curve: "RK4",
            order: Some(4),
            step: Step::Constant,
            has_dense_output: true,
            coarsest: 1.0,
            source: "Kutta, Z. Math. Phys. 46 (1901) 435",
        }
    }

    fn run(&self, problem: &Problem, output: &Output, setting: Setting) -> Result<Trajectory, Failure> {
        let (h, here) = (problem.length / setting.count as f64, problem.start());
        equal_steps(problem, output, setting.count, Walk { h, here, from: here, first: (0.0, 0.0), next: None })
    }
}

struct Walk {
    h: f64,
    here: State,
    /// Where the last step began, and u and a there.
    from: State,
    first: (f64, f64),
    /// u and a where it ended, if they are known: the first stage of the next step.
    next: Option<(f64, f64)>,
}

/// The cubic on [0, 1] with the values `v` and the derivatives `d` at its ends.
#[inline(always)]
fn cubic(s: f64, v: [f64; 2], d: [f64; 2]) -> f64 {
    let rise = v[1] - v[0];
    v[0] + s * (rise + (1.0 - s) * ((1.0 - s) * (d[0] - rise) + s * (rise - d[1])))
}

impl Walker for Walk {
    #[inline(always)]
    fn state(&self) -> State {
        self.here
    }

    #[inline(always)]
    fn inside<F: Force>(&mut self, force: &mut Counted<F>, fractions: &[f64], states: &mut Vec<State>) {
        let (h, from, to, (u1, a1)) = (self.h, self.from, self.here, self.first);
        let (u, a) = force.at(to.x);
        self.next = Some((u, a));
        states.extend(fractions.iter().map(
            #[inline(always)]
            |&s| State {
                elapsed: cubic(s, [from.elapsed, to.elapsed], [h * u1, h * u]),
                x: cubic(s, [from.x, to.x], [h * from.w, h * to.w]),
                w: cubic(s, [from.w, to.w], [h * a1, h * a]),
            },
        ));
    }
}

impl EqualSteps for Walk {
    #[inline(always)]
    fn advance<F: Force>(&mut self, force: &mut Counted<F>, steps: usize) -> Result<(), Failure> {
        let h = self.h;
        for _ in 0..steps {
            let State { elapsed: t, x, w } = self.here;
            let (u1, a1) = match self.next.take() {
                Some(known) => known,
                None => force.at(x),
            };
            let w2 = w + 0.5 * h * a1;
            let (u2, a2) = force.at(x + 0.5 * h * w);
            let w3 = w + 0.5 * h * a2;
            let (u3, a3) = force.at(x + 0.5 * h * w2);
            let w4 = w + h * a3;
            let (u4, a4) = force.at(x + h * w3);
            (self.from, self.first) = (self.here, (u1, a1));
            self.here = State {
                elapsed: t + h / 6.0 * ((u1 + u4) + 2.0 * (u2 + u3)),
                x: x + h / 6.0 * ((w + w4) + 2.0 * (w2 + w3)),
                w: w + h / 6.0 * ((a1 + a4) + 2.0 * (a2 + a3)),
            };
        }
        Ok(())
    }
}
