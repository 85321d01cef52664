//! Initial data of a geodesic, its constants of motion and its acceleration.
//!
//! ```text
//! d/dγ( g00 ṫ ) = 0,     ẍ + ½ g00′(x) ṫ² = 0,     ˙ = d/dγ
//! ```
//!
//! ```
//! use geodesic_ivp::geometry::geodesic::InitialData;
//! use geodesic_ivp::geometry::metric::Metric;
//! use geodesic_ivp::geometry::potential::Potential;
//!
//! let metric = Metric::new(Potential::quartic(0.5), 1.0, 1.0);
//! let invariants = InitialData { t: 0.0, x: 1.0, t_dot: 1.0, x_dot: 0.1 }.invariants(&metric);
//! assert_eq!(invariants.q_t, 2.0);
//! assert!((invariants.k - 1.99).abs() < 1e-15);
//! ```

use crate::geometry::Start;
use crate::geometry::metric::Metric;

pub use crate::geometry::metric::{acceleration, acceleration_slope};
use crate::number::Real;

/// Position and tangent of the world-line at γ_i, in the units of the case.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InitialData<S = f64> {
    /// t_i.
    pub t: S,
    /// x_i.
    pub x: S,
    /// ṫ_i = dt/dγ.
    pub t_dot: S,
    /// ẋ_i = dx/dγ.
    pub x_dot: S,
}

/// The constants of motion of the continuum.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Invariants<S = f64> {
    /// Noether charge of time translations, Q_t = g00(x) ṫ (Killing vector (1, 0)).
    pub q_t: S,
    /// Norm of the tangent, K = g00(x) ṫ² − ẋ²; K > 0 is timelike.
    pub k: S,
}

impl<S: Real> InitialData<S> {
    /// The start in the coordinates t and x, with the momenta p_t = Q_t and p_x = −ẋ.
    pub fn start(&self, metric: &Metric<S>) -> Start<S> {
        let Self { t, x, t_dot, x_dot } = *self;
        Start { q: vec![t, x], q_dot: vec![t_dot, x_dot], p: vec![self.invariants(metric).q_t, -x_dot] }
    }

    /// Q_t and K of the geodesic that starts here.
    pub fn invariants(&self, metric: &Metric<S>) -> Invariants<S> {
        let g00 = metric.g00(self.x);
        Invariants { q_t: g00 * self.t_dot, k: g00 * self.t_dot * self.t_dot - self.x_dot * self.x_dot }
    }
}
