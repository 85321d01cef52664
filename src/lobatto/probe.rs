//! Why a window failed.

use super::{MarchFailure, State};
use crate::geodesic::acceleration;
use crate::metric::Metric;

/// Explicit steps across the failed window.
const STEPS: usize = 256;

/// Follows the geodesic across a failed window by the classical Runge–Kutta method: it either leaves the domain or
/// shows that the window as such is passable, only too long.
pub(super) fn why(metric: &Metric, q_t: f64, start: &State, length: f64, window: usize, gamma: f64) -> MarchFailure {
    let force = |x: f64| {
        let g = metric.at(x);
        if g.is_inside() { Ok(acceleration(q_t, g.g00, g.first)) } else { Err((x, g.g00)) }
    };
    let h = length / STEPS as f64;
    let (mut x, mut w) = (start.x.hi, start.w.hi);
    let mut step = || {
        let a1 = force(x)?;
        let a2 = force(x + 0.5 * h * w)?;
        let a3 = force(x + 0.5 * h * w + 0.25 * h * h * a1)?;
        let a4 = force(x + h * w + 0.5 * h * h * a2)?;
        x += h * w + h * h / 6.0 * (a1 + a2 + a3);
        w += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
        force(x)
    };
    for k in 0..STEPS {
        if let Err((x, g00)) = step() {
            return MarchFailure::OutsideDomain { window, gamma: gamma + k as f64 * h, x, g00 };
        }
    }
    MarchFailure::NotConverged { window, gamma, x: start.x.hi }
}
