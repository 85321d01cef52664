//! Where a formula of the state first changes its sign, roughly: Runge–Kutta steps on Hamilton's equations.

use super::explicit::runge_kutta;
use super::setup::SceneSetup;
use crate::geometry::{Geometry, Observable, OutsideGeometry, Rates};
use crate::scalar::Real;

/// Steps for each interval between two nodes.
const STEPS: usize = 8;

/// q^a of all coordinates, then p_a of all, on the way.
struct Flow<'g> {
    geometry: &'g Geometry,
    rates: Rates<f64>,
    state: Vec<f64>,
    slopes: [Vec<f64>; 4],
    k: f64,
}

/// The rates of a state.
fn slope(geometry: &Geometry, state: &[f64], rates: &mut Rates<f64>, out: &mut [f64]) -> Result<(), OutsideGeometry> {
    let (n, field) = (geometry.dimension(), geometry.field());
    field.evaluate(&state[..n], &state[n..], rates)?;
    (0..n).for_each(|a| out[a] = field.q_dot(rates, a));
    out[n..].fill(0.0);
    for (place, &a) in field.active().iter().enumerate() {
        out[n + a] = field.p_dot(rates, place);
    }
    Ok(())
}

impl Flow<'_> {
    fn value(&mut self, formula: &mut Observable) -> Result<f64, OutsideGeometry> {
        let n = self.geometry.dimension();
        slope(self.geometry, &self.state, &mut self.rates, &mut self.slopes[0])?;
        Ok(formula.at(&self.state[..n], &self.slopes[0][..n], &self.state[n..], self.k))
    }

    fn step(&mut self, h: f64) -> Result<(), OutsideGeometry> {
        let Self { geometry, rates, state, slopes, .. } = self;
        runge_kutta(state, h, slopes, |_, trial, out| slope(geometry, trial, rates, out))
    }
}

/// The flow at its start.
fn begin<S: Real>(setup: &SceneSetup<S>) -> Flow<'_> {
    let (geometry, start) = (&*setup.rough.geometry, &setup.rough.start);
    let k = geometry.norm(&start.q, &start.q_dot);
    let state: Vec<f64> = start.q.iter().chain(&start.p).copied().collect();
    let slopes = [(); 4].map(|()| vec![0.0; state.len()]);
    Flow { geometry, rates: geometry.field().room(), state, slopes, k }
}

/// The sign of the formula on the way to its first change of sign; a formula that is zero at the start takes that of the
/// first step.
pub(super) fn side_before<S: Real>(setup: &SceneSetup<S>, formula: &Observable) -> f64 {
    let (mut flow, mut formula) = (begin(setup), formula.clone());
    let sign = |value: f64| if value == 0.0 { None } else { Some(value.signum()) };
    let here = flow.value(&mut formula).ok().and_then(sign);
    here.or_else(|| {
        let size = flow.state.iter().fold(1e-9, |size: f64, value| size.max(1e-6 * value.abs()));
        flow.step(size).ok()?;
        flow.value(&mut formula).ok().and_then(sign)
    })
    .unwrap_or(1.0)
}

/// γ − γ_i of the first change of sign within `length`; `None` if there is none, or the flow ends before it.
pub(super) fn first<S: Real>(setup: &SceneSetup<S>, formula: &Observable, length: f64) -> Option<f64> {
    let side = side_before(setup, formula);
    let (mut flow, mut formula) = (begin(setup), formula.clone());
    let steps = STEPS * (setup.n_gamma - 1) * setup.windows;
    let h = length / steps as f64;
    let mut before = flow.value(&mut formula).ok()?;
    for k in 0..steps {
        flow.step(h).ok()?;
        let here = flow.value(&mut formula).ok()?;
        if here * side < 0.0 {
            return Some(h * (k as f64 + before / (before - here)));
        }
        before = here;
    }
    None
}
