//! Integrals over γ by the operator of a window: u with du/dγ = r and u = 0 at the start.

use super::newton::{Equations, Failure, Root, RoundingLevels};
use super::refinement;
use super::status::Status;
use super::window::{FormDerivative, Window};
use crate::geometry::OutsideGeometry;
use crate::linalg::Singular;
use crate::linalg::banded::solve_banded;
use crate::number::Real;
use crate::number::norm::max_abs;

/// u on the nodes of `window`, where `h_rate` is h r at a node, with iterative refinement: one round for `f64`, as many
/// as the digits need otherwise. `rough` is the window in `f64`.
pub(super) fn integral<S: Real>(
    window: &Window<'_, S>,
    rough: &Window<'_, f64>,
    h_rate: impl Fn(usize) -> S,
) -> Result<Vec<S>, Failure> {
    let (derivative, rough) = (window.derivative(), rough.derivative());
    let (first, unknowns) = (derivative.first_unknown(), derivative.unknowns());
    let [values, slope] = [(); 2].map(|()| vec![S::ZERO; window.points()]);
    let mut rows = Rows { derivative, h_rate, values, slope };
    let (h, (lower, upper)) = (rough.sbp.spacing(), rough.reach());
    let solve = |right: &mut [f64]| {
        solve_banded(lower, upper, right, |k, row| {
            row.fill(0.0);
            rough.row(k).for_each(|(column, d)| row[column + lower - k] += h * d);
        })
    };
    if S::IS_EXTENDED {
        let start = Root { unknowns: vec![0.0; unknowns], history: Vec::new() };
        let root = refinement::refine(&mut rows, solve, start, (window.digits, window.max_iterations))?;
        rows.values[first..].copy_from_slice(&root.unknowns);
        return Ok(rows.values);
    }
    let mut right: Vec<f64> = (0..unknowns).map(|k| (rows.h_rate)(k).to_f64()).collect();
    for round in 0..2 {
        solve(&mut right).map_err(|Singular| Failure::without_iterate(Status::Singular))?;
        for (u, &correction) in rows.values[first..].iter_mut().zip(&right) {
            *u += S::from(correction);
        }
        if round == 0 {
            rows.evaluate();
            for (k, r) in right.iter_mut().enumerate() {
                *r = -rows.row(k).to_f64();
            }
        }
    }
    Ok(rows.values)
}

/// Rows h du/dγ − h r in the unknown u.
struct Rows<'a, S, R> {
    derivative: FormDerivative<'a, S>,
    h_rate: R,
    // The values that were evaluated last.
    values: Vec<S>,
    slope: Vec<S>,
}

impl<S: Real, R: Fn(usize) -> S> Rows<'_, S, R> {
    fn evaluate(&mut self) {
        self.derivative.apply(&self.values, S::ZERO, &mut self.slope);
    }

    fn row(&self, k: usize) -> S {
        self.derivative.sbp.spacing() * self.slope[k] - (self.h_rate)(k)
    }
}

impl<S: Real, R: Fn(usize) -> S> Equations<S> for Rows<'_, S, R> {
    fn residual(&mut self, u: &[S], out: &mut [S]) -> Result<(), OutsideGeometry> {
        let first = self.derivative.first_unknown();
        self.values[first..].copy_from_slice(u);
        self.evaluate();
        out.iter_mut().enumerate().for_each(|(k, row)| *row = self.row(k));
        Ok(())
    }

    fn rounding(&self, u: &[S]) -> Option<RoundingLevels> {
        let row_sum = self.derivative.sbp.row_sum();
        Some(vec![(0..u.len(), row_sum * S::EPSILON.to_f64() * max_abs(u).to_f64())])
    }

    fn sizes(&self, u: &[S]) -> Vec<S> {
        vec![max_abs(u)]
    }
}
