//! The classical Runge–Kutta method of order 4.

use super::driver::{EqualSteps, Method, Task, Walker, equal_steps};
use super::equations::{Equations, step};
use super::{Failure, Trajectory};

pub(super) struct Rk4;

impl Method for Rk4 {
    #[inline(always)]
    fn integrate<E: Equations>(&self, equations: E, task: &Task<'_>) -> Result<Trajectory, Failure> {
        let h = task.problem.length / task.setting.count as f64;
        let (here, zero) = (equations.start(), equations.rows(0.0));
        let stages = std::array::from_fn(|_| zero.clone());
        let walk = Walk { h, from: here.clone(), at: zero, here, stages, next: None };
        equal_steps(equations, task, walk)
    }
}

struct Walk<E: Equations> {
    h: f64,
    here: E::Rows<f64>,
    /// Where the last step began.
    from: E::Rows<f64>,
    /// Where a stage is.
    at: E::Rows<f64>,
    /// The derivatives at the stages of the last step.
    stages: [E::Rows<f64>; 4],
    /// The derivatives where it ended, if they are known: the first stage of the next step.
    next: Option<E::Rows<f64>>,
}

/// The cubic on [0, 1] with the values `v` and the derivatives `d` at its ends.
#[inline(always)]
fn cubic(s: f64, v: [f64; 2], d: [f64; 2]) -> f64 {
    let rise = v[1] - v[0];
    v[0] + s * (rise + (1.0 - s) * ((1.0 - s) * (d[0] - rise) + s * (rise - d[1])))
}

impl<E: Equations> Walker<E> for Walk<E> {
    #[inline(always)]
    fn state(&self) -> &E::Rows<f64> {
        &self.here
    }

    #[inline(always)]
    fn inside(&mut self, equations: &mut E, fractions: &[f64]) -> Vec<E::Rows<f64>> {
        let mut next = self.here.clone();
        equations.rates(&self.here, &mut next);
        let (h, from, to) = (self.h, self.from.as_ref(), self.here.as_ref());
        let (first, last) = (self.stages[0].as_ref(), next.as_ref());
        let at = |s: f64| {
            let mut state = self.here.clone();
            for (k, state) in state.as_mut().iter_mut().enumerate() {
                *state = cubic(s, [from[k], to[k]], [h * first[k], h * last[k]]);
            }
            state
        };
        let states = fractions.iter().map(|&s| at(s)).collect();
        self.next = Some(next);
        states
    }
}

impl<E: Equations> EqualSteps<E> for Walk<E> {
    #[inline(always)]
    fn advance(self, equations: &mut E, steps: usize) -> Result<Self, Failure> {
        let Self { h, mut here, mut from, mut at, stages: [mut k1, mut k2, mut k3, mut k4], mut next } = self;
        for _ in 0..steps {
            match next.take() {
                Some(known) => k1 = known,
                None => equations.rates(&here, &mut k1),
            }
            step(&mut at, &here, 0.5 * h, &k1);
            equations.rates(&at, &mut k2);
            // The result would not be finite either. The branch also keeps the compiler from computing the stages on
            // both sides of it as one pair, which would wait for each other: the first two do not.
            if !k2.as_ref().iter().all(|rate| rate.is_finite()) {
                return Err(Failure::Diverged);
            }
            step(&mut at, &here, 0.5 * h, &k2);
            equations.rates(&at, &mut k3);
            step(&mut at, &here, h, &k3);
            equations.rates(&at, &mut k4);
            from.clone_from(&here);
            let (k1, k2, k3, k4) = (k1.as_ref(), k2.as_ref(), k3.as_ref(), k4.as_ref());
            for (k, here) in here.as_mut().iter_mut().enumerate() {
                *here += h / 6.0 * ((k1[k] + k4[k]) + 2.0 * (k2[k] + k3[k]));
            }
        }
        Ok(Self { h, here, from, at, stages: [k1, k2, k3, k4], next })
    }
}
