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
use super::state::{BothStates, BranchState};
use crate::geometry::{Lagrangian, Term, other, single};
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

impl<S: Real, L: Lagrangian<S>> DoubledAction<'_, S, L> {
    pub(super) fn ties(&self, u: &[S], states: &BothStates<S>) -> [Tie<S>; 2] {
        let (layout, structure) = (self.layout(), self.lagrangian.structure());
        let n = layout.dimension();
        [0, self.sbp.points() - 1].map(|k: usize| {
            let gap = |a| layout.values(u, 0, a)[k] - layout.values(u, 1, a)[k];
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
        for (branch, sign) in [S::ONE, -S::ONE].into_iter().enumerate() {
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

/// Pushes an entry and its mirror image.
fn both(push: &mut impl FnMut(usize, usize, f64), row: usize, column: usize, value: f64) {
    push(row, column, value);
    push(column, row, value);
}

impl<L: Lagrangian<f64>> DoubledAction<'_, f64, L> {
    /// Calls `push` for the second derivatives of the boundary terms.
    pub(super) fn visit_boundary(
        &self,
        ties: &[Tie<f64>; 2],
        states: &BothStates<f64>,
        push: &mut impl FnMut(usize, usize, f64),
    ) {
        let (layout, structure) = (self.layout(), self.lagrangian.structure());
        let n = layout.dimension();
        for Tie { k, gaps, .. } in ties {
            let k = *k;
            for branch in 0..2 {
                let state = states.get(branch);
                let row = |a: usize| layout.row(branch, a);
                // −½ (q₁^a − q₂^a) ∂²p_a.
                for &Term { ab, by: [c], value } in structure.first.iter().filter(|term| term.ab[1] < n) {
                    let value = state.samples.at(value, k);
                    for (a, b) in both_orders(ab) {
                        for (column, d) in self.bars[b].row(k) {
                            both(push, row(b) + column, row(c) + k, -0.5 * gaps[a] * value * d);
                        }
                    }
                }
                for &Term { ab, by: [c, d], value } in &structure.second {
                    let value = state.samples.at(value, k);
                    for (a, b) in both_orders(ab).filter(|(a, _)| *a < n) {
                        let entry = -0.5 * gaps[a] * value * state.velocity(b, k);
                        if c == d {
                            push(row(c) + k, row(d) + k, entry);
                        } else {
                            both(push, row(c) + k, row(d) + k, entry);
                        }
                    }
                }
                // −½ ∂p_a ∂(q₁^a − q₂^a), in both orders; the difference has a part on each branch.
                for (gap_branch, sign) in [1.0, -1.0].into_iter().enumerate() {
                    for a in 0..n {
                        let gap = layout.row(gap_branch, a) + k;
                        for &Term { ab, value, .. } in &structure.values {
                            let Some(b) = other(ab, a).filter(|&b| b < n) else { continue };
                            let value = state.samples.at(value, k);
                            for (column, d) in self.bars[b].row(k) {
                                both(push, row(b) + column, gap, -0.5 * sign * value * d);
                            }
                        }
                        for &Term { ab, by: [c], value } in &structure.first {
                            let Some(b) = other(ab, a) else { continue };
                            let entry = -0.5 * sign * state.samples.at(value, k) * state.velocity(b, k);
                            both(push, row(c) + k, gap, entry);
                        }
                    }
                }
            }
        }
    }
}
