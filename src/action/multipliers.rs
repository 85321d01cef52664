//! The strong form ties the two branches together by four constraints with Lagrange multipliers for each coordinate.
//!
//! ```text
//! Σ_a { λ_a (q₁^a[1] − q_i^a) + μ_a ((Dq₁^a)[1] − q̇_i^a) + ν_a (q₁^a − q₂^a)[N] + κ_a ((Dq₁^a) − (Dq₂^a))[N] }
//! ```
//!
//! In t and x they are the paper's λ1 … λ8, in the order λ_t, μ_t, λ_x, μ_x, ν_t, ν_x, κ_t, κ_x.

use super::layout::Unknowns;
use super::{DoubledAction, MULTIPLIERS_PER_COORDINATE};
use crate::number::{Real, sum};

impl<S: Real> DoubledAction<'_, S> {
    /// The constraints that the multipliers of the strong form enforce, in their order. They can be asked for in the
    /// weak form, too.
    pub fn constraints(&self, u: &[S]) -> Vec<S> {
        self.constraints_of(&self.layout().split(u))
    }

    pub(super) fn constraints_of(&self, u: &Unknowns<'_, S>) -> Vec<S> {
        let layout = self.layout();
        let last = self.sbp.points() - 1;
        let row = |k: usize, u: &[S]| self.sbp.derivative_at(u, k);
        let mut constraints = vec![S::ZERO; MULTIPLIERS_PER_COORDINATE * layout.dimension()];
        for a in 0..layout.dimension() {
            let [one, two] = [0, 1].map(|branch| u.branches[branch][a]);
            constraints[layout.lambda(a)] = one[0] - self.initial.q[a];
            constraints[layout.mu(a)] = row(0, one) - self.initial.q_dot[a];
            constraints[layout.nu(a)] = one[last] - two[last];
            constraints[layout.kappa(a)] = row(last, one) - row(last, two);
        }
        constraints
    }

    /// Σ λ_j C_j(u).
    pub(super) fn multiplier_terms(&self, u: &Unknowns<'_, S>) -> S {
        let constraints = self.constraints_of(u);
        sum(u.multipliers.iter().zip(constraints).map(|(&lambda, c)| lambda * c))
    }

    /// Adds Σ λ_j ∇C_j to the branches in `out`.
    pub(super) fn add_multiplier_gradient(&self, u: &Unknowns<'_, S>, out: &mut [S]) {
        let (layout, multipliers) = (self.layout(), u.multipliers);
        let last = self.sbp.points() - 1;
        for a in 0..layout.dimension() {
            layout.values_mut(out, 0, a)[0] += multipliers[layout.lambda(a)];
            for (branch, sign) in layout.signs(out).enumerate() {
                let row = layout.values_mut(out, branch, a);
                row[last] += sign * multipliers[layout.nu(a)];
                self.add_row(last, sign * multipliers[layout.kappa(a)], row);
            }
            self.add_row(0, multipliers[layout.mu(a)], layout.values_mut(out, 0, a));
        }
    }

    /// `out` += `factor` · Dᵀe_k.
    fn add_row(&self, k: usize, factor: S, out: &mut [S]) {
        for (column, d) in self.sbp.row(k) {
            out[column] += factor * d;
        }
    }
}
