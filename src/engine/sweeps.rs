//! Sweeps over a window: its collocation equations, solved by repeated substitution.

use pulp::{Simd, WithSimd};

use super::Failure;
use super::kernel::{On, evaluate};
use super::local::LocalErrors;
use super::rule::{Continuation, Order, Rule, Tables};
use super::sizes::Size;
use super::system::System;
use super::tuning::{FAST, NOISE_OF_SWEEPS, SLOWEST_UNSEEN, STALLED, UNSEEN_CHANGE};
use super::window::{Row, Solver};
use crate::formula::Program;
use crate::number::vector::{Lanes, Level, Matrix, Nodes, multiply, product_error_of};

/// More sweeps than a window of a good length needs, and more than one of a given length does.
const MOST_SWEEPS: [usize; 2] = [30, 60];

/// The outcome of the sweeps over a window.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Swept {
    /// Their number.
    pub(super) sweeps: usize,
    /// The errors of the solved window, where they are measured.
    pub(super) local: LocalErrors,
}

impl<'g, const N: usize> Solver<'g, N> {
    /// Solves the window with these tables until sweeps leave no more than `threshold`, relative to sizes. The first
    /// guess continues the window before, if there are tables for that.
    ///
    /// # Errors
    /// If the sweeps do not converge, or if a node is outside the domain.
    pub(super) fn solve(
        &mut self,
        tables: &Tables<N>,
        continuation: Option<&Continuation<N>>,
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
impl<const N: usize> WithSimd for On<(&mut Solver<'_, N>, &Tables<N>, Option<&Continuation<N>>, f64)> {
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
        let mut changes = [f64::INFINITY; 3];
        let mut decay = Decay { change: 0.0, contraction: 0.0 };
        for sweeps in 1..=MOST_SWEEPS[usize::from(!measures)] {
            let was_small = changes[2] <= NOISE_OF_SWEEPS;
            let Sweep { change, is_rounding, begins } = solver.sweep(s, tables, (sweeps == 1, was_small), mended);
            if sweeps == 1 || begins {
                solver.take_sizes(s, tables.length);
            }
            changes = [changes[1], changes[2], if begins { f64::INFINITY } else { change }];
            decay.follow(changes);
            let is_noise = || (was_small && is_rounding) || is_stalled(changes);
            // Windows of one length have no other way out.
            let is_over = || !measures || decay.is_over();
            let is_done = || (is_noise() && is_over()) || left(changes) <= threshold;
            if (was_small || !is_far(changes, threshold)) && is_done() {
                // A guess may have gone further than the motion does.
                if solver.take_sizes(s, tables.length) {
                    changes = [f64::INFINITY; 3];
                    continue;
                }
                evaluate(s, &solver.system.others, &mut solver.system.registers, mended);
                solver.take_ways(s, tables.length);
                let local = solver.measure(s, tables.length);
                return Some(Swept { sweeps, local });
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

/// The changes that one sweep made.
struct Sweep {
    /// The largest change, relative to sizes.
    change: f64,
    /// True if changes were looked at and are no more than the rounding of values.
    is_rounding: bool,
    /// True if something moves that had no size.
    begins: bool,
}

impl<const N: usize> Solver<'_, N> {
    /// Substitutes once in all rows. The first sweep computes the small products, and after small changes it looks
    /// whether these are rounding.
    #[inline(always)]
    fn sweep<S: Simd>(
        &mut self,
        s: S,
        tables: &Tables<N>,
        (is_first, was_small): (bool, bool),
        mended: Option<&Program<f64>>,
    ) -> Sweep {
        let Self { system: System { registers, passes, order, .. }, rows, .. } = self;
        let (power, mut change) = (order.power_of(tables.length), Lanes::splat(s, 0.0));
        let (mut is_rounding, mut begins) = (true, false);
        for pass in &*passes {
            evaluate(s, &pass.steps, registers, mended);
            for k in 0..pass.slopes.len() {
                let (row, slope, unknown) = (&mut rows[pass.first + k], pass.slopes[k], pass.unknowns[k]);
                if let Some(low) = &tables.collocation_low
                    && is_first
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
        Sweep { change: change.largest(), is_rounding, begins }
    }

    /// The motion without forces, and on top of it the slopes of the window before, continued.
    #[inline(always)]
    fn guess<S: Simd>(&mut self, s: S, length: f64, continuation: Option<&Continuation<N>>) {
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
                    Some(Continuation { increments, growth }) => {
                        let modes = continued(s, rule, &row.slopes_before, growth);
                        multiply(s, increments, &modes, [offset, Lanes::splat(s, 0.0)])
                    }
                    None => offset,
                };
                registers[unknown] = (increments + row.start.high).nodes();
            }
        }
    }
}

/// The Legendre modes of these slopes that say something of the next window: those before the least of the terms that
/// they make in the middle of it. From there on terms grow, as those of a series that is asymptotic, or as rounding.
#[inline(always)]
fn continued<S: Simd, const N: usize>(s: S, rule: &Rule<N>, slopes: &Nodes<N>, growth: &Nodes<N>) -> Nodes<N> {
    let modes = multiply(s, &rule.modes, slopes, [Lanes::splat(s, 0.0); 2]);
    let terms = (modes * Lanes::new(s, growth)).abs().nodes().0;
    // An even and an odd one together, as one of them may be 0 by a symmetry.
    let pairs = rule.points() / 2;
    let (mut least, mut place) = (f64::INFINITY, pairs);
    for (k, pair) in terms.as_chunks::<2>().0[..pairs].iter().enumerate().skip(1) {
        let term = if pair[0] > pair[1] { pair[0] } else { pair[1] };
        let is_less = term <= least;
        least = if is_less { term } else { least };
        place = if is_less { k } else { place };
    }
    // Those that fall up to the last one are all good.
    let place = if place + 1 == pairs { pairs } else { place };
    (modes * Lanes::new(s, &rule.first_pairs[place])).nodes()
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

/// True if more than the threshold is left, and no change is noise, as can be seen without a division: what is left is
/// no less than the last change, or that times its contraction.
#[inline(always)]
fn is_far([_, before, last]: [f64; 3], threshold: f64) -> bool {
    last > STALLED && 0.99 * last > threshold && 0.99 * last * last > threshold * before
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
