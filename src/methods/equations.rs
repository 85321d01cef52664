//! The problem that a method integrates.
//!
//! A state is a row of numbers: quadratures, positions, and a velocity or momentum for every position. The equations
//! are of one of two kinds:
//!
//! ```text
//! second order   t′ = u(x),       x′ = w,          w′ = a(x)
//! first order    t′ = u(x, p),    x′ = v(x, p),    p′ = f(x, p)
//! ```
//!
//! Nothing depends on a quadrature. Every method is written for both kinds; with the first one an implicit method
//! solves for positions only.

use std::ops::Range;

use super::{Failure, States};

/// Which numbers a state has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Parts {
    /// Numbers that nothing depends on, which come first.
    pub(super) quadratures: usize,
    /// Positions, which come next. There are as many velocities or momenta behind them.
    pub(super) positions: usize,
    /// True if the equations are of the second order.
    pub(super) is_second_order: bool,
}

impl Parts {
    /// The places of positions and momenta; what is before them are quadratures, on which nothing depends.
    #[inline(always)]
    pub(super) fn moving(self) -> Range<usize> {
        self.quadratures..self.quadratures + 2 * self.positions
    }

    /// The unknowns of an implicit method: positions, and momenta if the equations are of the first order.
    #[inline(always)]
    pub(super) fn unknowns(self) -> Range<usize> {
        let count = if self.is_second_order { self.positions } else { 2 * self.positions };
        self.quadratures..self.quadratures + count
    }

    /// An unknown with index k follows from the rate with the index k + this: that of its velocity, or its own.
    #[inline(always)]
    pub(super) fn behind(self) -> usize {
        if self.is_second_order { self.positions } else { 0 }
    }

    /// The rates from which unknowns and quadratures follow.
    #[inline(always)]
    pub(super) fn driving(self) -> Range<usize> {
        let unknowns = self.unknowns();
        unknowns.start + self.behind()..unknowns.end + self.behind()
    }
}

/// The right-hand side of the equations, with the linear algebra of their derivatives.
pub(super) trait Equations {
    /// A value for each number of a state: an array where its length is known, so that it stays in registers.
    type Rows<T: Copy>: Clone + AsRef<[T]> + AsMut<[T]>;

    /// `value` for each number of a state.
    fn rows<T: Copy>(&self, value: T) -> Self::Rows<T>;

    /// Which numbers a state has.
    fn parts(&self) -> Parts;

    /// The state to begin with; quadratures are counted from there.
    fn start(&self) -> Self::Rows<f64>;

    /// The number of evaluations so far, by [`Self::rates`] and [`Self::linearise`].
    fn evaluations(&self) -> usize;

    /// The derivatives of all numbers of a state. Outside the domain they may be anything, NaN included.
    fn rates(&mut self, state: &Self::Rows<f64>, rates: &mut Self::Rows<f64>);

    /// Adds a state to the points of a trajectory.
    ///
    /// # Errors
    /// If the computation cannot go on from there.
    fn point(&mut self, state: &Self::Rows<f64>, out: &mut States) -> Result<(), Failure>;

    /// Learns the Jacobian J at a state.
    fn linearise(&mut self, state: &Self::Rows<f64>);

    /// Prepares [`Self::correct`], where J₁ is the derivative of the driving rates by the unknowns:
    /// 1 − `scale` · `matrix` ⊗ J₁.
    fn factor(&mut self, matrix: &[[f64; 3]; 3], scale: f64);

    /// Solves with that matrix for the unknowns at three nodes.
    fn correct(&mut self, right: &mut Self::Rows<[f64; 3]>);

    /// Solves with `diagonal` − J for all but the quadratures.
    fn smooth(&mut self, diagonal: f64, right: &mut Self::Rows<f64>);
}

/// `out` = `y` + `h` · `v`.
#[inline(always)]
pub(super) fn step<R: AsRef<[f64]> + AsMut<[f64]>>(out: &mut R, y: &R, h: f64, v: &R) {
    for ((out, y), v) in out.as_mut().iter_mut().zip(y.as_ref()).zip(v.as_ref()) {
        *out = y + h * v;
    }
}
