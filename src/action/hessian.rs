//! The Hessian of the doubled action: symmetric, indefinite, sparse.
//!
//! The sparsity depends on the operator and on which components are not zero only, so the pattern is found once and
//! every later Hessian refills its values in O(N). Per branch, with the Lagrangian L at the nodes:
//!
//! ```text
//! ∂²F = D̄ᵀ H (∂²L/∂q̇^a∂q̇^b) D̄,    D̄ᵀ H ∂²L/∂q̇^a∂q^c,    H ∂²L/∂q^c∂q^d
//! ∂²L/∂q̇^a∂q̇^b = g_ab,    ∂²L/∂q̇^a∂q^c = ∂_c g_ab q̇^b + ∂_c A_a,    ∂²L/∂q^c∂q^d = ½ ∂_c∂_d g_ab q̇^a q̇^b + …
//! ```

use super::boundary::Tie;
use super::force::MeanForce;
use super::state::{BothStates, BranchState};
use super::{DoubledAction, Form};
use crate::geometry::{Lagrangian, Term, other};
use crate::linalg::sparse::{Envelope, Pattern, SparseMatrix};

/// What the Hessian is computed from: both branches, their ends and the force.
struct Evaluated {
    states: BothStates<f64>,
    ties: [Tie<f64>; 2],
    force: Option<MeanForce<f64>>,
}

impl<L: Lagrangian<f64>> DoubledAction<'_, f64, L> {
    /// The pattern of [`Self::hessian`], one row per unknown; both triangles are stored.
    pub fn hessian_pattern(&self) -> Pattern {
        let mut places = Vec::new();
        let unknowns = self.layout().unknowns();
        // The pattern does not depend on the values, so zeros are as good as any.
        let zeros = vec![0.0; unknowns];
        let states = BothStates::zeros(self.lagrangian, self.sbp.points());
        let ties = self.ties(&zeros, &states);
        let force = MeanForce::zeros(self);
        let at = Evaluated { states, ties, force };
        self.visit(&at, |row, column, _| places.push((row as u32, column as u32)));
        Pattern::new(unknowns, &places)
    }

    /// The Hessian ∇²E_IVP at `u`, with the `pattern` of [`Self::hessian_pattern`].
    ///
    /// # Errors
    /// The first node of either branch that lies outside the domain.
    pub fn hessian<'p>(&self, u: &[f64], pattern: &'p Pattern) -> Result<SparseMatrix<'p>, L::Outside> {
        let states = self.both_branches(u)?;
        let ties = self.ties(u, &states);
        let force = MeanForce::new(self, u, &states);
        let mut sum = pattern.sum();
        self.visit(&Evaluated { states, ties, force }, |_, _, part| sum.add(part));
        Ok(sum.matrix())
    }

    /// What an elimination of the Hessian fills in, in the order of unknowns that keeps this smallest: along one branch
    /// and back along the other, unless a force ties the branches to each other at every node.
    pub fn envelope(&self, pattern: &Pattern) -> Envelope {
        let orders = [self.layout().along_branches(), self.layout().along_nodes()];
        let [one, other] = orders.map(|order| Envelope::new(pattern, &order));
        if one.size() <= other.size() { one } else { other }
    }

    /// Calls `push(row, column, value)` for every contribution, always in the same order. Contributions to the same
    /// entry are to be added.
    fn visit(&self, at: &Evaluated, mut push: impl FnMut(usize, usize, f64)) {
        for branch in 0..2 {
            let state = at.states.get(branch);
            let sign = if branch == 0 { 1.0 } else { -1.0 };
            for k in 0..self.sbp.points() {
                self.visit_node(state, branch, k, sign, &mut push);
            }
        }
        if let Some(force) = &at.force {
            self.visit_force(force, &mut push);
        }
        match self.form {
            Form::Strong => self.visit_constraints(&mut push),
            Form::Weak => self.visit_boundary(&at.ties, &at.states, &mut push),
        }
    }

    /// The contributions of node k of a branch to ±∂²F.
    fn visit_node(
        &self,
        state: &BranchState<f64>,
        branch: usize,
        k: usize,
        sign: f64,
        push: &mut impl FnMut(usize, usize, f64),
    ) {
        let (layout, structure, weight) = (self.layout(), self.lagrangian.structure(), self.sbp.weights()[k]);
        let row = |a: usize| layout.row(branch, a);
        let n = layout.dimension();
        for a in 0..n {
            for &Term { ab, by: [_, c], value } in structure.second.iter().filter(|term| term.by[0] == a) {
                let factor = if ab[0] == ab[1] { 0.5 * weight } else { weight };
                let [u, v] = ab.map(|b| state.velocity(b, k));
                let curvature = state.samples.at(value, k) * (factor * u * v);
                push(row(a) + k, row(c) + k, sign * curvature);
                if a != c {
                    push(row(c) + k, row(a) + k, sign * curvature);
                }
            }
            for (column, d) in self.bars[a].row(k) {
                for &Term { ab: [_, b], value, .. } in structure.values.iter().filter(|term| term.ab[0] == a) {
                    if b == n {
                        continue;
                    }
                    let mass = state.samples.at(value, k) * weight;
                    for (other, e) in self.bars[b].row(k) {
                        push(row(a) + column, row(b) + other, sign * d * mass * e);
                        if a != b {
                            push(row(b) + other, row(a) + column, sign * d * mass * e);
                        }
                    }
                }
                for &Term { ab, by: [c], value } in &structure.first {
                    let Some(b) = other(ab, a) else { continue };
                    let mixed = state.samples.at(value, k) * (weight * state.velocity(b, k));
                    push(row(a) + column, row(c) + k, sign * d * mixed);
                    push(row(c) + k, row(a) + column, sign * d * mixed);
                }
            }
        }
    }
}
