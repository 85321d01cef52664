//! Products of matrices and vectors, and sums of products.

use pulp::{Simd, WithSimd};

use crate::number::vector::twofold::fast_two_sum;
use crate::number::vector::{count, multiply_add, product_error, vectors, vectors_mut};

/// G vectors of rows of `base` + M v from the `r`-th on; 4 G independent chains hide the latency of multiply-adds.
#[inline(always)]
fn rows<S: Simd, const P: usize, const G: usize>(
    s: S,
    base: &[f64; P],
    m: &[[f64; P]],
    v: &[f64; P],
    r: usize,
    out: &mut [f64; P],
) {
    let mut sum = [[s.splat_f64s(0.0); G]; 4];
    let base = &vectors::<S>(base)[r..r + G];
    let mut g = 0;
    while g < G {
        sum[0][g] = base[g];
        g += 1;
    }
    let m = m.as_chunks::<4>().0;
    let v = &v.as_chunks::<4>().0[..m.len()];
    let mut k = 0;
    while k < m.len() {
        for c in 0..4 {
            let factor = s.splat_f64s(v[k][c]);
            let column = &vectors::<S>(&m[k][c])[r..r + G];
            for g in 0..G {
                sum[c][g] = multiply_add(s, column[g], factor, sum[c][g]);
            }
        }
        k += 1;
    }
    let out = &mut vectors_mut::<S>(out)[r..r + G];
    for g in 0..G {
        out[g] = s.add_f64s(s.add_f64s(sum[0][g], sum[1][g]), s.add_f64s(sum[2][g], sum[3][g]));
    }
}

/// out = base + M v, as part of what it is called by; for single numbers out of line.
#[inline(always)]
pub(super) fn product<S: Simd, const P: usize>(
    s: S,
    base: &[f64; P],
    m: &[[f64; P]],
    v: &[f64; P],
    out: &mut [f64; P],
) {
    if S::IS_SCALAR {
        product_apart(s, base, m, v, out);
    } else {
        product_inlined(s, base, m, v, out);
    }
}

/// The same, compiled once for each level and length: for what is done once in a window, or costs much more.
#[inline(never)]
pub(super) fn product_apart<S: Simd, const P: usize>(
    s: S,
    base: &[f64; P],
    m: &[[f64; P]],
    v: &[f64; P],
    out: &mut [f64; P],
) {
    s.vectorize(Product { base, m, v, out });
}

struct Product<'r, const P: usize> {
    base: &'r [f64; P],
    m: &'r [[f64; P]],
    v: &'r [f64; P],
    out: &'r mut [f64; P],
}

impl<const P: usize> WithSimd for Product<'_, P> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, s: S) {
        product_inlined(s, self.base, self.m, self.v, self.out);
    }
}

/// As many rows at a time as fit the registers.
#[inline(always)]
fn product_inlined<S: Simd, const P: usize>(s: S, base: &[f64; P], m: &[[f64; P]], v: &[f64; P], out: &mut [f64; P]) {
    // `v` is to be read from memory: broadcasting loads are cheap, shuffles of a register compete with the arithmetic
    // (with AVX-512 a fifth of the whole time for 20 nodes).
    let v = std::hint::black_box(v);
    let count = count::<S>(P / S::F64_LANES);
    let mut r = 0;
    if count.is_multiple_of(3) {
        while r < count {
            rows::<S, P, 3>(s, base, m, v, r, out);
            r += 3;
        }
    }
    while r + 2 <= count {
        rows::<S, P, 2>(s, base, m, v, r, out);
        r += 2;
    }
    if r < count {
        rows::<S, P, 1>(s, base, m, v, r, out);
    }
}

/// Σ (c + c_lo)_j (v + dv)_j as a pair, good to about 30 digits.
///
/// `big` is 1.5 times a power of two and at least 4 Σ|c v|: adding and subtracting it cuts every product to a multiple
/// of one unit, and such numbers add without error in any order (Rump, Ogita, Oishi 2008, "Accurate floating-point
/// summation", ExtractVector). What is cut off is added plainly. With too small a `big` the sum is merely a plain one.
#[inline(always)]
pub(super) fn dot<S: Simd, const P: usize>(
    s: S,
    c: [&[f64; P]; 2],
    v: &[f64; P],
    dv: &[f64; P],
    big: f64,
) -> (f64, f64) {
    let big = s.splat_f64s(big);
    let (mut sum, mut rest) = (s.splat_f64s(0.0), s.splat_f64s(0.0));
    let (c, c_lo) = (vectors::<S>(c[0]), vectors::<S>(c[1]));
    let (v, dv) = (vectors::<S>(v), vectors::<S>(dv));
    for i in 0..c.len() {
        let p = s.mul_f64s(c[i], v[i]);
        let cut = s.sub_f64s(s.add_f64s(p, big), big);
        let error = multiply_add(s, c_lo[i], v[i], product_error(s, c[i], v[i], p));
        let error = multiply_add(s, c[i], dv[i], error);
        rest = s.add_f64s(rest, s.add_f64s(error, s.sub_f64s(p, cut)));
        sum = s.add_f64s(sum, cut);
    }
    fast_two_sum(s.reduce_sum_f64s(sum), s.reduce_sum_f64s(rest))
}

/// Σ c_j v_j.
#[inline(always)]
pub(super) fn plain_dot<S: Simd, const P: usize>(s: S, c: &[f64; P], v: &[f64; P]) -> f64 {
    let (c, v) = (vectors::<S>(c), vectors::<S>(v));
    let mut sum = s.splat_f64s(0.0);
    for i in 0..c.len() {
        sum = multiply_add(s, c[i], v[i], sum);
    }
    s.reduce_sum_f64s(sum)
}
