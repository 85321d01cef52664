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
use super::kernel::{Evaluate, On, evaluate};
use super::rule::{Order, Tables};
use super::sizes::{Size, UNITS_OF_RATES};
use super::system::{Linear, System, Term};
use super::tuning::{END, FAST, INSIDE_MARGIN, NOISE, NOISE_OF_SWEEPS, SLOWEST_UNSEEN, STALLED, UNSEEN_CHANGE};
use super::window::{Row, Solver};
use crate::number::vector::{Lanes, Level, Matrix, Nodes, multiply, product_error_of};

/// More sweeps than a window of a good length needs, and more than one of a given length does.
const MOST_SWEEPS: [usize; 2] = [30, 60];

/// Modes that the nodes do not see are a geometric series, each of them once on the nodes and once between them: that
/// with the ratio of the highest modes, or with this one if that is larger.
const SLOWEST_DECAY: f64 = 0.9;
const MOST_UNSEEN: f64 = 2.0 * SLOWEST_DECAY / (1.0 - SLOWEST_DECAY);
/// Slopes on the nodes are rounded in their last digit, and polynomials through them are up to three times as far off.
const ROUNDING_OF_SLOPES: f64 = 4.0 * f64::EPSILON;

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
        if self.is_noisy {
            self.measure_noise(tables.length);
        }
        let mut swept = Level::Best.dispatch(On((&mut *self, tables, continuation, threshold)));
        if swept.is_none() && !self.is_mended && self.system.is_broken() {
            self.is_mended = true;
            swept = Level::Best.dispatch(On((&mut *self, tables, None, threshold)));
        }
        if swept.is_none() && !self.is_noisy && self.measure_noise(tables.length) {
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
        solver.rows.iter_mut().for_each(|row| row.size.inverse = row.size.before);
        let measures = solver.highest_modes.is_some();
        let is_patient = solver.is_patient || !solver.rule.has_end();
        let geometry = solver.geometry;
        let mended = solver.is_mended.then(|| &geometry.hamiltonian.program);
        let power = solver.system.order.power_of(tables.length);
        let mut changes = [f64::INFINITY; 3];
        let mut decay = Decay { change: 0.0, contraction: 0.0 };
        for sweeps in 1..=MOST_SWEEPS[usize::from(!measures)] {
            let Solver { system: System { registers, passes, .. }, rows, .. } = &mut *solver;
            let mut change = Lanes::splat(s, 0.0);
            let (was_small, mut is_rounding, mut begins) = (changes[2] <= NOISE_OF_SWEEPS, true, false);
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
                    let Size { inverse, noise, .. } = row.size;
                    change = change.max((of_row - power * noise) * inverse);
                    begins |= inverse == 0.0 && of_row.largest() > power * noise;
                    if was_small {
                        let largest = Lanes::new(s, &registers[unknown]).abs().largest();
                        is_rounding &= of_row.largest() <= NOISE_OF_SWEEPS * largest;
                    }
                }
            }
            if sweeps == 1 || begins {
                solver.take_sizes(s, tables.length);
            }
            changes = [changes[1], changes[2], if begins { f64::INFINITY } else { change.largest() }];
            decay.follow(changes);
            let is_noise = (was_small && is_rounding) || is_stalled(changes);
            // Windows of one length have no other way out.
            let is_over = !measures || decay.is_over();
            let left = if is_noise && is_over { 0.0 } else { left(changes) };
            if left <= threshold {
                // A guess may have gone further than the motion does.
                if solver.take_sizes(s, tables.length) {
                    changes = [f64::INFINITY; 3];
                    continue;
                }
                evaluate(s, &solver.system.others, &mut solver.system.registers, mended);
                solver.take_ways(s, tables.length);
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

impl<const N: usize> Solver<'_, N> {
    /// Takes sizes from the values on the nodes. Returns true if some were taken to be more than twice as large.
    #[inline(always)]
    fn take_sizes<S: Simd>(&mut self, s: S, h: f64) -> bool {
        let Self { system: System { registers, passes, order, .. }, rows, rule, scales, .. } = &mut *self;
        let m = rows.len() / 2;
        for pass in &*passes {
            for k in 0..pass.slopes.len() {
                let row = &mut rows[pass.first + k];
                let way = (Lanes::new(s, &registers[pass.unknowns[k]]) - row.start.high).abs();
                row.size.take(way.largest());
                if *order == Order::Second {
                    let slope = Lanes::new(s, &registers[pass.slopes[k]]).abs();
                    rows[m + k].size.take(h * slope.dot(Lanes::new(s, &rule.weights)));
                }
            }
        }
        if !scales.shared.is_empty() {
            self.share_sizes();
        }
        self.rows.iter().any(|row| row.size.has_shrunk())
    }

    /// The same for the ways of ignorable coordinates, whose rates are known.
    #[inline(always)]
    fn take_ways<S: Simd>(&mut self, s: S, h: f64) {
        for (way, &rate) in self.ways.iter_mut().zip(&self.system.ignorable) {
            let rate = Lanes::new(s, &self.system.registers[rate]).abs();
            way.take(h * rate.dot(Lanes::new(s, &self.rule.weights)));
        }
    }

    /// By what rates are rounded at the start of the window. Returns true if that is more than sweeps can leave: where
    /// terms cancel, a rate may be nothing but rounding, and what it moves has no other size.
    #[cold]
    #[inline(never)]
    pub(super) fn measure_noise(&mut self, h: f64) -> bool {
        let (geometry, momenta) = (self.geometry, &self.initial.p);
        let linear = self.linear.get_or_insert_with(|| Box::new(Linear::new(geometry, momenta)));
        for (row, &unknown) in self.rows.iter().zip(&linear.unknowns) {
            linear.registers[unknown] = Nodes([row.start.high; 8]);
        }
        Level::Best.dispatch(Evaluate { registers: &mut linear.registers, steps: linear.steps });
        let level = |terms: &[Term], row: usize| {
            let of = terms.iter().filter(|term| term.row == row);
            let sum = of.map(|term| {
                (term.factor * linear.registers[term.register].0[0] * self.rows[term.column].start.high).abs()
            });
            UNITS_OF_RATES * f64::EPSILON * sum.sum::<f64>()
        };
        let noise: Vec<f64> = (0..self.rows.len()).map(|row| level(&linear.rows, row)).collect();
        let of_ways: Vec<f64> = (0..self.ways.len()).map(|j| level(&linear.rates, j)).collect();
        let (m, is_second) = (self.rows.len() / 2, self.system.order == Order::Second);
        let power = self.system.order.power_of(h);
        let mut matters = false;
        for (row, size) in self.rows.iter_mut().map(|row| &mut row.size).enumerate() {
            // In second order the rows of accelerations come first, and those of velocities have the same slopes.
            let own = if is_second { noise[row % m] } else { noise[row] };
            size.noise = own;
            let by = if is_second && row >= m { h } else { power };
            matters |= own * by * size.inverse > STALLED;
        }
        for (size, own) in self.ways.iter_mut().zip(of_ways) {
            size.noise = own;
            matters |= own * h * size.inverse > STALLED;
        }
        self.is_noisy = matters;
        if !matters {
            self.rows.iter_mut().map(|row| &mut row.size).chain(&mut self.ways).for_each(|size| size.noise = 0.0);
        }
        matters
    }
}

