//! sin, cos and tan.

use super::pair::{ROUND, abs, fma, polynomial, quotient, signed, sum};
use std::f64::consts::{FRAC_2_PI, FRAC_PI_2};

/// Up to here the reduction is exact; three parts of π/2 serve up to 2²⁰ of them.
pub(super) const MOST: f64 = 1e6;

/// The second part of π/2 has 33 bits, so that its multiples are numbers; the third is rounded.
const SECOND: f64 = 6.123_233_995_384_61e-17;
const THIRD: f64 = 3.521_559_865_183_2e-27;

/// (sin r − r)/r³ by z = r²; error 8.5e-19 of sin.
const SIN: [f64; 6] = [
    -0.166_666_666_666_666_66,
    0.008_333_333_333_330_936,
    -0.000_198_412_698_367_405_32,
    2.755_731_609_319_840_4e-6,
    -2.505_112_989_645_018_5e-8,
    1.591_798_897_939_743_5e-10,
];
/// (cos r − 1 + z/2)/z² by z = r²; error 8.5e-19 of cos.
const COS: [f64; 6] = [
    0.041_666_666_666_666_664,
    -0.001_388_888_888_888_738_9,
    2.480_158_729_875_44e-5,
    -2.755_731_726_587_808e-7,
    2.087_614_504_941_318e-9,
    -1.138_254_464_534_925e-11,
];

/// The quarter turn nearest to x, and what is left as a pair. Cody and Waite's reduction (1980, "Software manual for
/// the elementary functions") with the fused multiply-add, where the first step has no rounding error for a constant of
/// full length (Boldo, Daumas, Li 2009, "Formally verified argument reduction with a fused multiply-add").
#[inline(always)]
fn reduced(x: f64) -> (u64, f64, f64) {
    let turns = fma(x, FRAC_2_PI, ROUND);
    let n = turns - ROUND;
    let first = fma(-n, FRAC_PI_2, x);
    let r = fma(-n, SECOND, first);
    let low = fma(-n, THIRD, fma(-n, SECOND, first - r));
    (turns.to_bits(), r, low)
}

/// sin and cos of r + low in ±π/4 as two terms each, a large and a small one, like those of fdlibm (Sun Microsystems
/// 1993, k_sin.c and k_cos.c).
#[inline(always)]
fn terms(r: f64, low: f64) -> ((f64, f64), (f64, f64)) {
    let z = r * r;
    let half = 0.5 * z;
    let sin = fma(z * r, polynomial(&SIN, z), fma(-half, low, low));
    let one_less = 1.0 - half;
    let lack = (1.0 - one_less) - half;
    let cos = fma(z * z, polynomial(&COS, z), fma(-r, low, lack));
    ((r, sin), (one_less, cos))
}

/// One kernel for both: what is not asked for is not compiled.
#[inline(always)]
pub(super) fn sin_cos(x: f64) -> (f64, f64) {
    let (turns, r, low) = reduced(abs(x));
    let (sin, cos) = terms(r, low);
    let (sin, cos) = (sin.0 + sin.1, cos.0 + cos.1);
    let (sin, cos) = if turns & 1 == 0 { (sin, cos) } else { (cos, sin) };
    (signed(sin, turns << 62 ^ x.to_bits()), signed(cos, turns.wrapping_add(1) << 62))
}

#[inline(always)]
pub(super) fn sin(x: f64) -> f64 {
    sin_cos(x).0
}

#[inline(always)]
pub(super) fn cos(x: f64) -> f64 {
    sin_cos(x).1
}

#[inline(always)]
pub(super) fn tan(x: f64) -> f64 {
    let (turns, r, low) = reduced(abs(x));
    let (sin, cos) = terms(r, low);
    let (sin, cos) = (sum(sin), sum(cos));
    let is_even = turns & 1 == 0;
    let (above, below) = if is_even { (sin, cos) } else { (cos, sin) };
    let (q, q_low) = quotient(above, below);
    signed(q + q_low, turns << 63 ^ x.to_bits())
}
