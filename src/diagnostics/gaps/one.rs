//! The gaps of a run of one coordinate.

use super::{Between, Enclosed, bend};
use crate::engine::enclosure::{Enclosure, Path, negligible_potential};
use crate::geometry::metric::{Metric, acceleration};
use crate::number::Real;
use crate::solve::{Solution, WindowNodes};

impl<S: Real> Enclosed<S> for Metric<S> {
    type Between<'r> = BetweenNodes<'r>;
}

/// A run of one coordinate between its nodes.
#[derive(Debug)]
pub struct BetweenNodes<'r> {
    metric: &'r Metric,
    q_t: f64,
    length: f64,
    /// max(1, size) of t and x.
    sizes: [f64; 2],
    /// The x of the window from which the least moves it: where g00 is smallest.
    lowest: f64,
}

impl<'r, S: Real> Between<'r, S, Metric<S>> for BetweenNodes<'r> {
    fn new(solution: &'r Solution<S>, metric: &'r Metric) -> Self {
        let (q_t, length) = (solution.invariants().q_t.to_f64(), solution.length.to_f64());
        let duration = solution.duration().to_f64().abs();
        let x_size = solution.x().iter().fold(1.0, |most: f64, x| most.max(x.to_f64().abs()));
        Self { metric, q_t, length, sizes: [duration.max(1.0), x_size], lowest: 0.0 }
    }

    fn enclosure(&self) -> Option<Enclosure> {
        Enclosure::of_metric(self.metric)
    }

    fn describe(&mut self, view: &WindowNodes<'_, S>, distances: &[f64], path: &mut Path) {
        let x: Vec<f64> = view.row(1).iter().map(|x| x.to_f64()).collect();
        let jets: Vec<_> = x.iter().map(|&x| self.metric.at(x)).collect();
        let a = |k: usize| acceleration(self.q_t, jets[k].g00, jets[k].first);
        path.begin(x.len());
        path.push(0, &x, |k| bend(0.5 * distances[k] * distances[k] * (a(k) + a(k + 1))));
        let lowest = (0..x.len()).min_by(|&j, &k| jets[j].g00.total_cmp(&jets[k].g00));
        self.lowest = lowest.map_or(0.0, |k| x[k]);
    }

    fn tolerances(&self, error: f64) -> Vec<f64> {
        negligible_potential(self.metric, (self.q_t, self.lowest), self.length, self.sizes, error)
    }
}
