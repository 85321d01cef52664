//! Initial data of a geodesic and what the symmetries make of them.
//!
//! ```text
//! d/dγ( g00 ṫ ) = 0,     ẍ + ½ g00′(x) ṫ² = 0,     ˙ = d/dγ
//! ```

use crate::metric::Metric;

/// Position and tangent of the world-line at γ_i.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InitialData {
    /// t_i.
    pub t: f64,
    /// x_i.
    pub x: f64,
    /// ṫ_i = dt/dγ.
    pub t_dot: f64,
    /// ẋ_i = dx/dγ.
    pub x_dot: f64,
}

/// The continuum constants of motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Invariants {
    /// Noether charge of time translations, Q_t = g00(x) ṫ (Killing vector (1, 0)).
    pub q_t: f64,
    /// Norm of the tangent, K = g00(x) ṫ² − ẋ²; K > 0 is timelike.
    pub k: f64,
}

impl InitialData {
    /// Q_t and K of the geodesic that starts here.
    pub fn invariants(&self, metric: &Metric) -> Invariants {
        let g00 = metric.at(self.x).g00;
        Invariants { q_t: g00 * self.t_dot, k: g00 * self.t_dot * self.t_dot - self.x_dot * self.x_dot }
    }
}

/// ẍ = −½ g00′ (Q_t/g00)², the geodesic equation for x after Q_t has eliminated ṫ.
#[inline]
pub fn acceleration(q_t: f64, g00: f64, first: f64) -> f64 {
    let t_dot = q_t / g00;
    -0.5 * first * t_dot * t_dot
}

/// dẍ/dx of [`acceleration`], −½ g00″ (Q_t/g00)² + g00′² Q_t²/g00³.
#[inline]
pub fn acceleration_slope(q_t: f64, g00: f64, first: f64, second: f64) -> f64 {
    let t_dot = q_t / g00;
    t_dot * t_dot * (first * first / g00 - 0.5 * second)
}
