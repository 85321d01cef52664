//! A run with what is known of it on the nodes: velocities, metric, momenta, forces; and what may change a sum of
//! momenta, K or a formula there, as [`witnesses`](super::witnesses) need it.

use std::ops::Range;

use super::limits::take_limits;
use super::witnesses::{Heard, Place};
use crate::geometry::{Contraction, ForceTerm, Motion, OnNodes, Samples, Structure, Term};
use crate::number::Real;
use crate::number::norm::{larger, max_abs, times};
use crate::solve::{Window, WindowNodes, WorldLine};

/// A run with its velocities, its metric and its momenta on the nodes.
pub(super) struct Fields<'r, S> {
    pub(super) run: &'r WorldLine<S>,
    /// Dq^a or D̄q^a.
    pub(super) velocities: Vec<Vec<S>>,
    /// The metric and the one-form with their first derivatives, and with second ones in the paper's space-time of t
    /// and x.
    pub(super) samples: Samples<S>,
    /// F_a, empty where no force acts.
    pub(super) forces: Vec<Vec<S>>,
    /// p_a.
    pub(super) momenta: Vec<Vec<S>>,
    /// The force with its derivatives, if one acts.
    pub(super) force: Option<Samples<S>>,
    pub(super) of_windows: Vec<OfWindow>,
}

/// A window in which a coordinate moves by no more than so many roundings of it.
const ROUNDED: f64 = 64.0;
/// A window is short if it is no longer than this part of the run, and noisy if rounding is more than this part of a
/// velocity.
const SHORT: f64 = 1e-6;
const NOISY: f64 = 1e-10;

impl<'r, S: Real> Fields<'r, S> {
    /// Differentiates the rows of `run`, and fills in the rest.
    pub(super) fn new(run: &'r WorldLine<S>) -> Self {
        let (lagrangian, rows) = (run.geometry(), run.q.iter().map(Vec::as_slice).collect::<Vec<_>>());
        let (structure, points) = (lagrangian.structure(), rows[0].len());
        let n = structure.dimension;
        let mut velocities: Vec<Vec<S>> = (0..n).map(|a| derivative(run, rows[a], |view| view.first(a))).collect();
        know_clocks(run, &mut velocities);
        know_in_short_windows(run, &mut velocities);
        // A number that is not finite leaves NaN, and a verdict doubts that.
        let has_second = lagrangian.c_squared.is_some();
        let of_rows = |rows: &[&[S]]| if has_second { lagrangian.all_at(rows) } else { lagrangian.first_at(rows) };
        let mut samples = of_rows(&rows);
        take_limits(run, &rows, &mut samples, of_rows);
        let mut forces = vec![Vec::new(); n];
        let force = (!structure.force.is_empty()).then(|| {
            let state: Vec<&[S]> = rows.iter().copied().chain(velocities.iter().map(Vec::as_slice)).collect();
            let of_state = |state: &[&[S]]| {
                let mut force = Samples::zeros(structure.force_rows, state[0].len());
                lagrangian.fill_force(&state[..n], &state[n..], &mut force);
                force
            };
            let mut force = of_state(&state);
            take_limits(run, &state, &mut force, of_state);
            for term in &structure.force {
                forces[term.a] = (0..points).map(|k| force.at(term.value, k)).collect();
            }
            force
        });
        let of_windows = OfWindow::all(run);
        let mut fields = Self { run, velocities, samples, forces, momenta: Vec::new(), force, of_windows };
        let mut momenta: Vec<Vec<S>> = vec![fields.zeros(); n];
        momenta.iter_mut().enumerate().for_each(|(a, row)| fields.contraction().add_momentum(a, row));
        fields.momenta = momenta;
        fields
    }

    pub(super) fn structure(&self) -> &'r Structure<S> {
        self.run.geometry().structure()
    }

    /// A zero for every node.
    pub(super) fn zeros(&self) -> Vec<S> {
        vec![S::ZERO; self.velocities[0].len()]
    }

    /// The metric and the one-form with the velocities.
    pub(super) fn contraction<'c>(&'c self) -> Contraction<'c, S, impl Fn(usize) -> Option<&'c [S]>> {
        let (structure, samples) = (self.structure(), &self.samples);
        let velocity = |b: usize| self.velocities.get(b).map(Vec::as_slice);
        Contraction { structure, samples, nodes: 0..self.velocities[0].len(), velocity }
    }

    /// The largest absolute value of a row over a part of every window; NaN if any value there is.
    pub(super) fn largest(&self, row: &[S], part: impl Fn(&Window<S>) -> Range<usize>) -> S {
        self.run.windows.iter().fold(S::ZERO, |largest, window| max_abs(&[largest, max_abs(&row[part(window)])]))
    }
}

