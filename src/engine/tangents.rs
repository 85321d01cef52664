//! The linearised equations of a window on its own nodes: how small changes of its start change its end.
//!
//! ```text
//! first order    δ = δ₀ + h A J δ
//! second order   δq = δq₀ + h c δq̇₀ + h² A² J δq,    δq̇ = δq̇₀ + h A J δq
//! ```
//!
//! for a unit vector δ₀ of each unknown, positions and momenta, where J is the Jacobian of the slopes on the nodes of
//! the solved window. It is evaluated once, and sweeps solve these equations as they solve those of the motion. The
//! ends of all δ are the columns of Φ, the derivative of the end of the window with respect to its start.

use pulp::{Simd, WithSimd};

use super::kernel::On;
use super::rule::{Order, Tables};
use super::sensitivity::Sensitivity;
use super::sizes::inverse;
use super::system::Linear;
use super::window::Solver;
use crate::geometry::Geometry;
use crate::number::Compensated;
use crate::number::vector::{Lanes, Level, Nodes, multiply};

/// The sweeps of the motion converged, and these do at the same pace.
const MOST_SWEEPS: usize = 200;
/// Sweeps end where this part of the largest δ is left, relative to sizes, or where changes are rounding errors.
const LEFT: f64 = 0.25 * f64::EPSILON;
const NOISE: f64 = 4.0 * f64::EPSILON;

/// The solutions for all unit vectors.
pub(super) struct Tangents<'g, const N: usize> {
    linear: Linear<'g, N>,
    /// Number m of active coordinates, and of rows that sweeps iterate.
    active: usize,
    rows: usize,
    /// The tables of a window of length 1.
    tables: Tables<N>,
    /// Where the terms of each row begin; terms are sorted by rows.
    first: Vec<usize>,
    /// h J or h² J, in the order of the terms.
    jacobian: Vec<Nodes<N>>,
    /// The rows of each δ on the nodes without, and with their slopes, and the slopes, δ by δ.
    bases: Vec<Nodes<N>>,
    deltas: Vec<Nodes<N>>,
    slopes: Vec<Nodes<N>>,
    /// By row and δ, size of the unit vector / size of the row.
    weights: Vec<f64>,
    /// Φ by rows.
    matrix: Vec<f64>,
    /// True for the unknowns whose growth is measured, and then for those that these depend on: the others are not
    /// integrated.
    counts: Vec<bool>,
    steers: Vec<bool>,
}

impl<'g, const N: usize> Tangents<'g, N> {
    /// No solutions yet.
    pub(super) fn new(Solver { geometry, rule, initial, .. }: &Solver<'g, N>) -> Self {
        let mut linear = Linear::new(geometry, &initial.p);
        linear.rows.sort_by_key(|term| term.row);
        let active = geometry.active().len();
        let rows = if linear.order == Order::First { 2 * active } else { active };
        let room = || vec![Nodes::ZERO; rows * 2 * active];
        let counts = counted(geometry);
        Self {
            steers: steering(&linear, counts.clone()),
            counts,
            active,
            rows,
            tables: rule.tables(linear.order, Compensated::from(1.0), false),
            first: (0..=rows).map(|row| linear.rows.partition_point(|term| term.row < row)).collect(),
            jacobian: vec![Nodes::ZERO; linear.rows.len()],
            bases: room(),
            deltas: room(),
            slopes: room(),
            weights: Vec::new(),
            matrix: vec![0.0; 4 * active * active],
            linear,
        }
    }

    /// Carries small changes over the finished window.
    pub(super) fn follow(&mut self, window: &Solver<'g, N>, sensitivity: &mut Sensitivity) {
        let n = 2 * self.active;
        if sensitivity.inverse_sizes.is_empty() {
            let inverse_sizes = (0..n).map(|k| self.inverse_size(window, k)).collect();
            sensitivity.set_sizes(inverse_sizes, &self.counts, &self.steers);
        }
        let inverse_sizes = &sensitivity.inverse_sizes;
        let weight = |at: usize| inverse_sizes[at % self.rows] / inverse_sizes[at / self.rows];
        self.weights.clear();
        self.weights.extend((0..self.rows * n).map(weight));
        Level::Best.dispatch(On((self, window, sensitivity)));
    }

    /// 1/unit of an unknown, which is 1 where there is none at the start. A momentum is as large as velocities make it.
    fn inverse_size(&self, Solver { scales, metric, .. }: &Solver<'g, N>, k: usize) -> f64 {
        let (m, units) = (self.active, &scales.units);
        let found = match (k.checked_sub(m), self.linear.order) {
            (Some(place), Order::Second) => {
                let terms = units[m..].iter().zip(&metric[place * m..]);
                terms.map(|(speed, g)| g.abs() * speed).fold(0.0, f64::max)
            }
            _ => units[k],
        };
        if found > 0.0 { inverse(found) } else { 1.0 }
    }
}

