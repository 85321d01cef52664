//! One number for each node of a window, with the operators that kernels are written in.
//!
//! Whatever computes on lanes is generic over [`pulp::Simd`] and `#[inline(always)]`: it is compiled once for each
//! instruction set, inside of the function that [`pulp::Simd::vectorize`] makes for it, and only what is inlined there
//! gets its instructions. Numbers are kept as [`Nodes`], which know of no instruction set.

use std::ops::{Add, Mul, Sub};

use pulp::Simd;

use super::{Nodes, abs, multiply_add, neg, product_error, vectors, vectors_mut};
use crate::number::Compensated;

/// N numbers, N a multiple of 8. The token `s` has no size.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
pub(crate) struct Lanes<S, const N: usize> {
    values: [f64; N],
    s: S,
}

/// Lanes with each vector `a` of others replaced by an expression of it, and of vectors of further lanes.
macro_rules! each {
    ($lanes:ident |$a:ident $(, $b:ident: $other:ident)*| $value:expr) => {{
        let mut out = $lanes;
        $(let $b = vectors::<S>(&$other.values);)*
        let to = vectors_mut::<S>(&mut out.values);
        for i in 0..to.len() {
            let $a = to[i];
            $(let $b = $b[i];)*
            to[i] = $value;
        }
        out
    }};
}

impl<S: Simd, const N: usize> Lanes<S, N> {
    /// The same number in all lanes.
    #[inline(always)]
    pub(crate) fn splat(s: S, value: f64) -> Self {
        Self { values: [value; N], s }
    }

    /// The numbers on the nodes.
    #[inline(always)]
    pub(crate) fn new(s: S, nodes: &Nodes<N>) -> Self {
        Self { values: nodes.0, s }
    }

    /// The numbers, to be kept.
    #[inline(always)]
    pub(crate) fn nodes(self) -> Nodes<N> {
        Nodes(self.values)
    }

    /// self·factor + addend, with one rounding where the machine can.
    #[inline(always)]
    pub(crate) fn mul_add(self, factor: Self, addend: Self) -> Self {
        each!(self |a, b: factor, c: addend| self.s.mul_add_e_f64s(a, b, c))
    }

    /// self·factor + addend for one factor.
    #[inline(always)]
    pub(crate) fn scale_add(self, factor: f64, addend: Self) -> Self {
        self.mul_add(Self::splat(self.s, factor), addend)
    }

    /// Lane by lane the larger number. A NaN may be lost.
    #[inline(always)]
    pub(crate) fn max(self, other: Self) -> Self {
        each!(self |a, b: other| self.s.max_f64s(a, b))
    }

    /// Absolute values.
    #[inline(always)]
    pub(crate) fn abs(self) -> Self {
        each!(self | a | abs(self.s, a))
    }

    /// Σ a_j b_j.
    #[inline(always)]
    pub(crate) fn dot(self, other: Self) -> f64 {
        let (a, b) = (vectors::<S>(&self.values), vectors::<S>(&other.values));
        let mut sums = Lanes::<S, 8>::splat(self.s, 0.0);
        let to = vectors_mut::<S>(&mut sums.values);
        for i in 0..a.len() {
            let place = i % to.len();
            to[place] = self.s.mul_add_e_f64s(a[i], b[i], to[place]);
        }
        sums.total()
    }

    /// The number on the last node.
    #[inline(always)]
    pub(crate) fn last(self) -> f64 {
        self.values[N - 1]
    }

    /// −a.
    #[inline(always)]
    pub(crate) fn neg(self) -> Self {
        each!(self | a | neg(self.s, a))
    }

    /// The largest lane. A NaN may be lost.
    #[inline(always)]
    pub(crate) fn largest(self) -> f64 {
        let v = vectors::<S>(&self.values);
        let mut most = v[0];
        for &v in &v[1..] {
            most = self.s.max_f64s(most, v);
        }
        self.s.reduce_max_f64s(most)
    }
}

impl<S: Simd> Lanes<S, 8> {
    /// The sum of all lanes, halves first: every instruction set adds in this order, so that results are the same.
    #[inline(always)]
    fn total(mut self) -> f64 {
        let v = vectors_mut::<S>(&mut self.values);
        let mut half = v.len() / 2;
        while half > 0 {
            for i in 0..half {
                v[i] = self.s.add_f64s(v[i], v[i + half]);
            }
            half /= 2;
        }
        self.s.reduce_sum_f64s(v[0])
    }
}