/// The places of a clock are nothing but rounding in a window that meets a jump. Its rate is known.
fn know_clocks<S: Real>(run: &WorldLine<S>, velocities: &mut [Vec<S>]) {
    let geometry = run.geometry();
    for (place, &a) in geometry.active().iter().enumerate() {
        let is_rounding = |nodes: &Range<usize>| {
            let [from, to] = [run.q[a][nodes.start], run.q[a][nodes.end - 1]];
            (to - from).abs() <= S::from(ROUNDED) * S::EPSILON * from.abs()
        };
        for nodes in run.windows.iter().map(Window::nodes).filter(is_rounding) {
            if geometry.is_clock(place) {
                velocities[a][nodes].fill(run.velocities(run.joint(0))[a]);
            }
        }
    }
}

/// Beside a kink or a jump windows may be so short that D̄q^a is hardly more than rounding there. Velocities are those
/// of the momenta on the nodes then.
fn know_in_short_windows<S: Real>(run: &WorldLine<S>, velocities: &mut [Vec<S>]) {
    let is_short = |view: &WindowNodes<'_, S>| view.window.length() <= S::from(SHORT) * run.length;
    let (mut motion, mut rates) = (None, Vec::new());
    for view in run.views().filter(|view| run.accuracy.is_some() && is_short(view)) {
        let ends = [view.start, view.end].map(|joint| run.velocities(joint));
        let rounding = S::EPSILON * S::from(row_sum(view.window, 0));
        let is_noisy = |(a, q): (usize, &S)| {
            let is_clock = run.geometry().active().iter().position(|&active| active == a);
            let is_clock = is_clock.is_some_and(|place| run.geometry().is_clock(place));
            !is_clock && rounding * q.abs() > S::from(NOISY) * ends[0][a].abs().max(ends[1][a].abs())
        };
        if !view.start.q.iter().enumerate().any(is_noisy) {
            continue;
        }
        let nodes = view.window.nodes();
        let q: Vec<Vec<S>> = view.rows().into_iter().map(<[S]>::to_vec).collect();
        let p: Vec<Vec<S>> = run.p.iter().map(|row| row[nodes.clone()].to_vec()).collect();
        let motion = motion.get_or_insert_with(|| Motion::new(run.geometry()));
        let on_nodes = OnNodes { q: &q, p: &p, start: view.start.p };
        // A node outside of the domain is looked at elsewhere.
        if motion.all_rates(on_nodes, nodes.len(), &mut rates).is_ok() {
            velocities.iter_mut().zip(&rates).for_each(|(row, rates)| row[nodes.clone()].copy_from_slice(rates));
        }
    }
}

/// d/dγ of a row as the form of the action means it; it is `start` where a window starts.
pub(super) fn derivative<S: Real>(run: &WorldLine<S>, row: &[S], start: impl Fn(&WindowNodes<'_, S>) -> S) -> Vec<S> {
    let mut slopes = vec![S::ZERO; row.len()];
    for view in run.views() {
        let nodes = view.window.nodes();
        view.window.derivative(&row[nodes.clone()], start(&view), &mut slopes[nodes]);
    }
    slopes
}

/// What a window says of the errors of its numbers.
pub(super) struct OfWindow {
    /// The largest absolute value of each coordinate on its nodes, as the operator is applied to it.
    sizes: Vec<f64>,
    /// The number of terms in a row of D.
    row: usize,
}

/// A sum of momenta, or K: Σ g_ab u^a q̇^b, where u are constants, or the velocities.
#[derive(Clone, Copy)]
pub(super) enum Weights<'w, S> {
    /// The constants c^a of Σ c^a p_a.
    Constants(&'w [(usize, S)]),
    /// u = q̇, for K.
    Velocities,
}

impl<S: Real> Weights<'_, S> {
    /// Writes u^a into its room, where velocities are these.
    #[inline]
    fn of(&self, q_dot: impl ExactSizeIterator<Item = f64>, Room { u, .. }: &mut Room) {
        match self {
            Self::Velocities => {
                u.clear();
                u.extend(q_dot);
            }
            Self::Constants(terms) => {
                zero(u, q_dot.len());
                terms.iter().for_each(|(a, c)| u[*a] = c.to_f64());
            }
        }
    }

    /// True if the one-form is a part of it, as of momenta.
    fn has_one_form(&self) -> bool {
        matches!(self, Self::Constants(_))
    }

    /// Both orders of a pair of n coordinates; the one-form is g_an, and q̇^n = 1.
    fn pairs(&self, [a, b]: [usize; 2], n: usize) -> impl Iterator<Item = [usize; 2]> + use<S> {
        let has_one_form = self.has_one_form();
        let second = (a != b && b < n).then_some([b, a]);
        std::iter::once([a, b]).filter(move |[_, b]| *b < n || has_one_form).chain(second)
    }
}