/// A coordinate whose rates are rounded by this part of what moves it in a window is moved by rounding.
const BY_ROUNDING: f64 = 0.1;

impl<const N: usize> Solver<'_, N> {
    /// The coordinates that rounding moves in a window of length h like the last one.
    pub(super) fn moved_by_rounding(&mut self, h: f64) -> Vec<usize> {
        if !self.measure_noise(h) {
            return Vec::new();
        }
        let (active, m) = (self.geometry.active(), self.rows.len() / 2);
        let part = |row: usize| self.rows[row].size.noise * h * self.rows[row].size.inverse;
        (0..m).filter(|&place| part(place).max(part(m + place)) > BY_ROUNDING).map(|place| active[place]).collect()
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

impl<const N: usize> WithSimd for On<(&mut Solver<'_, N>, f64)> {
    type Output = LocalErrors;

    #[inline(always)]
    fn with_simd<S: Simd>(self, s: S) -> LocalErrors {
        let On((solver, h)) = self;
        solver.measure(s, h)
    }
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
    /// The errors of the solved window of this length, measured once more.
    #[cold]
    pub(super) fn measured(&mut self, h: f64) -> LocalErrors {
        Level::Best.dispatch(On((self, h)))
    }

    /// Measures a window of length `h`, if it is to be measured, and leaves the error of each unknown at the end with
    /// its row, and those of ignorable coordinates.
    #[inline(always)]
    pub(super) fn measure<S: Simd>(&mut self, s: S, h: f64) -> LocalErrors {
        let Self { system, rows, ways, ignorable_errors, highest_modes, is_shortest, .. } = self;
        let Some(highest) = highest_modes else { return LocalErrors::default() };
        let System { registers, passes, ignorable, order, .. } = system;
        let (n, is_second) = (self.rule.points() as f64, *order == Order::Second);
        let m = rows.len() / 2;
        let (mut inside, mut most, mut roughness) = (0.0_f64, 0.0_f64, 0.0_f64);
        for pass in &*passes {
            for k in 0..pass.slopes.len() {
                let Row { start, size, .. } = rows[pass.first + k];
                let inverse = size.counted(*is_shortest);
                let slope = Lanes::new(s, &registers[pass.slopes[k]]);
                let [a, tail, next, unseen] = modes(s, highest, slope);
                let [a, tail, next] = [a, tail, next].map(|mode| beyond(mode, size.noise));
                let largest = slope.abs().largest();
                rows[pass.first + k].foreseen = unseen + size.noise + ROUNDING_OF_SLOPES * largest;
                let weight = order.power_of(h) * inverse;
                if pass.first + k < m {
                    let first_node = (registers[pass.unknowns[k]].0[0] - start.high).abs();
                    let first_node = beyond(first_node, order.power_of(h) * size.noise) * inverse;
                    let expected = if is_second { tail / (2.0 * (2.0 * n - 3.0)) } else { next };
                    inside = larger(inside, larger(first_node, 0.5 * weight * expected / (n - 1.0)));
                }
                let driven = &mut rows[if is_second { m } else { pass.first } + k];
                driven.end_error = larger(a, next);
                let weight = larger(weight, if is_second { h * driven.size.counted(*is_shortest) } else { 0.0 });
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
            let (rate, inverse) = (Lanes::new(s, &registers[ignorable[k]]), ways[k].counted(*is_shortest));
            let [a, tail, next, _] = modes(s, highest, rate).map(|mode| beyond(mode, ways[k].noise));
            let largest = rate.abs().largest();
            inside = larger(inside, h * larger(a, 0.5 * next) / (n - 1.0) * inverse);
            // It is integrated once, whatever the order of the others is.
            let roughness = if largest > 0.0 { tail / largest } else { 0.0 };
            ignorable_errors[k] = END[0] * roughness * h * larger(a, next);
            end = larger(end, ignorable_errors[k] * inverse);
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

/// The part of a number above the noise in it.
#[inline(always)]
fn beyond(value: f64, noise: f64) -> f64 {
    // NaN stays.
    if value <= noise { 0.0 } else { value - noise }
}

/// Measures the modes of a slope: the highest one, the larger one of the two highest, what the decay of modes foretells
/// of the highest where it happens to be small, and what it foretells of those that the nodes do not see.
#[inline(always)]
fn modes<S: Simd, const N: usize>(s: S, highest: &[Nodes<N>; 4], slope: Lanes<S, N>) -> [f64; 4] {
    let (a, b) = (mode_of(s, &highest[0], slope), mode_of(s, &highest[1], slope));
    let (c, d) = (mode_of(s, &highest[2], slope), mode_of(s, &highest[3], slope));
    let (tail, before) = (larger(a, b), larger(c, d));
    // From one mode to the next.
    let ratio = if tail < before { (tail / before).sqrt() } else { 1.0 };
    let next = if tail < before { tail * ratio } else { tail };
    let unseen = if ratio < SLOWEST_DECAY { 2.0 * tail * ratio / (1.0 - ratio) } else { MOST_UNSEEN * tail };
    [a, tail, next, unseen]
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
