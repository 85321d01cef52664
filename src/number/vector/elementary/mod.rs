//! The functions of formulas on all nodes at once.
//!
//! A kernel has no branches and takes one number; the loops over nodes are compiled once for each level, with its
//! instructions, and become vectors there. A kernel serves a range of arguments. Outside of it (infinities, NaN,
//! subnormal numbers, huge angles, logarithms of what is not positive) a node gets the number of the standard library,
//! as all of them do where the machine has no fused multiply-add.
//!
//! The polynomials come from `scripts/elementary.py`.

mod circular;
mod exponential;
mod inverse;
mod logarithm;
mod pair;
#[cfg(test)]
mod tests;

use pulp::{Simd, WithSimd};

use self::pair::SIGN;
use super::is_fused;
use crate::number::{Function, Real};

/// All of `x`, whose length is a multiple of 8, so that the compiler knows this and makes no code for a rest.
#[inline(always)]
fn eights(x: &[f64]) -> &[f64] {
    x.as_chunks::<8>().0.as_flattened()
}

/// The arguments that a kernel serves: those from `least` on, `span` bit patterns in all, of their sizes or themselves.
#[derive(Clone, Copy)]
struct Range {
    mask: u64,
    least: u64,
    span: u64,
}

impl Range {
    /// No x.
    const NONE: Self = Self { mask: 0, least: 1, span: 0 };
    /// All x.
    const ALL: Self = Self { mask: !0, least: 0, span: !0 };
    /// Positive normal numbers.
    const POSITIVE: Self =
        Self { mask: !0, least: f64::MIN_POSITIVE.to_bits(), span: f64::MAX.to_bits() - f64::MIN_POSITIVE.to_bits() };

    /// |x| ≤ `most`.
    const fn within(most: f64) -> Self {
        Self { mask: !SIGN, least: 0, span: most.to_bits() }
    }

    #[inline(always)]
    fn lacks(self, x: f64) -> bool {
        (x.to_bits() & self.mask).wrapping_sub(self.least) > self.span
    }
}

/// f(x) node by node.
struct Call<'a> {
    function: Function,
    x: &'a [f64],
    out: &'a mut [f64],
}

/// The loop over nodes; whether all of them are in range.
macro_rules! over {
    ($call:ident, $range:expr, $kernel:path) => {{
        let range = $range;
        let x = eights($call.x);
        let out = &mut $call.out[..x.len()];
        let mut outside = 0;
        for k in 0..x.len() {
            out[k] = $kernel(x[k]);
            outside |= u64::from(range.lacks(x[k]));
        }
        (range, outside)
    }};
}

impl WithSimd for Call<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let call = self;
        let (range, outside) = match call.function {
            Function::Sin => over!(call, Range::within(circular::MOST), circular::sin),
            Function::Cos => over!(call, Range::within(circular::MOST), circular::cos),
            Function::Tan => over!(call, Range::within(circular::MOST), circular::tan),
            Function::Sinh => over!(call, Range::within(exponential::MOST), exponential::sinh),
            Function::Cosh => over!(call, Range::within(exponential::MOST), exponential::cosh),
            Function::Tanh => over!(call, Range::within(f64::MAX), exponential::tanh),
            Function::Asin => over!(call, Range::within(1.0), inverse::asin),
            Function::Acos => over!(call, Range::within(1.0), inverse::acos),
            Function::Atan => over!(call, Range::within(inverse::MOST), inverse::atan),
            Function::Exp => over!(call, Range::within(exponential::MOST), exponential::exp),
            Function::Ln => over!(call, Range::POSITIVE, logarithm::ln),
            Function::Log10 => over!(call, Range::POSITIVE, logarithm::log10),
            Function::Sqrt => over!(call, Range::ALL, f64::sqrt),
            Function::Abs => over!(call, Range::ALL, pair::abs),
            Function::Sign => over!(call, Range::ALL, Real::sign),
            Function::Step => over!(call, Range::ALL, Real::step),
            // A spline is found for each number alone.
            Function::Table(_) => (Range::NONE, 1),
        };
        if outside != 0 {
            outside_of(range, call.function, call.x, call.out);
        }
    }
}

/// sin x and cos x node by node, for little more than one of them.
struct SinCos<'a> {
    x: &'a [f64],
    sin: &'a mut [f64],
    cos: &'a mut [f64],
}

impl WithSimd for SinCos<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let range = Range::within(circular::MOST);
        let x = eights(self.x);
        let (sin, cos) = (&mut self.sin[..x.len()], &mut self.cos[..x.len()]);
        let mut outside = 0;
        for k in 0..x.len() {
            (sin[k], cos[k]) = circular::sin_cos(x[k]);
            outside |= u64::from(range.lacks(x[k]));
        }
        if outside != 0 {
            outside_of(range, Function::Sin, self.x, self.sin);
            outside_of(range, Function::Cos, self.x, self.cos);
        }
    }
}

/// The nodes that a kernel does not serve.
#[cold]
#[inline(never)]
fn outside_of(range: Range, function: Function, x: &[f64], out: &mut [f64]) {
    for (out, &x) in out.iter_mut().zip(x).filter(|&(_, &x)| range.lacks(x)) {
        *out = function.apply(x);
    }
}

/// x^y node by node.
struct Power<'a> {
    x: &'a [f64],
    y: &'a [f64],
    out: &'a mut [f64],
}

impl WithSimd for Power<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let range = Range::within(exponential::MOST);
        let x = eights(self.x);
        let (y, out) = (&self.y[..x.len()], &mut self.out[..x.len()]);
        let mut outside = 0;
        for k in 0..x.len() {
            let (power, exponent) = logarithm::power(x[k], y[k]);
            let lacks = range.lacks(exponent) | Range::POSITIVE.lacks(x[k]);
            // No power in range is NaN.
            out[k] = if lacks { f64::NAN } else { power };
            outside |= u64::from(lacks);
        }
        if outside != 0 {
            powers_outside(self.x, self.y, self.out);
        }
    }
}

#[cold]
#[inline(never)]
fn powers_outside(x: &[f64], y: &[f64], out: &mut [f64]) {
    for k in 0..x.len() {
        if out[k].is_nan() {
            out[k] = x[k].powf(y[k]);
        }
    }
}

/// f(x) on as many nodes as there are. Compiled once for every level, with its instructions.
#[inline(never)]
pub(crate) fn call<S: Simd>(s: S, function: Function, x: &[f64], out: &mut [f64]) {
    if is_fused::<S>() {
        s.vectorize(Call { function, x, out });
    } else {
        outside_of(Range::NONE, function, x, out);
    }
}

/// x^y likewise.
#[inline(never)]
pub(crate) fn power<S: Simd>(s: S, x: &[f64], y: &[f64], out: &mut [f64]) {
    if is_fused::<S>() {
        s.vectorize(Power { x, y, out });
    } else {
        out.fill(f64::NAN);
        powers_outside(x, y, out);
    }
}

/// sin x and cos x likewise.
#[inline(never)]
pub(crate) fn sin_cos<S: Simd>(s: S, x: &[f64], [sin, cos]: [&mut [f64]; 2]) {
    if is_fused::<S>() {
        s.vectorize(SinCos { x, sin, cos });
    } else {
        outside_of(Range::NONE, Function::Sin, x, sin);
        outside_of(Range::NONE, Function::Cos, x, cos);
    }
}
