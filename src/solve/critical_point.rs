//! The critical point of the doubled action: Newton's method on ∇E_IVP = 0 with a sparse LU of the Hessian.

use faer::Col;
use faer::linalg::solvers::SolveCore;
use faer::sparse::linalg::solvers::{Lu, SymbolicLu};

use super::newton::{self, Failure, LinearFailure, NewtonSystem, Root, RoundingLevels};
use super::refinement::{self, Refined};
use super::setup::Setup;
use super::status::Status;
use crate::action::{DoubledAction, GradientRounding, HessianPattern, Layout, MULTIPLIERS};
use crate::metric::OutsideDomain;
use crate::norm::max_abs;
use crate::scalar::Real;

/// A refined linear solution must leave less than this share of the right-hand side; more means that the factorisation
/// is useless.
const LINEAR_TOLERANCE: f64 = 1e-3;

/// Newton's method for actions on one operator: the sparsity and its symbolic factorisation are found once.
pub(super) struct CriticalPointSolver {
    pattern: HessianPattern,
    symbolic: SymbolicLu<usize>,
}

impl CriticalPointSolver {
    pub(super) fn new(action: &DoubledAction<'_>) -> Self {
        let pattern = action.hessian_pattern();
        let symbolic =
            SymbolicLu::try_new(pattern.symbolic().as_ref()).expect("the order of the Hessian fits its index type");
        Self { pattern, symbolic }
    }

    /// The critical point of `action` that Newton's method reaches from `guess`.
    pub(super) fn solve(
        &self,
        action: &DoubledAction<'_>,
        guess: Vec<f64>,
        max_iterations: usize,
    ) -> Result<Root, Failure> {
        newton::solve(&mut Stationarity { solver: self, action }, guess, max_iterations)
    }

    /// The critical point of `fine` close to that of `rough`, the same action in `f64`, whose Hessian is factored once.
    pub(super) fn refine<S: Real>(
        &self,
        fine: &DoubledAction<'_, S>,
        rough: &DoubledAction<'_>,
        root: Root,
        setup: &Setup<S>,
    ) -> Result<Root<S>, Failure> {
        let hessian = rough.hessian(&root.unknowns, &self.pattern).ok();
        let lu = hessian.and_then(|hessian| Lu::try_new_with_symbolic(self.symbolic.clone(), hessian.as_ref()).ok());
        let lu = lu.ok_or_else(|| Failure::without_iterate(Status::Singular))?;
        refinement::refine(&mut RefinedStationarity { action: fine, lu }, root, setup.digits, setup.max_iterations)
    }
}

/// ∇E_IVP = 0 as a Newton system.
struct Stationarity<'a> {
    solver: &'a CriticalPointSolver,
    action: &'a DoubledAction<'a>,
}

impl NewtonSystem for Stationarity<'_> {
    fn residual(&mut self, u: &[f64], out: &mut [f64]) -> Result<(), OutsideDomain> {
        self.action.gradient(u, out)
    }

    fn rounding(&self, u: &[f64]) -> Option<RoundingLevels> {
        rounding(self.action, u)
    }

    fn newton_step(&mut self, u: &[f64], residual: &[f64], step: &mut [f64]) -> Result<(), LinearFailure> {
        let hessian = self.action.hessian(u, &self.solver.pattern).map_err(|_| LinearFailure)?;
        let lu =
            Lu::try_new_with_symbolic(self.solver.symbolic.clone(), hessian.as_ref()).map_err(|_| LinearFailure)?;
        let size = max_abs(residual);
        // One solve and two steps of iterative refinement: the Hessian is indefinite and its entries span 1/h.
        let mut remainder = Col::from_fn(residual.len(), |i| -residual[i]);
        let right_hand_side = remainder.clone();
        let mut solution = Col::<f64>::zeros(residual.len());
        for _ in 0..3 {
            lu.solve_in_place_with_conj(faer::Conj::No, remainder.as_mat_mut());
            solution += &remainder;
            remainder = &right_hand_side - &hessian * &solution;
        }
        for (step, value) in step.iter_mut().zip(solution.iter()) {
            *step = *value;
        }
        let left =
            remainder.iter().fold(0.0, |largest: f64, r| if r.is_nan() { f64::INFINITY } else { largest.max(r.abs()) });
        if left <= LINEAR_TOLERANCE * size || size == 0.0 { Ok(()) } else { Err(LinearFailure) }
    }

    fn sizes(&self, u: &[f64]) -> [f64; 2] {
        sizes(self.action.layout(), u)
    }
}

/// The rounding errors to be expected in ∇E_IVP, block by block.
fn rounding<S: Real>(action: &DoubledAction<'_, S>, u: &[S]) -> Option<RoundingLevels> {
    let rounding = action.gradient_rounding(u).ok()?;
    let (layout, h) = (action.layout(), action.sbp().spacing().to_f64());
    let points = action.sbp().points();
    let mut levels = Vec::with_capacity(4 + MULTIPLIERS);
    for branch in 0..2 {
        levels.push((layout.t(branch)..layout.t(branch) + points, rounding.t_rows));
        levels.push((layout.x(branch)..layout.x(branch) + points, rounding.x_rows));
    }
    let GradientRounding { t, x, .. } = rounding;
    let constraints = [t, t / h, x, x / h, t, x, t / h, x / h];
    levels.extend(layout.multiplier_range().zip(constraints).map(|(row, level)| (row..row + 1, level)));
    Some(levels)
}

/// Largest |t| and |x| of both branches.
fn sizes<S: Real>(layout: Layout, u: &[S]) -> [S; 2] {
    let [forward, backward] = layout.branches(u);
    [max_abs(forward.t).max(max_abs(backward.t)), max_abs(forward.x).max(max_abs(backward.x))]
}

/// ∇E_IVP with all digits, its Hessian at the `f64` critical point.
struct RefinedStationarity<'a, S> {
    action: &'a DoubledAction<'a, S>,
    lu: Lu<usize, f64>,
}

impl<S: Real> Refined<S> for RefinedStationarity<'_, S> {
    fn residual(&mut self, u: &[S], out: &mut [S]) -> Result<(), OutsideDomain> {
        self.action.gradient(u, out)
    }

    fn solve_linearised(&mut self, right: &mut [f64]) -> Result<(), LinearFailure> {
        let rows = right.len();
        self.lu.solve_in_place_with_conj(faer::Conj::No, faer::MatMut::from_column_major_slice_mut(right, rows, 1));
        Ok(())
    }

    fn rounding(&self, u: &[S]) -> Option<RoundingLevels> {
        rounding(self.action, u)
    }

    fn sizes(&self, u: &[S]) -> [S; 2] {
        sizes(self.action.layout(), u)
    }
}
