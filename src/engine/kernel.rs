//! All that is compiled for every level of instructions and every number of lanes.

use pulp::{Simd, WithSimd};

use super::rule::Order;
use crate::formula::{Algebra, Function, Fused, Register, Step, run};
use crate::number::Compensated;
use crate::number::vector::{
    Lanes, Matrix, Nodes, Twofold, Weights, elementary, multiply, multiply_add, neg, product_error_of, vectors,
    vectors_mut,
};

/// Two changes in turn below this, relative to sizes, are rounding errors;
const NOISE_OF_SWEEPS: f64 = 2.5e-16;
/// and so is a change below this that does not contract.
const STALLED: f64 = 1e-12;
/// More sweeps than a window of a good length needs.
const MOST_SWEEPS: usize = 60;

/// One of the functions of γ that sweeps iterate.
#[derive(Debug, Clone, Copy)]
pub(super) struct Row<const N: usize> {
    /// Its value at the start of the window.
    pub(super) start: Compensated<f64>,
    /// Its slope at the start of the window, where the slope is an unknown too.
    pub(super) velocity: Compensated<f64>,
    /// 1/size, by which errors become relative; 0 if nothing is known of the size.
    pub(super) inverse_size: f64,
    /// Its value at the end of the window.
    pub(super) end: Compensated<f64>,
    /// The part of the increments on the nodes that is known before the window is solved.
    offset: Nodes<N>,
    /// The product of the slopes with the part of the matrix that rounding took from its entries.
    low: Nodes<N>,
    /// The slopes in the window before.
    slopes_before: Nodes<N>,
}

impl<const N: usize> Row<N> {
    /// An unknown that never moves has size 0, and counts nowhere.
    pub(super) fn new(start: f64, velocity: f64, size: f64) -> Self {
        Self {
            start: Compensated::from(start),
            velocity: Compensated::from(velocity),
            inverse_size: if size > 0.0 { 1.0 / size } else { 0.0 },
            end: Compensated::from(start),
            offset: Nodes::ZERO,
            low: Nodes::ZERO,
            slopes_before: Nodes::ZERO,
        }
    }

    /// Goes on to the next window. Sizes grow with what they are sizes of.
    pub(super) fn advance(&mut self, slopes: &Nodes<N>) {
        self.start = self.end;
        self.slopes_before = *slopes;
        if self.start.high.abs() * self.inverse_size > 1.0 {
            self.inverse_size = 1.0 / self.start.high.abs();
        }
    }
}

/// Slopes that are computed together, and then integrated.
#[derive(Debug)]
pub(super) struct Pass {
    pub(super) steps: Box<[Step]>,
    /// The first of their rows.
    pub(super) first: usize,
    /// The registers of the slopes, and those from which the program reads the unknowns.
    pub(super) slopes: Box<[Register]>,
    pub(super) unknowns: Box<[Register]>,
}

/// The outcome of the sweeps over a window.
#[derive(Debug, Clone, Copy)]
pub(super) struct Swept {
    /// Their number.
    pub(super) sweeps: usize,
    /// True if they converged.
    pub(super) is_solved: bool,
}

/// Solves the collocation equations of a window by repeated substitution, from a first guess.
///
/// ```text
/// first order    x = x₀ + h A ẋ(x), the momenta first, then the positions with the new momenta
/// second order   q = q₀ + h c q̇₀ + h² A² q̈(q)
/// ```
pub(super) struct Sweeps<'w, const N: usize> {
    pub(super) registers: &'w mut [Nodes<N>],
    pub(super) rows: &'w mut [Row<N>],
    pub(super) passes: &'w [Pass],
    pub(super) order: Order,
    /// c, and what rounding took from it.
    pub(super) nodes: &'w [Nodes<N>; 2],
    pub(super) length: f64,
    /// h A or h² A².
    pub(super) collocation: &'w Matrix<N>,
    /// The part that rounding took from its entries.
    pub(super) collocation_low: &'w Matrix<N>,
    /// The same as `collocation` after continuation from the window before, if there is one.
    pub(super) continuation: Option<&'w Matrix<N>>,
    /// The largest error that sweeps may leave, relative to sizes.
    pub(super) threshold: f64,
}

