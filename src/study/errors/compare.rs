//! The comparison of a run with a second and cheaper solve, and with the Taylor series of [`crate::reference`].

use super::stepped_over::{Windows, along_reference};
use super::{Judge, RunError};
use crate::diagnostics::Reach;
use crate::engine::{Accuracy, Engine, POINTS};
use crate::geometry::largest_of_kind;
use crate::number::Real;
use crate::reference::ReferenceTrajectory;
use crate::solve::{Place, WorldLine};
use crate::trajectory::Sample;

/// The accuracy of every window of the second solve. What they add up to is estimated on its way.
const ACCURACY: f64 = 1e-13;

/// The largest number of windows of the second solve: the first number is per node of the run, and the second one is
/// allowed in any case.
const WINDOWS: (usize, usize) = (1, 10_000);

/// The nodes of a run, counted from its start and its origin, or samples in place of some of them.
pub(super) struct Points<S> {
    /// γ − γ_i.
    gamma: Vec<S>,
    /// q^a, a row for each coordinate.
    rows: Vec<Vec<S>>,
    /// dq^a/dγ at the end.
    q_dot: Vec<S>,
    /// The coordinate whose value ended the run, if one did. The last point is compared at that value.
    clock: Option<usize>,
    /// The origins of sizes: 0 of active coordinates, and the start of ignorable ones.
    origins: Vec<S>,
    /// For each coordinate the first with the same metric coefficient.
    alike: Vec<usize>,
}

impl<S: Real> Points<S> {
    /// The samples before `line`, and its nodes.
    pub(super) fn new(line: &WorldLine<S>, samples: &[Sample<S>], clock: Option<usize>) -> Self {
        let (geometry, start) = (line.geometry(), &line.place.start);
        let n = geometry.dimension();
        let mut gamma: Vec<S> = Vec::with_capacity(line.nodes());
        let mut rows: Vec<Vec<S>> = vec![Vec::with_capacity(line.nodes()); n];
        let first = line.gamma_from_start().next().unwrap_or(S::ZERO);
        let from_start = |sample: &Sample<S>| line.signed(sample.gamma - line.gamma_i);
        let mut before: Vec<&Sample<S>> = samples.iter().filter(|sample| from_start(sample) < first).collect();
        if before.first().zip(before.last()).is_some_and(|(first, last)| from_start(first) > from_start(last)) {
            before.reverse();
        }
        gamma.extend(before.iter().map(|sample| from_start(sample)));
        gamma.extend(line.gamma_from_start());
        for (a, row) in rows.iter_mut().enumerate() {
            row.extend(before.iter().map(|sample| sample.q[a] - line.origin_of(a)));
            row.extend(line.counted_from_origin(a, &line.q[a]));
        }
        let origin = |a: usize| if geometry.active().contains(&a) { S::ZERO } else { start.q[a] };
        let (q_dot, alike) = (line.end_inside().q_dot, geometry.alike(&start.q));
        Self { gamma, rows, q_dot, clock, origins: (0..n).map(origin).collect(), alike }
    }

    /// Number of points.
    fn len(&self) -> usize {
        self.gamma.len()
    }

    /// The size of every coordinate, shared with others of its kind.
    pub(super) fn sizes(&self) -> Vec<f64> {
        let far = |(row, &origin): (&Vec<S>, &S)| Reach::of(row.iter().map(|&q| (q - origin).to_f64())).size();
        let sizes: Vec<f64> = self.rows.iter().zip(&self.origins).map(far).collect();
        largest_of_kind(&self.alike, &sizes)
    }

    /// By how much the last point is off at most in every coordinate, where it is off by `off` at equal γ from a
    /// world-line with `q_dot` there. Where the value of a coordinate ended the run, points with that value are
    /// compared: the pace of the world-line on the way there changes by about half of what it differs at both ends.
    fn at_end(&self, off: Vec<f64>, q_dot: &[f64]) -> Vec<f64> {
        let Some(clock) = self.clock else { return off };
        let at = |a: usize| {
            let pace = q_dot[a] / q_dot[clock];
            (off[a] - off[clock] * pace).abs() + 0.5 * off[clock].abs() * (self.pace(a, clock) - pace).abs()
        };
        (0..off.len()).map(|a| if a == clock { 0.0 } else { at(a) }).collect()
    }

    /// dq^a by the change of the coordinate `clock`, at the end.
    fn pace(&self, a: usize, clock: usize) -> f64 {
        (self.q_dot[a] / self.q_dot[clock]).to_f64()
    }

    /// The errors of a judge that is off by so much in every coordinate. In a run that ends at a value of one, all of
    /// the error is in the others.
    fn own(&self, mut errors: Vec<f64>) -> Vec<f64> {
        if let Some(clock) = self.clock {
            let late = std::mem::take(&mut errors[clock]);
            let others = errors.iter_mut().enumerate().filter(|(a, _)| *a != clock);
            others.for_each(|(a, own)| *own += late * self.pace(a, clock).abs());
        }
        errors
    }
}

