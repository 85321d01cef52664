//! What is known of the error of a world-line in a scene.

use super::state::FlowState;
use super::transport::{Local, Transport};
use super::tuning::{TUNING, Tuning, fall, ratio, unseen};
use super::window::{FlowWindow, Weights};
use crate::geometry::Geometry;

/// The minimum of the estimate: the result is rounded.
pub(super) const ROUNDING: f64 = 2.0 * f64::EPSILON;

/// Sizes of the coordinates, and the largest error relative to them.
pub(super) struct Judge<'g> {
    geometry: &'g Geometry,
    tuning: Tuning,
    ignorable: Vec<usize>,
    start: Vec<f64>,
    /// max(1, |q^a|) of active coordinates, max(1, |q^a − q_i^a|) of ignorable ones, at most so far.
    pub(super) sizes: Vec<f64>,
    pub(super) weights: Weights,
    /// The coordinate whose value ends the run, and the largest |dq^a/dt| so far with it in place of t: by this much
    /// its error counts as one of q^a, as the end is compared at an equal value.
    clock: Option<usize>,
    paces: Vec<f64>,
    /// Of the linearised equations: all entries by rows, and room for their square.
    entries: Vec<f64>,
    square: Vec<f64>,
    /// Largest |∂q̇^b/∂p_a| over the size of q^b, by place of a.
    coupling: Vec<f64>,
    /// K at the start, and how far it may be off because of rounding.
    norm: f64,
    rounds: f64,
    worst: f64,
    /// The largest error that a change of K stands for.
    by_norm: f64,
    inside: f64,
}

/// What the modes of a window show.
#[derive(Debug, Clone, Copy)]
pub(super) struct WindowErrors {
    /// The error at its end.
    pub(super) end: f64,
    /// The error at the nodes inside it.
    pub(super) inside: f64,
    /// The factor by which the slowest modes fall from one to the next.
    pub(super) fall: f64,
}

impl WindowErrors {
    /// Of a window that was not solved.
    pub(super) const NONE: Self = Self { end: f64::INFINITY, inside: f64::INFINITY, fall: 1.0 };
}

/// The error in units of the probe, at most. In the median of thousands of random scenes it is a fiftieth; on
/// ellipses in windows that are allowed a large error, where modes fall slowly, it can be a little more than one.
pub(super) const CAUTION: f64 = 2.0;

/// The rounding of a window in units of that of its largest rate, where the kinetic part is constant and elsewhere:
/// rates that need the inverse of the metric are rounded more than once.
const ROUNDED: [f64; 2] = [0.5, 2.0];

/// The rounding of a window's rates because positions and momenta are rounded on its nodes, in units of what a unit in
/// the last place of all of them does. Near a mass this is more than the rounding of the rates themselves.
pub(super) const ROUNDED_NODES: f64 = 0.25;

/// What K is off by because it is rounded, in units of the rounding of its terms.
const K_ROUNDS: f64 = 16.0 * f64::EPSILON;

/// What a change of K means for the coordinates, in units of the smallest error that makes it.
pub(super) const BY_NORM: f64 = 3.0;

impl<'g> Judge<'g> {
    /// From the start, where all momenta are `momenta`, for a run that ends at a value of the coordinate `clock`.
    pub(super) fn new(geometry: &'g Geometry, start: &FlowState, momenta: &[f64], clock: Option<usize>) -> Self {
        let m = geometry.active().len();
        let q: Vec<f64> = start.q.iter().map(|q| q.hi).collect();
        let mut judge = Self {
            geometry,
            tuning: TUNING,
            ignorable: geometry.ignorable().collect(),
            sizes: vec![1.0; q.len()],
            weights: Weights { q: vec![1.0; q.len()], p: vec![0.0; m] },
            clock,
            paces: vec![0.0; q.len()],
            entries: vec![0.0; 4 * m * m],
            square: vec![0.0; 4 * m * m],
            coupling: vec![0.0; m],
            norm: 0.0,
            rounds: 0.0,
            worst: 0.0,
            by_norm: 0.0,
            inside: 0.0,
            start: q.clone(),
        };
        judge.set_norm(&q, momenta, start);
        judge.measure(start);
        judge
    }

    /// K and the size of its terms at the start.
    fn set_norm(&mut self, q: &[f64], momenta: &[f64], start: &FlowState) {
        let mut p = momenta.to_vec();
        for (&a, active) in self.geometry.active().iter().zip(&start.p) {
            p[a] = active.hi;
        }
        let mut point = self.geometry.point();
        // A start outside the domain is found by the first window.
        let _ = point.evaluate(q, &p);
        let q_dot: Vec<f64> = (0..q.len()).map(|a| point.q_dot(a)).collect();
        self.norm = self.geometry.norm(q, &q_dot);
        self.keep_pace(|a| q_dot[a]);
        let terms = q_dot.iter().zip(&p).map(|(q_dot, p)| (q_dot * p).abs());
        self.rounds = K_ROUNDS * terms.sum::<f64>();
    }

