//! The weak form ties the two branches together by boundary terms and has no multipliers.
//!
//! The paper's outlook asks for a weak formulation without Lagrange multipliers. With v = g00(x)∘D̄t and w = D̄x on
//! each branch, and `[1]` and `[N]` for the values at the first and the last node, these terms give one:
//!
//! ```text
//! − ( ½(v₁ + v₂)[1] − Q_t ) (t₁ − t₂)[1] + ( ½(w₁ + w₂)[1] − ẋ_i ) (x₁ − x₂)[1]
//! −   ½(v₁ + v₂)[N]         (t₁ − t₂)[N] +   ½(w₁ + w₂)[N]         (x₁ − x₂)[N]
//! ```
//!
//! Where the branches agree, only the factors of (t₁ − t₂) and (x₁ − x₂) are left in the gradient. Together with
//! D̄ᵀH = −HD + E_N they turn ∂E/∂t = 0 into D̄v = H⁻¹e_1 Q_t, where D̄ stands for its linear part D + H⁻¹E_0. As that
//! is invertible, v = Q_t at every node, the last one included. v and w are functions of t and x themselves, so away
//! from the physical limit the gradient also contains their derivatives.

use super::layout::BranchMut;
use super::{Branch, BranchState, DoubledAction};
use crate::metric::MetricJet;
use crate::scalar::Real;

/// What the boundary terms need to know of a branch at one of its ends.
#[derive(Debug, Clone, Copy)]
pub(super) struct EndNode<S> {
    t: S,
    x: S,
    t_dot: S,
    x_dot: S,
    metric: MetricJet<S>,
}

impl<S: Real> EndNode<S> {
    /// v = g00 D̄t.
    fn v(&self) -> S {
        self.metric.g00 * self.t_dot
    }
}

/// A branch at its first and its last node.
#[derive(Debug, Clone, Copy)]
pub(super) struct BranchEnds<S>([EndNode<S>; 2]);

impl<S: Real> Default for BranchEnds<S> {
    fn default() -> Self {
        let zero = S::ZERO;
        let metric = MetricJet { g00: zero, first: zero, second: zero };
        Self([EndNode { t: zero, x: zero, t_dot: zero, x_dot: zero, metric }; 2])
    }
}

impl<S: Real> BranchEnds<S> {
    pub(super) fn new(branch: &Branch<'_, S>, state: &BranchState<S>) -> Self {
        let samples = &state.metric;
        Self([0, branch.t.len() - 1].map(|k| EndNode {
            t: branch.t[k],
            x: branch.x[k],
            t_dot: state.t_dot[k],
            x_dot: state.x_dot[k],
            metric: MetricJet { g00: samples.g00[k], first: samples.first[k], second: samples.second[k] },
        }))
    }
}

/// One end of both branches together.
pub(super) struct Tie<S> {
    /// Index of the node.
    k: usize,
    nodes: [EndNode<S>; 2],
    /// t₁ − t₂ and x₁ − x₂.
    t_gap: S,
    x_gap: S,
    /// ½(v₁ + v₂) and ½(w₁ + w₂); at the first node minus the initial values Q_t and ẋ_i.
    v: S,
    w: S,
}

impl<S: Real> DoubledAction<'_, S> {
    pub(super) fn ties(&self, ends: &[BranchEnds<S>; 2]) -> [Tie<S>; 2] {
        let last = self.sbp.points() - 1;
        let given = [(0, self.q_t, self.initial.x_dot), (last, S::ZERO, S::ZERO)];
        [0, 1].map(|end: usize| {
            let nodes = [ends[0].0[end], ends[1].0[end]];
            let [one, two] = nodes;
            let (k, q_t, x_dot) = given[end];
            Tie {
                k,
                nodes,
                t_gap: one.t - two.t,
                x_gap: one.x - two.x,
                v: (one.v() + two.v()).half() - q_t,
                w: (one.x_dot + two.x_dot).half() - x_dot,
            }
        })
    }

    /// The boundary terms.
    pub(super) fn boundary_terms(&self, ends: &[BranchEnds<S>; 2]) -> S {
        let [first, last] = self.ties(ends).map(|tie| tie.w * tie.x_gap - tie.v * tie.t_gap);
        first + last
    }

    /// Adds the gradient of the boundary terms to the branches of `out`.
    pub(super) fn add_boundary_gradient(&self, ends: &[BranchEnds<S>; 2], out: &mut [S]) {
        let branches = self.layout().branches_mut(out);
        let ties = self.ties(ends);
        for ((branch, mut out), sign) in branches.into_iter().enumerate().zip([S::ONE, -S::ONE]) {
            self.add_ties(&ties, branch, sign, &mut out);
        }
    }

    /// Adds the gradient of the boundary terms with respect to one branch, whose t and x enter them with `sign`.
    pub(super) fn add_ties(&self, ties: &[Tie<S>; 2], branch: usize, sign: S, out: &mut BranchMut<'_, S>) {
        for Tie { k, nodes, t_gap, x_gap, v, w } in ties {
            let (k, node) = (*k, nodes[branch]);
            out.t[k] += -sign * *v;
            out.x[k] += sign * *w;
            if *t_gap == S::ZERO && *x_gap == S::ZERO {
                continue;
            }
            // The derivatives of ½(v₁ + v₂) and ½(w₁ + w₂) with respect to t and x of this branch.
            for (column, d) in self.bar_t.row(k) {
                out.t[column] += -(t_gap.half() * node.metric.g00) * d;
            }
            out.x[k] += -t_gap.half() * node.metric.first * node.t_dot;
            for (column, d) in self.bar_x.row(k) {
                out.x[column] += x_gap.half() * d;
            }
        }
    }
}

impl DoubledAction<'_> {
    /// Calls `push` for the second derivatives of the boundary terms.
    pub(super) fn visit_boundary(&self, ends: &[BranchEnds<f64>; 2], push: &mut impl FnMut(usize, usize, f64)) {
        let layout = self.layout();
        let signs = [1.0, -1.0];
        for Tie { k, nodes, t_gap, .. } in self.ties(ends) {
            for (branch, node) in nodes.into_iter().enumerate() {
                let (t, x) = (layout.t(branch), layout.x(branch));
                let MetricJet { g00, first, second } = node.metric;
                // −½(t₁ − t₂) ∂²v.
                for (column, d) in self.bar_t.row(k) {
                    let mixed = -0.5 * t_gap * first * d;
                    push(t + column, x + k, mixed);
                    push(x + k, t + column, mixed);
                }
                push(x + k, x + k, -0.5 * t_gap * second * node.t_dot);
                // −½ ∂v ∂(t₁ − t₂) and ½ ∂w ∂(x₁ − x₂), in both orders; ∂(t₁ − t₂) and ∂(x₁ − x₂) have a part on each
                // branch.
                for (other, sign) in signs.into_iter().enumerate() {
                    let (t_gap, x_gap) = (layout.t(other) + k, layout.x(other) + k);
                    let mut both = |row: usize, column: usize, value: f64| {
                        push(row, column, value);
                        push(column, row, value);
                    };
                    for (column, d) in self.bar_t.row(k) {
                        both(t + column, t_gap, -0.5 * sign * g00 * d);
                    }
                    both(x + k, t_gap, -0.5 * sign * first * node.t_dot);
                    for (column, d) in self.bar_x.row(k) {
                        both(x + column, x_gap, 0.5 * sign * d);
                    }
                }
            }
        }
    }
}
