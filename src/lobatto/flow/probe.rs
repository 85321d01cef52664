//! Why a window of a scene failed.

use super::FlowFailure;
use super::state::FlowState;
use crate::geometry::{Geometry, OutsideGeometry, Rates};

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
    let mut rates = geometry.field().room();
    let h = length / STEPS as f64;
    for step in 0..STEPS {
        if let Err(outside) = advance(geometry, &mut rates, &mut state, h) {
            let gamma = gamma + h * step as f64;
            return FlowFailure::OutsideDomain { gamma, q: state[..n].to_vec(), outside };
        }
    }
    FlowFailure::NotConverged { gamma, q: start.q.iter().map(|q| q.hi).collect() }
}

fn advance(geometry: &Geometry, rates: &mut Rates<f64>, state: &mut [f64], h: f64) -> Result<(), OutsideGeometry> {
    let n = geometry.dimension();
    let (field, from) = (geometry.field(), state.to_vec());
    let mut trial = from.clone();
    for (share, weight) in [(0.5, 1.0), (0.5, 2.0), (1.0, 2.0), (0.0, 1.0)] {
        field.evaluate(&trial[..n], &trial[n..], rates)?;
        let mut set = |index: usize, slope: f64| {
            state[index] += h / 6.0 * weight * slope;
            trial[index] = from[index] + share * h * slope;
        };
        (0..n).for_each(|a| set(a, field.q_dot(rates, a)));
        field.active().iter().enumerate().for_each(|(place, &a)| set(n + a, field.p_dot(rates, place)));
    }
    Ok(())
}
