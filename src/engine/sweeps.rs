//! Sweeps over a window: its collocation equations, solved by repeated substitution.
//!
//! Local errors say by how much a solved window is off, from the highest Legendre modes of its slopes.
//!
//! A integrates P_0 … P_{n−2} exactly, and A P_{n−1} − ∫P_{n−1} = (P_{n−1} − P_{n−2})/2(n − 1). So of slopes h ẋ with
//! the modes a_k
//!
//! * the largest error inside is that of the first node, |a_{n−1}|/(n − 1), which is also its distance from the start
//!   of the window; where it happens to be small, the mode that a_{n−2} and the decay of modes foretell stands for it;
//! * for equations of second order the same holds with the last mode of q̇, that is h² a_{n−2}/2(2n − 3);
//! * at the end this error counts only as far as the linearised equations have a mode like it: once more the
//!   truncation, relative.

use pulp::{Simd, WithSimd};

use super::Failure;
use super::kernel::{On, evaluate};
use super::rule::{Order, Tables};
use super::system::System;
use super::tuning::{END, FAST, INSIDE_MARGIN, NOISE, NOISE_OF_SWEEPS, SLOWEST_UNSEEN, STALLED, UNSEEN_CHANGE};
use super::window::{Row, Solver};
use crate::number::vector::{Lanes, Level, Matrix, Nodes, multiply, product_error_of};

/// More sweeps than a window of a good length needs, and more than one of a given length does.
const MOST_SWEEPS: [usize; 2] = [30, 60];

/// The outcome of the sweeps over a window.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Swept {
    /// Their number.
    pub(super) sweeps: usize,
    /// The error that they left, relative to sizes, by the slower one of the last two contractions.
    pub(super) left: f64,
    /// The errors of the solved window, where they are measured.
    pub(super) local: LocalErrors,
}

impl<'g, const N: usize> Solver<'g, N> {
    /// Solves the window with these tables until sweeps leave no more than `threshold`, relative to sizes. The first
    /// guess continues the window before, if there is a matrix for that.
    ///
    /// # Errors
    /// If the sweeps do not converge, or if a node is outside the domain.
    pub(super) fn solve(
        &mut self,
        tables: &Tables<N>,
        continuation: Option<&Matrix<N>>,
        threshold: f64,
    ) -> Result<Swept, Failure> {
        let mut swept = Level::Best.dispatch(On((&mut *self, tables, continuation, threshold)));
        if swept.is_none() && !self.is_mended && self.system.is_broken() {
            self.is_mended = true;
            swept = Level::Best.dispatch(On((&mut *self, tables, None, threshold)));
        }
        let swept = swept.ok_or(Failure::NotConverged)?;
        self.system.check_domain(self.rule.points()).map_err(Failure::OutsideDomain)?;
        Ok(swept)
    }
}

/// Solves the collocation equations of a window by repeated substitution, from a first guess.
impl<const N: usize> WithSimd for On<(&mut Solver<'_, N>, &Tables<N>, Option<&Matrix<N>>, f64)> {
    type Output = Option<Swept>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, s: S) -> Option<Swept> {
        let On((solver, tables, continuation, threshold)) = self;
        solver.guess(s, tables.length, continuation);
        let measures = solver.highest_modes.is_some();
        let is_patient = solver.is_patient || !solver.rule.has_end();
        let geometry = solver.geometry;
        let mended = solver.is_mended.then(|| &geometry.hamiltonian.program);
        let Solver { system: System { registers, passes, .. }, rows, .. } = &mut *solver;
        let mut changes = [f64::INFINITY; 3];
        let mut decay = Decay { change: 0.0, contraction: 0.0 };
        for sweeps in 1..=MOST_SWEEPS[usize::from(!measures)] {
            let mut change = Lanes::splat(s, 0.0);
            let (was_small, mut is_rounding) = (changes[2] <= NOISE_OF_SWEEPS, true);
            for pass in &*passes {
                evaluate(s, &pass.steps, registers, mended);
                for k in 0..pass.slopes.len() {
                    let (row, slope, unknown) = (&mut rows[pass.first + k], pass.slopes[k], pass.unknowns[k]);
                    if let Some(low) = &tables.collocation_low
                        && sweeps == 1
                    {
                        // The small product, which slopes of the first sweep are good enough for.
                        row.low = multiply(s, low, &registers[slope], [Lanes::splat(s, 0.0); 2]).nodes();
                    }
                    let of_row = row.update(s, &tables.collocation, registers, [slope, unknown]);
                    change = change.max(of_row * row.inverse_size);
                    if was_small {
                        let largest = Lanes::new(s, &registers[unknown]).abs().largest();
                        is_rounding &= of_row.largest() <= NOISE_OF_SWEEPS * largest;
                    }
                }
            }
            changes = [changes[1], changes[2], change.largest()];
            decay.follow(changes);
            let is_noise = (was_small && is_rounding) || is_stalled(changes);
            // Windows of one length have no other way out.
            let is_over = !measures || decay.is_over();
            let left = if is_noise && is_over { 0.0 } else { left(changes) };
            if left <= threshold {
                evaluate(s, &solver.system.others, &mut solver.system.registers, mended);
                return Some(Swept { sweeps, left, local: solver.measure(s, tables.length) });
            }
            // Where a window may be shorter, or Newton's method takes over, that is better than many sweeps.
            let is_slow = !(changes[2] <= 0.5 * changes[1] || changes[2] <= STALLED);
            if sweeps >= 5 && is_slow && !is_patient {
                return None;
            }
        }
        None
    }
}

