//! The scales of a motion: its size, its speed and its frequency. Deviations are judged relative to these.

use super::g00::G00;
use crate::number::Real;
use crate::solve::Solution;

/// Extremes over the nodes of a run. They serve to judge deviations, for which `f64` is enough.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scales {
    /// Largest |dx/dγ|; in the strong form without the last node of each window.
    pub x_dot: f64,
    /// Largest local frequency: ω² = −dẍ/dx where that is positive, or 0.
    pub omega: f64,
    /// Largest (mean) spacing of the nodes of a window.
    pub spacing: f64,
    /// Least g00/c².
    pub g00: f64,
}

impl Scales {
    pub(super) fn new<S: Real>(solution: &Solution<S>, metric: G00<'_, S>, x_dot: &[S]) -> Self {
        let q_t = solution.q_t();
        let least = |a: f64, b: f64| if b < a { b } else { a };
        let most = |a: f64, b: f64| if b > a { b } else { a };
        let nodes = || (0..solution.nodes()).map(|k| metric.at(k));
        // ω² = −dẍ/dx = ½ g00″ ṫ² − g00′² Q_t²/g00³.
        let squares = nodes().map(|[g00, first, second]| {
            let t_dot = q_t / g00;
            (t_dot * t_dot * (second.half() - first * first / g00)).to_f64()
        });
        let c_squared = solution.geometry().c_squared().map_or(f64::NAN, S::to_f64);
        let g00 = nodes().map(|[g00, ..]| g00.to_f64() / c_squared);
        let exact = solution.views().flat_map(|view| x_dot[view.grid.exact()].iter());
        Self {
            x_dot: exact.map(|x_dot| x_dot.to_f64().abs()).fold(0.0, most),
            omega: squares.fold(0.0, most).sqrt(),
            spacing: solution.views().map(|view| view.grid.sbp().spacing().to_f64()).fold(0.0, most),
            g00: g00.fold(f64::INFINITY, least),
        }
    }

    /// Δγω: the largest spacing times the largest local frequency.
    pub fn step(&self) -> f64 {
        self.spacing * self.omega
    }

    /// The extremes over a run, from those over its first part, `self`, and its second part, `next`.
    pub(super) fn followed_by(self, next: Self) -> Self {
        Self {
            x_dot: self.x_dot.max(next.x_dot),
            omega: self.omega.max(next.omega),
            spacing: self.spacing.max(next.spacing),
            g00: self.g00.min(next.g00),
        }
    }
}
