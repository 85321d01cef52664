//! Numbers with what rounding took from them.

use std::ops::Mul;

use super::{Extended, Real};

/// The unevaluated sum of a rounded number and its rounding error. Of `f64` it has about 32 digits.
///
/// The algorithms are those of Dekker (1971), Knuth (TAOCP 2, 4.2.2) and Hida, Li, Bailey (2001), "Algorithms for
/// quad-double precision floating point arithmetic".
#[derive(Debug, Clone, Copy, Default)]
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
    /// The nearest one to a number of more digits.
    pub(crate) fn nearest(exact: Extended) -> Self {
        let high = exact.to_f64();
        Self { high, low: (exact - Extended::from(high)).to_f64() }
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
