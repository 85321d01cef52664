//! Interval arithmetic on eight boxes at once.
//!
//! An interval holds every value that an expression takes where its variables are in theirs. Arithmetic rounds to
//! nearest, and bounds are then moved outwards by more than that rounding. −∞ as a lower and ∞ as an upper bound say
//! that nothing is known; a lower bound is never ∞, an upper one never −∞, and none is NaN.

use pulp::{Simd, WithSimd};

use super::{BOXES, Intervals, ROUNDS, TINY};
use crate::formula::{Algebra, Function, Step, run};
use crate::number::vector::{abs, elementary, multiply_add, neg, vectors, vectors_mut};

/// Carries out steps of a program on boxes.
pub(super) struct Enclose<'r> {
    pub(super) steps: &'r [Step],
    pub(super) registers: &'r mut [Intervals],
}

impl WithSimd for Enclose<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, s: S) {
        run(&Boxes(s), self.steps, self.registers);
    }
}

struct Boxes<S>(S);

/// Bounds of a sum moved outwards: next to 0 sums are exact.
#[inline(always)]
fn outwards_of_sum<S: Simd>(s: S, lo: S::f64s, hi: S::f64s) -> [S::f64s; 2] {
    let eps = s.splat_f64s(ROUNDS);
    let (lo, hi) = (s.min_f64s(lo, s.splat_f64s(f64::MAX)), s.max_f64s(hi, s.splat_f64s(-f64::MAX)));
    [s.sub_f64s(lo, s.mul_f64s(abs(s, lo), eps)), s.add_f64s(hi, s.mul_f64s(abs(s, hi), eps))]
}

/// Bounds moved outwards.
#[inline(always)]
fn outwards<S: Simd>(s: S, lo: S::f64s, hi: S::f64s) -> [S::f64s; 2] {
    let (eps, tiny) = (s.splat_f64s(ROUNDS), s.splat_f64s(TINY));
    let (lo, hi) = (s.min_f64s(lo, s.splat_f64s(f64::MAX)), s.max_f64s(hi, s.splat_f64s(-f64::MAX)));
    let below = s.sub_f64s(lo, multiply_add(s, abs(s, lo), eps, tiny));
    let above = s.add_f64s(hi, multiply_add(s, abs(s, hi), eps, tiny));
    [below, above]
}

/// a b for bounds, of which 0 times ∞ is 0: what is 0 exactly stays 0 times anything.
#[inline(always)]
fn times<S: Simd>(s: S, a: S::f64s, b: S::f64s) -> S::f64s {
    let product = s.mul_f64s(a, b);
    s.select_f64s(s.equal_f64s(product, product), product, s.splat_f64s(0.0))
}

/// Bounds of a product moved outwards, but for those of what is 0 exactly times anything: there is nothing to round.
#[inline(always)]
fn outwards_of<S: Simd>(s: S, factors: [[S::f64s; 2]; 2], lo: S::f64s, hi: S::f64s) -> [S::f64s; 2] {
    let zero = s.splat_f64s(0.0);
    let [below, above] = outwards(s, lo, hi);
    factors.into_iter().fold([below, above], |[below, above], [lo, hi]| {
        let is_zero = s.equal_f64s(s.max_f64s(hi, neg(s, lo)), zero);
        [s.select_f64s(is_zero, zero, below), s.select_f64s(is_zero, zero, above)]
    })
}

/// [a] [b] without rounding outwards.
#[inline(always)]
fn product<S: Simd>(s: S, a: [S::f64s; 2], b: [S::f64s; 2]) -> [S::f64s; 2] {
    let low = [times(s, a[0], b[0]), times(s, a[0], b[1])];
    let high = [times(s, a[1], b[0]), times(s, a[1], b[1])];
    let least = s.min_f64s(s.min_f64s(low[0], low[1]), s.min_f64s(high[0], high[1]));
    let most = s.max_f64s(s.max_f64s(low[0], low[1]), s.max_f64s(high[0], high[1]));
    [least, most]
}

