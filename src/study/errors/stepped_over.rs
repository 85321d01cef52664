//! The look whether a solve that judges another one has itself stepped over a feature: a hump of V, say, that is
//! narrower than its windows and lies between their nodes.
//!
//! Such a solve is smooth where the motion is not, and nothing on its nodes tells. But K at a point between them is
//! that of V or the metric *there*: inside of a hump that it does not know, K is off by all that the hump does to the
//! motion.

use std::ops::ControlFlow;

use crate::engine::{Dense, Engine, POINTS, Window};
use crate::geometry::{Geometry, Motion, OnNodes, Start};
use crate::number::Real;
use crate::reference::ReferenceTrajectory;
use crate::solve::{Setup, WorldLine};

/// So many points are looked at, spread evenly over the run.
const PROBES: usize = 8192;
/// The number of probes that are evaluated at a time.
const TOGETHER: usize = 256;
/// The least number of probes in every window.
const IN_A_WINDOW: usize = 8;
/// A deviation of K below this share of the largest term of K can be rounding.
const ROUNDING: f64 = 1e4 * f64::EPSILON;

/// The deviations of K at points between nodes.
#[derive(Debug, Clone, Copy, Default)]
struct Between {
    /// The integral of |ΔK| over γ.
    drift: f64,
    /// The largest contribution of motion to K.
    motion: f64,
    /// The length of γ that was looked at.
    length: f64,
}

impl Between {
    /// Takes a point into account, for this `length` of γ around it: the deviation of K there, the largest term of K,
    /// and what motion contributes to K.
    fn see(&mut self, length: f64, delta_k: f64, largest_term: f64, motion: f64) {
        self.motion = self.motion.max(motion);
        self.length += length.abs();
        // NaN is no rounding.
        let is_rounding = delta_k.abs() <= ROUNDING * largest_term.abs();
        if !is_rounding {
            self.drift += length.abs() * delta_k.abs();
        }
    }

    /// The share of its way by which a motion may be off. Where K is off by ΔK, the velocity is by half the share that
    /// ΔK is of the motion.
    fn share(self) -> f64 {
        if self.drift == 0.0 { 0.0 } else { 0.5 * self.drift / (self.motion * self.length) }
    }
}

/// The deviation of K along a motion without a force, which would change K.
struct Gaps<'g, S: Real> {
    geometry: &'g Geometry<S>,
    k: S,
    between: Between,
}

impl<'g, S: Real> Gaps<'g, S> {
    fn new(geometry: &'g Geometry<S>, start: &Start<S>) -> Self {
        Self { geometry, k: geometry.norm(&start.q, &start.q_dot), between: Between::default() }
    }

    /// Takes points into account, for this `length` of γ around each: rows of positions and velocities.
    fn see(&mut self, length: f64, q: &[Vec<S>], q_dot: &[Vec<S>]) {
        let [q, q_dot] = [q, q_dot].map(|rows| rows.iter().map(Vec::as_slice).collect::<Vec<_>>());
        let [norm, motion] = self.geometry.norm_and_motion(&q, &q_dot);
        for (k, (here, motion)) in norm.into_iter().zip(motion).enumerate() {
            let (motion, delta_k) = (motion.to_f64(), (here - self.k).to_f64());
            let mut largest = motion + self.k.to_f64().abs();
            if delta_k.abs() > ROUNDING * largest {
                largest += self.of_places(&[&q, &q_dot].map(|rows| rows.iter().map(|row| row[k]).collect::<Vec<S>>()));
            }
            self.between.see(length, delta_k, largest, motion);
        }
    }

    /// By how much K changes where positions change by as much as they are: next to rest it rounds like that.
    fn of_places(&self, [q, q_dot]: &[Vec<S>; 2]) -> f64 {
        let forces = self.geometry.forces(q, q_dot);
        2.0 * forces.iter().zip(q).map(|(force, q)| (*force * *q).to_f64().abs()).sum::<f64>()
    }

    fn share(&self) -> f64 {
        if self.geometry.has_force() { 0.0 } else { self.between.share() }
    }
}

/// The share of its way by which the motion may be off because of what the reference does not know.
pub(super) fn along_reference<S: Real>(line: &WorldLine<S>, reference: &ReferenceTrajectory<S>) -> f64 {
    let (geometry, start, length) = (line.geometry(), &line.place.start, line.length.to_f64());
    if S::IS_EXTENDED {
        return 0.0;
    }
    let mut gaps = Gaps::new(geometry, start);
    let places: Vec<f64> = fractions(PROBES).collect();
    for places in places.chunks(TOGETHER) {
        let points: Vec<_> = places.iter().map(|&place| reference.at(line.length * S::from(place))).collect();
        let row = |of: fn(&Start<S>) -> &[S], a: usize| points.iter().map(|point| of(point)[a]).collect();
        let rows = |of: fn(&Start<S>) -> &[S]| (0..start.q.len()).map(|a| row(of, a)).collect::<Vec<Vec<S>>>();
        gaps.see(length / PROBES as f64, &rows(|point| &point.q), &rows(|point| &point.q_dot));
    }
    gaps.share()
}