/// Room for what is summed up at a node: u, and what changes of positions and of velocities make.
#[derive(Default)]
pub(super) struct Room {
    u: Vec<f64>,
    positions: Vec<f64>,
    velocities: Vec<f64>,
}

/// Makes a row so many zeros.
fn zero(row: &mut Vec<f64>, count: usize) {
    row.clear();
    row.resize(count, 0.0);
}

impl OfWindow {
    /// Looks at every window of a run once.
    pub(super) fn all<S: Real>(run: &WorldLine<S>) -> Vec<Self> {
        let largest = |row: &[S]| row.iter().fold(0.0, |most, q| larger(most, q.to_f64().abs()));
        let of = |window: &Window<S>| {
            let rows = [0, window.points() / 2].map(|k| window.sbp().row(k).count());
            Self { sizes: run.q.iter().map(|row| largest(&row[window.nodes()])).collect(), row: rows[0].max(rows[1]) }
        };
        run.windows.iter().map(of).collect()
    }
}

impl<S: Real> Fields<'_, S> {
    /// The places of a witness that changes by `delta` on the nodes and by `ends` at the ends of windows, which is
    /// `factor` times a sum of momenta or K at each node.
    pub(super) fn heard(
        &self,
        [delta, ends]: [&[S]; 2],
        weights: Weights<'_, S>,
        factor: impl Fn(usize) -> f64,
    ) -> Heard {
        let (mut heard, mut room) = (Heard::default(), Room::default());
        for (index, window) in self.run.windows.iter().enumerate() {
            let exact = window.exact();
            let (last, most) = (exact.end - 1, largest_of(delta, exact));
            for (k, change) in [(most, delta[most]), (last, ends[index])] {
                // Most windows change it less than others, and nothing else need be known of them.
                let (change, factor) = (change.to_f64().abs(), factor(k));
                if heard.keeps(change, factor * self.terms(k, weights, &mut room)) {
                    let place = self.place(index, k, weights).scaled(factor);
                    heard.see(Place { change, ..place });
                }
            }
        }
        heard
    }

    /// What may change a sum of momenta, or K, at node k of a window.
    pub(super) fn place(&self, index: usize, k: usize, weights: Weights<'_, S>) -> Place {
        let mut place = Place::default();
        self.look(index, k, weights, (&mut Room::default(), &mut place));
        place
    }

    /// The sizes of the terms of a sum of momenta, or of K, at node k.
    pub(super) fn terms(&self, k: usize, weights: Weights<'_, S>, room: &mut Room) -> f64 {
        let (n, mut terms) = (self.velocities.len(), 0.0);
        let q_dot = |a: usize| if a < n { self.velocities[a][k].to_f64() } else { 1.0 };
        weights.of((0..n).map(q_dot), room);
        let (u, has_one_form) = (&room.u, weights.has_one_form());
        for &Term { ab: [a, b], value, .. } in &self.structure().values {
            // These are `Weights::pairs`, without an iterator, as nearly nothing else is done of each window.
            let g = self.samples.at(value, k).to_f64();
            if b < n || has_one_form {
                terms += (u[a] * g * q_dot(b)).abs();
            }
            if a != b && b < n {
                terms += (u[b] * g * q_dot(a)).abs();
            }
        }
        terms
    }

    /// Writes what [`Self::place`] tells into a place that is there.
    pub(super) fn look(&self, index: usize, k: usize, weights: Weights<'_, S>, (room, place): (&mut Room, &mut Place)) {
        let (structure, n, window) = (self.structure(), self.velocities.len(), &self.run.windows[index]);
        let q_dot = |a: usize| if a < n { self.velocities[a][k].to_f64() } else { 1.0 };
        let terms = self.terms(k, weights, room);
        let Room { u, positions, velocities } = room;
        [&mut *positions, &mut *velocities].into_iter().for_each(|row| zero(row, n));
        let (factor, is_norm) = if let Weights::Velocities = weights { (2.0, true) } else { (1.0, false) };
        for &Term { ab, value, .. } in &structure.values {
            let g = self.samples.at(value, k).to_f64();
            for [a, b] in weights.pairs(ab, n) {
                velocities.get_mut(b).into_iter().for_each(|by| *by += factor * u[a] * g);
            }
        }
        for &Term { ab, by: [c], value } in &structure.first {
            let g = self.samples.at(value, k).to_f64();
            weights.pairs(ab, n).for_each(|[a, b]| positions[c] += u[a] * g * q_dot(b));
        }
        let row_sum = row_sum(window, k - window.nodes().start);
        let Place { gamma, change, terms: of_place, by, rounding } = place;
        by.clear();
        by.extend(positions.iter().zip(&*velocities).map(|(q, u)| q.abs() + row_sum * u.abs()));
        *rounding = self.rounding(index, by, structure.values.len() + 2, terms);
        if is_norm {
            by.resize(2 * n, 0.0);
            by.push(1.0);
        }
        (*gamma, *change, *of_place) = (gamma_at(self.run, index, k), 0.0, terms);
    }

    /// What may change the balance of p_a and the work of the force: p_a at the end of the run, and F_a on all nodes,
    /// of which every one counts with its weight.
    pub(super) fn balance_place(&self, a: usize, change: f64) -> Place {
        let (structure, n) = (self.structure(), self.velocities.len());
        let last = self.run.windows.len() - 1;
        let mut place = self.place(last, self.run.windows[last].exact().end - 1, Weights::Constants(&[(a, S::ONE)]));
        let Some(force) = &self.force else { return place };
        // Errors of the force itself come behind those of coordinates.
        place.by.resize(2 * n, 0.0);
        for window in &self.run.windows {
            let weights = window.sbp().weights();
            for k in window.nodes() {
                let weight = weights[k - window.nodes().start].to_f64();
                place.terms += weight * self.forces[a][k].to_f64().abs();
                place.by[n + a] += weight;
                for &ForceTerm { by: [variable], value, .. } in structure.force_first.iter().filter(|term| term.a == a)
                {
                    let slope = weight * force.at(value, k).to_f64().abs();
                    let of_node = if variable < n { 1.0 } else { row_sum(window, k - window.nodes().start) };
                    place.by[variable % n] += of_node * slope;
                }
            }
        }
        let count = self.velocities[0].len() + structure.values.len() + 2;
        place.rounding = self.rounding(last, &place.by, count, place.terms);
        Place { change, ..place }
    }

    /// The rounding of a sum of so many terms of this size altogether, of which each is rounded, and of the products
    /// with rows of D that are in it: n ε Σ |term| for n terms (N. J. Higham, Accuracy and Stability of Numerical
    /// Algorithms, section 3.1).
    pub(super) fn rounding(&self, index: usize, by: &[f64], count: usize, terms: f64) -> f64 {
        let OfWindow { sizes, row } = &self.of_windows[index];
        let products: f64 = by.iter().zip(sizes).map(|(&by, &size)| times(by, size)).sum();
        S::EPSILON.to_f64() * (count as f64 * terms + *row as f64 * products)
    }
}

