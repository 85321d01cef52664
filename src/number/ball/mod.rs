//! Balls: numbers of 32 digits with a radius that holds everything that is not known of them, rounding included.
//!
//! A ball (hi + lo, rad) stands for every number whose distance from hi + lo is at most rad. No rounding mode is
//! changed. An operation computes its midpoint by a known algorithm on pairs of doubles, and its radius is
//!
//! ```text
//! what the radii of its operands make of the result  +  what the algorithm is off by  (+  2^-1001 for underflow),
//! ```
//!
//! times [`UP`] for the rounding of the radius itself. With u = 2^-53 the algorithms are off by at most 3u²/(1−4u) of a
//! sum, 5u² of a product and 15u² + 56u³ of a quotient (M. Joldes, J.-M. Muller, V. Popescu, "Tight and rigorous error
//! bounds for basic building blocks of double-word arithmetic", ACM TOMS 44 (2017): algorithms 6, 11 and 17; for
//! algorithm 11 J.-M. Muller, L. Rideau, ACM TOMS 48 (2022)). Their operands are pairs with |lo| ≤ u |hi|, as these
//! algorithms return. What leaves the range of doubles gets an infinite radius or one that is NaN; neither is below
//! any bound, so no comparison that a proof rests on succeeds with it.
//!
//! Elementary functions are written with these operations, so that their roundings are counted by them, and add the
//! truncation of their series ([`functions`]). [`Disc`] is the same in the complex plane, with doubles.

mod disc;
mod functions;
#[cfg(test)]
mod tests;

pub(crate) use disc::Disc;

use std::ops::{Add, Div, Mul, Neg, Sub};

use super::{Extended, Real};

/// The rounding of a double: 2^-53.
const U: f64 = f64::EPSILON / 2.0;
/// More than the errors of the algorithms on pairs, in units of the result. Algorithm 17 takes its product by a double
/// from algorithm 7, which is off by 3u²/2 + 4u³; the one here is algorithm 9, by 2u², which adds u²/2 to a quotient.
const SUM: f64 = 3.003 * U * U;
const PRODUCT: f64 = 5.005 * U * U;
const QUOTIENT: f64 = 15.6 * U * U;
/// A radius is a sum of products of positive numbers with at most 62 roundings, each of which takes away at most
/// the part u of it.
pub(crate) const UP: f64 = 1.0 + 64.0 * U;
/// Numbers of a case are decimals, or formulas of few of them, in 71 digits. This bounds what they are off by, relative
/// to them, where no more than 11 digits cancel on the way.
pub(crate) const OFF: f64 = 1e-60;
/// 2^-1001, more than underflow takes away: the product, its error and the cross terms lose at most 2^-1074 each.
const TINY: f64 = f64::MIN_POSITIVE * 2_097_152.0;

/// All numbers that are at most `rad` away from hi + lo, where |lo| ≤ u |hi|.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Ball {
    pub(crate) hi: f64,
    pub(crate) lo: f64,
    pub(crate) rad: f64,
}

/// `a + b` exactly, as (rounded sum, error), if |a| ≥ |b| or a = 0 (Dekker).
#[inline(always)]
fn quick_two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    (sum, b - (sum - a))
}

/// `a + b` exactly, as (rounded sum, error), whichever is larger (Knuth).
#[inline(always)]
pub(crate) fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let b_seen = sum - a;
    (sum, (a - (sum - b_seen)) + (b - b_seen))
}

/// `a b` exactly, as (rounded product, error), unless it underflows.
#[inline(always)]
pub(crate) fn two_product(a: f64, b: f64) -> (f64, f64) {
    let product = a * b;
    (product, a.mul_add(b, -product))
}

impl Ball {
    /// A double.
    #[inline(always)]
    pub(crate) fn exact(hi: f64) -> Self {
        Self { hi, lo: 0.0, rad: 0.0 }
    }

    /// No number is excluded.
    pub(crate) const UNKNOWN: Self = Self { hi: 0.0, lo: 0.0, rad: f64::INFINITY };

    /// A number that was computed in extended precision, with `off` as the bound of what it is off by, relative to it.
    pub(crate) fn of(number: Extended, off: f64) -> Self {
        let hi = number.to_f64();
        let rest = number - Extended::from(hi);
        let lo = rest.to_f64();
        // Both differences are exact: the digits of `number` after those of `hi`, and after those of `lo`.
        let left = (rest - Extended::from(lo)).abs().to_f64();
        Self { hi, lo, rad: (left + off * hi.abs() + TINY) * UP }
    }

