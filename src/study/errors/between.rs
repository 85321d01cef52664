//! The look whether a solve that judges another one has itself stepped over a feature: a hump of V, say, that is
//! narrower than its windows and lies between their nodes.
//!
//! Such a solve is smooth where the motion is not, and nothing on its nodes tells. But K at a point between them is
//! that of V or the metric *there*: inside of a hump that it does not know, K is off by all that the hump does to the
//! motion.

use std::ops::ControlFlow;

use crate::engine::{Dense, Engine, Window};
use crate::geometry::{Geometry, Motion, OnNodes, Start};
use crate::number::Real;
use crate::number::norm::larger;
use crate::solve::{Place, Setup, WorldLine};

/// So many points are looked at, spread evenly over the run.
pub(super) const PROBES: usize = 8192;
/// The least number of probes in every window.
const IN_A_WINDOW: usize = 8;
/// A deviation of K below this share of the largest term of K can be rounding.
const ROUNDING: f64 = 1e4 * f64::EPSILON;
/// At most so many windows of a run to an accuracy are looked at.
const MOST_WINDOWS: usize = 10_000;

/// The deviation of K between the nodes of a run.
pub(super) struct Between<'g> {
    geometry: &'g Geometry,
    /// K and p_a at the start, and the length of the run.
    k: f64,
    start: Vec<f64>,
    length: f64,
    /// Rounding takes so much from K, as its formulas lose digits.
    lost: f64,
    /// The integral of |ΔK| over the γ that was looked at.
    drift: f64,
    seen: f64,
    /// The largest contribution of motion to K.
    motion: f64,
    /// Rooms for q^a and p_a in a window.
    q: Vec<Vec<f64>>,
    p: Vec<Vec<f64>>,
    on_nodes: Motion<f64>,
}

impl<'g> Between<'g> {
    pub(super) fn new(geometry: &'g Geometry, start: &Start, length: f64, lost: f64) -> Self {
        let (n, m) = (start.q.len(), geometry.active().len());
        Self {
            geometry,
            k: geometry.norm(&start.q, &start.q_dot),
            start: start.p.clone(),
            length,
            lost,
            drift: 0.0,
            seen: 0.0,
            motion: 0.0,
            q: vec![Vec::new(); n],
            p: vec![Vec::new(); m],
            on_nodes: Motion::new(geometry),
        }
    }

    /// Takes a point into account, for this `length` of γ around it: the deviation of K there, the largest term of K,
    /// and what motion contributes to K.
    fn see_point(&mut self, length: f64, delta_k: f64, largest_term: f64, motion: f64) {
        self.motion = larger(self.motion, motion);
        self.seen += length.abs();
        // NaN is no rounding.
        let is_rounding = delta_k.abs() <= ROUNDING * largest_term.abs() + self.lost;
        if !is_rounding {
            self.drift += length.abs() * delta_k.abs();
        }
    }

    /// Takes points into account, for this `length` of γ around each: rows of positions and velocities.
    fn see_rows(&mut self, length: f64, q: &[Vec<f64>], q_dot: &[Vec<f64>]) {
        let [q, q_dot] = [q, q_dot].map(|rows| rows.iter().map(Vec::as_slice).collect::<Vec<_>>());
        let [norm, motion] = self.geometry.norm_and_motion(&q, &q_dot);
        for (k, (here, motion)) in norm.into_iter().zip(motion).enumerate() {
            let delta_k = here - self.k;
            let mut largest = motion + self.k.abs();
            if delta_k.abs() > ROUNDING * largest {
                // Next to rest K rounds as it changes where positions change by as much as they are.
                let [q, q_dot] = [&q, &q_dot].map(|rows| rows.iter().map(|row| row[k]).collect::<Vec<f64>>());
                let forces = self.geometry.forces(&q, &q_dot);
                largest += 2.0 * forces.iter().zip(&q).map(|(force, q)| (force * q).abs()).sum::<f64>();
            }
            self.see_point(length, delta_k, largest, motion);
        }
    }

    /// Takes the points in the middles of [`PROBES`] parts of the whole run into account.
    pub(super) fn see_points(&mut self, points: Vec<Start>) {
        let rows = |of: fn(&Start) -> &[f64]| {
            let row = |a: usize| points.iter().map(|point| of(point)[a]).collect();
            (0..self.geometry.dimension()).map(row).collect::<Vec<Vec<f64>>>()
        };
        let [q, q_dot] = [rows(|point| &point.q), rows(|point| &point.q_dot)];
        self.see_rows(self.length / PROBES as f64, &q, &q_dot);
    }

    /// Takes a window of the engine into account.
    pub(super) fn see(&mut self, window: &Window<'_>, dense: &Dense) {
        let Self { q, p, .. } = self;
        let points = (PROBES as f64 * (window.length / self.length)).ceil() as usize;
        let points = points.clamp(IN_A_WINDOW, PROBES);
        q.iter_mut().chain(&mut *p).for_each(Vec::clear);
        dense.append(middles(points), q, p);
        let each = window.length / points as f64;
        let mut rates = Vec::new();
        if self.on_nodes.all_rates(OnNodes { q, p, start: &self.start }, points, &mut rates).is_err() {
            // A motion that is outside of the domain between its nodes is wrong.
            self.see_point(each, f64::INFINITY, 0.0, 1.0);
            return;
        }
        let q = std::mem::take(q);
        self.see_rows(each, &q, &rates[..q.len()]);
        self.q = q;
    }

