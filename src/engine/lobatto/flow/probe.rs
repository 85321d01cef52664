//! Why a window of a scene failed.

use super::FlowFailure;
use super::state::FlowState;
use crate::geometry::Geometry;
use crate::number::runge_kutta::runge_kutta;

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
    let mut point = geometry.point();
    let mut slopes = [(); 4].map(|()| vec![0.0; state.len()]);
    let h = length / STEPS as f64;
    for step in 0..STEPS {
        let advanced = runge_kutta(&mut state, h, &mut slopes, |_, trial, out| point.slopes(trial, out));
        if let Err(outside) = advanced {
            let gamma = gamma + h * step as f64;
            return FlowFailure::OutsideDomain { gamma, q: state[..n].to_vec(), outside };
        }
    }
    FlowFailure::NotConverged { gamma, q: start.q.iter().map(|q| q.hi).collect() }
}

#[cfg(test)]
mod tests {
    use super::why;
    use crate::engine::lobatto::flow::{FlowFailure, FlowState};
    use crate::geometry::{Geometry, GeometryText, MetricText, Start};

    /// g_tt = 1 + 2x, which is zero at x = −½, and g_xx = −1. The start of the run is not the start of the window.
    #[test]
    fn a_horizon_is_met_where_it_is() {
        let components = [([0, 0], "1 + 2*x"), ([1, 1], "-1")].map(|(pair, text)| (pair, text.to_owned()));
        let text = MetricText {
            coordinates: ["t", "x"].map(str::to_owned).to_vec(),
            components: components.to_vec(),
            ..MetricText::default()
        };
        let geometry: Geometry = Geometry::new(&GeometryText::Metric(text)).unwrap().around(&[0.0, 0.0]).unwrap();
        // With p_t = 1 and K = p_t²/g_tt − p_x² = ¾ at x = 0, dγ = dg/2w has the integral below.
        let momenta = [1.0, 0.125];
        let start = Start { q: vec![5.0, 0.0], q_dot: vec![1.0, -0.5], p: vec![1.0, 0.5] };
        let state = FlowState::new(&start, geometry.active());
        let (k, angle) = (0.75_f64, (0.75_f64).sqrt().asin());
        let expected = 3.0 + (angle - angle.sin() * angle.cos()) / (2.0 * k.powf(1.5));
        let failure = why(&geometry, &state, &momenta, 0.6, 3.0);
        let FlowFailure::OutsideDomain { gamma, q, .. } = failure else { panic!("{failure}") };
        assert!((gamma - expected).abs() < 5e-3 && (q[1] + 0.5).abs() < 0.05, "{gamma} {expected}, {q:?}");
        // What lies beyond the window does not count.
        let failure = why(&geometry, &state, &momenta, 0.45, 3.0);
        assert_eq!(failure, FlowFailure::NotConverged { gamma: 3.0, q: vec![5.0, 0.0] });
    }
}
