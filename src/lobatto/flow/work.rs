//! What is compiled for every level of instructions: evaluating a program on all nodes, and products with a matrix.

use pulp::{Simd, WithSimd};

use crate::expr::{Program, Register};
use crate::lobatto::formula::Vectors;
use crate::lobatto::guess::Continuation;
use crate::lobatto::product::{plain_dot, product};
use crate::lobatto::simd::{abs, largest, vectors, vectors_mut};
use crate::lobatto::tables::{Nodes, Tables};

/// Runs the program for its first `outputs`, and copies some registers, multiplied by `factor`.
pub(super) struct Evaluate<'r, const P: usize> {
    pub(super) program: &'r Program<f64>,
    pub(super) outputs: usize,
    pub(super) registers: &'r mut [Nodes<P>],
    pub(super) factor: f64,
    pub(super) from: &'r [Register],
    pub(super) to: &'r mut [Nodes<P>],
}

impl<const P: usize> WithSimd for Evaluate<'_, P> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, s: S) {
        let Self { program, outputs, registers, factor, from, to } = self;
        program.walk(outputs, &mut Vectors { s, registers });
        let factor = s.splat_f64s(factor);
        let mut row = 0;
        while row < to.len() {
            let (from, to) = (vectors::<S>(&registers[from[row]].0), vectors_mut::<S>(&mut to[row].0));
            for i in 0..to.len() {
                to[i] = s.mul_f64s(factor, from[i]);
            }
            row += 1;
        }
    }
}

/// Register `to[row]` = `start[row]` + (`low[row]` + M `rates[row]`) for every row, and by how much it changes at most.
pub(super) struct Integrate<'r, const P: usize> {
    pub(super) matrix: &'r [[f64; P]],
    pub(super) rates: &'r [Nodes<P>],
    pub(super) start: &'r [f64],
    pub(super) low: &'r [Nodes<P>],
    pub(super) registers: &'r mut [Nodes<P>],
    pub(super) to: &'r [Register],
    pub(super) change: &'r mut [f64],
}

impl<const P: usize> WithSimd for Integrate<'_, P> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, s: S) {
        let Self { matrix, rates, start, low, registers, to, change } = self;
        let mut sum = Nodes::<P>::ZERO;
        let mut row = 0;
        while row < to.len() {
            product(s, &low[row].0, matrix, &rates[row].0, &mut sum.0);
            let start = s.splat_f64s(start[row]);
            let (sum, out) = (vectors::<S>(&sum.0), vectors_mut::<S>(&mut registers[to[row]].0));
            let mut most = s.splat_f64s(0.0);
            for i in 0..out.len() {
                let value = s.add_f64s(start, sum[i]);
                most = s.max_f64s(most, abs(s, s.sub_f64s(value, out[i])));
                out[i] = value;
            }
            change[row] = s.reduce_max_f64s(most);
            row += 1;
        }
    }
}

/// `out[row]` = M `rows[row]` for every row.
pub(super) struct Multiply<'r, const P: usize> {
    pub(super) matrix: &'r [[f64; P]],
    pub(super) rows: &'r [Nodes<P>],
    pub(super) out: &'r mut [Nodes<P>],
}

impl<const P: usize> WithSimd for Multiply<'_, P> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, s: S) {
        let Self { matrix, rows, out } = self;
        let mut row = 0;
        while row < rows.len() {
            product(s, &[0.0; P], matrix, &rows[row].0, &mut out[row].0);
            row += 1;
        }
    }
}

/// The polynomials of one window's rates on the nodes of another: `out[row]`.
pub(super) struct Continue<'r, const P: usize> {
    pub(super) from: &'r Continuation<'r, P>,
    pub(super) tables: &'r Tables<P>,
    pub(super) rows: &'r [Nodes<P>],
    pub(super) out: &'r mut [Nodes<P>],
}

impl<const P: usize> WithSimd for Continue<'_, P> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, s: S) {
        let Self { from, tables, rows, out } = self;
        let mut row = 0;
        while row < rows.len() {
            product(s, &[0.0; P], &from.modes[..tables.columns], &rows[row].0, &mut out[row].0);
            from.apply(s, tables, &mut out[row]);
            row += 1;
        }
    }
}

/// What a row of rates shows of the error of its window.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Tail {
    /// The larger of its two highest Legendre modes but the last.
    pub(super) tail: f64,
    /// Its largest value.
    pub(super) largest: f64,
}

/// Looks at the tails of all rows.
pub(super) struct Look<'r, const P: usize> {
    /// From nodal values to the two modes.
    pub(super) modes: &'r [Nodes<P>; 2],
    pub(super) rows: &'r [Nodes<P>],
    pub(super) out: &'r mut [Tail],
}

impl<const P: usize> WithSimd for Look<'_, P> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, s: S) {
        let Self { modes, rows, out } = self;
        let mut row = 0;
        while row < rows.len() {
            let v = &rows[row].0;
            let tail = plain_dot(s, &modes[0].0, v).abs().max(plain_dot(s, &modes[1].0, v).abs());
            out[row] = Tail { tail, largest: largest(s, v) };
            row += 1;
        }
    }
}