macro_rules! lanewise {
    ($($operator:ident $method:ident $instruction:ident),*) => {$(
        impl<S: Simd, const N: usize> $operator for Lanes<S, N> {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                each!(self |a, b: other| self.s.$instruction(a, b))
            }
        }

        impl<S: Simd, const N: usize> $operator<f64> for Lanes<S, N> {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: f64) -> Self {
                self.$method(Self::splat(self.s, other))
            }
        }
    )*};
}

lanewise!(Add add add_f64s, Sub sub sub_f64s, Mul mul mul_f64s);

/// Weights in twice the digits, 0 beyond the last node. Errors of rounded weights would be the same in every window.
#[derive(Debug, Clone)]
pub(crate) struct Weights<const N: usize> {
    pub(crate) high: Nodes<N>,
    pub(crate) low: Nodes<N>,
}

impl<const N: usize> Weights<N> {
    /// Makes one of n ≤ N nodes.
    pub(crate) fn new(n: usize, weight: impl Fn(usize) -> Compensated) -> Self {
        let (mut high, mut low) = (Nodes::ZERO, Nodes::ZERO);
        for (j, (high, low)) in high.0.iter_mut().zip(&mut low.0).enumerate().take(n) {
            Compensated { high: *high, low: *low } = weight(j);
        }
        Self { high, low }
    }

    /// Σ_j w_j v_j to about 30 digits.
    ///
    /// Adding and subtracting `big` cuts every product to a multiple of one unit, and such numbers add without error in
    /// any order (Rump, Ogita, Oishi 2008, "Accurate floating-point summation", ExtractVector). What is cut off is
    /// added plainly.
    #[inline(always)]
    pub(crate) fn dot<S: Simd>(&self, s: S, values: &Nodes<N>) -> Compensated {
        let largest = Lanes::new(s, &self.high).abs().largest() * Lanes::new(s, values).abs().largest();
        // 1.5 times a power of two, and at least 4 Σ |w v|.
        let power_of_two = f64::from_bits((8.0 * N as f64 * largest).to_bits() & 0x7ff0_0000_0000_0000);
        let big = s.splat_f64s(1.5 * power_of_two);
        let (mut sum, mut rest) = (s.splat_f64s(0.0), Lanes::<S, 8>::splat(s, 0.0));
        let to = vectors_mut::<S>(&mut rest.values);
        let (high, low, v) = (vectors::<S>(&self.high.0), vectors::<S>(&self.low.0), vectors::<S>(&values.0));
        for i in 0..v.len() {
            let product = s.mul_f64s(high[i], v[i]);
            let cut = s.sub_f64s(s.add_f64s(product, big), big);
            let error = multiply_add(s, low[i], v[i], product_error(s, high[i], v[i], product));
            let place = i % to.len();
            to[place] = s.add_f64s(to[place], s.add_f64s(error, s.sub_f64s(product, cut)));
            sum = s.add_f64s(sum, cut);
        }
        Compensated::new(s.reduce_sum_f64s(sum), rest.total())
    }
}

/// A matrix of N rows by columns, an even number of them, of which the last one may be 0.
pub(crate) type Matrix<const N: usize> = [Nodes<N>];

/// Σ bases + M x.
///
/// Even and odd columns have sums of their own, so that additions do not wait for each other; the second one is the
/// smaller one, if its base is. The number of columns is not known to the compiler: unrolled, it would multiply vector
/// after vector, each waiting for itself.
#[inline(always)]
pub(crate) fn multiply<S: Simd, const N: usize>(
    s: S,
    matrix: &Matrix<N>,
    x: &Nodes<N>,
    bases: [Lanes<S, N>; 2],
) -> Lanes<S, N> {
    let [mut even, mut odd] = bases;
    for (columns, x) in matrix.as_chunks::<2>().0.iter().zip(x.0.as_chunks::<2>().0) {
        even = Lanes::new(s, &columns[0]).scale_add(x[0], even);
        odd = Lanes::new(s, &columns[1]).scale_add(x[1], odd);
    }
    even + odd
}