/// The positions and momenta whose growth is that of the motion: of all coordinates but the time, which is called t, or
/// of all if no other is active.
fn counted(geometry: &Geometry) -> Vec<bool> {
    let counts = geometry.active().iter().map(|&a| geometry.names()[a] != "t").collect::<Vec<_>>();
    let all = !counts.contains(&true);
    [&counts[..], &counts].concat().into_iter().map(|counts| counts || all).collect()
}

/// The unknowns that those which `steers` marks depend on, in one step or in several, and these.
fn steering<const N: usize>(linear: &Linear<'_, N>, mut steers: Vec<bool>) -> Vec<bool> {
    // In second order the rows of velocities are those of positions.
    if linear.order == Order::Second {
        return vec![true; steers.len()];
    }
    while let Some(term) = linear.rows.iter().find(|term| steers[term.row] && !steers[term.column]) {
        steers[term.column] = true;
    }
    steers
}

/// Solves the equations, and carries a sensitivity to the end of the window.
impl<const N: usize> WithSimd for On<(&mut Tangents<'_, N>, &Solver<'_, N>, &mut Sensitivity)> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, s: S) {
        let On((tangents, window, sensitivity)) = self;
        tangents.evaluate(s, window);
        tangents.begin(s, window);
        let (mut before, mut most) = (0.0, 1.0);
        for _ in 0..MOST_SWEEPS {
            let change;
            (change, most) = tangents.sweep(s, most);
            // The next change is at most as much smaller as this one is.
            if change * change <= LEFT * most * before || change <= NOISE * most {
                break;
            }
            before = change;
        }
        tangents.end(s, window);
        let lengths = tangents.lengths(s, window, sensitivity);
        tangents.grow(s, window, sensitivity, lengths);
    }
}

