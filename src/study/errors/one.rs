//! The error of a run, estimated by a second and cheaper solve.
//!
//! The second solve is a run of [`crate::engine`], which chooses its own windows, with an accuracy far beyond
//! that of most runs. It shares neither grid nor operator with the run. Its own error estimate is added to the
//! differences that are found. If a run in extended precision agrees with it to its last digits, the Taylor series of
//! [`crate::reference`] in the same precision take its place.

use std::ops::ControlFlow;

use super::run_error::{Found, Judge, RunError};
use super::stepped_over::{Between, fractions, points_in};
use crate::engine::{Accuracy, Dense, Engine, POINTS, Window};
use crate::geometry::Start;
use crate::geometry::geodesic::{InitialData, Invariants};
use crate::geometry::metric::Metric;
use crate::number::Real;
use crate::reference::ReferenceTrajectory;
use crate::solve::{Setup, Solution};
use crate::trajectory::Sample;

/// The accuracies that are requested of the second solve, one after the other, until it can meet one. On a very long
/// run the first one is out of reach.
const ACCURACIES: [f64; 3] = [1e-12, 1e-9, 1e-6];

/// The largest number of windows of the second solve: the first number is per node of the run, and the second one is
/// allowed in any case.
const WINDOWS: (usize, usize) = (1, 10_000);

/// If the errors of an extended run are below this, relative to the sizes of t and x, they are measured in extended
/// precision.
const BEYOND_F64: f64 = 1e-11;

/// The error of the run of `setup` of which only its last part, the `solution`, and `samples` of all of it are kept;
/// `None` if no second solve is possible.
pub fn run_error<S: Real>(
    setup: &Setup<f64, Metric>,
    solution: &Solution<S>,
    samples: &[Sample<S>],
) -> Option<RunError> {
    if let Some(estimate) = solution.error_estimate {
        let largest: Vec<f64> = solution.sizes.iter().map(|size| estimate * size).collect();
        // If the run ends at a given time, all of its error there is one of x.
        let end = if setup.duration().is_some() { vec![0.0, largest[1]] } else { largest.clone() };
        let stepped_over = stepped_over(setup, solution);
        return Some(RunError { end, largest, own: vec![0.0; 2], judge: Judge::OwnEstimate, stepped_over });
    }
    let nodes = Nodes::new(setup, points(solution, samples));
    let found = nodes.by_second_solve(setup);
    let [t, x] = nodes.sizes;
    let is_beyond = |error: &RunError| error.at_most().iter().zip([t, x]).all(|(most, size)| *most < BEYOND_F64 * size);
    if S::IS_EXTENDED && found.as_ref().is_none_or(is_beyond) {
        by_taylor(setup, solution, samples).or(found)
    } else {
        found
    }
}

/// γ − γ_i, t − t_i and x at the samples before `solution`, in the order of the run, and at its nodes.
fn points<'s, S: Real>(solution: &'s Solution<S>, samples: &[Sample<S>]) -> impl Iterator<Item = [S; 3]> + use<'s, S> {
    let first = solution.gamma_from_start().next().unwrap_or(S::ZERO);
    let from_start = |sample: &Sample<S>| [sample.gamma - solution.gamma_i, sample.t - solution.t_i(), sample.x];
    let mut before: Vec<[S; 3]> = samples.iter().map(from_start).filter(|[gamma, ..]| *gamma < first).collect();
    if before.first().zip(before.last()).is_some_and(|(first, last)| first[0] > last[0]) {
        before.reverse();
    }
    let nodes = solution.gamma_from_start().zip(solution.counted_from_origin(0, solution.elapsed())).zip(solution.x());
    before.into_iter().chain(nodes.map(|((gamma, t), &x)| [gamma, t, x]))
}

/// The nodes of a run in `f64`, counted from its start, or samples in place of some of them.
struct Nodes {
    gamma: Vec<f64>,
    elapsed: Vec<f64>,
    x: Vec<f64>,
    /// Whether the run ends at a given time.
    in_time: bool,
    /// The largest |t − t_i| and |x|.
    sizes: [f64; 2],
}

/// What the judge may be off by, of a run that ends at a given time all in x.
fn own(errors: [f64; 2], in_time: bool) -> Vec<f64> {
    if in_time { vec![0.0, errors[0].max(errors[1])] } else { errors.to_vec() }
}

impl Nodes {
    fn new<S: Real>(setup: &Setup<f64, Metric>, points: impl Iterator<Item = [S; 3]>) -> Self {
        let (mut gamma, mut elapsed, mut x) = (Vec::new(), Vec::new(), Vec::new());
        for point in points {
            let [gamma_here, t, x_here] = point.map(S::to_f64);
            gamma.push(gamma_here);
            elapsed.push(t);
            x.push(x_here);
        }
        let size = |values: &[f64]| values.iter().fold(0.0, |size: f64, value| size.max(value.abs()));
        let sizes = [size(&elapsed), size(&x)];
        Self { gamma, elapsed, x, in_time: setup.duration().is_some(), sizes }
    }

