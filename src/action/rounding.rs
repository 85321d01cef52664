//! The size of the rounding error in the gradient, below which no gradient can be brought.

use super::{BranchState, DoubledAction};
use crate::metric::OutsideDomain;
use crate::norm::max_abs;
use crate::scalar::Real;

/// Rounding errors to be expected in ∇E_IVP.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GradientRounding {
    /// Of ∂E/∂t.
    pub t_rows: f64,
    /// Of ∂E/∂x.
    pub x_rows: f64,
    /// Of a value of t: the constraints of λ1 and λ5; divided by h those of λ2 and λ7.
    pub t: f64,
    /// Of a value of x: the constraints of λ3 and λ6; divided by h those of λ4 and λ8.
    pub x: f64,
}

impl<S: Real> DoubledAction<'_, S> {
    /// The size of the rounding error to be expected in the entries of ∇E_IVP at `u`, by kind of row. Differences of t
    /// and x are divided by h, so it grows like N.
    ///
    /// # Errors
    /// [`OutsideDomain`] if g00 is not positive and finite at a node of either branch.
    pub fn gradient_rounding(&self, u: &[S]) -> Result<GradientRounding, OutsideDomain> {
        let layout = self.layout();
        let lambda = layout.multipliers(u);
        let h = self.sbp.spacing().to_f64();
        let size = |u: &[S]| max_abs(u).to_f64();
        // The largest |λ_j| of the given indices; 0 in the weak form, which has no λ.
        let of = |indices: [usize; 2]| {
            indices.map(|j| lambda.get(j).map_or(0.0, |l| l.to_f64().abs())).into_iter().fold(0.0, f64::max)
        };
        let (mut t, mut x) = (0.0_f64, 0.0_f64);
        // λ1, λ5 and λ3, λ6 enter the gradient directly; λ2, λ7 and λ4, λ8 are multiplied by a row of D.
        let (mut t_row, mut x_row) = (of([0, 4]) + of([1, 6]) / h, of([2, 5]) + of([3, 7]) / h);
        let mut state = BranchState::zeros(self.sbp.points());
        for branch in layout.branches(u) {
            self.branch_into(branch.t, branch.x, &mut state)?;
            let t_dot = size(&state.t_dot).max(self.initial.t_dot.to_f64().abs());
            let x_dot = size(&state.x_dot).max(self.initial.x_dot.to_f64().abs());
            // Where x is zero at the start, perhaps at rest, rounding acts on the distances h ẋ and ½h²ẍ of one step.
            let fall = 0.5 * h * h * size(&state.metric.first) * t_dot * t_dot;
            let t_size = size(branch.t).max(h * t_dot);
            let x_size = size(branch.x).max(h * x_dot).max(fall).max(f64::MIN_POSITIVE);
            (t, x) = (t.max(t_size), x.max(x_size));
            t_row = t_row.max(size(&state.metric.g00) * t_size / h);
            // ½ H g00′ ṫ² inherits twice the relative error of ṫ, which is ε|t|/(h ṫ).
            let force = size(self.sbp.weights()) * size(&state.metric.first) * t_dot * t_size / h;
            x_row = x_row.max(x_size / h).max(force);
        }
        let epsilon = S::EPSILON.to_f64();
        // Rows of D with larger coefficients amplify the rounding of t and x; ∇E applies D twice.
        let once = epsilon * self.sbp.stiffness();
        let twice = once * self.sbp.stiffness();
        Ok(GradientRounding { t_rows: twice * t_row, x_rows: twice * x_row, t: once * t, x: once * x })
    }
}
