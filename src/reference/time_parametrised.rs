//! The motion with time as its parameter, with which the figures of the paper compare the world-line formulation.

use crate::geometry::{Geometry, Start};

/// A point of the time-parametrised motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimeState {
    /// t − t_i.
    pub elapsed: f64,
    /// x.
    pub x: f64,
    /// dx/dt.
    pub velocity: f64,
}

/// The solution of d²x/dt² = −(V′/m) (1 − (dx/dt)²/c²)^{3/2}, a relativistic particle with a potential term, at
/// `points` equidistant times.
///
/// It agrees with the geodesic only in the limit of weak fields and low speeds. It is computed by the classical
/// Runge–Kutta method with 64 steps between two points; the error is far below the width of a line in a plot. The
/// motion ends early where it is not defined.
/// It is empty where the geometry is not the paper's space-time of t and x.
pub fn time_parametrised(geometry: &Geometry, start: &Start, duration: f64, points: usize) -> Vec<TimeState> {
    let Some(c_squared) = geometry.c_squared() else { return Vec::new() };
    let [_, first, _] = geometry.sources_of_g00();
    const STEPS: usize = 64;
    let h = duration / ((points - 1) * STEPS) as f64;
    let acceleration = |x: f64, v: f64| {
        // V′/m = g00′/2.
        let squeeze = (1.0 - v * v / c_squared).max(0.0);
        -0.5 * geometry.at(&[0.0, x]).at(first, 0) * squeeze * squeeze.sqrt()
    };
    let (mut x, mut v) = (start.q[1], start.q_dot[1] / start.q_dot[0]);
    let mut states = vec![TimeState { elapsed: 0.0, x, velocity: v }];
    for k in 1..points {
        for _ in 0..STEPS {
            let a1 = acceleration(x, v);
            let v2 = v + 0.5 * h * a1;
            let a2 = acceleration(x + 0.5 * h * v, v2);
            let v3 = v + 0.5 * h * a2;
            let a3 = acceleration(x + 0.5 * h * v2, v3);
            let v4 = v + h * a3;
            let a4 = acceleration(x + h * v3, v4);
            x += h * (v + 2.0 * v2 + 2.0 * v3 + v4) / 6.0;
            v += h * (a1 + 2.0 * a2 + 2.0 * a3 + a4) / 6.0;
        }
        if !(x.is_finite() && v.is_finite()) {
            break;
        }
        states.push(TimeState { elapsed: (k * STEPS) as f64 * h, x, velocity: v });
    }
    states
}