/// The entries of row k of D, with what D̄ has besides at the first node of the weak form: there the first value and
/// the start may be off with different signs.
pub(super) fn row_of<S: Real>(window: &Window<S>, k: usize) -> impl Iterator<Item = (usize, f64)> {
    let (sbp, is_weak) = (window.sbp(), window.exact() == window.nodes());
    let penalty = (k == 0 && is_weak).then(|| (0, 2.0 / sbp.weights()[0].to_f64()));
    sbp.row(k).map(|(j, d)| (j, d.to_f64())).chain(penalty)
}

/// The sum of their sizes.
pub(super) fn row_sum<S: Real>(window: &Window<S>, k: usize) -> f64 {
    row_of(window, k).map(|(_, d)| d.abs()).sum()
}

/// The node of these at which a row is largest; NaN is larger than anything.
pub(super) fn largest_of<S: Real>(row: &[S], nodes: Range<usize>) -> usize {
    let first = nodes.start;
    nodes.fold(first, |most, k| {
        let [old, new] = [most, k].map(|k| row[k].abs());
        if new > old || (new.is_nan() && !old.is_nan()) { k } else { most }
    })
}

/// γ at a node of a run.
pub(super) fn gamma_at<S: Real>(line: &WorldLine<S>, index: usize, k: usize) -> f64 {
    let window = &line.windows[index];
    line.gamma_at(window.gamma_at(k - window.nodes().start)).to_f64()
}