impl<const N: usize> WithSimd for Sweeps<'_, N> {
    type Output = Swept;

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, s: S) -> Swept {
        self.guess(s);
        let mut changes = [f64::INFINITY; 3];
        for sweeps in 1..=MOST_SWEEPS {
            let mut change = Lanes::splat(s, 0.0);
            for pass in self.passes {
                carry_out(s, &pass.steps, self.registers);
                for k in 0..pass.slopes.len() {
                    if sweeps == 1 {
                        self.correct(s, pass.first + k, pass.slopes[k]);
                    }
                    change = change.max(self.update(s, pass.first + k, pass.slopes[k], pass.unknowns[k]));
                }
            }
            changes = [changes[1], changes[2], change.largest()];
            if left(changes) <= self.threshold {
                return Swept { sweeps, is_solved: true };
            }
            if sweeps >= 5 && !(changes[2] <= 0.5 * changes[1] || changes[2] <= STALLED) {
                return Swept { sweeps, is_solved: false };
            }
        }
        Swept { sweeps: MOST_SWEEPS, is_solved: false }
    }
}

impl<const N: usize> Sweeps<'_, N> {
    /// The motion without forces, and on top of it the slopes of the window before, continued.
    #[inline(always)]
    fn guess<S: Simd>(&mut self, s: S) {
        for pass in self.passes {
            for (k, &unknown) in pass.unknowns.iter().enumerate() {
                let row = &mut self.rows[pass.first + k];
                let mut offset = Lanes::splat(s, row.start.low);
                if self.order == Order::Second {
                    let [nodes, low] = self.nodes.each_ref().map(|nodes| Lanes::new(s, nodes));
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
    fn correct<S: Simd>(&mut self, s: S, row: usize, slope: Register) {
        let zero = Lanes::splat(s, 0.0);
        self.rows[row].low = multiply(s, self.collocation_low, &self.registers[slope], [zero; 2]).nodes();
    }

    /// x = start + (offset + M ẋ) for a row. Returns by how much that changes x, relative to size.
    #[inline(always)]
    fn update<S: Simd>(&mut self, s: S, row: usize, slope: Register, unknown: Register) -> Lanes<S, N> {
        let row = &mut self.rows[row];
        let increments = multiply(
            s,
            self.collocation,
            &self.registers[slope],
            [&row.offset, &row.low].map(|row| Lanes::new(s, row)),
        );
        let new = increments + row.start.high;
        let x = &mut self.registers[unknown];
        let change = (new - Lanes::new(s, x)).abs() * row.inverse_size;
        *x = new.nodes();
        change
    }
}

/// What is missing after three changes, the last one last: a geometric series with the slower one of their two
/// contractions, as the first change belongs to the guess. Nothing is missing if two changes in turn are rounding
/// errors. Before there are three of them it is the last change.
#[inline(always)]
fn left([first, second, last]: [f64; 3]) -> f64 {
    let [one, other] = [last / second, second / first];
    let contraction = if one > other || one.is_nan() { one } else { other };
    if last <= NOISE_OF_SWEEPS && second <= NOISE_OF_SWEEPS || last <= STALLED && contraction > 0.3 {
        0.0
    } else if first.is_finite() && contraction < 0.5 {
        last * contraction / (1.0 - contraction)
    } else {
        last
    }
}

/// Weighted sums of values that stand in registers.
pub(super) struct Sums<'w, const N: usize> {
    pub(super) weights: &'w Weights<N>,
    pub(super) registers: &'w [Nodes<N>],
    pub(super) from: &'w [Register],
    pub(super) sums: &'w mut Vec<Twofold>,
}

impl<const N: usize> WithSimd for Sums<'_, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, s: S) {
        self.sums.clear();
        for &register in self.from {
            self.sums.push(self.weights.dot(s, &self.registers[register]));
        }
    }
}