impl<const N: usize> Solver<'_, N> {
    /// The motion without forces, and on top of it the slopes of the window before, continued.
    #[inline(always)]
    fn guess<S: Simd>(&mut self, s: S, length: f64, continuation: Option<&Matrix<N>>) {
        let Self { system: System { registers, passes, order, .. }, rows, rule, .. } = self;
        let m = rows.len() / 2;
        for pass in &*passes {
            for (k, &unknown) in pass.unknowns.iter().enumerate() {
                let velocity = rows[m + k].start;
                let row = &mut rows[pass.first + k];
                let mut offset = Lanes::splat(s, row.start.low);
                if *order == Order::Second {
                    let (nodes, low) = (Lanes::new(s, &rule.nodes[0]), Lanes::new(s, &rule.nodes[1]));
                    let way = length * velocity.high;
                    let way_low = product_error_of::<S>(length, velocity.high, way) + length * velocity.low;
                    offset = nodes.scale_add(way, low.scale_add(way, nodes.scale_add(way_low, offset)));
                }
                row.offset = offset.nodes();
                let increments = match continuation {
                    Some(matrix) => multiply(s, matrix, &row.slopes_before, [offset, Lanes::splat(s, 0.0)]),
                    None => offset,
                };
                registers[unknown] = (increments + row.start.high).nodes();
            }
        }
    }
}

impl<const N: usize> Row<N> {
    /// x = start + (offset + M ẋ), where x is the register `unknown`. Returns by how much that changes x.
    #[inline(always)]
    fn update<S: Simd>(
        &mut self,
        s: S,
        matrix: &Matrix<N>,
        registers: &mut [Nodes<N>],
        [slope, unknown]: [usize; 2],
    ) -> Lanes<S, N> {
        let known = [Lanes::new(s, &self.offset), Lanes::new(s, &self.low)];
        let increments = multiply(s, matrix, &registers[slope], known);
        self.increment = increments.last();
        let new = increments + self.start.high;
        let x = &mut registers[unknown];
        let change = (new - Lanes::new(s, x)).abs();
        *x = new.nodes();
        change
    }
}

/// The change by a sweep as it would be without rounding, which hides it in the end: where sweeps converge slowly, they
/// would leave an error of one sign in every window.
struct Decay {
    change: f64,
    contraction: f64,
}

impl Decay {
    #[inline(always)]
    fn follow(&mut self, [_, before, last]: [f64; 3]) {
        // Larger changes are no noise yet.
        if last <= STALLED && before > STALLED {
            *self = Self { change: last, contraction: (last / before).min(SLOWEST_UNSEEN) };
        } else {
            self.change *= self.contraction;
        }
    }

    /// True if what is left is less than rounding errors.
    #[inline(always)]
    fn is_over(&self) -> bool {
        self.contraction <= FAST || self.change <= UNSEEN_CHANGE * NOISE_OF_SWEEPS
    }
}

/// The error that is left after three changes, the last one last: a geometric series with the slower one of their two
/// contractions, as the first change belongs to the guess. Where contractions slow down, they are taken to do so once
/// more: what is largest at first may vanish faster than the rest. Before there are three changes it is the last one.
#[inline(always)]
fn left(changes: [f64; 3]) -> f64 {
    let [first, second, last] = changes;
    let slower = (last / second) / (second / first);
    let contraction = contraction(changes) * if slower > 1.0 { slower } else { 1.0 };
    if first.is_finite() && contraction < 0.5 { last * contraction / (1.0 - contraction) } else { last }
}

/// True if the last change is so small that it is noise where it does not contract.
#[inline(always)]
fn is_stalled(changes: [f64; 3]) -> bool {
    changes[2] <= STALLED && contraction(changes) > 0.5
}

/// The slower one of two contractions.
#[inline(always)]
fn contraction([first, second, last]: [f64; 3]) -> f64 {
    let [one, other] = [last / second, second / first];
    if one > other || one.is_nan() { one } else { other }
}

/// Bounds of the errors that a window makes, relative to sizes.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct LocalErrors {
    /// At its nodes, of positions and ignorable coordinates: of order n.
    pub(super) inside: f64,
    /// At its end, of all unknowns and ignorable coordinates: of order 2n − 1.
    pub(super) end: f64,
    /// By how much the highest modes of slopes change an unknown.
    pub(super) tail: f64,
    /// The highest modes of slopes relative to these. If it is not small, the bounds say nothing.
    pub(super) roughness: f64,
}