impl<const N: usize> Tangents<'_, N> {
    /// The Jacobian on the nodes.
    #[inline(always)]
    fn evaluate<S: Simd>(&mut self, s: S, window: &Solver<'_, N>) {
        let Self { linear, rows, jacobian, .. } = self;
        let Solver { system, length: h, is_mended, .. } = window;
        let nodes = system.positions.iter().chain(&system.momenta);
        for (&to, &from) in linear.unknowns.iter().zip(nodes).take(*rows) {
            linear.registers[to] = system.registers[from];
        }
        linear.evaluate(s, *is_mended);
        let scale = linear.order.power_of(*h);
        for (entry, term) in jacobian.iter_mut().zip(&linear.rows) {
            *entry = (Lanes::new(s, &linear.registers[term.register]) * (term.factor * scale)).nodes();
        }
    }

    /// Every δ as if there were no slopes.
    #[inline(always)]
    fn begin<S: Simd>(&mut self, s: S, Solver { geometry, rule, length: h, .. }: &Solver<'_, N>) {
        let Self { linear, active, rows, bases, deltas, .. } = self;
        for (at, base) in bases.iter_mut().enumerate() {
            let (column, row) = (at / *rows, at % *rows);
            *base = match (linear.order, column.checked_sub(*active), geometry.separable()) {
                (Order::Second, Some(place), Some(inverse)) => {
                    (Lanes::new(s, &rule.nodes[0]) * (h * inverse[row * *active + place])).nodes()
                }
                _ => Nodes([f64::from(u8::from(row == column)); N]),
            };
        }
        deltas.copy_from_slice(bases);
    }

    /// One sweep over all δ, momenta first. Returns the largest change and the largest δ, relative to sizes.
    #[inline(always)]
    fn sweep<S: Simd>(&mut self, s: S, most: f64) -> (f64, f64) {
        let Self { linear, active, rows, tables, first, jacobian, bases, deltas, slopes, weights, .. } = self;
        let zero = Lanes::splat(s, 0.0);
        let (mut change, mut largest) = (zero, Lanes::splat(s, most));
        let columns = 2 * *active;
        for turn in 0..*rows {
            let row = (turn + *active) % *rows;
            for column in 0..columns {
                let delta = &mut deltas[column * *rows..][..*rows];
                let mut slope = zero;
                for k in first[row]..first[row + 1] {
                    let other = Lanes::new(s, &delta[linear.rows[k].column]);
                    slope = Lanes::new(s, &jacobian[k]).mul_add(other, slope);
                }
                let at = column * *rows + row;
                slopes[at] = slope.nodes();
                let base = Lanes::new(s, &bases[at]);
                let new = multiply(s, &tables.collocation, &slopes[at], [base, zero]);
                let weight = weights[at];
                change = change.max((new - Lanes::new(s, &delta[row])).abs() * weight);
                largest = largest.max(new.abs() * weight);
                delta[row] = new.nodes();
            }
        }
        (change.largest(), largest.largest())
    }

    /// Φ from the slopes.
    #[inline(always)]
    fn end<S: Simd>(&mut self, s: S, Solver { geometry, metric, length: h, .. }: &Solver<'_, N>) {
        let Self { linear, active, rows, tables, slopes, matrix, .. } = self;
        let (m, n) = (*active, 2 * *active);
        let [single, double] = [&tables.weights, &tables.end_weights].map(|weights| Lanes::new(s, &weights.high));
        for column in 0..n {
            let slopes = &slopes[column * *rows..][..*rows];
            for row in 0..n {
                let mut entry = f64::from(u8::from(row == column));
                match (linear.order, row.checked_sub(m)) {
                    (Order::Second, None) => {
                        if let (Some(place), Some(inverse)) = (column.checked_sub(m), geometry.separable()) {
                            entry = h * inverse[row * m + place];
                        }
                        entry += double.dot(Lanes::new(s, &slopes[row]));
                    }
                    (Order::Second, Some(place)) => {
                        for b in 0..m {
                            let gain = single.dot(Lanes::new(s, &slopes[b]));
                            entry += metric[place * m + b] / h * gain;
                        }
                    }
                    (Order::First, _) => entry += single.dot(Lanes::new(s, &slopes[row])),
                }
                matrix[row * n + column] = entry;
            }
        }
    }

    /// ln |δ| on the nodes, of the tangent that the sensitivity carries.
    #[inline(always)]
    fn lengths<S: Simd>(&self, s: S, window: &Solver<'_, N>, sensitivity: &Sensitivity) -> Nodes<N> {
        let Self { linear, active, rows, deltas, slopes, .. } = self;
        let Sensitivity { tangent, measures, .. } = sensitivity;
        let (m, zero, Solver { rule, metric, length: h, .. }) = (*active, Lanes::splat(s, 0.0), window);
        let mut square = zero;
        for k in (0..2 * m).filter(|&k| measures[k] > 0.0) {
            let value = match (k.checked_sub(m), linear.order) {
                (Some(place), Order::Second) => {
                    let mut force = zero;
                    for b in 0..m {
                        let g = metric[place * m + b];
                        force = combined(s, tangent, &slopes[b..], *rows).scale_add(g, force);
                    }
                    let start = Lanes::splat(s, h * tangent[k]);
                    multiply(s, &rule.integral, &force.nodes(), [start, zero]) * h.recip()
                }
                _ => combined(s, tangent, &deltas[k..], *rows),
            };
            let relative = value * measures[k];
            square = relative.mul_add(relative, square);
        }
        Nodes(square.nodes().0.map(|square| 0.5 * square.ln()))
    }

    /// Carries the sensitivity to the end of the window.
    #[inline(always)]
    fn grow<S: Simd>(&self, s: S, window: &Solver<'_, N>, sensitivity: &mut Sensitivity, lengths: Nodes<N>) {
        let (Self { tables, matrix, .. }, Solver { rule, length: h, .. }) = (self, window);
        let Sensitivity { gamma, growth, integral, mean, .. } = &mut *sensitivity;
        let (zero, weights) = (Lanes::splat(s, 0.0), Lanes::new(s, &tables.weights.high));
        let logarithms = Lanes::new(s, &lengths) + *growth;
        let integrals = multiply(s, &rule.integral, &logarithms.nodes(), [zero; 2]);
        let integrals = integrals.scale_add(*h, Lanes::splat(s, *integral)).nodes();
        let mut means = Nodes::ZERO;
        for k in 0..rule.points() {
            let place = *gamma + h * rule.nodes[0].0[k];
            means.0[k] = if place > 0.0 { 2.0 * (lengths.0[k] + *growth - integrals.0[k] / place) } else { 0.0 };
        }
        *mean += h * weights.dot(Lanes::new(s, &means));
        *integral += h * weights.dot(logarithms);
        *gamma += h;
        sensitivity.append(matrix);
    }
}

/// Σ c_j v_j, of every so many values.
#[inline(always)]
fn combined<S: Simd, const N: usize>(s: S, factors: &[f64], values: &[Nodes<N>], every: usize) -> Lanes<S, N> {
    let mut sum = Lanes::splat(s, 0.0);
    for (j, &factor) in factors.iter().enumerate() {
        sum = Lanes::new(s, &values[j * every]).scale_add(factor, sum);
    }
    sum
}
