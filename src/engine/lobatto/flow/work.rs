//! What is compiled for every level of instructions: evaluating a program on all nodes, and products with a matrix.

use pulp::{Simd, WithSimd};

use crate::engine::lobatto::formula::carry_out;
use crate::engine::lobatto::guess::Continuation;
use crate::engine::lobatto::product::{plain_dot, product};
use crate::engine::lobatto::tables::Tables;
use crate::formula::{Program, Register, Step};
use crate::number::vector::{Nodes, abs, largest, multiply_add, vectors, vectors_mut};

/// Outputs of a program to be mended on some nodes, see [`Program::mend_nodes`].
#[derive(Clone, Copy)]
pub(super) struct Mend<'r> {
    pub(super) program: &'r Program<f64>,
    pub(super) outputs: usize,
    pub(super) points: usize,
}

impl Mend<'_> {
    /// Mends the outputs that are not finite, and returns true if one of them could be mended.
    pub(super) fn apply<const P: usize>(self, registers: &mut [Nodes<P>]) -> bool {
        self.program.mend_nodes(self.outputs, self.points, registers)
    }
}

/// Carries out steps of a program, and copies some registers, multiplied by `factor`.
pub(super) struct Evaluate<'r, const P: usize> {
    pub(super) steps: &'r [Step],
    /// The outputs that are mended after the steps, if any are.
    pub(super) mend: Option<Mend<'r>>,
    pub(super) registers: &'r mut [Nodes<P>],
    pub(super) factor: f64,
    pub(super) from: &'r [Register],
    pub(super) to: &'r mut [Nodes<P>],
}

impl<const P: usize> WithSimd for Evaluate<'_, P> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, s: S) {
        let Self { steps, mend, registers, factor, from, to } = self;
        carry_out(s, steps, registers);
        if let Some(mend) = mend {
            mend.apply(registers);
        }
        scaled(s, factor, registers, from, to);
    }
}

/// `to[row]` = `factor` times register `from[row]`.
#[inline(always)]
fn scaled<S: Simd, const P: usize>(s: S, factor: f64, registers: &[Nodes<P>], from: &[Register], to: &mut [Nodes<P>]) {
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

/// What sweeps over a window are made of.
pub(super) struct Sweep<'r, const P: usize> {
    pub(super) registers: &'r mut [Nodes<P>],
    /// The length of the window.
    pub(super) h: f64,
    /// Rates of positions, or h² q̈ where these alone are unknowns; then of momenta.
    pub(super) rates: &'r mut [Nodes<P>],
    pub(super) start: &'r [f64],
    pub(super) low: &'r [Nodes<P>],
    pub(super) change: &'r mut [f64],
    /// By how much momenta change over the window, where only positions are unknowns; and the weights of that sum.
    pub(super) kicks: &'r mut [f64],
    pub(super) weights: &'r [f64; P],
    /// What is done, in order.
    pub(super) passes: &'r [Pass<'r, P>],
    /// The outputs that are mended in every pass, if any are, and a flag that is true once one of them was.
    pub(super) mend: Option<Mend<'r>>,
    pub(super) is_mended: &'r mut bool,
}

/// Rates of positions or of momenta, and their integrals.
#[derive(Clone, Copy)]
pub(super) struct Pass<'r, const P: usize> {
    /// The steps that compute them.
    pub(super) steps: &'r [Step],
    /// The registers of the rates.
    pub(super) from: &'r [Register],
    /// Whether positions are integrated; otherwise momenta.
    pub(super) is_position: bool,
    /// g^ab of active coordinates by rows, if positions follow from accelerations.
    pub(super) inverse: Option<&'r [f64]>,
    pub(super) matrix: &'r [[f64; P]],
    pub(super) to: &'r [Register],
}

impl<const P: usize> WithSimd for Sweep<'_, P> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, s: S) {
        let Self { registers, h, rates, start, low, change, kicks, weights, passes, mend, is_mended } = self;
        let m = rates.len() / 2;
        let mut place = 0;
        while place < passes.len() {
            let Pass { steps, from, is_position, inverse, matrix, to } = passes[place];
            place += 1;
            carry_out(s, steps, registers);
            if let Some(mend) = mend {
                *is_mended |= mend.apply(registers);
            }
            let (velocities, forces) = rates.split_at_mut(m);
            let rows = if inverse.is_none() && is_position { &mut *velocities } else { &mut *forces };
            scaled(s, h, registers, from, rows);
            if let Some(inverse) = inverse {
                // h² q̈^a = h g^ab (h ṗ_b)
                let mut row = 0;
                while row < m {
                    velocities[row] = Nodes::ZERO;
                    let out = vectors_mut::<S>(&mut velocities[row].0);
                    let mut column = 0;
                    while column < m {
                        let entry = inverse[row * m + column];
                        if entry != 0.0 {
                            let (factor, force) = (s.splat_f64s(h * entry), vectors::<S>(&forces[column].0));
                            for i in 0..out.len() {
                                out[i] = multiply_add(s, factor, force[i], out[i]);
                            }
                        }
                        column += 1;
                    }
                    let kick = plain_dot(s, weights, &forces[row].0);
                    change[m + row] = (kick - kicks[row]).abs();
                    kicks[row] = kick;
                    row += 1;
                }
            }
            let range = if is_position { 0..m } else { m..2 * m };
            Integrate {
                matrix,
                rates: if is_position { velocities } else { forces },
                start: &start[range.clone()],
                low: &low[range.clone()],
                registers,
                to,
                change: &mut change[range],
            }
            .with_simd(s);
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

/// `to[row]` = M `rows[row]` with a matrix of few rows, by columns.
pub(super) struct Sample<'r, const P: usize, const L: usize> {
    pub(super) matrix: &'r [[f64; L]; P],
    pub(super) points: usize,
    pub(super) rows: &'r [Nodes<P>],
    pub(super) registers: &'r mut [Nodes<L>],
    pub(super) to: &'r [Register],
}

impl<const P: usize, const L: usize> WithSimd for Sample<'_, P, L> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, s: S) {
        let Self { matrix, points, rows, registers, to } = self;
        let mut row = 0;
        while row < to.len() {
            let values = &rows[row].0;
            let mut sum = Nodes::<L>::ZERO;
            let out = vectors_mut::<S>(&mut sum.0);
            let mut j = 0;
            while j < points {
                let (column, value) = (vectors::<S>(&matrix[j]), s.splat_f64s(values[j]));
                for i in 0..out.len() {
                    out[i] = multiply_add(s, column[i], value, out[i]);
                }
                j += 1;
            }
            registers[to[row]] = sum;
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
