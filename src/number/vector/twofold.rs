//! Twofold (double-double) numbers: tables to 30 digits, and states that do not lose what a rounded sum drops.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// The unevaluated sum `hi + lo` with |lo| ≤ ½ ulp(hi): about 32 digits.
///
/// The algorithms are those of Dekker (1971), Knuth (TAOCP 2, 4.2.2) and Hida, Li, Bailey (2001), "Algorithms for
/// quad-double precision floating point arithmetic". Products are split after Dekker and not by `f64::mul_add`, which
/// is a slow library call wherever the instruction is not enabled.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Twofold {
    /// The number rounded to `f64`.
    pub hi: f64,
    /// The rounding error.
    pub lo: f64,
}

/// `a + b` exactly, as (rounded sum, error), whichever is larger (Knuth).
#[inline(always)]
pub(crate) fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let b_seen = sum - a;
    (sum, (a - (sum - b_seen)) + (b - b_seen))
}

/// `a + b` exactly if |a| ≥ |b| or a = 0 (Dekker).
#[inline(always)]
pub(crate) fn fast_two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    (sum, b - (sum - a))
}

/// 2^27 + 1: multiplying by it splits a number into two halves of 26 bits (Dekker).
pub(crate) const SPLITTER: f64 = 134_217_729.0;

#[inline(always)]
fn split(a: f64) -> (f64, f64) {
    let c = SPLITTER * a;
    let hi = c - (c - a);
    (hi, a - hi)
}

/// `a · b` exactly, as (rounded product, error).
#[inline(always)]
pub(crate) fn two_product(a: f64, b: f64) -> (f64, f64) {
    let product = a * b;
    let ((a_hi, a_lo), (b_hi, b_lo)) = (split(a), split(b));
    (product, ((a_hi * b_hi - product) + a_hi * b_lo + a_lo * b_hi) + a_lo * b_lo)
}

impl Twofold {
    /// 0.
    pub const ZERO: Self = Self { hi: 0.0, lo: 0.0 };
    /// 1.
    pub const ONE: Self = Self { hi: 1.0, lo: 0.0 };

    /// `hi + lo`, brought to the normal form; |hi| ≥ |lo| or hi = 0.
    #[inline(always)]
    pub fn new(hi: f64, lo: f64) -> Self {
        let (hi, lo) = fast_two_sum(hi, lo);
        Self { hi, lo }
    }

    /// Half of it, exactly.
    #[inline(always)]
    pub fn half(self) -> Self {
        Self { hi: 0.5 * self.hi, lo: 0.5 * self.lo }
    }

    /// |self|.
    #[inline(always)]
    pub fn abs(self) -> Self {
        if self.hi < 0.0 { -self } else { self }
    }

    /// `self` plus the small sum `b.0 + b.1`, for the joints of windows: one renormalisation, error 2^−104 |self|.
    #[inline(always)]
    pub(crate) fn plus_update(self, b: (f64, f64)) -> Self {
        let (sum, error) = two_sum(self.hi, b.0);
        let (hi, lo) = fast_two_sum(sum, error + (self.lo + b.1));
        Self { hi, lo }
    }
}

impl From<f64> for Twofold {
    #[inline(always)]
    fn from(hi: f64) -> Self {
        Self { hi, lo: 0.0 }
    }
}

impl Add for Twofold {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        let (sum, error) = two_sum(self.hi, other.hi);
        let (low, low_error) = two_sum(self.lo, other.lo);
        let (sum, error) = fast_two_sum(sum, error + low);
        let (hi, lo) = fast_two_sum(sum, error + low_error);
        Self { hi, lo }
    }
}

impl Neg for Twofold {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self { hi: -self.hi, lo: -self.lo }
    }
}

impl Sub for Twofold {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Twofold {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        let (product, error) = two_product(self.hi, other.hi);
        let (hi, lo) = fast_two_sum(product, error + (self.hi * other.lo + self.lo * other.hi));
        Self { hi, lo }
    }
}

impl Mul<f64> for Twofold {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: f64) -> Self {
        self * Self::from(other)
    }
}

impl Div for Twofold {
    type Output = Self;

    #[inline(always)]
    fn div(self, other: Self) -> Self {
        let first = self.hi / other.hi;
        let remainder = self - other * first;
        let second = remainder.hi / other.hi;
        let third = (remainder - other * second).hi / other.hi;
        Self::new(first, second) + Self::from(third)
    }
}
