//! Why a window of a scene failed.

use super::FlowFailure;
use super::state::FlowState;
use crate::geometry::Geometry;
use crate::runge_kutta::runge_kutta;

/// Explicit steps across the failed window.
const STEPS: usize = 512;

/// Follows the world-line from `start` over `length` by the classical Runge–Kutta method: it either leaves the domain
/// or shows that the window as such is passable.
pub(super) fn why(geometry: &Geometry, start: &FlowState, momenta: &[f64], length: f64, gamma: f64) -> FlowFailure {
    let n = geometry.dimension();
    let mut state: Vec<f64> = start.q.iter().map(|q| q.hi).chain(momenta.iter().copied()).collect();
    for (place, &a) in geometry.active().iter().enumerate() {
        state[n + a] = start.p[place].hi;
    }
    let (field, mut rates) = (geometry.field(), geometry.field().room());
    let mut slopes = [(); 4].map(|()| vec![0.0; state.len()]);
    let h = length / STEPS as f64;
    for step in 0..STEPS {
        let advanced = runge_kutta(&mut state, h, &mut slopes, |_, trial, out| field.slopes(trial, &mut rates, out));
        if let Err(outside) = advanced {
            let gamma = gamma + h * step as f64;
            return FlowFailure::OutsideDomain { gamma, q: state[..n].to_vec(), outside };
        }
    }
    FlowFailure::NotConverged { gamma, q: start.q.iter().map(|q| q.hi).collect() }
}
