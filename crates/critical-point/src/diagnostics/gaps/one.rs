//! The gaps of a run of one coordinate.

use super::super::Diagnosed;
use super::{Gaps, accuracy, bend, count, look};
use crate::enclosure::{Enclosure, Path, UNSEEN, negligible_potential};
use crate::metric::{Metric, acceleration};
use crate::scalar::Real;
use crate::solve::Solution;

impl Gaps {
    /// Looks at the gaps of `solution`, whose metric is `metric`. `error` is its estimated error relative to
    /// max(1, size) of its coordinates, as in [`Verdict`](crate::diagnostics::verdict::Verdict), if it is known.
    pub fn of_solution<S: Diagnosed>(solution: &Solution<S>, metric: &Metric, error: Option<f64>) -> Self {
        S::gaps(solution, metric, error)
    }

    pub(in crate::diagnostics) fn of_solution_here<S: Real>(
        solution: &Solution<S>,
        metric: &Metric,
        error: Option<f64>,
    ) -> Self {
        let accuracy = accuracy(error);
        let (q_t, length) = (solution.invariants().q_t.to_f64(), solution.length.to_f64());
        let duration = solution.duration().to_f64().abs();
        let x_size = solution.x().iter().fold(1.0, |most: f64, x| most.max(x.to_f64().abs()));
        let sizes = [duration.max(1.0), x_size];
        let mut hidden = Vec::new();
        if let Some(mut enclosure) = Enclosure::of_metric(metric) {
            for (window, view) in solution.views().enumerate() {
                let distances = view.grid.distances();
                let x = describe(&mut enclosure.path, view.row(1), &distances, metric, q_t);
                let tolerances = || negligible_potential(metric, (q_t, x), length, sizes, UNSEEN * accuracy);
                hidden.extend(look(&mut enclosure, window, &distances, (length, count(solution)), tolerances));
            }
        }
        Self::new(solution, accuracy, hidden)
    }
}

/// Describes a window as a path. Returns the x from which the least moves it: where g00 is smallest.
fn describe<S: Real>(path: &mut Path, x: &[S], distances: &[f64], metric: &Metric, q_t: f64) -> f64 {
    let x: Vec<f64> = x.iter().map(|x| x.to_f64()).collect();
    let jets: Vec<_> = x.iter().map(|&x| metric.at(x)).collect();
    let a = |k: usize| acceleration(q_t, jets[k].g00, jets[k].first);
    path.begin(x.len());
    path.push(0, &x, |k| bend(0.5 * distances[k] * distances[k] * (a(k) + a(k + 1))));
    let lowest = (0..x.len()).min_by(|&j, &k| jets[j].g00.total_cmp(&jets[k].g00));
    lowest.map_or(0.0, |k| x[k])
}
