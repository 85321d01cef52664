//! The motion with time as its parameter, with which the figures of the paper compare the world-line formulation.

use std::convert::Infallible;

use crate::geometry::{Geometry, Start};
use crate::number::runge_kutta::runge_kutta;

/// The solution of d²x/dt² = −(V′/m) (1 − (dx/dt)²/c²)^{3/2}, a relativistic particle with a potential term, at
/// `points` equidistant times: t − t_i and x.
///
/// It agrees with the geodesic only in the limit of weak fields and low speeds. It is computed by the classical
/// Runge–Kutta method with 64 steps between two points; the error is far below the width of a line in a plot. The
/// motion ends early where it is not defined.
/// It is empty where the geometry is not the paper's space-time of t and x.
pub fn time_parametrised(geometry: &Geometry, start: &Start, duration: f64, points: usize) -> Vec<(f64, f64)> {
    let Some(c_squared) = geometry.c_squared else { return Vec::new() };
    let [_, first, _] = geometry.sources_of_g00();
    const STEPS: usize = 64;
    let h = duration / ((points - 1) * STEPS) as f64;
    let mut rates = |state: &[f64], rates: &mut [f64]| {
        let (x, v) = (state[0], state[1]);
        // V′/m = g00′/2.
        let squeeze = (1.0 - v * v / c_squared).max(0.0);
        (rates[0], rates[1]) = (v, -0.5 * geometry.first_at(&[&[0.0], &[x]]).at(first, 0) * squeeze * squeeze.sqrt());
        Ok::<(), Infallible>(())
    };
    let mut state = [start.q[1], start.q_dot[1] / start.q_dot[0]];
    let mut states = vec![(0.0, state[0])];
    for k in 1..points {
        for _ in 0..STEPS {
            let Ok(()) = runge_kutta(&mut state, h, &mut rates);
        }
        if !state.iter().all(|value| value.is_finite()) {
            break;
        }
        states.push(((k * STEPS) as f64 * h, state[0]));
    }
    states
}
