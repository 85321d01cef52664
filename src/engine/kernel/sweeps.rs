//! Sweeps over a window: its collocation equations, solved by repeated substitution.

use pulp::{Simd, WithSimd};

use super::{LocalErrors, carry_out};
use crate::engine::rule::Order;
use crate::engine::tuning::{FAST, NOISE_OF_SWEEPS, SLOWEST_UNSEEN, STALLED, UNSEEN_CHANGE};
use crate::formula::{Program, Register, Step};
use crate::number::Compensated;
use crate::number::vector::{Lanes, Matrix, Nodes, multiply, product_error_of};

/// One of the functions of γ that sweeps iterate.
#[derive(Debug, Clone, Copy)]
pub(in super::super) struct Row<const N: usize> {
    /// Its value at the start of the window.
    pub(in super::super) start: Compensated<f64>,
    /// Its slope at the start of the window, where the slope is an unknown too.
    pub(in super::super) velocity: Compensated<f64>,
    /// 1/size, by which errors become relative; 0 if nothing is known of the size.
    pub(in super::super) inverse_size: f64,
    /// 1/size of that slope.
    pub(in super::super) inverse_speed: f64,
    /// Its value at the end of the window, and that of the slope.
    pub(in super::super) end: Compensated<f64>,
    pub(in super::super) velocity_end: Compensated<f64>,
    /// A bound of the error that a window makes in `end`; of the slope where that is an unknown too.
    pub(in super::super) end_error: f64,
    /// The increment at the last node, as sweeps left it.
    pub(in super::super) increment: f64,
    /// The part of the increments on the nodes that is known before the window is solved.
    offset: Nodes<N>,
    /// The product of the slopes with the part of the matrix that rounding took from its entries.
    low: Nodes<N>,
    /// The slopes in the window that was finished last.
    pub(in super::super) slopes_before: Nodes<N>,
}

impl<const N: usize> Row<N> {
    /// An unknown that never moves has size 0, and counts nowhere.
    pub(in super::super) fn new(start: f64, velocity: f64, [size, speed]: [f64; 2]) -> Self {
        Self {
            start: Compensated::from(start),
            velocity: Compensated::from(velocity),
            inverse_size: inverse(size),
            inverse_speed: inverse(speed),
            end: Compensated::from(start),
            velocity_end: Compensated::from(velocity),
            end_error: 0.0,
            increment: 0.0,
            offset: Nodes::ZERO,
            low: Nodes::ZERO,
            slopes_before: Nodes::ZERO,
        }
    }

    /// Goes on to the next window. Sizes grow with what they are sizes of.
    pub(in super::super) fn advance(&mut self) {
        (self.start, self.velocity) = (self.end, self.velocity_end);
        grow(&mut self.inverse_size, self.start.high);
        grow(&mut self.inverse_speed, self.velocity.high);
    }
}

/// 1/size, or 0.
pub(in super::super) fn inverse(size: f64) -> f64 {
    if size > 0.0 { 1.0 / size } else { 0.0 }
}

/// Takes the value for the size if it is larger.
#[inline(always)]
pub(in super::super) fn grow(inverse_size: &mut f64, value: f64) {
    if value.abs() * *inverse_size > 1.0 {
        *inverse_size = 1.0 / value.abs();
    }
}

/// Slopes that are computed together, and then integrated.
#[derive(Debug)]
pub(in super::super) struct Pass {
    pub(in super::super) steps: Box<[Step]>,
    /// The first of their rows.
    pub(in super::super) first: usize,
    /// The registers of the slopes, and those from which the program reads the unknowns.
    pub(in super::super) slopes: Box<[Register]>,
    pub(in super::super) unknowns: Box<[Register]>,
}

/// The outcome of the sweeps over a window.
#[derive(Debug, Clone, Copy)]
pub(in super::super) struct Swept {
    /// Their number.
    pub(in super::super) sweeps: usize,
    /// True if they converged.
    pub(in super::super) is_solved: bool,
    /// The error that they left, relative to sizes, by the slower one of the last two contractions.
    pub(in super::super) left: f64,
    /// The errors of the solved window, where they are measured.
    pub(in super::super) local: LocalErrors,
}

/// Solves the collocation equations of a window by repeated substitution, from a first guess.
///
/// ```text
/// first order    x = x₀ + h A ẋ(x), the momenta first, then the positions with the new momenta
/// second order   q = q₀ + h c q̇₀ + h² A² q̈(q)
/// ```
pub(in super::super) struct Sweeps<'w, const N: usize> {
    pub(in super::super) registers: &'w mut [Nodes<N>],
    pub(in super::super) rows: &'w mut [Row<N>],
    pub(in super::super) passes: &'w [Pass],
    pub(in super::super) order: Order,
    /// c, and what rounding took from it.
    pub(in super::super) nodes: &'w [Nodes<N>; 2],
    pub(in super::super) length: f64,
    /// h A or h² A².
    pub(in super::super) collocation: &'w Matrix<N>,
    /// The part that rounding took from its entries, unless it is left out.
    pub(in super::super) collocation_low: Option<&'w Matrix<N>>,
    /// The same as `collocation` after continuation from the window before, if there is one.
    pub(in super::super) continuation: Option<&'w Matrix<N>>,
    /// The largest error that sweeps may leave, relative to sizes, and the number of sweeps in which they must get
    /// there.
    pub(in super::super) threshold: f64,
    pub(in super::super) most_sweeps: usize,
    /// True if slow sweeps go on: nothing else would solve the window.
    pub(in super::super) is_patient: bool,
    /// The program, where values are to be mended that are finite although something on the way to them is not.
    pub(in super::super) mended: Option<&'w Program<f64>>,
    /// The steps to the velocities of ignorable coordinates and to the determinants, once the unknowns are known.
    pub(in super::super) others: &'w [Step],
    /// The registers of these velocities, 1/size of these coordinates, and their errors at the end.
    pub(in super::super) ignorable: &'w [Register],
    pub(in super::super) inverse_ignorable: &'w [f64],
    pub(in super::super) ignorable_errors: &'w mut [f64],
    /// Number n of nodes, and the weights of the highest Legendre modes if errors are to be measured.
    pub(in super::super) points: usize,
    pub(in super::super) highest_modes: Option<&'w [Nodes<N>; 4]>,
}

