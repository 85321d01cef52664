//! Where a formula of the state first changes its sign, roughly: Runge–Kutta steps on Hamilton's equations.

use super::setup::SceneSetup;
use crate::geometry::{Geometry, Observable, OutsideGeometry, Rates};
use crate::scalar::Real;

/// Steps for each interval between two nodes.
const STEPS: usize = 8;

/// q^a of all coordinates, then p_a of all.
struct Flow<'g> {
    geometry: &'g Geometry,
    rates: Rates<f64>,
    k: f64,
}

impl Flow<'_> {
    fn slope(&mut self, state: &[f64], out: &mut [f64]) -> Result<(), OutsideGeometry> {
        let n = self.geometry.dimension();
        let field = self.geometry.field();
        field.evaluate(&state[..n], &state[n..], &mut self.rates)?;
        (0..n).for_each(|a| out[a] = field.q_dot(&self.rates, a));
        out[n..].fill(0.0);
        for (place, &a) in field.active().iter().enumerate() {
            out[n + a] = field.p_dot(&self.rates, place);
        }
        Ok(())
    }

    fn value(&mut self, formula: &mut Observable, state: &[f64]) -> Result<f64, OutsideGeometry> {
        let n = self.geometry.dimension();
        let mut slope = vec![0.0; 2 * n];
        self.slope(state, &mut slope)?;
        Ok(formula.at(&state[..n], &slope[..n], &state[n..], self.k))
    }

    fn step(&mut self, state: &mut [f64], h: f64) -> Result<(), OutsideGeometry> {
        let mut sum = vec![0.0; state.len()];
        let (mut slope, mut trial) = (sum.clone(), state.to_vec());
        for (share, weight) in [(0.5, 1.0), (0.5, 2.0), (1.0, 2.0), (0.0, 1.0)] {
            self.slope(&trial, &mut slope)?;
            for (field, trial) in trial.iter_mut().enumerate() {
                sum[field] += weight * slope[field];
                *trial = state[field] + share * h * slope[field];
            }
        }
        state.iter_mut().zip(sum).for_each(|(state, sum)| *state += h / 6.0 * sum);
        Ok(())
    }
}

/// The flow and its start.
fn begin<S: Real>(setup: &SceneSetup<S>) -> (Flow<'_>, Vec<f64>) {
    let (geometry, start) = (&*setup.rough.geometry, &setup.rough.start);
    let k = geometry.norm(&start.q, &start.q_dot);
    let state = start.q.iter().chain(&start.p).copied().collect();
    (Flow { geometry, rates: geometry.field().room(), k }, state)
}

/// The sign of the formula on the way to its first change of sign; a formula that is zero at the start takes that of the
/// first step.
pub(super) fn side_before<S: Real>(setup: &SceneSetup<S>, formula: &Observable) -> f64 {
    let ((mut flow, mut state), mut formula) = (begin(setup), formula.clone());
    let sign = |value: f64| if value == 0.0 { None } else { Some(value.signum()) };
    let here = flow.value(&mut formula, &state).ok().and_then(sign);
    here.or_else(|| {
        let size = state.iter().fold(1e-9, |size: f64, value| size.max(1e-6 * value.abs()));
        flow.step(&mut state, size).ok()?;
        flow.value(&mut formula, &state).ok().and_then(sign)
    })
    .unwrap_or(1.0)
}

/// γ − γ_i of the first change of sign within `length`; `None` if there is none, or the flow ends before it.
pub(super) fn first<S: Real>(setup: &SceneSetup<S>, formula: &Observable, length: f64) -> Option<f64> {
    let side = side_before(setup, formula);
    let ((mut flow, mut state), mut formula) = (begin(setup), formula.clone());
    let steps = STEPS * (setup.n_gamma - 1) * setup.windows;
    let h = length / steps as f64;
    let mut before = flow.value(&mut formula, &state).ok()?;
    for k in 0..steps {
        flow.step(&mut state, h).ok()?;
        let here = flow.value(&mut formula, &state).ok()?;
        if here * side < 0.0 {
            return Some(h * (k as f64 + before / (before - here)));
        }
        before = here;
    }
    None
}
