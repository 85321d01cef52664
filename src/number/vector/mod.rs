//! Vectors of the best instruction set that the machine has, chosen at run time.
//!
//! Everything that works on vectors is written against [`pulp::Simd`] and is `#[inline(always)]`: only what is inlined
//! into pulp's entry function is compiled with the instructions of the level. For the same reason there are no
//! closures, no iterator adaptors and no calls of the standard library over vectors.

pub(crate) mod elementary;
mod lanes;
mod nodes;

pub(crate) use lanes::{Lanes, Matrix, Weights, multiply};
pub(crate) use nodes::Nodes;

use pulp::{Arch, Scalar, Simd, WithSimd};

use super::compensated::SPLITTER;

/// Which instructions to use.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Level {
    /// The best that the machine has.
    Best,
    /// AVX2 with fused multiply-add where the machine has it, otherwise [`Self::Scalar`].
    #[cfg(test)]
    Avx2,
    /// One number at a time, no fused multiply-add.
    #[cfg(test)]
    Scalar,
}

impl Level {
    #[inline]
    pub(crate) fn dispatch<W: WithSimd>(self, work: W) -> W::Output {
        #[cfg(target_arch = "x86_64")]
        match (self, Arch::new()) {
            (Self::Best, Arch::V4(simd)) => return Simd::vectorize(simd, work),
            (Self::Best, Arch::V3(simd)) => return Simd::vectorize(simd, work),
            #[cfg(test)]
            (Self::Avx2, _) => {
                if let Some(simd) = pulp::x86::V3::try_new() {
                    return Simd::vectorize(simd, work);
                }
            }
            _ => {}
        }
        #[cfg(target_arch = "aarch64")]
        if let (Self::Best, Arch::Neon(simd)) = (self, Arch::new()) {
            return Simd::vectorize(simd, work);
        }
        one_by_one(work)
    }
}

/// Kept out of line: it is rarely run, and as large as the others together.
#[cold]
#[inline(never)]
fn one_by_one<W: WithSimd>(work: W) -> W::Output {
    work.with_simd(Scalar)
}

/// A length for which the compiler does not unroll loops over single numbers. Unrolled, they would be larger than the
/// code of all other levels together and take as long to build, for machines that hardly exist.
#[inline(always)]
pub(crate) fn count<S: Simd>(length: usize) -> usize {
    if S::IS_SCALAR { std::hint::black_box(length) } else { length }
}

/// Returns true if a multiply-add is one instruction; otherwise it is a slow library call.
#[inline(always)]
pub(crate) fn is_fused<S: Simd>() -> bool {
    !S::IS_SCALAR && cfg!(any(target_arch = "x86_64", target_arch = "aarch64"))
}

/// |a|. The trait's methods for this and the next one are not always inlined, and are then compiled without the level's
/// instructions.
#[inline(always)]
pub(crate) fn abs<S: Simd>(s: S, a: S::f64s) -> S::f64s {
    s.and_f64s(s.splat_f64s(f64::from_bits(!(1 << 63))), a)
}

/// −a.
#[inline(always)]
pub(crate) fn neg<S: Simd>(s: S, a: S::f64s) -> S::f64s {
    s.xor_f64s(a, s.splat_f64s(-0.0))
}

/// a b + c with one rounding or two.
#[inline(always)]
pub(crate) fn multiply_add<S: Simd>(s: S, a: S::f64s, b: S::f64s, c: S::f64s) -> S::f64s {
    s.mul_add_e_f64s(a, b, c)
}

/// a b − p exactly, for the rounded product p = a b.
#[inline(always)]
pub(crate) fn product_error<S: Simd>(s: S, a: S::f64s, b: S::f64s, p: S::f64s) -> S::f64s {
    if is_fused::<S>() {
        return s.mul_add_f64s(a, b, neg(s, p));
    }
    let k = s.splat_f64s(SPLITTER);
    let (ca, cb) = (s.mul_f64s(k, a), s.mul_f64s(k, b));
    let (ah, bh) = (s.sub_f64s(ca, s.sub_f64s(ca, a)), s.sub_f64s(cb, s.sub_f64s(cb, b)));
    let (al, bl) = (s.sub_f64s(a, ah), s.sub_f64s(b, bh));
    let e = s.sub_f64s(s.mul_f64s(ah, bh), p);
    let e = s.add_f64s(s.add_f64s(e, s.mul_f64s(ah, bl)), s.mul_f64s(al, bh));
    s.add_f64s(e, s.mul_f64s(al, bl))
}

/// a b − p for the rounded product p, where the machine has a fused multiply-add; otherwise it is left out.
#[inline(always)]
pub(crate) fn product_error_of<S: Simd>(a: f64, b: f64, p: f64) -> f64 {
    if is_fused::<S>() { a.mul_add(b, -p) } else { 0.0 }
}

/// The vectors of a slice whose length is a multiple of 8, and with it of the vector length.
#[inline(always)]
pub(crate) fn vectors<S: Simd>(v: &[f64]) -> &[S::f64s] {
    S::as_simd_f64s(&v[..count::<S>(v.len())]).0
}

/// The same vectors, writable.
#[inline(always)]
pub(crate) fn vectors_mut<S: Simd>(v: &mut [f64]) -> &mut [S::f64s] {
    let length = count::<S>(v.len());
    S::as_mut_simd_f64s(&mut v[..length]).0
}
