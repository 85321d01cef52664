//! Numbers with what rounding took from them.

use std::ops::{Add, Div, Mul, Neg, Sub};

use super::Real;

/// The unevaluated sum of a rounded number and its rounding error. Of `f64` it has about 32 digits.
///
/// The algorithms are those of Dekker (1971), Knuth (TAOCP 2, 4.2.2) and Hida, Li, Bailey (2001), "Algorithms for
/// quad-double precision floating point arithmetic".
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Compensated<S = f64> {
    /// The number, rounded.
    pub high: S,
    /// Its rounding error.
    pub(crate) low: S,
}

/// `a + b` exactly, as (rounded sum, error), whichever is larger (Knuth).
#[inline(always)]
fn two_sum<S: Real>(a: S, b: S) -> (S, S) {
    let sum = a + b;
    let b_seen = sum - a;
    (sum, (a - (sum - b_seen)) + (b - b_seen))
}

/// 2^27 + 1: multiplying by it splits a number into two halves of 26 bits (Dekker).
pub(super) const SPLITTER: f64 = 134_217_729.0;

#[inline(always)]
fn split(a: f64) -> (f64, f64) {
    let c = SPLITTER * a;
    let high = c - (c - a);
    (high, a - high)
}

impl<S: Real> Compensated<S> {
    /// A sum of one number.
    #[inline(always)]
    pub(crate) fn from(value: S) -> Self {
        Self { high: value, low: S::ZERO }
    }

    /// Adds `increment`.
    pub(crate) fn plus(self, increment: S) -> Self {
        let (high, low) = two_sum(self.high, increment + self.low);
        Self { high, low }
    }
}

impl Compensated {
    /// 0.
    pub(crate) const ZERO: Self = Self { high: 0.0, low: 0.0 };
    /// 1.
    pub(crate) const ONE: Self = Self { high: 1.0, low: 0.0 };

    /// Half of it, exactly.
    pub(crate) fn half(self) -> Self {
        Self { high: 0.5 * self.high, low: 0.5 * self.low }
    }

    /// `high + low`, brought to the normal form; |high| ≥ |low| or high = 0 (Dekker).
    #[inline(always)]
    pub(crate) fn new(high: f64, low: f64) -> Self {
        let sum = high + low;
        Self { high: sum, low: low - (sum - high) }
    }

    /// `self` plus a small sum, for the joints of windows: one renormalisation, error 2^−104 |self|.
    #[inline(always)]
    pub(crate) fn plus_small(self, other: Self) -> Self {
        let (sum, error) = two_sum(self.high, other.high);
        Self::new(sum, error + (self.low + other.low))
    }
}

/// Factors are split after Dekker and not multiplied by `f64::mul_add`, which is a slow library call wherever the
/// instruction is not enabled.
impl Mul for Compensated {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        let product = self.high * other.high;
        let ((a_high, a_low), (b_high, b_low)) = (split(self.high), split(other.high));
        let error = ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low;
        Self::new(product, error + (self.high * other.low + self.low * other.high))
    }
}

impl Mul<f64> for Compensated {
    type Output = Self;

    fn mul(self, other: f64) -> Self {
        self * Self::from(other)
    }
}

impl Add for Compensated {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        let (sum, error) = two_sum(self.high, other.high);
        let (low, low_error) = two_sum(self.low, other.low);
        let Self { high, low } = Self::new(sum, error + low);
        Self::new(high, low + low_error)
    }
}

impl Neg for Compensated {
    type Output = Self;

    fn neg(self) -> Self {
        Self { high: -self.high, low: -self.low }
    }
}

impl Sub for Compensated {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Div for Compensated {
    type Output = Self;

    fn div(self, other: Self) -> Self {
        let first = self.high / other.high;
        let remainder = self - other * first;
        let second = remainder.high / other.high;
        let third = (remainder - other * second).high / other.high;
        Self::new(first, second) + Self::from(third)
    }
}
