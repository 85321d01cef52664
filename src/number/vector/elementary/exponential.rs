//! exp and its relatives, from e^x − 1 as a pair.

use super::pair::{ROUND, abs, fma, polynomial, product, quotient, signed, sum};
use std::f64::consts::{LN_2, LOG2_E};

/// Up to here e^x and e^−x are normal numbers.
pub(super) const MOST: f64 = 708.0;
/// From here on tanh is 1.
const TANH_IS_ONE: f64 = 20.0;

/// The rounding error of the number ln 2.
const LN_2_LOW: f64 = 2.319_046_813_846_299_6e-17;

/// (e^r − 1 − r − r²/2)/r³; error 2.1e-18 of e^r − 1.
const EXP: [f64; 10] = [
    0.166_666_666_666_666_69,
    0.041_666_666_666_666_664,
    0.008_333_333_333_330_039,
    0.001_388_888_888_888_653_7,
    0.000_198_412_698_631_715_57,
    2.480_158_731_722_872_4e-5,
    2.755_726_827_690_569_6e-6,
    2.755_728_283_880_048_4e-7,
    2.510_047_250_569_499_6e-8,
    2.091_129_876_594_02e-9,
];

/// e^x = 2^k (1 + p + p_low), as 2^k, p and p_low, for |x| ≤ [`MOST`]; |p_low| < 0.01. Reduced like the angle of sin: x
/// less n ln 2 is exact in the first step.
#[inline(always)]
fn parts(x: f64) -> (f64, f64, f64) {
    let shifted = fma(x, LOG2_E, ROUND);
    let n = shifted - ROUND;
    let first = fma(-n, LN_2, x);
    let r = fma(-n, LN_2_LOW, first);
    let low = fma(-n, LN_2_LOW, first - r);
    let (square, square_low) = product(r, r);
    let (p, error) = sum((r, 0.5 * square));
    let rest = fma(r * square, polynomial(&EXP, r), fma(low, r, low));
    let scale = f64::from_bits(shifted.to_bits().wrapping_add(1023) << 52);
    (scale, p, error + fma(0.5, square_low, rest))
}

/// e^x as 2^k and a pair.
#[inline(always)]
fn exp_pair(x: f64) -> (f64, (f64, f64)) {
    let (scale, p, p_low) = parts(x);
    let (e, error) = sum((1.0, p));
    (scale, sum((e, error + p_low)))
}

/// e^x − 1 as a pair, for x ≥ 0.
#[inline(always)]
fn exp_m1_pair(x: f64) -> (f64, f64) {
    let (scale, p, p_low) = parts(x);
    let whole = scale - 1.0;
    let (m, error) = sum((whole, scale * p));
    sum((m, fma(scale, p_low, error + ((scale - whole) - 1.0))))
}

#[inline(always)]
pub(super) fn exp(x: f64) -> f64 {
    let (scale, p, p_low) = parts(x);
    fma(scale, p + p_low, scale)
}

/// e^(x + low) for |low| < 1e-12.
#[inline(always)]
pub(super) fn exp_of_pair((x, low): (f64, f64)) -> f64 {
    let (scale, (e, e_low)) = exp_pair(x);
    scale * (e + fma(e, low, e_low))
}

/// ½ (m + m/(m + 1)) with m = e^|x| − 1.
#[inline(always)]
pub(super) fn sinh(x: f64) -> f64 {
    let m = exp_m1_pair(abs(x));
    let q = quotient(m, one_more(m, 1.0));
    let (s, error) = sum((m.0, q.0));
    signed(0.5 * (s + (error + (m.1 + q.1))), x.to_bits())
}

#[inline(always)]
pub(super) fn cosh(x: f64) -> f64 {
    let (scale, (e, e_low)) = exp_pair(abs(x));
    let e = (scale * e, scale * e_low);
    let q = quotient((1.0, 0.0), e);
    let (s, error) = sum((e.0, q.0));
    0.5 * (s + (error + (e.1 + q.1)))
}

/// m/(m + 2) with m = e^2|x| − 1.
#[inline(always)]
pub(super) fn tanh(x: f64) -> f64 {
    let size = abs(x);
    let m = exp_m1_pair(2.0 * if size < TANH_IS_ONE { size } else { TANH_IS_ONE });
    let (q, q_low) = quotient(m, one_more(m, 2.0));
    signed(q + q_low, x.to_bits())
}

/// m + c for m ≥ 0.
#[inline(always)]
fn one_more(m: (f64, f64), c: f64) -> (f64, f64) {
    let (large, small) = if m.0 > c { (m.0, c) } else { (c, m.0) };
    let (s, error) = sum((large, small));
    (s, error + m.1)
}