    /// The share of its way by which a motion may be off. Where K is off by ΔK, the velocity is by half the share that
    /// ΔK is of the motion. A force changes K, and nothing is known.
    pub(super) fn share(&self) -> f64 {
        if self.drift == 0.0 || self.geometry.has_force() {
            return 0.0;
        }
        0.5 * self.drift / (self.motion * self.seen)
    }
}

/// The share of its way by which a run to an accuracy may be off because of what lies between its nodes: 0 if its
/// windows were proved to see everything. Otherwise the march is done once more, over the first windows of a very long
/// run. Rounding takes `lost` from K.
pub(super) fn own_windows<S: Real>(setup: &Setup<S>, line: &WorldLine<S>, lost: f64) -> f64 {
    let Some(accuracy) = line.accuracy.filter(|_| line.windows_unproved != Some(0)) else { return 0.0 };
    let (place, length) = (&setup.rough, line.length.to_f64());
    let Ok(mut engine) = Engine::accurate(&place.geometry, &place.start, length, accuracy) else { return 0.0 };
    engine.set_floors(&setup.floors);
    share_of(&mut engine, (place, length, lost), MOST_WINDOWS)
}

/// The share of its way by which the march of `engine` may be off, which goes from a place over this length, and is
/// looked at in so many windows at most. Rounding takes `lost` from K.
pub(super) fn share_of(engine: &mut Engine<'_>, (place, length, lost): (&Place, f64, f64), most: usize) -> f64 {
    let mut between = Between::new(&place.geometry, &place.start, length, lost);
    // It has the windows of a run that was solved, but for the last digit of its length, and fails where that did.
    let _ = engine.run(|window| {
        if window.index == 0 {
            (between.drift, between.seen, between.motion) = (0.0, 0.0, 0.0);
        }
        between.see(&window, &window.dense());
        if window.index >= most { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    between.share()
}

/// The middles of so many equal parts, as fractions of the whole.
pub(super) fn middles(parts: usize) -> impl Iterator<Item = f64> {
    (0..parts).map(move |k| (k as f64 + 0.5) / parts as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::Accuracy;
    use crate::geometry::GeometryText;

    /// V as a formula of x, and where a motion starts.
    fn of_x(expression: &str, x: f64, x_dot: f64) -> (Geometry, Start) {
        let geometry: Geometry = Geometry::of_x(&GeometryText::of_x(expression, 1.0, 3.0)).unwrap();
        let (q, q_dot) = (vec![0.0, x], vec![1.2, x_dot]);
        let p = geometry.momenta(&q, &q_dot);
        (geometry, Start { q, q_dot, p })
    }

    /// K is off between nodes by what a hump that windows go straight across does to g00, and windows count by their
    /// lengths, which are very different near a steep well.
    #[test]
    fn what_is_stepped_over_is_an_integral_over_gamma() {
        let hump = "1e-3*exp(-((x-0.707)/2e-3)^2)";
        for (expression, (x, x_dot), length, windows) in
            [(hump, (-0.3, 0.5), 4.0, 1), (hump, (-0.3, 0.5), 4.0, 3), ("-0.1/sqrt(x^2+0.01)", (1.5, 0.0), 9.0, 0)]
        {
            let (geometry, start) = of_x(expression, x, x_dot);
            let (q_t, k) = (start.p[0], geometry.norm(&start.q, &start.q_dot));
            let mut engine = match windows {
                0 => Engine::accurate(&geometry, &start, length, Accuracy::Local(1e-4)).unwrap(),
                _ => Engine::equal(&geometry, &start, length, windows, 8).unwrap(),
            };
            let (mut off, mut motion, mut seen) = (0.0, 0.0_f64, Between::new(&geometry, &start, length, 0.0));
            while let Some(window) = engine.next().unwrap() {
                let (h, dense) = (window.length, window.dense());
                seen.see(&window, &dense);
                let points = (5e4 * h).ceil() as usize;
                for place in middles(points) {
                    let (mut q, mut p) = ([0.0; 2], [0.0]);
                    dense.at(place, &mut q, &mut p);
                    off += h / points as f64 * (q_t * q_t / geometry.g00(&q).unwrap() - p[0] * p[0] - k).abs();
                    motion = motion.max(p[0] * p[0]);
                }
            }
            let (share, found) = (0.5 * off / (motion * length), seen.share());
            assert!(share > 1e-9 && (found / share - 1.0).abs() < 0.01, "{expression}: {found:e} for {share:e}");
            assert!(windows == 0 || (engine.place().1[1] - x - 0.5 * length).abs() < 1e-12, "the hump is not seen");
            seen.see_point(1.0, f64::NAN, 1e3, 1.0);
            assert!(seen.share().is_nan(), "it is no rounding");
        }
    }
}