/// Carries out steps of a program.
pub(super) struct Evaluate<'w, const N: usize> {
    pub(super) registers: &'w mut [Nodes<N>],
    pub(super) steps: &'w [Step],
}

impl<const N: usize> WithSimd for Evaluate<'_, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, s: S) {
        carry_out(s, self.steps, self.registers);
    }
}

/// Every row becomes `factor` M row.
pub(super) struct Product<'w, const N: usize> {
    pub(super) matrix: &'w Matrix<N>,
    pub(super) factor: f64,
    pub(super) rows: &'w mut [Nodes<N>],
}

impl<const N: usize> WithSimd for Product<'_, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, s: S) {
        for row in self.rows {
            *row = (multiply(s, self.matrix, row, [Lanes::splat(s, 0.0); 2]) * self.factor).nodes();
        }
    }
}

/// Carries out steps of a program on all nodes. It is one function for each level and number of lanes, since it is long
/// and called from several places.
#[inline(always)]
fn carry_out<S: Simd, const N: usize>(s: S, steps: &[Step], registers: &mut [Nodes<N>]) {
    s.vectorize(CarryOut { steps, registers });
}

struct CarryOut<'w, const N: usize> {
    steps: &'w [Step],
    registers: &'w mut [Nodes<N>],
}

impl<const N: usize> WithSimd for CarryOut<'_, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, s: S) {
        run(&Vectors { s }, self.steps, self.registers);
    }
}

/// The arithmetic of values that have a number on every node.
struct Vectors<S, const N: usize> {
    s: S,
}

macro_rules! lanewise {
    ($($name:ident $instruction:ident),*) => {$(
        #[inline(always)]
        fn $name(&self, to: &mut Nodes<N>, a: &Nodes<N>, b: &Nodes<N>) {
            let (a, b, to) = (vectors::<S>(&a.0), vectors::<S>(&b.0), vectors_mut::<S>(&mut to.0));
            for i in 0..to.len() {
                to[i] = self.s.$instruction(a[i], b[i]);
            }
        }
    )*};
}

impl<S: Simd, const N: usize> Algebra for Vectors<S, N> {
    type Value = Nodes<N>;

    lanewise!(add add_f64s, subtract sub_f64s, multiply mul_f64s, divide div_f64s);

    #[inline(always)]
    fn power(&self, to: &mut Nodes<N>, a: &Nodes<N>, b: &Nodes<N>) {
        elementary::power(self.s, &a.0, &b.0, &mut to.0);
    }

    #[inline(always)]
    fn negate(&self, to: &mut Nodes<N>, a: &Nodes<N>) {
        let (a, to) = (vectors::<S>(&a.0), vectors_mut::<S>(&mut to.0));
        for i in 0..to.len() {
            to[i] = neg(self.s, a[i]);
        }
    }

    #[inline(always)]
    fn call(&self, to: &mut Nodes<N>, function: Function, a: &Nodes<N>) {
        elementary::call(self.s, function, &a.0, &mut to.0);
    }

    #[inline(always)]
    fn fused(&self, to: &mut Nodes<N>, fused: Fused, [a, b, c]: [&Nodes<N>; 3]) {
        let [a, b, c] = [a, b, c].map(|operand| vectors::<S>(&operand.0));
        let to = vectors_mut::<S>(&mut to.0);
        for i in 0..to.len() {
            to[i] = match fused {
                Fused::Add => multiply_add(self.s, a[i], b[i], c[i]),
                Fused::Subtract => multiply_add(self.s, a[i], b[i], neg(self.s, c[i])),
                Fused::SubtractFrom => multiply_add(self.s, neg(self.s, a[i]), b[i], c[i]),
            };
        }
    }

    #[inline(always)]
    fn sin_cos(&self, sin: &mut Nodes<N>, cos: &mut Nodes<N>, a: &Nodes<N>) {
        elementary::sin_cos(self.s, &a.0, [&mut sin.0, &mut cos.0]);
    }
}