    fn by_second_solve(&self, setup: &Setup<f64, Metric>) -> Option<RunError> {
        ACCURACIES.into_iter().find_map(|accuracy| self.second_solve(setup, accuracy))
    }

    fn second_solve(&self, setup: &Setup<f64, Metric>, accuracy: f64) -> Option<RunError> {
        let (metric, initial) = (setup.metric(), setup.initial());
        let q_t = initial.invariants(metric).q_t;
        let (most, length) = (WINDOWS.1.max(WINDOWS.0 * self.x.len()), *self.gamma.last()?);
        let (mut found, mut next, mut tired) = (Found::none(2), 0, false);
        let mut gaps = Gaps::new(metric, initial, length);
        let start = InitialData { t: 0.0, ..initial }.start(metric);
        let mut engine = Engine::accurate(metric.scene(), &start, length, promised(accuracy), POINTS).ok()?;
        let solved = engine.run(|window| {
            if window.index == 0 {
                (found, next) = (Found::none(2), 0);
            }
            let (begin, h) = (window.gamma, window.length);
            let is_last = begin + h >= length * (1.0 - 4.0 * f64::EPSILON);
            let motion = Motion::new(&window, &start);
            while let Some(gamma) = self.gamma.get(next).filter(|gamma| **gamma < begin + h || is_last) {
                let is_end = next + 1 == self.x.len();
                let fraction = if is_end { 1.0 } else { ((gamma - begin) / h).clamp(0.0, 1.0) };
                let [t, x, w] = motion.at(fraction);
                let off = [self.elapsed[next] - t, self.x[next] - x];
                found.see(if is_end && self.in_time { at_that_time(metric, off, x, w / q_t) } else { off });
                next += 1;
            }
            gaps.see(&window, &motion);
            tired = window.index >= most;
            if tired { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        let estimate = solved.ok().filter(|()| !tired).and_then(|()| engine.error_estimate())?;
        (next == self.x.len()).then(|| {
            let sizes = engine.sizes();
            let own = own([estimate * sizes[0], estimate * sizes[1]], self.in_time);
            found.finish(own, Judge::SecondSolve(accuracy), gaps.share())
        })
    }
}

/// A run that keeps its accuracy, without certificates.
fn promised(accuracy: f64) -> Accuracy {
    Accuracy::Promised(accuracy)
}

/// t from the start of the run, x and dx/dγ in a window.
struct Motion {
    dense: Dense,
    /// dx/dγ, if x is ignorable.
    constant: Option<f64>,
}

impl Motion {
    fn new(window: &Window<'_>, start: &Start) -> Self {
        Self { dense: window.dense(), constant: window.end().momenta().is_empty().then(|| -start.p[1]) }
    }

    fn at(&self, fraction: f64) -> [f64; 3] {
        let (mut q, mut p) = ([0.0; 2], [0.0; 1]);
        match self.constant {
            Some(w) => {
                self.dense.at(fraction, &mut q, &mut []);
                [q[0], q[1], w]
            }
            None => {
                self.dense.at(fraction, &mut q, &mut p);
                [q[0], q[1], -p[0]]
            }
        }
    }
}

/// What K is off by between the nodes of a march.
struct Gaps<'m> {
    metric: &'m Metric,
    q_t: f64,
    k: f64,
    length: f64,
    between: Between,
}

impl<'m> Gaps<'m> {
    fn new(metric: &'m Metric, initial: InitialData, length: f64) -> Self {
        let Invariants { q_t, k } = initial.invariants(metric);
        Self { metric, q_t, k, length, between: Between::default() }
    }

    fn see(&mut self, window: &Window<'_>, motion: &Motion) {
        if window.index == 0 {
            self.between = Between::default();
        }
        let points = points_in(window.length / self.length);
        let length = window.length / points as f64;
        fractions(points).for_each(|fraction| {
            let [_, x, w] = motion.at(fraction);
            let timelike = self.q_t * self.q_t / self.metric.g00(x);
            self.between.see(length, timelike - w * w - self.k, timelike, w * w);
        });
    }

    fn share(&self) -> f64 {
        self.between.share()
    }
}

/// The share of its way by which a run to an accuracy may be off because of what lies between its nodes. The march is
/// done once more, which costs less than to keep all of it, over the first windows of a very long run.
fn stepped_over<S: Real>(setup: &Setup<f64, Metric>, solution: &Solution<S>) -> f64 {
    let (metric, initial) = (setup.metric(), setup.initial());
    let (length, accuracy) = (solution.length.to_f64(), solution.accuracy.unwrap_or(promised(ACCURACIES[0])));
    let mut gaps = Gaps::new(metric, initial, length);
    let start = InitialData { t: 0.0, ..initial }.start(metric);
    let Ok(mut engine) = Engine::accurate(metric.scene(), &start, length, accuracy, POINTS) else {
        return gaps.share();
    };
    // It has the windows of the run, but for the last digit of its length, and does not fail where that did not.
    let _ = engine.run(|window| {
        gaps.see(&window, &Motion::new(&window, &start));
        if window.index >= WINDOWS.1 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    gaps.share()
}

/// The error of a node at equal time, to second order in dt. The node differs by `[dt, dx]` from the point x of the
/// world-line, where dx/dγ is `w_per_charge` times Q_t.
fn at_that_time(metric: &Metric, [dt, dx]: [f64; 2], x: f64, w_per_charge: f64) -> [f64; 2] {
    let g = metric.at(x);
    let velocity = w_per_charge * g.g00;
    [0.0, (dx - velocity * dt).abs() + 0.25 * (g.first * dt * dt).abs()]
}

/// The error of a run by the Taylor series of the reference, in the precision of the run.
fn by_taylor<S: Real>(setup: &Setup<f64, Metric>, solution: &Solution<S>, samples: &[Sample<S>]) -> Option<RunError> {
    let (metric, initial) = (solution.geometry(), solution.initial());
    let in_time = setup.duration().is_some();
    let reference = ReferenceTrajectory::new(metric, &initial, solution.length, solution.digits).ok()?;
    let mut found = Found::none(2);
    let mut sizes = [0.0_f64; 2];
    let mut points = points(solution, samples).peekable();
    while let Some([gamma, t, x]) = points.next() {
        let exact = reference.at(gamma);
        let (dt, dx) = (t - exact.elapsed, x - exact.x);
        sizes = [sizes[0].max(t.to_f64().abs()), sizes[1].max(x.to_f64().abs())];
        let off = [dt.to_f64(), dx.to_f64()];
        let x = exact.x.to_f64();
        let w = || (exact.x_dot / (metric.g00(exact.x) * exact.t_dot)).to_f64();
        found.see(if in_time && points.peek().is_none() { at_that_time(setup.metric(), off, x, w()) } else { off });
    }
    let error = reference.error_estimate();
    // It is asked only where a second solve agrees to many digits, which has looked between its nodes.
    Some(found.finish(own(sizes.map(|size| error * size), in_time), Judge::Taylor(error), 0.0))
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;
    use crate::geometry::potential::{Formula, Potential};

    /// V = 1e-3 exp(−((x − 0.707)/w)²) with c = 3, which a march of few nodes steps over: it goes straight on, and K
    /// between its nodes is off by what the hump does to g00.
    #[test]
    fn what_a_march_steps_over_is_known_between_its_nodes() {
        for (x, length, width) in [(-0.3, 4.0, 2e-3), (0.65, 0.25, 4e-5)] {
            let hump = format!("1e-3*exp(-((x-0.707)/{width})^2)");
            let hump = Formula::new(&hump, &BTreeMap::new()).unwrap();
            let metric = Metric::new(Potential::Formula(hump), 1.0, 3.0);
            let initial = InitialData { t: 0.0, x, t_dot: 1.2, x_dot: 0.5 };
            let k = |gamma: f64, q_t: f64| q_t * q_t / metric.g00(initial.x + 0.5 * gamma) - 0.25;
            let Invariants { q_t, k: start } = initial.invariants(&metric);
            let points = 400_000;
            let off: f64 =
                (0..points).map(|j| (k(length * (f64::from(j) + 0.5) / f64::from(points), q_t) - start).abs()).sum();
            let share = 0.5 * off / f64::from(points) / 0.25;
            for windows in [1, 3] {
                let mut gaps = Gaps::new(&metric, initial, length);
                let begin = InitialData { t: 0.0, ..initial }.start(&metric);
                // A run that begins again forgets what was seen before.
                for _ in 0..2 {
                    let mut engine = Engine::equal(metric.scene(), &begin, length, windows, 8).unwrap();
                    let mut end = 0.0;
                    let solved = engine.run(|window| {
                        gaps.see(&window, &Motion::new(&window, &begin));
                        end = window.end().positions()[1];
                        ControlFlow::Continue(())
                    });
                    solved.unwrap();
                    assert!((end - x - 0.5 * length).abs() < 1e-12, "it does not see the hump");
                }
                let found = gaps.share();
                assert!((found / share - 1.0).abs() < 1e-3, "{length} {windows}: {found:e} for {share:e}");
            }
        }
    }
}
