//! The parts that kernels share. Each takes one number and has no branches: loops over nodes become vectors. Pairs
//! are unevaluated sums (larger, smaller).

/// 1.5·2⁵²: added to a number below 2⁵¹ it leaves the nearest integer, whose low bits are those of the sum.
pub(super) const ROUND: f64 = 6_755_399_441_055_744.0;
pub(super) const SIGN: u64 = 1 << 63;

/// a b + c, one instruction wherever these kernels are used.
#[inline(always)]
pub(super) fn fma(a: f64, b: f64, c: f64) -> f64 {
    a.mul_add(b, c)
}

#[inline(always)]
pub(super) fn abs(a: f64) -> f64 {
    f64::from_bits(a.to_bits() & !SIGN)
}

/// `a`, negated where `sign` has the sign bit.
#[inline(always)]
pub(super) fn signed(a: f64, sign: u64) -> f64 {
    f64::from_bits(a.to_bits() ^ (sign & SIGN))
}

/// a + b exactly, for |a| ≥ |b| or a = 0.
#[inline(always)]
pub(super) fn sum((a, b): (f64, f64)) -> (f64, f64) {
    let sum = a + b;
    (sum, b - (sum - a))
}

/// a b exactly.
#[inline(always)]
pub(super) fn product(a: f64, b: f64) -> (f64, f64) {
    let p = a * b;
    (p, fma(a, b, -p))
}

/// a/b of pairs, by one division.
#[inline(always)]
pub(super) fn quotient(a: (f64, f64), b: (f64, f64)) -> (f64, f64) {
    let reciprocal = 1.0 / b.0;
    let q = a.0 * reciprocal;
    let rest = fma(-q, b.0, a.0) + fma(-q, b.1, a.1);
    (q, rest * reciprocal)
}

/// Σ c_k z^k, as two chains of even and odd powers.
#[inline(always)]
pub(super) fn polynomial<const N: usize>(c: &[f64; N], z: f64) -> f64 {
    let square = z * z;
    let (mut high, mut low) = (c[N - 1], c[N - 2]);
    let mut k = N - 2;
    while k >= 2 {
        high = fma(high, square, c[k - 1]);
        low = fma(low, square, c[k - 2]);
        k -= 2;
    }
    // `high` goes with the odd powers if N is even, otherwise one coefficient is left, with the power 0.
    if N.is_multiple_of(2) { fma(high, z, low) } else { fma(fma(high, z, low), z, c[0]) }
}