/// `$body` for the intervals p and q of a and b gives that of `to`.
macro_rules! on_boxes {
    ($algebra:expr, $to:expr, $a:expr, $b:expr, |$s:ident, $p:ident, $q:ident| $body:expr) => {{
        let $s = $algebra.0;
        let (p_lo, p_hi) = $a.0.split_at(BOXES);
        let (q_lo, q_hi) = $b.0.split_at(BOXES);
        let (p_lo, p_hi) = (vectors::<S>(p_lo), vectors::<S>(p_hi));
        let (q_lo, q_hi) = (vectors::<S>(q_lo), vectors::<S>(q_hi));
        let (lo, hi) = $to.0.split_at_mut(BOXES);
        let (lo, hi) = (vectors_mut::<S>(lo), vectors_mut::<S>(hi));
        for n in 0..lo.len() {
            let ($p, $q) = ([p_lo[n], p_hi[n]], [q_lo[n], q_hi[n]]);
            [lo[n], hi[n]] = $body;
        }
    }};
}

impl<S: Simd> Algebra for Boxes<S> {
    type Value = Intervals;

    #[inline(always)]
    fn add(&self, to: &mut Intervals, a: &Intervals, b: &Intervals) {
        on_boxes!(self, to, a, b, |s, p, q| outwards_of_sum(s, s.add_f64s(p[0], q[0]), s.add_f64s(p[1], q[1])));
    }

    #[inline(always)]
    fn subtract(&self, to: &mut Intervals, a: &Intervals, b: &Intervals) {
        on_boxes!(self, to, a, b, |s, p, q| outwards_of_sum(s, s.sub_f64s(p[0], q[1]), s.sub_f64s(p[1], q[0])));
    }

    #[inline(always)]
    fn multiply(&self, to: &mut Intervals, a: &Intervals, b: &Intervals) {
        on_boxes!(self, to, a, b, |s, p, q| {
            let [lo, hi] = product(s, p, q);
            outwards_of(s, [p, q], lo, hi)
        });
    }

    #[inline(always)]
    fn divide(&self, to: &mut Intervals, a: &Intervals, b: &Intervals) {
        on_boxes!(self, to, a, b, |s, p, q| {
            let (one, zero) = (s.splat_f64s(1.0), s.splat_f64s(0.0));
            let [lo, hi] = outwards(s, s.div_f64s(one, q[1]), s.div_f64s(one, q[0]));
            // Not beyond 0, and everything if the divisor may be 0.
            let (is_positive, is_negative) = (s.greater_than_f64s(q[0], zero), s.less_than_f64s(q[1], zero));
            let unknown = s.splat_f64s(f64::INFINITY);
            let lo = s.select_f64s(is_positive, s.max_f64s(lo, zero), s.select_f64s(is_negative, lo, neg(s, unknown)));
            let hi = s.select_f64s(is_negative, s.min_f64s(hi, zero), s.select_f64s(is_positive, hi, unknown));
            let [below, above] = product(s, p, [lo, hi]);
            outwards_of(s, [p, p], below, above)
        });
    }

    #[inline(always)]
    fn negate(&self, to: &mut Intervals, a: &Intervals) {
        on_boxes!(self, to, a, a, |s, p, _q| [neg(s, p[1]), neg(s, p[0])]);
    }

    fn power(&self, _: &mut Intervals, _: &Intervals, _: &Intervals) {
        unreachable!("powers are written by exp and ln");
    }

    #[inline(always)]
    fn call(&self, to: &mut Intervals, function: Function, a: &Intervals) {
        let mut argument = Intervals::ZERO;
        before(function, a, &mut argument);
        elementary::call(self.0, function, &argument.0, &mut to.0);
        after(function, a, to);
    }

    #[inline(always)]
    fn square(&self, to: &mut Intervals, a: &Intervals) {
        on_boxes!(self, to, a, a, |s, p, _q| {
            let zero = s.splat_f64s(0.0);
            let least = s.max_f64s(s.max_f64s(p[0], neg(s, p[1])), zero);
            let most = s.max_f64s(neg(s, p[0]), p[1]);
            let [lo, hi] = outwards(s, s.mul_f64s(least, least), s.mul_f64s(most, most));
            [s.max_f64s(lo, zero), hi]
        });
    }

