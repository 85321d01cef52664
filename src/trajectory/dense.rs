//! The dense output of the march for windows that the run has stored.

use crate::engine::lobatto::{Inside, WeakRule, WindowView};
use crate::geometry::geodesic::acceleration;
use crate::geometry::metric::Metric;
use crate::number::Real;
use crate::solve::{Joint, WindowNodes};

/// Legendre coefficients of the forces that count as rounding, relative to the largest force.
const ROUNDING: f64 = 1e-16;

/// A window in `f64` whose forces are polynomials through those on its nodes. Integrating them takes no evaluation of
/// the potential, and is of order n + 1 inside the window, as against 2n − 2 at its end.
#[derive(Debug)]
pub(super) struct Dense {
    rule: &'static WeakRule,
    /// Time counts from the start of the window.
    ends: [Inside; 2],
    length: f64,
    u: Vec<f64>,
    a: Vec<f64>,
}

impl Dense {
    /// For a window.
    pub(super) fn new<S: Real>(view: &WindowNodes<'_, S>, q_t: S, metric: &Metric<S>) -> Self {
        let x = view.row(1);
        let forces = x.iter().map(|&x| {
            let [g00, slope] = metric.g00_and_slope(x);
            ((q_t / g00).to_f64(), acceleration(q_t, g00, slope).to_f64())
        });
        let (u, a) = forces.unzip();
        let begun = view.start.q[0];
        let inside = |Joint { q, p }: Joint<'_, S>| {
            let [t, x, w] = [q[0] - begun, q[1], -p[1]].map(S::to_f64);
            Inside { t, x, w }
        };
        let ends = [view.start, view.end].map(inside);
        Self { rule: WeakRule::shared(x.len()), ends, length: view.window.length().to_f64(), u, a }
    }

    /// Whether no digit would be gained by more nodes: the highest coefficients of both forces are rounding.
    pub(super) fn is_resolved(&self) -> bool {
        let last = self.rule.points() - 1;
        [&self.u, &self.a].into_iter().all(|force| {
            let largest = force.iter().fold(0.0_f64, |largest, v| largest.max(v.abs()));
            let tail = (last.saturating_sub(2)..=last).map(|k| self.rule.mode_of(k, force).abs());
            tail.fold(0.0, f64::max) <= ROUNDING * largest
        })
    }

    /// t (counted from the start of the window), x and w at every `gamma`, counted in the same way.
    pub(super) fn at(&self, gamma: impl IntoIterator<Item = f64>, mut see: impl FnMut([f64; 3])) {
        let view = WindowView::stored(self.rule, self.length, self.ends, [&self.u, &self.a]);
        let fractions = gamma.into_iter().map(|gamma| gamma / self.length);
        view.inside(fractions, |Inside { t, x, w }| see([t, x, w]));
    }
}