    /// Brings the sizes up to date with a joint.
    fn measure(&mut self, state: &FlowState) {
        for &a in self.geometry.active() {
            self.sizes[a] = self.sizes[a].max(state.q[a].hi.abs());
        }
        for &a in &self.ignorable {
            self.sizes[a] = self.sizes[a].max((state.q[a].hi - self.start[a]).abs());
        }
        self.weights.q.iter_mut().zip(&self.sizes).for_each(|(weight, size)| *weight = 1.0 / size);
        if let Some(clock) = self.clock {
            let others = self.paces.iter().zip(&self.sizes).map(|(pace, size)| pace / size);
            self.weights.q[clock] = others.fold(self.weights.q[clock], f64::max);
        }
    }

    /// Brings the paces up to date with velocities.
    fn keep_pace(&mut self, velocity: impl Fn(usize) -> f64) {
        let Some(clock) = self.clock else { return };
        let per_time = 1.0 / velocity(clock);
        for (a, pace) in self.paces.iter_mut().enumerate() {
            let here = (velocity(a) * per_time).abs();
            // Where the clock stands still no error is finite.
            if a != clock && here.is_finite() {
                *pace = pace.max(here);
            }
        }
    }

    /// The rate of the motion where `transport` has arrived, in radians.
    pub(super) fn look_at(&mut self, transport: &Transport<'_>) -> f64 {
        let active = self.geometry.active();
        let m = active.len();
        self.coupling.fill(0.0);
        let (coupling, sizes, entries) = (&mut self.coupling, &self.sizes, &mut self.entries);
        transport.at_end(|row, column, value| {
            entries[row * 2 * m + column] = value;
            if row < m && column >= m {
                let value = value.abs() / sizes[active[row]];
                coupling[column - m] = coupling[column - m].max(value);
            }
        });
        self.rate()
    }

    /// The rate near the middle of the window, with the part of it that comes before. What the window adds to an error
    /// is found with the linearised equations there.
    pub(super) fn look_back(&mut self, transport: &Transport<'_>) -> (f64, f64) {
        let columns = 2 * self.coupling.len();
        let entries = &mut self.entries;
        let part = transport.at_middle(|row, column, value| entries[row * columns + column] = value);
        (part, self.rate())
    }

    /// The rate of the motion from the entries J of the linearised equations. With S = J² it is the fourth root of
    /// ½ Σ |S_ij S_ji|, so that neither the units of coordinates nor a rotation change it: ω for an oscillator.
    fn rate(&mut self) -> f64 {
        let (entries, square) = (&self.entries, &mut self.square);
        let n = 2 * self.coupling.len();
        square.fill(0.0);
        for (row, s) in entries.chunks(n).zip(square.chunks_mut(n)) {
            for (&entry, others) in row.iter().zip(entries.chunks(n)).filter(|(entry, _)| **entry != 0.0) {
                s.iter_mut().zip(others).for_each(|(s, other)| *s += entry * other);
            }
        }
        let pairs = (0..n).flat_map(|i| (0..i).map(move |j| (i, j)));
        let twice: f64 = pairs.map(|(i, j)| (square[i * n + j] * square[j * n + i]).abs()).sum();
        let once: f64 = (0..n).map(|i| square[i * n + i].powi(2)).sum();
        (0.5 * once + twice).sqrt().sqrt()
    }

    /// Sets by how much errors of momenta count: by what they do to positions in the time scale of the motion.
    pub(super) fn set_scale(&mut self, time: f64) {
        self.weights.p.iter_mut().zip(&self.coupling).for_each(|(weight, coupling)| *weight = time * coupling);
    }

    /// The errors of the solved window.
    pub(super) fn of_window<const P: usize>(&self, window: &FlowWindow<'_, P>, lasting: f64) -> WindowErrors {
        let m = self.geometry.active().len();
        let is_separable = self.geometry.is_separable();
        let per_square = 1.0 / (window.rule.rule.points() as f64).powi(2);
        let (mut end, mut inside, mut slowest) = (0.0_f64, 0.0_f64, 0.0_f64);
        for (row, &tail) in window.tails.iter().enumerate() {
            let q = |a: usize| self.weights.q[a];
            let (weight, twice) = match row {
                _ if row < m && is_separable => (q(self.geometry.active()[row]) * lasting, Some(per_square / lasting)),
                _ if row < m => (q(self.geometry.active()[row]), None),
                _ if row < 2 * m && is_separable => continue,
                _ if row < 2 * m => (self.weights.p[row - m], Some(0.0)),
                _ => (q(self.ignorable[row - 2 * m]), None),
            };
            let inner = twice.map_or(self.tuning.inside[0], |factor| factor * self.tuning.inside[1]);
            end = end.max(weight * self.tuning.end_of(tail, weight));
            inside = inside.max(weight * inner * tail.tail);
            slowest = slowest.max(ratio(tail, weight));
        }
        let fall = fall(slowest, window.points());
        WindowErrors { end, inside: inside * unseen(fall), fall }
    }