/// The errors found so far, node by node.
#[derive(Debug)]
struct Found {
    largest: Vec<f64>,
    last: Vec<f64>,
}

impl Found {
    fn none(coordinates: usize) -> Self {
        Self { largest: vec![0.0; coordinates], last: vec![0.0; coordinates] }
    }

    /// Takes the next node into account, which is off by this.
    fn see(&mut self, off: impl IntoIterator<Item = f64>) {
        for ((largest, last), off) in self.largest.iter_mut().zip(&mut self.last).zip(off) {
            *last = off.abs();
            // A comparison that is false for NaN would drop it.
            *largest = if *last > *largest || last.is_nan() { *last } else { *largest };
        }
    }

    /// All nodes have been seen.
    fn finish(self, own: Vec<f64>, judge: Judge, stepped_over: f64) -> RunError {
        RunError { end: self.last, largest: self.largest, own, judge, stepped_over }
    }
}

/// Compares the points of a run that starts at `place`. `None` if the second solve does not reach the end.
pub(super) fn with_second_solve<S: Real>(place: &Place, points: &Points<S>) -> Option<RunError> {
    let (geometry, start) = (&*place.geometry, &*place.start);
    let (most, last) = (WINDOWS.1.max(WINDOWS.0 * points.len()), points.len() - 1);
    let length = points.gamma[last].to_f64();
    let mut engine = Engine::accurate(geometry, start, length, Accuracy::Estimated(ACCURACY), POINTS).ok()?;
    let (mut found, mut next) = (Found::none(start.q.len()), 0);
    let mut between = Windows::new(geometry, start, length);
    let (mut q, mut p) = (vec![Vec::new(); start.q.len()], vec![Vec::new(); geometry.active().len()]);
    let (mut end, mut end_p) = (start.q.clone(), start.p.clone());
    // Windows that may add up to anything are never begun again.
    while let Some(window) = engine.next().ok()? {
        let (begin, h, dense) = (window.gamma, window.length, window.dense());
        let is_here = |k: &usize| window.is_last || points.gamma[*k].to_f64() < begin + h;
        let here = next..(next..last).take_while(is_here).last().map_or(next, |k| k + 1);
        q.iter_mut().chain(&mut p).for_each(Vec::clear);
        let fractions = here.clone().map(|k| ((points.gamma[k].to_f64() - begin) / h).clamp(0.0, 1.0));
        dense.append(fractions, &mut q, &mut p);
        for k in here.clone() {
            found.see(points.rows.iter().zip(&q).map(|(row, q)| row[k].to_f64() - q[k - next]));
        }
        next = here.end;
        between.see(&window, &dense);
        end.clone_from(&window.end().positions());
        geometry.active().iter().zip(window.end().momenta()).for_each(|(&a, p)| end_p[a] = p);
        if window.index >= most {
            return None;
        }
    }
    if next < last {
        return None;
    }
    let off = points.rows.iter().zip(&end).map(|(row, q)| row[last].to_f64() - q).collect();
    found.see(points.at_end(off, &geometry.velocities(&end, &end_p).ok()?));
    let (estimate, sizes) = (engine.error_estimate()?, engine.sizes());
    let own = points.own(sizes.iter().map(|size| estimate * size).collect());
    Some(found.finish(own, Judge::SecondSolve(estimate), between.share()))
}

/// Compares the points of a world-line with a Taylor reference of as many digits. `None` if that does not reach the
/// end.
pub(super) fn with_taylor<S: Real>(line: &WorldLine<S>, points: &Points<S>) -> Option<RunError> {
    let (geometry, start) = (line.geometry(), &line.place.start);
    let reference = ReferenceTrajectory::new(geometry, start, line.length, line.digits).ok()?;
    let mut found = Found::none(geometry.dimension());
    let last = points.len() - 1;
    for (k, &gamma) in points.gamma[..last].iter().enumerate() {
        let exact = reference.at(gamma);
        found.see(points.rows.iter().zip(&exact.q).map(|(row, &q)| (row[k] - q).to_f64()));
    }
    let end = reference.at(line.length);
    let off = points.rows.iter().zip(&end.q).map(|(row, &q)| (row[last] - q).to_f64()).collect();
    let q_dot: Vec<f64> = end.q_dot.iter().map(|q_dot| q_dot.to_f64()).collect();
    found.see(points.at_end(off, &q_dot));
    let error = reference.error_estimate();
    let own = points.own(points.sizes().into_iter().map(|size| error * size).collect());
    Some(found.finish(own, Judge::Taylor(error), along_reference(line, &reference)))
}