/// The same along windows of the engine.
pub(super) struct Windows<'g> {
    gaps: Gaps<'g, f64>,
    length: f64,
    start: Vec<f64>,
    motion: Motion<f64>,
    q: Vec<Vec<f64>>,
    p: Vec<Vec<f64>>,
    rates: Vec<Vec<f64>>,
}

impl<'g> Windows<'g> {
    /// Makes one of a run of this length.
    pub(super) fn new(geometry: &'g Geometry, start: &Start, length: f64) -> Self {
        let (n, m) = (start.q.len(), geometry.active().len());
        Self {
            gaps: Gaps::new(geometry, start),
            length,
            start: start.p.clone(),
            motion: geometry.motion_on_nodes(),
            q: vec![Vec::new(); n],
            p: vec![Vec::new(); m],
            rates: vec![Vec::new(); 2 * m],
        }
    }

    pub(super) fn see(&mut self, window: &Window<'_>, dense: &Dense) {
        let Self { gaps, length, start, motion, q, p, rates } = self;
        let (geometry, points) = (gaps.geometry, points_in(window.length / *length));
        q.iter_mut().chain(&mut *p).for_each(Vec::clear);
        dense.append(fractions(points), q, p);
        rates.iter_mut().for_each(|row| row.resize(points, 0.0));
        let each = window.length / points as f64;
        if motion.rates(OnNodes { q, p, start }, rates).is_err() {
            // A motion that is outside of the domain between its nodes is wrong.
            gaps.between.see(each, f64::INFINITY, 0.0, 1.0);
            return;
        }
        let (mut active, mut ignorable) = (rates.iter(), motion.steps(1.0).into_iter());
        let row = |a: usize| match geometry.active().contains(&a) {
            true => active.next().cloned(),
            false => ignorable.next(),
        };
        let q_dot: Vec<Vec<f64>> = (0..q.len()).filter_map(row).collect();
        gaps.see(each, q, &q_dot);
    }

    pub(super) fn share(&self) -> f64 {
        self.gaps.share()
    }
}

/// At most so many windows of a run to an accuracy are looked at.
const MOST_WINDOWS: usize = 10_000;

