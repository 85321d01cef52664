//! The deviation of a motion from that of Newton's mechanics.
//!
//! With time as the parameter and v = dx/dt, the geodesic equations of the metric diag(g00, −1), g00 = c² + 2V/m, are
//!
//! ```text
//! dv/dt = −(V′/m) (1 − 2v²/g00).
//! ```
//!
//! (ẋ = vṫ gives ẍ = ṫ² dv/dt + v ẗ, and g00 ṫ = Q_t gives ẗ = −g00′ ẋ ṫ/g00.) So the acceleration differs from
//! Newton's by exactly the share 2v²/g00, and the motion is Newton's in the limit of large c.

use super::g00::G00;
use crate::number::Real;
use crate::solve::Solution;

/// The deviation for which [`Newtonian::c`] is chosen.
pub const NEGLIGIBLE: f64 = 1e-6;

/// The deviation of a run from Newton's mechanics.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Newtonian {
    /// The largest 2v²/g00 over the nodes where a force acts; 0 for free motion, infinite if t does not change.
    pub deviation: f64,
    /// The largest v² of Newton's mechanics at the places visited, v_i² + 2(V_i − V)/m.
    speed_squared: f64,
    /// The largest −2V/m at the places visited.
    depth: f64,
}

impl Newtonian {
    pub(super) fn new<S: Real>(solution: &Solution<S>, metric: G00<'_, S>, x_dot: &[S]) -> Self {
        let (q_t, begin) = (solution.q_t(), &solution.place.start);
        let nan = S::from(f64::NAN);
        let c_squared = solution.geometry().c_squared().unwrap_or(nan);
        let start = solution.geometry().g00(&begin.q).unwrap_or(nan);
        let v = begin.q_dot[1] / begin.q_dot[0];
        let mut found = Self { deviation: 0.0, speed_squared: 0.0, depth: f64::NEG_INFINITY };
        for view in solution.views() {
            let last = view.grid.points() - 1;
            for (k, node) in view.grid.nodes().enumerate() {
                let [g00, first, _] = metric.at(node);
                let w = if k == last { -view.end.p[1] } else { x_dot[node] };
                if first != S::ZERO {
                    let v = w * g00 / q_t;
                    let deviation = (S::from(2.0) * v * v / g00).to_f64();
                    // dx/dt is 0/0 where neither t nor x changes.
                    found.deviation = found.deviation.max(if deviation.is_nan() { f64::INFINITY } else { deviation });
                }
                found.speed_squared = found.speed_squared.max((v * v + (start - g00)).to_f64());
                found.depth = found.depth.max((c_squared - g00).to_f64());
            }
        }
        found
    }

    /// The speed of light, rounded up to three digits, with which the deviation at the places visited would be
    /// [`NEGLIGIBLE`]; `None` if the particle does not move.
    pub fn c(&self) -> Option<f64> {
        let squared = 2.0 / NEGLIGIBLE * self.speed_squared + self.depth;
        if !(self.speed_squared > 0.0 && squared > 0.0 && squared.is_finite()) {
            return None;
        }
        let c = squared.sqrt();
        let unit = 10.0_f64.powi(c.log10().floor() as i32 - 2);
        Some((c / unit).ceil() * unit)
    }

    /// The extremes over a run, from those over its first part, `self`, and its second part, `next`.
    pub(super) fn followed_by(self, next: Self) -> Self {
        Self {
            deviation: self.deviation.max(next.deviation),
            speed_squared: self.speed_squared.max(next.speed_squared),
            depth: self.depth.max(next.depth),
        }
    }
}
