//! What is known of the error of a world-line in a scene.

use super::control::{TUNING, Tuning};
use super::state::FlowState;
use super::window::{FlowWindow, Weights};
use crate::geometry::{Geometry, Rates};

/// The minimum of the estimate: the result is rounded.
pub(super) const ROUNDING: f64 = 2.0 * f64::EPSILON;

/// Sizes of the coordinates, and the largest distance of the companion relative to them.
pub(super) struct Judge<'g> {
    geometry: &'g Geometry,
    tuning: Tuning,
    ignorable: Vec<usize>,
    start: Vec<f64>,
    /// max(1, |q^a|) of active coordinates, max(1, |q^a − q_i^a|) of ignorable ones, at most so far.
    pub(super) sizes: Vec<f64>,
    pub(super) weights: Weights,
    jacobian: Rates<f64>,
    /// Positions and momenta of all coordinates, to evaluate the Jacobian at.
    q: Vec<f64>,
    p: Vec<f64>,
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

/// The error in units of the companion's distance, at most. Where the modes fall quickly it is a hundredth. Where they
/// fall by a third from two to two, as towards a periapsis in windows that are allowed a large error, window and
/// companion are off by 2 and 3 of what they are apart.
const CAUTION: f64 = 3.0;

/// What K is off by because it is rounded, in units of the rounding of its terms.
const K_ROUNDS: f64 = 16.0 * f64::EPSILON;

/// What a change of K means for the coordinates, in units of the smallest error that makes it.
const BY_NORM: f64 = 3.0;

impl<'g> Judge<'g> {
    /// From the start, where all momenta are `momenta`.
    pub(super) fn new(geometry: &'g Geometry, start: &FlowState, momenta: &[f64]) -> Self {
        let m = geometry.active().len();
        let q: Vec<f64> = start.q.iter().map(|q| q.hi).collect();
        let mut judge = Self {
            geometry,
            tuning: TUNING,
            ignorable: geometry.ignorable().collect(),
            sizes: vec![1.0; q.len()],
            weights: Weights { q: vec![1.0; q.len()], p: vec![0.0; m] },
            jacobian: geometry.field().jacobian_room(),
            p: momenta.to_vec(),
            coupling: vec![0.0; m],
            norm: 0.0,
            rounds: 0.0,
            worst: 0.0,
            by_norm: 0.0,
            inside: 0.0,
            start: q.clone(),
            q,
        };
        judge.measure(start);
        judge.set_norm();
        judge
    }

    /// K and the size of its terms at the start.
    fn set_norm(&mut self) {
        let field = self.geometry.field();
        let mut rates = field.room();
        // A start outside the domain is found by the first window.
        let _ = field.evaluate(&self.q, &self.p, &mut rates);
        let q_dot: Vec<f64> = (0..self.q.len()).map(|a| field.q_dot(&rates, a)).collect();
        self.norm = self.geometry.norm(&self.q, &q_dot);
        let terms = q_dot.iter().zip(&self.p).map(|(q_dot, p)| (q_dot * p).abs());
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
    }

    /// The rate of the fastest motion at a joint, in radians: from the square of the Jacobian of Hamilton's equations.
    pub(super) fn look_at(&mut self, state: &FlowState) -> f64 {
        let active = self.geometry.active();
        for (place, &a) in active.iter().enumerate() {
            (self.q[a], self.p[a]) = (state.q[a].hi, state.p[place].hi);
        }
        let m = active.len();
        self.coupling.fill(0.0);
        let mut entries = vec![0.0; 4 * m * m];
        let (coupling, sizes) = (&mut self.coupling, &self.sizes);
        self.geometry.field().jacobian(&self.q, &self.p, &mut self.jacobian, |row, column, value: f64| {
            entries[row * 2 * m + column] = value;
            if row < m && column >= m {
                let value = value.abs() / sizes[active[row]];
                coupling[column - m] = coupling[column - m].max(value);
            }
        });
        let square = |i: usize| (0..2 * m).map(|k| entries[i * 2 * m + k] * entries[k * 2 * m + i]).sum::<f64>();
        (0..2 * m).map(|i| square(i).abs()).fold(0.0, f64::max).sqrt()
    }

    /// Sets by how much errors of momenta count: by what they do to positions in the time scale of the motion.
    pub(super) fn set_scale(&mut self, time: f64) {
        self.weights.p.iter_mut().zip(&self.coupling).for_each(|(weight, coupling)| *weight = time * coupling);
    }

    /// The errors of the solved window: at its end, and at the nodes inside it.
    pub(super) fn of_window<const P: usize>(&self, window: &FlowWindow<'_, P>, lasting: f64) -> [f64; 2] {
        let m = self.geometry.active().len();
        let is_separable = self.geometry.is_separable();
        let per_square = 1.0 / (window.rule.rule.points() as f64).powi(2);
        let (mut end, mut inside) = (0.0_f64, 0.0_f64);
        for (row, &tail) in window.tails.iter().enumerate() {
            let q = |a: usize| self.weights.q[a];
            let (weight, twice) = match row {
                _ if row < m && is_separable => (q(self.geometry.active()[row]) * lasting, Some(per_square / lasting)),
                _ if row < m => (q(self.geometry.active()[row]), None),
                _ if row < 2 * m && is_separable => continue,
                _ if row < 2 * m => (self.weights.p[row - m], Some(0.0)),
                _ => (q(self.ignorable[row - 2 * m]), None),
            };
            let factors = self.tuning.inside_of(tail, weight);
            let inner = twice.map_or(factors[0], |factor| factor * factors[1]);
            end = end.max(weight * self.tuning.end_of(tail, weight));
            inside = inside.max(weight * inner * tail.tail);
        }
        [end, inside]
    }

    /// Sees an accepted window with that error inside and the companion's distance at its end.
    ///
    /// K is a judge of its own, as it belongs to no scheme. With ½ dK = q̇^a dp_a − ṗ_a dq^a its change says how large
    /// the errors are at least, also where V is so rough that window and companion are wrong together.
    pub(super) fn see<const P: usize>(&mut self, window: &FlowWindow<'_, P>, inside: f64, delta: &FlowState) {
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
        let off = delta.q.iter().zip(&self.weights.q).map(|(delta, weight)| weight * delta.hi.abs());
        self.worst = off.fold(self.worst, |worst, off| if off <= worst { worst } else { off });
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