/// The share of its way by which a run to an accuracy may be off because of what lies between its nodes: 0 if its
/// windows were proved to see everything. Otherwise the march is done once more, over the first windows of a very long
/// run.
pub(super) fn own_windows<S: Real>(setup: &Setup<S>, line: &WorldLine<S>) -> f64 {
    let Some(accuracy) = line.accuracy.filter(|_| line.windows_unproved != Some(0)) else { return 0.0 };
    let (geometry, start) = (&*setup.rough.geometry, &*setup.rough.start);
    let length = line.length.to_f64();
    let mut windows = Windows::new(geometry, start, length);
    let Ok(mut engine) = Engine::accurate(geometry, start, length, accuracy, POINTS) else { return windows.share() };
    engine.set_floors(&setup.floors);
    // It has the windows of the run, but for the last digit of its length, and does not fail where that did not.
    let _ = engine.run(|window| {
        if window.index == 0 {
            windows.gaps.between = Between::default();
        }
        windows.see(&window, &window.dense());
        if window.index >= MOST_WINDOWS { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    windows.share()
}

/// The number of points in a window that is this share of the run.
fn points_in(share: f64) -> usize {
    (((PROBES as f64) * share).ceil() as usize).clamp(IN_A_WINDOW, PROBES)
}

/// The places of that many points in a window, as fractions of it.
fn fractions(points: usize) -> impl Iterator<Item = f64> {
    (0..points).map(move |k| (k as f64 + 0.5) / points as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::Accuracy;
    use crate::geometry::PotentialText;

    #[test]
    fn rounding_of_k_moves_nothing_and_a_nan_is_not_rounding() {
        let share = |delta_k: f64| {
            let mut between = Between::default();
            between.see(1.0, delta_k, 1e3, 1.0);
            between.share()
        };
        assert_eq!((share(0.0), share(1e-9), share(-1e-9)), (0.0, 0.0, 0.0));
        assert!(share(1e-8) > 0.0 && share(f64::NAN).is_nan());
        assert_eq!(Between::default().share(), 0.0);
    }

    #[test]
    fn points_are_the_middles_of_equal_parts() {
        for points in [1, 8, 9] {
            let places: Vec<f64> = fractions(points).collect();
            assert_eq!(places.len(), points);
            assert!(places.iter().zip(places.iter().rev()).all(|(a, b)| (a + b - 1.0).abs() < 1e-15), "{places:?}");
            assert!(places.windows(2).all(|pair| (pair[1] - pair[0] - 1.0 / points as f64).abs() < 1e-15));
        }
        // Windows of any length have the points of all of the run among them, and a few at least.
        assert_eq!([1.0, 0.5, 0.25, 1e-9].map(points_in), [PROBES, PROBES / 2, PROBES / 4, IN_A_WINDOW]);
    }

    /// V as a formula of x, and where a motion starts.
    fn of_x(expression: String, x: f64, [t_dot, x_dot]: [f64; 2]) -> (Geometry, Start) {
        let text = PotentialText {
            coordinates: vec!["x".to_owned()],
            expression,
            masses: vec!["1".to_owned()],
            mass: "1".to_owned(),
            c: "3".to_owned(),
            ..PotentialText::default()
        };
        let geometry: Geometry = Geometry::of_x(text).unwrap();
        let (q, q_dot) = (vec![0.0, x], vec![t_dot, x_dot]);
        let p = geometry.momenta(&q, &q_dot);
        (geometry, Start { q, q_dot, p })
    }

    /// V = 1e-3 exp(−((x − 0.707)/w)²), which windows of few nodes step over: they go straight on, and K between their
    /// nodes is off by what the hump does to g00.
    #[test]
    fn what_windows_step_over_is_known_between_their_nodes() {
        for (x, length, width) in [(-0.3, 4.0, 2e-3), (0.65, 0.25, 4e-5)] {
            let (geometry, begin) = of_x(format!("1e-3*exp(-((x-0.707)/{width})^2)"), x, [1.2, 0.5]);
            let k = |gamma: f64| begin.p[0].powi(2) / geometry.g00(&[0.0, x + 0.5 * gamma]).unwrap() - 0.25;
            let (points, start) = (400_000, geometry.norm(&begin.q, &begin.q_dot));
            let off: f64 =
                (0..points).map(|j| (k(length * (f64::from(j) + 0.5) / f64::from(points)) - start).abs()).sum();
            let share = 0.5 * off / f64::from(points) / 0.25;
            for windows in [1, 3] {
                let mut seen = Windows::new(&geometry, &begin, length);
                let mut engine = Engine::equal(&geometry, &begin, length, windows, 8).unwrap();
                while let Some(window) = engine.next().unwrap() {
                    seen.see(&window, &window.dense());
                }
                assert!((engine.place().1[1] - x - 0.5 * length).abs() < 1e-12, "they do not see the hump");
                let found = seen.share();
                assert!((found / share - 1.0).abs() < 1e-3, "{length} {windows}: {found:e} for {share:e}");
            }
        }
    }

    /// Windows count by their lengths, which are very different near a steep well.
    #[test]
    fn what_is_stepped_over_is_an_integral_over_gamma() {
        let (geometry, start) = of_x("-0.1/sqrt(x^2+0.01)".to_owned(), 1.5, [1.2, 0.0]);
        let (q_t, k) = (start.p[0], geometry.norm(&start.q, &start.q_dot));
        let (mut off, mut motion, mut lengths) = (0.0, 0.0_f64, [f64::INFINITY, 0.0]);
        let mut engine = Engine::accurate(&geometry, &start, 9.0, Accuracy::Local(1e-4), POINTS).unwrap();
        let mut seen = Windows::new(&geometry, &start, 9.0);
        while let Some(window) = engine.next().unwrap() {
            let (h, dense) = (window.length, window.dense());
            seen.see(&window, &dense);
            lengths = [lengths[0].min(h), lengths[1].max(h)];
            let points = (1e4 * h).ceil();
            for j in 0..points as usize {
                let (mut q, mut p) = ([0.0; 2], [0.0]);
                dense.at((j as f64 + 0.5) / points, &mut q, &mut p);
                let g00 = geometry.g00(&q).unwrap();
                off += h / points * (q_t * q_t / g00 - p[0] * p[0] - k).abs();
                motion = motion.max(p[0] * p[0]);
            }
        }
        assert!(lengths[1] > 3.0 * lengths[0], "{lengths:?}");
        let (share, found) = (0.5 * off / (motion * 9.0), seen.share());
        assert!(share > 1e-9 && (found / share - 1.0).abs() < 0.01, "{found:e} for {share:e}");
    }
}
