//! What windows of a rule have in common, whatever their length.
//!
//! A geodesic may be walked in any affine parameter: with s = γ/h, h Q_t and h w take the place of Q_t and w, and every
//! window has length 1. So one set of tables serves windows of all lengths.

use pulp::Simd;

use super::guess::Continuation;
use super::tables::{LengthFree, Matrix, Tables};
use crate::number::vector::{Nodes, Twofold, vectors, vectors_mut};
use crate::sbp::collocation::{Collocation, share};

/// The tables of a rule, made once in its life.
#[derive(Debug, Clone)]
pub(super) struct Unit<const P: usize> {
    pub(super) tables: Box<Tables<P>>,
    /// From nodal values to Legendre coefficients, by columns.
    pub(super) modes: Box<Matrix<P>>,
    /// (2k + 1)/(k + 1) and k/(k + 1): P_{k+1} = the one z P_k − the other P_{k−1}.
    pub(super) recurrence: Vec<[f64; 2]>,
    /// 1/(2(2k + 1)) for k < n.
    pub(super) shares: Nodes<P>,
    /// A by columns, every entry rounded by itself.
    pub(super) a: Box<Matrix<P>>,
    /// A⁻¹ = D + H⁻¹E_0 by columns.
    pub(super) derivative: Box<Matrix<P>>,
}

impl<const P: usize> Unit<P> {
    fn new(operators: &Collocation, free: &LengthFree) -> Self {
        let n = operators.points();
        let mut modes = Box::new([[0.0; P]; P]);
        for k in 0..n {
            modes.iter_mut().zip(operators.mode(k)).for_each(|(column, weight)| column[k] = weight);
        }
        let ratio = |k: usize| [(2 * k + 1) as f64 / (k + 1) as f64, k as f64 / (k + 1) as f64];
        let mut shares = Nodes::ZERO;
        (0..n).for_each(|k| shares.0[k] = share(k));
        let (mut a, mut derivative) = (Box::new([[0.0; P]; P]), Box::new([[0.0; P]; P]));
        for i in 0..n {
            for j in 0..n {
                (a[j][i], derivative[j][i]) = (operators.a()[i * n + j].hi, operators.derivative(i, j).hi);
            }
        }
        Self {
            tables: Tables::new(operators, free, Twofold::ONE),
            modes,
            recurrence: (0..=n).map(ratio).collect(),
            shares,
            a,
            derivative,
        }
    }

    /// `factor` A v, summed from the first node to the last with every product rounded, as
    /// [`WindowView::t`](super::view::WindowView::t) does it.
    #[inline(always)]
    pub(super) fn integral<S: Simd>(&self, s: S, v: &Nodes<P>, factor: f64, out: &mut Nodes<P>) {
        let (factor, zero) = (s.splat_f64s(factor), s.splat_f64s(0.0));
        *out = Nodes::ZERO;
        let out = vectors_mut::<S>(&mut out.0);
        let mut j = 0;
        while j < self.tables.points {
            let (column, value) = (vectors::<S>(&self.a[j]), s.splat_f64s(v.0[j]));
            for i in 0..out.len() {
                out[i] = s.add_f64s(out[i], s.mul_f64s(column[i], value));
            }
            j += 1;
        }
        for sum in out {
            *sum = s.add_f64s(zero, s.mul_f64s(factor, *sum));
        }
    }

    /// The forces of a window as a polynomial of `degree`, on one that begins at its start (`begin` 0) or end (1) and
    /// is `ratio` as long.
    pub(super) fn continuation(&self, degree: usize, begin: f64, ratio: f64) -> Continuation<'_, P> {
        Continuation {
            modes: &self.modes,
            recurrence: &self.recurrence,
            degree,
            first: 2.0 * begin - 1.0,
            step: 2.0 * ratio,
            factor: ratio * ratio,
        }
    }
}

/// The smallest compiled size that holds the nodes.
#[derive(Debug, Clone)]
pub(super) enum SizedUnit {
    P8(Box<Unit<8>>),
    P16(Box<Unit<16>>),
    P24(Box<Unit<24>>),
    P32(Box<Unit<32>>),
    P64(Box<Unit<64>>),
}

impl SizedUnit {
    pub(super) fn new(operators: &Collocation, free: &LengthFree) -> Self {
        match operators.points() {
            ..=8 => Self::P8(Box::new(Unit::new(operators, free))),
            9..=16 => Self::P16(Box::new(Unit::new(operators, free))),
            17..=24 => Self::P24(Box::new(Unit::new(operators, free))),
            25..=32 => Self::P32(Box::new(Unit::new(operators, free))),
            _ => Self::P64(Box::new(Unit::new(operators, free))),
        }
    }
}

/// `$body` with `$unit` of whichever size it has.
macro_rules! with_unit {
    ($rule:expr, $unit:ident => $body:expr) => {
        match $rule.unit() {
            $crate::engine::lobatto::unit::SizedUnit::P8($unit) => $body,
            $crate::engine::lobatto::unit::SizedUnit::P16($unit) => $body,
            $crate::engine::lobatto::unit::SizedUnit::P24($unit) => $body,
            $crate::engine::lobatto::unit::SizedUnit::P32($unit) => $body,
            $crate::engine::lobatto::unit::SizedUnit::P64($unit) => $body,
        }
    };
}

pub(super) use with_unit;
