//! The terms that tie the two branches together.
//!
//! The strong form has four constraints with Lagrange multipliers for each coordinate:
//!
//! ```text
//! Σ_a { λ_a (q₁^a[1] − q_i^a) + μ_a ((Dq₁^a)[1] − q̇_i^a) + ν_a (q₁^a − q₂^a)[N] + κ_a ((Dq₁^a) − (Dq₂^a))[N] }
//! ```
//!
//! In t and x they are the paper's λ1 … λ8, in the order λ_t, μ_t, λ_x, μ_x, ν_t, ν_x, κ_t, κ_x.
//!
//! The weak form without multipliers, which the paper's outlook asks for, has boundary terms. With the momenta
//! p_a = g_ab D̄q^b + A_a of each branch, and `[1]` and `[N]` for the values at the first and the last node, they are
//!
//! ```text
//! − Σ_a { ½(p₁ + p₂)_a[N] (q₁^a − q₂^a)[N] + ( ½(p₁ + p₂)_a[1] − p_a,i ) (q₁^a − q₂^a)[1] }
//! ```
//!
//! Where the branches agree, only the factors of q₁^a − q₂^a are left in the gradient. Together with D̄ᵀH = −HD + E_N
//! they turn ∂E/∂t = 0 into D̄p_t = H⁻¹e_1 Q_t, where D̄ stands for its linear part D + H⁻¹E_0. As that is invertible,
//! p_t = Q_t at every node, the last one included. The momenta are functions of the positions themselves, so away from
//! the physical limit the gradient also contains their derivatives.

use super::layout::Unknowns;
use super::state::{BranchState, of_branch};
use super::{DoubledAction, MULTIPLIERS_PER_COORDINATE};
use crate::geometry::{Term, other, single};
use crate::number::{Real, sum};

/// One end of both branches together.
pub(super) struct Tie<S> {
    /// Index of the node.
    k: usize,
    /// q₁^a − q₂^a.
    gaps: Vec<S>,
    /// ½(p₁ + p₂)_a; at the first node minus the initial value.
    momenta: Vec<S>,
}

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
        let mut constraints = vec![S::ZERO; MULTIPLIERS_PER_COORDINATE * layout.dimension];
        for a in 0..layout.dimension {
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
        for a in 0..layout.dimension {
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

    pub(super) fn ties(&self, u: &Unknowns<'_, S>, states: &[BranchState<S>]) -> [Tie<S>; 2] {
        let structure = self.lagrangian.structure();
        let n = structure.dimension;
        [0, self.sbp.points() - 1].map(|k: usize| {
            let gap = |a: usize| u.branches[0][a][k] - u.branches[1][a][k];
            let momentum = |a: usize| {
                let [one, two] = [0, 1].map(|branch| {
                    let at = of_branch(states, branch).contraction(structure, k..k + 1);
                    single(|p| at.add_momentum(a, p))
                });
                (one + two).half() - if k == 0 { self.initial.p[a] } else { S::ZERO }
            };
            Tie { k, gaps: (0..n).map(gap).collect(), momenta: (0..n).map(momentum).collect() }
        })
    }

    /// The boundary terms.
    pub(super) fn boundary_terms(&self, ties: &[Tie<S>; 2]) -> S {
        let of = |tie: &Tie<S>| tie.momenta.iter().zip(&tie.gaps).fold(S::ZERO, |sum, (&p, &gap)| sum - p * gap);
        of(&ties[0]) + of(&ties[1])
    }

    /// Adds the gradient of the boundary terms to the branches of `out`.
    pub(super) fn add_boundary_gradient(&self, ties: &[Tie<S>; 2], states: &[BranchState<S>], out: &mut [S]) {
        let layout = self.layout();
        for (branch, sign) in layout.signs(out).enumerate() {
            for Tie { k, gaps, momenta } in ties {
                for (a, &p) in momenta.iter().enumerate() {
                    layout.values_mut(out, branch, a)[*k] += -sign * p;
                }
                // The derivatives of ½(p₁ + p₂)_a with respect to the positions of this branch.
                for (a, gap) in gaps.iter().enumerate().filter(|(_, gap)| **gap != S::ZERO) {
                    self.slopes_of_momentum(a, of_branch(states, branch), *k, &mut |b, column, slope| {
                        layout.values_mut(out, branch, b)[column] += -gap.half() * slope;
                    });
                }
            }
        }
    }

    /// Calls `push(b, column, slope)` for the parts of ∂p_a/∂q^b at node k, where `column` is the node of q^b.
    pub(super) fn slopes_of_momentum(
        &self,
        a: usize,
        state: &BranchState<S>,
        k: usize,
        push: &mut impl FnMut(usize, usize, S),
    ) {
        let (structure, n) = (self.lagrangian.structure(), self.bars.len());
        for &Term { ab, value, .. } in &structure.values {
            let Some(b) = other(ab, a).filter(|&b| b < n) else { continue };
            let value = state.samples.at(value, k);
            self.bars[b].row(k).for_each(|(column, d)| push(b, column, value * d));
        }
        for &Term { ab, by: [c], value } in &structure.first {
            let Some(b) = other(ab, a) else { continue };
            push(c, k, state.samples.at(value, k) * state.velocity(b, k));
        }
    }
}
