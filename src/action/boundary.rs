//! The weak form ties the two branches together by boundary terms and has no multipliers.
//!
//! The paper's outlook asks for a weak formulation without Lagrange multipliers. With the momenta
//! p_a = g_ab D̄q^b + A_a of each branch, and `[1]` and `[N]` for the values at the first and the last node, these
//! terms give one:
//!
//! ```text
//! − Σ_a { ½(p₁ + p₂)_a[N] (q₁^a − q₂^a)[N] + ( ½(p₁ + p₂)_a[1] − p_a,i ) (q₁^a − q₂^a)[1] }
//! ```
//!
//! Where the branches agree, only the factors of q₁^a − q₂^a are left in the gradient. Together with D̄ᵀH = −HD + E_N
//! they turn ∂E/∂t = 0 into D̄p_t = H⁻¹e_1 Q_t, where D̄ stands for its linear part D + H⁻¹E_0. As that is invertible,
//! p_t = Q_t at every node, the last one included. The momenta are functions of the positions themselves, so away from
//! the physical limit the gradient also contains their derivatives.

use super::DoubledAction;
use super::layout::Unknowns;
use super::state::{BothStates, BranchState};
use crate::geometry::{Term, other, single};
use crate::number::Real;

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
    pub(super) fn ties(&self, u: &Unknowns<'_, S>, states: &BothStates<S>) -> [Tie<S>; 2] {
        let structure = self.lagrangian.structure();
        let n = structure.dimension;
        [0, self.sbp.points() - 1].map(|k: usize| {
            let gap = |a: usize| u.branches[0][a][k] - u.branches[1][a][k];
            let momentum = |a: usize| {
                let [one, two] = [0, 1].map(|branch| {
                    let at = states.get(branch).contraction(structure, k..k + 1);
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
    pub(super) fn add_boundary_gradient(&self, ties: &[Tie<S>; 2], states: &BothStates<S>, out: &mut [S]) {
        for (branch, sign) in self.layout().signs(out).enumerate() {
            for tie in ties {
                self.add_tie(tie, states.get(branch), branch, sign, out);
            }
        }
    }

    /// Adds the gradient of one boundary term with respect to one branch, whose q enter it with `sign`.
    fn add_tie(&self, tie: &Tie<S>, state: &BranchState<S>, branch: usize, sign: S, out: &mut [S]) {
        let (layout, structure) = (self.layout(), self.lagrangian.structure());
        let Tie { k, gaps, momenta } = tie;
        let (k, n) = (*k, layout.dimension());
        for (a, &p) in momenta.iter().enumerate() {
            layout.values_mut(out, branch, a)[k] += -sign * p;
        }
        if gaps.iter().all(|&gap| gap == S::ZERO) {
            return;
        }
        // The derivatives of ½(p₁ + p₂)_a with respect to the positions of this branch.
        for &Term { ab, value, .. } in structure.values.iter().filter(|term| term.ab[1] < n) {
            let value = state.samples.at(value, k);
            for (a, b) in both_orders(ab) {
                for (column, d) in self.bars[b].row(k) {
                    layout.values_mut(out, branch, b)[column] += -(gaps[a].half() * value) * d;
                }
            }
        }
        for &Term { ab, by: [c], value } in &structure.first {
            let value = state.samples.at(value, k);
            for (a, b) in both_orders(ab).filter(|(a, _)| *a < n) {
                layout.values_mut(out, branch, c)[k] += -gaps[a].half() * value * state.velocity(b, k);
            }
        }
    }
}

/// A pair in both orders, once if they are the same.
fn both_orders([a, b]: [usize; 2]) -> impl Iterator<Item = (usize, usize)> {
    debug_assert_eq!(other([a, b], a), Some(b));
    std::iter::once((a, b)).chain((a != b).then_some((b, a)))
}
