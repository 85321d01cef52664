//! Integrals over γ by the operator of a window: u with du/dγ = r and u = 0 at the start.

use super::derivative::FormDerivative;
use super::newton::{Failure, LinearFailure, Root, RoundingLevels};
use super::refinement::{self, Refined};
use super::status::Status;
use crate::linalg::banded::solve_banded;
use crate::number::Real;
use crate::number::norm::max_abs;

/// The rule of integration on a window.
#[derive(Clone, Copy)]
pub(super) struct Integral<'a, S> {
    pub(super) derivative: FormDerivative<'a, S>,
    /// The same in `f64`.
    pub(super) rough: FormDerivative<'a, f64>,
    /// Significant digits wanted.
    pub(super) digits: u32,
}

impl<S: Real> Integral<'_, S> {
    /// u on the nodes, where `h_rate` is h r at a node, with iterative refinement: one round for `f64`, as many as the
    /// digits need otherwise. `spare` is room for N numbers.
    pub(super) fn of<O: Copy>(
        self,
        h_rate: impl Fn(usize) -> S,
        spare: Vec<S>,
        max_iterations: usize,
    ) -> Result<Vec<S>, Failure<O>> {
        let (first, unknowns) = (self.derivative.first_unknown(), self.derivative.unknowns());
        let values = vec![S::ZERO; spare.len()];
        let mut right: Vec<f64> = (0..unknowns).map(|k| h_rate(k).to_f64()).collect();
        let outside = std::marker::PhantomData;
        let mut system = Rows { integral: self, h_rate, values, slope: spare, outside };
        if S::IS_EXTENDED {
            let start = Root { unknowns: vec![0.0; unknowns], history: Vec::new() };
            let root = refinement::refine(&mut system, start, self.digits, max_iterations)?;
            system.values[first..].copy_from_slice(&root.unknowns);
            return Ok(system.values);
        }
        for round in 0..2 {
            let solved = system.solve_linearised(&mut right);
            solved.map_err(|LinearFailure| Failure::without_iterate(Status::Singular))?;
            for (u, &correction) in system.values[first..].iter_mut().zip(&right) {
                *u += S::from(correction);
            }
            if round == 0 {
                system.evaluate();
                for (k, r) in right.iter_mut().enumerate() {
                    *r = -system.row(k).to_f64();
                }
            }
        }
        Ok(system.values)
    }
}

/// Rows h du/dγ − h r in the unknown u.
struct Rows<'a, S, R, O> {
    integral: Integral<'a, S>,
    h_rate: R,
    // The values that were evaluated last.
    values: Vec<S>,
    slope: Vec<S>,
    /// A linear system is defined everywhere; the failure of a whole that contains it has points outside.
    outside: std::marker::PhantomData<O>,
}

impl<S: Real, R: Fn(usize) -> S, O> Rows<'_, S, R, O> {
    fn evaluate(&mut self) {
        self.integral.derivative.apply(&self.values, S::ZERO, &mut self.slope);
    }

    fn row(&self, k: usize) -> S {
        self.integral.derivative.sbp().spacing() * self.slope[k] - (self.h_rate)(k)
    }
}

impl<S: Real, R: Fn(usize) -> S, O: Copy> Refined<S> for Rows<'_, S, R, O> {
    type Outside = O;

    fn residual(&mut self, u: &[S], out: &mut [S]) -> Result<(), O> {
        let first = self.integral.derivative.first_unknown();
        self.values[first..].copy_from_slice(u);
        self.evaluate();
        for (k, row) in out.iter_mut().enumerate() {
            *row = self.row(k);
        }
        Ok(())
    }

    fn solve_linearised(&mut self, right: &mut [f64]) -> Result<(), LinearFailure> {
        let derivative = self.integral.rough;
        let (lower, upper) = derivative.reach();
        let h = derivative.sbp().spacing();
        solve_banded(lower, upper, right, |k, row| {
            row.fill(0.0);
            derivative.row(k).for_each(|(column, d)| row[column + lower - k] += h * d);
        })
        .map_err(|_| LinearFailure)
    }

    fn rounding(&self, u: &[S]) -> Option<RoundingLevels> {
        let row_sum = self.integral.derivative.sbp().row_sum();
        Some(vec![(0..u.len(), row_sum * S::EPSILON.to_f64() * max_abs(u).to_f64())])
    }

    fn sizes(&self, u: &[S]) -> Vec<S> {
        vec![max_abs(u)]
    }
}
