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
use crate::geometry::{Geometry, Start};
use crate::number::Real;
use crate::reference::ReferenceTrajectory;
use crate::solve::{Limit, Setup, Solution};
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
pub fn run_error<S: Real>(setup: &Setup, solution: &Solution<S>, samples: &[Sample<S>]) -> Option<RunError> {
    if let Some(estimate) = solution.error_estimate {
        let largest: Vec<f64> = solution.sizes.iter().map(|size| estimate * size).collect();
        // If the run ends at a given time, all of its error there is one of x.
        let end = if ends_in_time(setup) { vec![0.0, largest[1]] } else { largest.clone() };
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
    let from_start = |sample: &Sample<S>| [sample.gamma - solution.gamma_i, sample.q[0] - solution.t_i(), sample.q[1]];
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
    fn new<S: Real>(setup: &Setup, points: impl Iterator<Item = [S; 3]>) -> Self {
        let (mut gamma, mut elapsed, mut x) = (Vec::new(), Vec::new(), Vec::new());
        for point in points {
            let [gamma_here, t, x_here] = point.map(S::to_f64);
            gamma.push(gamma_here);
            elapsed.push(t);
            x.push(x_here);
        }
        let size = |values: &[f64]| values.iter().fold(0.0, |size: f64, value| size.max(value.abs()));
        let sizes = [size(&elapsed), size(&x)];
        Self { gamma, elapsed, x, in_time: ends_in_time(setup), sizes }
    }

    fn by_second_solve(&self, setup: &Setup) -> Option<RunError> {
        ACCURACIES.into_iter().find_map(|accuracy| self.second_solve(setup, accuracy))
    }

    fn second_solve(&self, setup: &Setup, accuracy: f64) -> Option<RunError> {
        let (geometry, start) = (&*setup.place.geometry, &*setup.place.start);
        let q_t = start.p[0];
        let (most, length) = (WINDOWS.1.max(WINDOWS.0 * self.x.len()), *self.gamma.last()?);
        let (mut found, mut next, mut tired) = (Found::none(2), 0, false);
        let mut gaps = Gaps::new(geometry, start, length);
        let mut engine = Engine::accurate(geometry, start, length, promised(accuracy), POINTS).ok()?;
        let solved = engine.run(|window| {
            if window.index == 0 {
                (found, next) = (Found::none(2), 0);
            }
            let (begin, h) = (window.gamma, window.length);
            let is_last = begin + h >= length * (1.0 - 4.0 * f64::EPSILON);
            let motion = Motion::new(&window);
            while let Some(gamma) = self.gamma.get(next).filter(|gamma| **gamma < begin + h || is_last) {
                let is_end = next + 1 == self.x.len();
                let fraction = if is_end { 1.0 } else { ((gamma - begin) / h).clamp(0.0, 1.0) };
                let [t, x, w] = motion.at(fraction);
                let off = [self.elapsed[next] - t, self.x[next] - x];
                found.see(if is_end && self.in_time { at_that_time(geometry, off, x, w / q_t) } else { off });
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

/// True if the run is to end at a time.
fn ends_in_time(setup: &Setup) -> bool {
    matches!(setup.limit, Limit::Value { .. })
}

/// g00 at x.
fn g00(geometry: &Geometry, x: f64) -> f64 {
    geometry.g00(&[0.0, x]).unwrap_or(f64::NAN)
}

/// A run that keeps its accuracy, without certificates.
fn promised(accuracy: f64) -> Accuracy {
    Accuracy::Promised(accuracy)
}

/// t from the start of the run, x and dx/dγ in a window.
struct Motion(Dense);

impl Motion {
    fn new(window: &Window<'_>) -> Self {
        Self(window.dense())
    }

    fn at(&self, fraction: f64) -> [f64; 3] {
        let (mut q, mut p) = ([0.0; 2], [0.0; 1]);
        self.0.at(fraction, &mut q, &mut p);
        [q[0], q[1], -p[0]]
    }
}

/// What K is off by between the nodes of a march.
struct Gaps<'g> {
    geometry: &'g Geometry,
    q_t: f64,
    k: f64,
    length: f64,
    between: Between,
}

impl<'g> Gaps<'g> {
    fn new(geometry: &'g Geometry, start: &Start, length: f64) -> Self {
        let k = geometry.norm(&start.q, &start.q_dot);
        Self { geometry, q_t: start.p[0], k, length, between: Between::default() }
    }

    fn see(&mut self, window: &Window<'_>, motion: &Motion) {
        if window.index == 0 {
            self.between = Between::default();
        }
        let points = points_in(window.length / self.length);
        let length = window.length / points as f64;
        fractions(points).for_each(|fraction| {
            let [_, x, w] = motion.at(fraction);
            let timelike = self.q_t * self.q_t / g00(self.geometry, x);
            self.between.see(length, timelike - w * w - self.k, timelike, w * w);
        });
    }

    fn share(&self) -> f64 {
        self.between.share()
    }
}

/// The share of its way by which a run to an accuracy may be off because of what lies between its nodes. The march is
/// done once more, which costs less than to keep all of it, over the first windows of a very long run.
fn stepped_over<S: Real>(setup: &Setup, solution: &Solution<S>) -> f64 {
    let (geometry, start) = (&*setup.place.geometry, &*setup.place.start);
    let (length, accuracy) = (solution.length.to_f64(), solution.accuracy.unwrap_or(promised(ACCURACIES[0])));
    let mut gaps = Gaps::new(geometry, start, length);
    let Ok(mut engine) = Engine::accurate(geometry, start, length, accuracy, POINTS) else {
        return gaps.share();
    };
    // It has the windows of the run, but for the last digit of its length, and does not fail where that did not.
    let _ = engine.run(|window| {
        gaps.see(&window, &Motion::new(&window));
        if window.index >= WINDOWS.1 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    gaps.share()
}

/// The error of a node at equal time, to second order in dt. The node differs by `[dt, dx]` from the point x of the
/// world-line, where dx/dγ is `w_per_charge` times Q_t.
fn at_that_time(geometry: &Geometry, [dt, dx]: [f64; 2], x: f64, w_per_charge: f64) -> [f64; 2] {
    let samples = geometry.at(&[0.0, x]);
    let [g00, slope, _] = geometry.sources_of_g00().map(|source| samples.at(source, 0));
    let velocity = w_per_charge * g00;
    [0.0, (dx - velocity * dt).abs() + 0.25 * (slope * dt * dt).abs()]
}

/// The error of a run by the Taylor series of the reference, in the precision of the run.
fn by_taylor<S: Real>(setup: &Setup, solution: &Solution<S>, samples: &[Sample<S>]) -> Option<RunError> {
    let (geometry, start) = (solution.geometry(), &solution.place.start);
    let in_time = ends_in_time(setup);
    let reference = ReferenceTrajectory::new(geometry, start, solution.length, solution.digits).ok()?;
    let mut found = Found::none(2);
    let mut sizes = [0.0_f64; 2];
    let mut points = points(solution, samples).peekable();
    while let Some([gamma, t, x]) = points.next() {
        let exact = reference.at(gamma);
        let (dt, dx) = (t - exact.q[0], x - exact.q[1]);
        sizes = [sizes[0].max(t.to_f64().abs()), sizes[1].max(x.to_f64().abs())];
        let off = [dt.to_f64(), dx.to_f64()];
        let x = exact.q[1].to_f64();
        let w = || (exact.q_dot[1] / exact.p[0]).to_f64();
        found.see(if in_time && points.peek().is_none() {
            at_that_time(&setup.place.geometry, off, x, w())
        } else {
            off
        });
    }
    let error = reference.error_estimate();
    // It is asked only where a second solve agrees to many digits, which has looked between its nodes.
    Some(found.finish(own(sizes.map(|size| error * size), in_time), Judge::Taylor(error), 0.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case::Case;

    /// V = 1e-3 exp(−((x − 0.707)/w)²) with c = 3, which a march of few nodes steps over: it goes straight on, and K
    /// between its nodes is off by what the hump does to g00.
    #[test]
    fn what_a_march_steps_over_is_known_between_its_nodes() {
        for (x, length, width) in [(-0.3, 4.0, 2e-3), (0.65, 0.25, 4e-5)] {
            let text = format!(
                "potential.formula = \"1e-3*exp(-((x-0.707)/{width})^2)\"\nparticle.c = 3.0\n\
                 initial = {{ x = {x:?}, t_dot = 1.2, x_dot = 0.5 }}\ngrid.n_gamma = 32\nscheme.sbp = \"SBP21\"\n"
            );
            let case = Case::parse("hump", &text, &[]).unwrap();
            let (geometry, begin): (Geometry, Start) = (case.geometry(), case.start());
            let (q_t, start) = (begin.p[0], geometry.norm(&begin.q, &begin.q_dot));
            let k = |gamma: f64, q_t: f64| q_t * q_t / g00(&geometry, x + 0.5 * gamma) - 0.25;
            let points = 400_000;
            let off: f64 =
                (0..points).map(|j| (k(length * (f64::from(j) + 0.5) / f64::from(points), q_t) - start).abs()).sum();
            let share = 0.5 * off / f64::from(points) / 0.25;
            for windows in [1, 3] {
                let mut gaps = Gaps::new(&geometry, &begin, length);
                // A run that begins again forgets what was seen before.
                for _ in 0..2 {
                    let mut engine = Engine::equal(&geometry, &begin, length, windows, 8).unwrap();
                    let mut end = 0.0;
                    let solved = engine.run(|window| {
                        gaps.see(&window, &Motion::new(&window));
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
