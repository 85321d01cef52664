//! The strong form ties the two branches together by eight constraints with Lagrange multipliers.
//!
//! ```text
//! λ1 (t₁[1] − t_i) + λ2 ((Dt₁)[1] − ṫ_i) + λ3 (x₁[1] − x_i) + λ4 ((Dx₁)[1] − ẋ_i)
//! + λ5 (t₁[N] − t₂[N]) + λ6 (x₁[N] − x₂[N])
//! + λ7 ((Dt₁)[N] − (Dt₂)[N]) + λ8 ((Dx₁)[N] − (Dx₂)[N])
//! ```

use super::{DoubledAction, MULTIPLIERS};
use crate::scalar::{Real, sum};

impl<S: Real> DoubledAction<'_, S> {
    /// The eight constraints C_j that the multipliers λ_j enforce, in order.
    pub fn constraints(&self, u: &[S]) -> [S; MULTIPLIERS] {
        let [b1, b2] = self.layout().branches(u);
        let last = self.sbp.points() - 1;
        let row = |k: usize, u: &[S]| self.sbp.derivative_at(u, k);
        [
            b1.t[0] - self.initial.t,
            row(0, b1.t) - self.initial.t_dot,
            b1.x[0] - self.initial.x,
            row(0, b1.x) - self.initial.x_dot,
            b1.t[last] - b2.t[last],
            b1.x[last] - b2.x[last],
            row(last, b1.t) - row(last, b2.t),
            row(last, b1.x) - row(last, b2.x),
        ]
    }

    /// Σ λ_j C_j(u).
    pub(super) fn multiplier_terms(&self, u: &[S]) -> S {
        let constraints = self.constraints(u);
        let multipliers = self.layout().multipliers(u);
        sum(multipliers.iter().zip(constraints).map(|(&lambda, c)| lambda * c))
    }

    /// Adds Σ λ_j ∇C_j to the branches of `out`, and writes the constraints after them.
    pub(super) fn add_multiplier_gradient(&self, u: &[S], out: &mut [S]) {
        let layout = self.layout();
        let constraints = self.constraints(u);
        let lambda = layout.multipliers(u);
        let last = self.sbp.points() - 1;
        let [b1, b2] = layout.branches_mut(out);
        b1.t[0] += lambda[0];
        b1.x[0] += lambda[2];
        for (sign, branch) in [(S::ONE, &mut *b1.t), (-S::ONE, &mut *b2.t)] {
            branch[last] += sign * lambda[4];
            self.add_row(last, sign * lambda[6], branch);
        }
        for (sign, branch) in [(S::ONE, &mut *b1.x), (-S::ONE, &mut *b2.x)] {
            branch[last] += sign * lambda[5];
            self.add_row(last, sign * lambda[7], branch);
        }
        self.add_row(0, lambda[1], b1.t);
        self.add_row(0, lambda[3], b1.x);
        layout.multipliers_mut(out).copy_from_slice(&constraints);
    }

    /// `out` += `factor` · Dᵀe_k.
    fn add_row(&self, k: usize, factor: S, out: &mut [S]) {
        for (column, d) in self.sbp.row(k) {
            out[column] += factor * d;
        }
    }
}

impl DoubledAction<'_> {
    /// Calls `push` for the constant border of the Hessian: ∂C_j/∂u and its transpose.
    pub(super) fn visit_constraints(&self, push: &mut impl FnMut(usize, usize, f64)) {
        let layout = self.layout();
        let last = self.sbp.points() - 1;
        let border = layout.multiplier_range().start;
        let mut both = |lambda: usize, unknown: usize, value: f64| {
            push(border + lambda, unknown, value);
            push(unknown, border + lambda, value);
        };
        let (t1, x1, t2, x2) = (layout.t(0), layout.x(0), layout.t(1), layout.x(1));
        let single = [(0, t1, 1.0), (2, x1, 1.0)];
        let ends = [(4, t1 + last, 1.0), (4, t2 + last, -1.0), (5, x1 + last, 1.0), (5, x2 + last, -1.0)];
        for (lambda, unknown, value) in single.into_iter().chain(ends) {
            both(lambda, unknown, value);
        }
        let rows = [(1, t1, 0, 1.0), (3, x1, 0, 1.0)];
        let end_rows = [(6, t1, last, 1.0), (6, t2, last, -1.0), (7, x1, last, 1.0), (7, x2, last, -1.0)];
        for (lambda, block, k, sign) in rows.into_iter().chain(end_rows) {
            for (column, d) in self.sbp.row(k) {
                both(lambda, block + column, sign * d);
            }
        }
        debug_assert_eq!(layout.unknowns() - border, MULTIPLIERS);
    }
}