impl<const N: usize> Solver<'_, N> {
    /// Measures a window of length `h`, if it is to be measured, and leaves the error of each unknown at the end with
    /// its row, and those of ignorable coordinates.
    #[inline(always)]
    pub(super) fn measure<S: Simd>(&mut self, s: S, h: f64) -> LocalErrors {
        let Self { system, rows, inverse_ignorable, ignorable_errors, highest_modes, .. } = self;
        let Some(highest) = highest_modes else { return LocalErrors::default() };
        let System { registers, passes, ignorable, order, .. } = system;
        let (n, is_second) = (self.rule.points() as f64, *order == Order::Second);
        let m = rows.len() / 2;
        let (mut inside, mut most, mut roughness) = (0.0_f64, 0.0_f64, 0.0_f64);
        for pass in &*passes {
            for k in 0..pass.slopes.len() {
                let Row { start, inverse_size, .. } = rows[pass.first + k];
                let slope = Lanes::new(s, &registers[pass.slopes[k]]);
                let [a, tail, next] = modes(s, highest, slope);
                let largest = slope.abs().largest();
                let weight = order.power_of(h) * inverse_size;
                if pass.first + k < m {
                    let first_node = (registers[pass.unknowns[k]].0[0] - start.high).abs() * inverse_size;
                    let expected = if is_second { tail / (2.0 * (2.0 * n - 3.0)) } else { next };
                    inside = larger(inside, larger(first_node, 0.5 * weight * expected / (n - 1.0)));
                }
                let driven = &mut rows[if is_second { m } else { pass.first } + k];
                driven.end_error = larger(a, next);
                let weight = larger(weight, if is_second { h * driven.inverse_size } else { 0.0 });
                most = larger(most, weight * driven.end_error);
                if largest * weight > NOISE || largest.is_nan() {
                    roughness = larger(roughness, tail / largest);
                }
            }
        }
        // It is not 0, so that what is seen elsewhere can raise the errors.
        let factor = END[usize::from(is_second)] * larger(roughness, f64::EPSILON) * h;
        for row in rows.iter_mut() {
            row.end_error *= factor;
        }
        let mut end = factor / h * most;
        for k in 0..ignorable.len() {
            let rate = Lanes::new(s, &registers[ignorable[k]]);
            let ([a, tail, next], largest) = (modes(s, highest, rate), rate.abs().largest());
            inside = larger(inside, h * larger(a, 0.5 * next) / (n - 1.0) * inverse_ignorable[k]);
            // It is integrated once, whatever the order of the others is.
            let roughness = if largest > 0.0 { tail / largest } else { 0.0 };
            ignorable_errors[k] = END[0] * roughness * h * larger(a, next);
            end = larger(end, ignorable_errors[k] * inverse_ignorable[k]);
        }
        LocalErrors { inside: INSIDE_MARGIN * inside, end, tail: most, roughness }
    }

    /// The local error at the end of the window with these errors, if modes that its nodes do not see are smaller by
    /// `decay` than the highest ones that they see: they make errors at the end, too.
    pub(super) fn with_unseen(&mut self, local: LocalErrors, decay: f64) -> f64 {
        let unseen = local.tail * decay;
        let factor = unseen / local.end;
        if factor > 1.0 && factor.is_finite() {
            let own = self.rows.iter_mut().map(|row| &mut row.end_error);
            own.chain(&mut self.ignorable_errors).for_each(|error| *error *= factor);
            return unseen;
        }
        local.end
    }
}

/// Measures the modes of a slope: the highest one, the larger one of the two highest, and what the decay of modes
/// foretells of the highest where it happens to be small.
#[inline(always)]
fn modes<S: Simd, const N: usize>(s: S, highest: &[Nodes<N>; 4], slope: Lanes<S, N>) -> [f64; 3] {
    let (a, b) = (mode_of(s, &highest[0], slope), mode_of(s, &highest[1], slope));
    let (c, d) = (mode_of(s, &highest[2], slope), mode_of(s, &highest[3], slope));
    let (tail, before) = (larger(a, b), larger(c, d));
    let next = if tail < before { tail * (tail / before).sqrt() } else { tail };
    [a, tail, next]
}

/// The size of one mode.
#[inline(always)]
fn mode_of<S: Simd, const N: usize>(s: S, weights: &Nodes<N>, slope: Lanes<S, N>) -> f64 {
    Lanes::new(s, weights).dot(slope).abs()
}

/// The larger number; NaN if one is NaN, unlike `f64::max`.
#[inline(always)]
pub(super) fn larger(a: f64, b: f64) -> f64 {
    if a > b || a.is_nan() { a } else { b }
}