    /// Sees an accepted window with that error inside and what errors have grown to at its end.
    ///
    /// K is a judge of its own, as it belongs to no scheme. With ½ dK = q̇^a dp_a − ṗ_a dq^a its change says how large
    /// the errors are at least, also where V is so rough that the modes do not show it.
    pub(super) fn see<const P: usize>(&mut self, window: &FlowWindow<'_, P>, inside: f64, transport: &Transport<'_>) {
        self.keep_pace(|a| window.velocity_at_end(a));
        self.measure(&window.end);
        let off = (window.norm - self.norm).abs() - self.rounds.max(K_ROUNDS * window.norm_terms());
        if !self.geometry.has_force() && off > 0.0 {
            let shares = self.geometry.active().iter().enumerate().map(|(place, &a)| {
                let [velocity, force] = window.rates_at_end(place);
                velocity.abs() / self.weights.p[place] + force.abs() / self.weights.q[a]
            });
            // A momentum that nothing depends on has no weight.
            let size: f64 = shares.filter(|share| share.is_finite()).sum();
            if size > 0.0 {
                self.by_norm = self.by_norm.max(0.5 * BY_NORM * off / size);
            }
        }
        self.inside = self.inside.max(inside);
        let m = self.geometry.active().len();
        let rows = || (0..m).chain(2 * m..m + self.sizes.len()).map(|row| (self.coordinate(row), row));
        let off = |(a, row): (usize, usize)| self.weights.q[a] * transport.of(row).abs();
        let clock: f64 = rows().filter(|&(a, _)| Some(a) == self.clock).map(off).sum();
        // NaN must not be lost.
        let most = |most: f64, off: f64| if off <= most { most } else { off };
        let others = rows().filter(|&(a, _)| Some(a) != self.clock).map(off).fold(0.0, most);
        self.worst = most(self.worst, others + clock);
    }

    /// The coordinate of a row of positions.
    fn coordinate(&self, row: usize) -> usize {
        let m = self.geometry.active().len();
        if row < m { self.geometry.active()[row] } else { self.ignorable[row - 2 * m] }
    }

    /// What the solved window adds to the error of a row.
    pub(super) fn local<const P: usize>(&self, window: &FlowWindow<'_, P>, row: usize) -> Local {
        let m = self.geometry.active().len();
        let tail = window.tails[row];
        let is_momentum = m <= row && row < 2 * m;
        let weight = if is_momentum { self.weights.p[row - m] } else { self.weights.q[self.coordinate(row)] };
        let half_norm = match row {
            _ if row < m => -window.rates_at_end(row)[1],
            _ if row < 2 * m => window.rates_at_end(row - m)[0],
            _ => 0.0,
        };
        let left = if weight > 0.0 && row < 2 * m { window.left / weight } else { 0.0 };
        let size = self.tuning.end_of(tail, weight) + left;
        let rounded = ROUNDED[usize::from(!self.geometry.is_separable())];
        let nodes = if row < 2 * m { ROUNDED_NODES * window.length * self.inputs(window, row) } else { 0.0 };
        Local { size, half_norm, rounding: f64::EPSILON * (rounded * tail.largest + nodes) }
    }

    /// By how much a row of rates changes at most for a relative change of all positions and momenta, in units of that
    /// change: by the linearised equations in the middle of the window, with the values at its end.
    fn inputs<const P: usize>(&self, window: &FlowWindow<'_, P>, row: usize) -> f64 {
        let (active, m) = (self.geometry.active(), self.weights.p.len());
        let entries = &self.entries[row * 2 * m..][..2 * m];
        let q = active.iter().zip(entries).map(|(&a, entry)| (entry * window.end.q[a].hi).abs());
        let p = window.end.p.iter().zip(&entries[m..]).map(|(p, entry)| (entry * p.hi).abs());
        q.chain(p).sum()
    }

    /// The error at the ends of windows so far.
    pub(super) fn at_ends(&self) -> f64 {
        (CAUTION * self.worst).max(self.by_norm)
    }

    /// The error so far.
    pub(super) fn so_far(&self) -> f64 {
        self.at_ends() + self.inside + ROUNDING
    }
}
