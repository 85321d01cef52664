//! Logarithms and powers.

use super::exponential::exp_of_pair;
use super::pair::{fma, polynomial, product, sum};
use std::f64::consts::{LN_2, LOG10_E, SQRT_2};

/// The rounding errors of the numbers ln 2, 1/3 and 1/ln 10.
const LN_2_LOW: f64 = 2.319_046_813_846_299_6e-17;
const THIRD_LOW: f64 = 1.850_371_707_708_594e-17;
const LOG10_E_LOW: f64 = 1.098_319_650_216_765e-17;

/// (artanh s − s − s³/3)/s⁵ by z = s²; error 1.0e-20 of artanh.
const LN: [f64; 8] = [
    0.2,
    0.142_857_142_857_146_85,
    0.111_111_111_108_263_83,
    0.090_909_091_680_499_24,
    0.076_922_974_435_035_9,
    0.066_674_043_994_061_7,
    0.058_530_632_322_816_99,
    0.058_621_635_304_233_734,
];

/// ln x as a pair to about 20 digits, for positive normal x: with x = 2^k m and m in [√½, √2) it is
/// k ln 2 + 2 artanh s, s = (m − 1)/(m + 1), and artanh s = s + s³/3 + … (as in fdlibm, Sun Microsystems 1993, e_log.c;
/// pairs for the first two terms, as powers need them).
#[inline(always)]
fn ln_pair(x: f64) -> (f64, f64) {
    let bits = x.to_bits();
    // The distance to the bits of √½ has k as its exponent.
    let above = bits.wrapping_sub((0.5 * SQRT_2).to_bits());
    let k_bits = above & 0xfff0_0000_0000_0000;
    let m = f64::from_bits(bits.wrapping_sub(k_bits));
    // k is moved into the mantissa of 2⁵², where 1024 more keep it positive.
    let k = f64::from_bits((k_bits >> 52).wrapping_add(1024) & 0xfff | 0x4330_0000_0000_0000)
        - (4_503_599_627_370_496.0 + 1024.0);
    let above = m - 1.0;
    let below = sum((2.0, above));
    let reciprocal = 1.0 / below.0;
    let s = above * reciprocal;
    let s_low = (fma(-s, below.0, above) - s * below.1) * reciprocal;
    let (z, z_low) = product(s, s);
    let z_low = fma(2.0 * s, s_low, z_low);
    // q = z/3 + z² (…), then 2 s (1 + q)
    const THIRD: f64 = 1.0 / 3.0;
    let (t, t_low) = product(z, THIRD);
    let t_low = fma(z, THIRD_LOW, fma(z_low, THIRD, t_low));
    let (q, q_low) = sum((t, z * z * polynomial(&LN, z)));
    let q_low = q_low + t_low;
    let (p, p_low) = product(2.0 * s, q);
    let p_low = fma(2.0 * s, q_low, fma(2.0 * s_low, q, p_low));
    let (a, a_low) = sum((2.0 * s, p));
    let a_low = a_low + (p_low + 2.0 * s_low);
    let (l, l_low) = product(k, LN_2);
    let l_low = fma(k, LN_2_LOW, l_low);
    let (h, h_low) = sum((l, a));
    sum((h, h_low + (l_low + a_low)))
}

#[inline(always)]
pub(super) fn ln(x: f64) -> f64 {
    ln_pair(x).0
}

#[inline(always)]
pub(super) fn log10(x: f64) -> f64 {
    let (l, low) = ln_pair(x);
    let (p, p_low) = product(l, LOG10_E);
    p + fma(l, LOG10_E_LOW, fma(low, LOG10_E, p_low))
}

/// x^y, and y ln x, by which one sees whether it is in range.
#[inline(always)]
pub(super) fn power(x: f64, y: f64) -> (f64, f64) {
    let (l, low) = ln_pair(x);
    let (p, p_low) = product(l, y);
    (exp_of_pair((p, fma(low, y, p_low))), p)
}