    /// The same with a larger radius.
    #[inline(always)]
    pub(crate) fn widened(self, by: f64) -> Self {
        Self { rad: (self.rad + by) * UP, ..self }
    }

    /// A bound of the absolute value of every number in it.
    #[inline(always)]
    pub(crate) fn size(self) -> f64 {
        (self.hi.abs() + self.rad) * UP
    }

    /// A lower bound of the absolute value of every number in it; below 0 if none is known.
    #[inline(always)]
    fn least(self) -> f64 {
        self.hi.abs() * (1.0 - 4.0 * U) - self.rad * UP
    }

    /// The nearest double, and a bound of the distance from it.
    #[inline(always)]
    pub(crate) fn rounded(self) -> (f64, f64) {
        (self.hi, (self.lo.abs() + self.rad) * UP)
    }

    /// A power of two times the ball, or minus that, which rounds nothing.
    #[inline(always)]
    fn scaled(self, by: f64) -> Self {
        Self { hi: by * self.hi, lo: by * self.lo, rad: by.abs() * self.rad }
    }

    /// |√x − s| for s = s0 + (x − s0²)/2s0: as √x = s0 + (x − s0²)/(√x + s0), it is at most (x − s0²)²/2s0³, whatever
    /// s0 > 0 is. For another x′ of the ball |√x′ − √x| = |x′ − x|/(√x′ + √x) ≤ rad/√x.
    #[inline(always)]
    pub(crate) fn sqrt(self) -> Self {
        self.sqrt_near(self.hi.sqrt())
    }

    #[inline(always)]
    fn sqrt_near(self, guess: f64) -> Self {
        let root = Self::exact(guess);
        let middle = Self { rad: 0.0, ..self };
        let left = middle - root * root;
        let most = left.size();
        let sum = root + left / root.scaled(2.0);
        let known = sum.widened((0.5 * (most / root.hi) * (most / root.hi / root.hi) + TINY) * UP);
        let result = known.widened(self.rad / known.least() * UP);
        if self.hi > 0.0 && self.least() > 0.0 && known.least() > 0.0 { result } else { Self::UNKNOWN }
    }
}

impl Add for Ball {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        let (sum, error) = two_sum(self.hi, other.hi);
        let (low, low_error) = two_sum(self.lo, other.lo);
        let (sum, error) = quick_two_sum(sum, error + low);
        let (hi, lo) = quick_two_sum(sum, error + low_error);
        Self { hi, lo, rad: (self.rad + other.rad + SUM * hi.abs()) * UP }
    }
}

impl Neg for Ball {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self { hi: -self.hi, lo: -self.lo, rad: self.rad }
    }
}

impl Sub for Ball {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Ball {
    type Output = Self;

    /// |ab − AB| ≤ |A| |b − B| + |a − A| |B| + |a − A| |b − B|.
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        let (product, error) = two_product(self.hi, other.hi);
        let cross = self.hi.mul_add(other.lo, self.lo * other.hi);
        let (hi, lo) = quick_two_sum(product, error + cross);
        let (a, b) = (self.hi.abs(), other.hi.abs());
        let of_radii = a * other.rad + self.rad * b + self.rad * other.rad;
        Self { hi, lo, rad: (of_radii + PRODUCT * hi.abs() + TINY) * UP }
    }
}

impl Div for Ball {
    type Output = Self;

    /// |a/b − A/B| = |(a − A) − (A/B)(b − B)|/|b| ≤ (|a − A| + |A/B| |b − B|)/(|B| − |b − B|).
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        let first = self.hi / other.hi;
        let (product, error) = two_product(first, other.hi);
        let (product, error) = quick_two_sum(product, first.mul_add(other.lo, error));
        let rest = (self.hi - product) + (self.lo - error);
        let (hi, lo) = quick_two_sum(first, rest / other.hi);
        let least = other.least();
        // Underflow in the rest is divided by b, too.
        let of_radii = (self.rad + hi.abs() * other.rad + TINY) / least;
        let rad = (of_radii + QUOTIENT * hi.abs() + TINY) * UP;
        Self { hi, lo, rad: if least > 0.0 { rad } else { f64::INFINITY } }
    }
}
