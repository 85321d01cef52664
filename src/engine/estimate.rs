//! The error of a run, which the errors of its windows add up to.
//!
//! Each window makes a local error, which its highest modes tell; the linearised equations carry it on. The estimate is
//! one solution δ of them, to which each window adds its local error such that δ grows most: in closed form for one
//! active coordinate ([`Plane`]), by steps for more ([`Steps`]). Rounding errors have others, to which each
//! window adds such that squares add up, as their signs are random.

use super::POINTS;
use super::between::Kink;
use super::local::larger;
use super::plane::Plane;
use super::sizes::inverse;
use super::steps::{Errors, Steps, Total};
use super::tuning::{LEFT_MARGIN, MARGIN, OF_SLOPES, ROUNDING};
use super::window::Solver;

/// δ, window by window.
pub(super) struct ErrorEstimate<'g> {
    method: Method<'g>,
    /// The local errors of the unknowns, without signs, and those of rounding.
    local: Vec<Errors>,
    /// By steps, it lags behind until the last window.
    pub(super) total: Total,
}

enum Method<'g> {
    Plane(Box<Plane<'g>>),
    Steps(Box<Steps<'g>>),
}

impl<'g> ErrorEstimate<'g> {
    /// No error at the start.
    pub(super) fn new(solver: &Solver<'g, POINTS>) -> Self {
        let m = solver.geometry.active().len();
        let method = if m == 1 && !solver.geometry.has_force() {
            Method::Plane(Box::new(Plane::new(solver)))
        } else {
            Method::Steps(Box::new(Steps::new(solver)))
        };
        let local = vec![[0.0; 2]; 2 * m];
        Self { method, local, total: Total::default() }
    }

    /// Goes back to the start, where there is no error.
    pub(super) fn begin(&mut self) {
        match &mut self.method {
            Method::Plane(plane) => plane.begin(),
            Method::Steps(steps) => steps.begin(),
        }
        self.total = Total::default();
    }

    /// At the end of a run to a value of `coordinate` errors are those at equal values of it: its own error is one of
    /// the others too.
    pub(super) fn judge_at_equal(&mut self, window: &Solver<'g, POINTS>, coordinate: usize) {
        let of = |a: usize| match &self.method {
            Method::Plane(plane) => plane.error(window.place(a))[0],
            Method::Steps(steps) => steps.error(window.place(a)),
        };
        let late = of(coordinate) / window.end_rate(coordinate).abs();
        let others = (0..window.geometry.dimension()).filter(|&a| a != coordinate);
        let worst = others
            .fold(0.0, |worst, a| larger(worst, (of(a) + late * window.end_rate(a).abs()) * window.inverse_size(a)));
        let Total { now: [now, rounding], reached, largest } = self.total;
        self.total = Total { now: [larger(now, worst), rounding], reached, largest }.grown();
    }

    /// Carries δ over a window that is finished, and adds the window's own error. `left` is what its sweeps left
    /// undone, relative to sizes; `done` is the part of the run that is behind, and the window is at this kink.
    pub(super) fn follow(&mut self, window: &Solver<'g, POINTS>, left: f64, done: f64, kink: Kink) {
        for (k, local) in self.local.iter_mut().enumerate() {
            let row = &window.rows[k];
            let left = LEFT_MARGIN * left * inverse(row.size.inverse);
            let magnitude = row.start.high.abs().max(row.end.high.abs());
            *local = [MARGIN * (window.end_error(k) + left), ROUNDING * magnitude];
        }
        match &mut self.method {
            Method::Plane(plane) => {
                let gains = plane.follow(window).map(|gain| OF_SLOPES * gain);
                let of = |k: usize| self.local[k][1] + gains[k];
                plane.add([self.local[0][0], self.local[1][0]], [of(0), of(1)]);
                let inverse = |a: usize| {
                    let size = window.size(a);
                    if window.place(a).is_ok() { size.for_sums(done) } else { size.of_way(done) }
                };
                let error = |a: usize| plane.error(window.place(a)).map(|error| error * inverse(a));
                let errors = (1..window.geometry.dimension()).map(error);
                let now =
                    errors.fold(error(0), |[all, rounding], error| [larger(all, error[0]), larger(rounding, error[1])]);
                let Total { reached, largest, .. } = self.total;
                self.total = Total { now, reached: reached + window.length, largest }.grown();
            }
            Method::Steps(steps) => {
                steps.follow(window, &self.local, done, kink);
                if done == 1.0 {
                    steps.finish(window);
                }
                self.total = steps.total;
            }
        }
        if done == 1.0 {
            let most = match &self.method {
                Method::Plane(plane) => &plane.most_ignorable,
                Method::Steps(steps) => &steps.most_ignorable,
            };
            // Ways may have come to less than was expected.
            let of_ways = most.iter().zip(&window.ways).map(|(most, way)| most * way.inverse);
            self.total.largest = of_ways.fold(self.total.largest, larger);
        }
    }
}