    #[inline(always)]
    fn sin_cos(&self, sin: &mut Intervals, cos: &mut Intervals, a: &Intervals) {
        let mut argument = Intervals::ZERO;
        before(Function::Sin, a, &mut argument);
        elementary::sin_cos(self.0, &argument.0, [&mut sin.0, &mut cos.0]);
        after(Function::Sin, a, sin);
        after(Function::Cos, a, cos);
    }
}

/// More than the functions of [`crate::number::vector::elementary`] and of the standard library are off by, relative to
/// the result: one unit in the last place, or two.
const ERROR: f64 = 4.0 * f64::EPSILON;

/// Angles that differ by more are not followed.
const WIDEST: f64 = 3.0;

/// The points at which the function is wanted, in the places of the bounds that follow from them.
fn before(function: Function, x: &Intervals, to: &mut Intervals) {
    let (lo, hi) = x.0.split_at(BOXES);
    let (at_lo, at_hi) = to.0.split_at_mut(BOXES);
    for k in 0..BOXES {
        (at_lo[k], at_hi[k]) = match function {
            Function::Sqrt | Function::Ln | Function::Log10 => (lo[k].max(0.0), hi[k]),
            Function::Asin => (lo[k].max(-1.0), hi[k].min(1.0)),
            Function::Acos => (hi[k].min(1.0), lo[k].max(-1.0)),
            Function::Cosh | Function::Abs => (lo[k].max(-hi[k]).max(0.0), (-lo[k]).max(hi[k])),
            Function::Sin | Function::Cos if is_wide(lo[k], hi[k]) => (0.0, 0.0),
            Function::Sin | Function::Cos | Function::Tan | Function::Sinh | Function::Tanh => (lo[k], hi[k]),
            Function::Atan | Function::Exp | Function::Sign | Function::Step => (lo[k], hi[k]),
            Function::Table(_) => (lo[k], hi[k]),
        };
    }
}

fn is_wide(lo: f64, hi: f64) -> bool {
    // Also where it is NaN, as of infinities.
    let is_narrow = hi - lo <= WIDEST;
    !is_narrow
}

/// From the values there to an interval that holds all values on `x`.
fn after(function: Function, x: &Intervals, out: &mut Intervals) {
    let (x_lo, x_hi) = x.0.split_at(BOXES);
    let (lo, hi) = out.0.split_at_mut(BOXES);
    for k in 0..BOXES {
        (lo[k], hi[k]) = match function {
            Function::Abs | Function::Sign | Function::Step => (lo[k], hi[k]),
            Function::Sin | Function::Cos => angle(x_lo[k], x_hi[k], lo[k], hi[k]),
            Function::Table(table) => table.bounds([x_lo[k], x_hi[k]]).into(),
            _ => interval(lo[k], hi[k], range(function)),
        };
    }
}

/// Where the values of a function are.
fn range(function: Function) -> [f64; 2] {
    match function {
        Function::Exp | Function::Sqrt | Function::Acos => [0.0, f64::INFINITY],
        Function::Cosh => [1.0, f64::INFINITY],
        Function::Tanh => [-1.0, 1.0],
        _ => [-f64::INFINITY, f64::INFINITY],
    }
}

/// Bounds from two values of a monotone function. Where it is not defined, nothing is known.
fn interval(at_lo: f64, at_hi: f64, [least, most]: [f64; 2]) -> (f64, f64) {
    if at_lo.is_nan() || at_hi.is_nan() || at_hi < at_lo {
        return (-f64::INFINITY, f64::INFINITY);
    }
    let (lo, hi) = (at_lo.min(f64::MAX), at_hi.max(-f64::MAX));
    ((lo - (lo.abs() * ERROR + TINY)).max(least), (hi + (hi.abs() * ERROR + TINY)).min(most))
}

/// Bounds of a sine or a cosine. As its second derivative is at most 1, it leaves the chord between its ends by at most
/// an eighth of the squared distance of these.
fn angle(x_lo: f64, x_hi: f64, at_lo: f64, at_hi: f64) -> (f64, f64) {
    if is_wide(x_lo, x_hi) {
        return (-1.0, 1.0);
    }
    let distance = x_hi - x_lo;
    let margin = distance * distance * (0.125 + ERROR) + ERROR;
    ((at_lo.min(at_hi) - margin).max(-1.0), (at_lo.max(at_hi) + margin).min(1.0))
}