impl<const N: usize> WithSimd for Sweeps<'_, N> {
    type Output = Swept;

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, s: S) -> Swept {
        self.guess(s);
        let mut changes = [f64::INFINITY; 3];
        let mut decay = Decay { change: 0.0, contraction: 0.0 };
        for sweeps in 1..=self.most_sweeps {
            let mut change = Lanes::splat(s, 0.0);
            let (was_small, mut is_rounding) = (changes[2] <= NOISE_OF_SWEEPS, true);
            for pass in self.passes {
                carry_out(s, &pass.steps, self.registers);
                self.mend();
                for k in 0..pass.slopes.len() {
                    if let Some(low) = self.collocation_low
                        && sweeps == 1
                    {
                        self.correct(s, low, pass.first + k, pass.slopes[k]);
                    }
                    let (row, unknown) = (pass.first + k, pass.unknowns[k]);
                    let of_row = self.update(s, row, pass.slopes[k], unknown);
                    change = change.max(of_row * self.rows[row].inverse_size);
                    if was_small {
                        let largest = Lanes::new(s, &self.registers[unknown]).abs().largest();
                        is_rounding &= of_row.largest() <= NOISE_OF_SWEEPS * largest;
                    }
                }
            }
            changes = [changes[1], changes[2], change.largest()];
            decay.follow(changes);
            let is_noise = (was_small && is_rounding) || is_stalled(changes);
            // Windows of one length have no other way out.
            let is_over = self.highest_modes.is_none() || decay.is_over();
            let left = if is_noise && is_over { 0.0 } else { left(changes) };
            if left <= self.threshold {
                carry_out(s, self.others, self.registers);
                self.mend();
                let local = match self.highest_modes {
                    Some(highest) => self.measure(s, highest),
                    None => LocalErrors::default(),
                };
                return Swept { sweeps, is_solved: true, left, local };
            }
            // Where a window may be shorter, or Newton's method takes over, that is better than many sweeps.
            let is_slow = !(changes[2] <= 0.5 * changes[1] || changes[2] <= STALLED);
            if sweeps >= 5 && is_slow && !self.is_patient {
                return Swept { sweeps, is_solved: false, left, local: LocalErrors::default() };
            }
        }
        Swept { sweeps: self.most_sweeps, is_solved: false, left: left(changes), local: LocalErrors::default() }
    }
}

impl<const N: usize> Sweeps<'_, N> {
    #[inline(always)]
    fn mend(&mut self) {
        if let Some(program) = self.mended {
            program.mend_points(program.outputs(), N, self.registers, &mut 1);
        }
    }

    /// The motion without forces, and on top of it the slopes of the window before, continued.
    #[inline(always)]
    fn guess<S: Simd>(&mut self, s: S) {
        for pass in self.passes {
            for (k, &unknown) in pass.unknowns.iter().enumerate() {
                let row = &mut self.rows[pass.first + k];
                let mut offset = Lanes::splat(s, row.start.low);
                if self.order == Order::Second {
                    let (nodes, low) = (Lanes::new(s, &self.nodes[0]), Lanes::new(s, &self.nodes[1]));
                    let way = self.length * row.velocity.high;
                    let way_low =
                        product_error_of::<S>(self.length, row.velocity.high, way) + self.length * row.velocity.low;
                    offset = nodes.scale_add(way, low.scale_add(way, nodes.scale_add(way_low, offset)));
                }
                row.offset = offset.nodes();
                let increments = match self.continuation {
                    Some(matrix) => multiply(s, matrix, &row.slopes_before, [offset, Lanes::splat(s, 0.0)]),
                    None => offset,
                };
                self.registers[unknown] = (increments + row.start.high).nodes();
            }
        }
    }

    /// The small product, which slopes of the first sweep are good enough for.
    #[inline(always)]
    fn correct<S: Simd>(&mut self, s: S, low: &Matrix<N>, row: usize, slope: Register) {
        self.rows[row].low = multiply(s, low, &self.registers[slope], [Lanes::splat(s, 0.0); 2]).nodes();
    }

    /// x = start + (offset + M ẋ) for a row. Returns by how much that changes x.
    #[inline(always)]
    fn update<S: Simd>(&mut self, s: S, row: usize, slope: Register, unknown: Register) -> Lanes<S, N> {
        let row = &mut self.rows[row];
        let increments = multiply(
            s,
            self.collocation,
            &self.registers[slope],
            [Lanes::new(s, &row.offset), Lanes::new(s, &row.low)],
        );
        row.increment = increments.last();
        let new = increments + row.start.high;
        let x = &mut self.registers[unknown];
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
/// contractions, as the first change belongs to the guess. Before there are three of them it is the last change.
#[inline(always)]
fn left(changes: [f64; 3]) -> f64 {
    let ([first, _, last], contraction) = (changes, contraction(changes));
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
