//! The Newton system of the doubled action at equal branches.
//!
//! With the mean s = ½(q₁ + q₂) and the gap d = q₁ − q₂ of the branches, E_IVP is odd in d: an exchange of the branches
//! changes the sign of F(q₁) − F(q₂), of what ties the ends, and of the work of a force, if λ = μ = 0. So at d = 0,
//! λ = μ = 0 its derivatives by s, λ and μ by these vanish, and the Hessian is
//!
//! ```text
//! ( 0   B )      rows and columns (s, ν, κ | d, λ, μ)
//! ( Bᵀ  0 )
//! ```
//!
//! Newton's method from equal branches therefore keeps them equal, δd = δλ = δμ = 0, and needs no more than
//!
//! ```text
//! Bᵀ (δs, δν, δκ) = −(∂E/∂d, C_λ, C_μ),    ∂E/∂d = ½(∂E/∂q₁ − ∂E/∂q₂),    C_λ = q[1] − q_i,    C_μ = (Dq)[1] − q̇_i
//! ```
//!
//! which has half of the unknowns. Bᵀ is the Hessian of one branch, with the Lagrangian L at the nodes,
//!
//! ```text
//! ∂²F = D̄ᵀ H (∂²L/∂q̇^a∂q̇^b) D̄,    D̄ᵀ H ∂²L/∂q̇^a∂q^c,    H ∂²L/∂q^c∂q^d
//! ∂²L/∂q̇^a∂q̇^b = g_ab,    ∂²L/∂q̇^a∂q^c = ∂_c g_ab q̇^b + ∂_c A_a,    ∂²L/∂q^c∂q^d = ½ ∂_c∂_d g_ab q̇^a q̇^b + …
//! ```
//!
//! and in its rows of d also H ∂F_a of a force, −∂p_a of the boundary terms (weak form), or ν and κ (strong form).

use super::force::MeanForce;
use super::state::BranchState;
use super::{DoubledAction, Form};
use crate::geometry::{ForceTerm, OutsideGeometry, Term, other};
use crate::linalg::sparse::Pattern;

impl DoubledAction<'_, f64> {
    /// The pattern of [`Self::newton_matrix`], see [`Layout::equal_unknowns`](super::Layout::equal_unknowns).
    pub fn newton_pattern(&self) -> Pattern {
        let mut places = Vec::new();
        // The places of the parts do not depend on the values, so zeros are as good as any.
        let state = BranchState::zeros(self.lagrangian, self.sbp.points());
        self.visit(&state, MeanForce::zeros(self).as_ref(), &mut |row, column, _| {
            places.push((row as u32, column as u32))
        });
        Pattern::new(self.layout().equal_unknowns(), &places)
    }

    /// The parts of Bᵀ at `u`, whose branches are equal, for the pattern [`Self::newton_pattern`]. Its rows and columns
    /// are those of [`Layout::equal_unknowns`](super::Layout::equal_unknowns). O(N).
    ///
    /// # Errors
    /// The first node that lies outside the domain.
    pub fn newton_matrix(&self, u: &[f64]) -> Result<Vec<f64>, OutsideGeometry> {
        let u = &self.layout().split(u);
        let states = self.states(u)?;
        let force = MeanForce::new(self, u, &states);
        let mut parts = Vec::new();
        self.visit(&states[0], force.as_ref(), &mut |_, _, part| parts.push(part));
        Ok(parts)
    }

    /// Calls `push(row, column, part)` for every part, always in the same order.
    fn visit(
        &self,
        state: &BranchState<f64>,
        force: Option<&MeanForce<f64>>,
        push: &mut impl FnMut(usize, usize, f64),
    ) {
        for k in 0..self.sbp.points() {
            self.visit_node(state, k, push);
        }
        if let Some(force) = force {
            self.visit_force(force, push);
        }
        match self.form {
            Form::Strong => self.visit_constraints(push),
            Form::Weak => self.visit_ends(state, push),
        }
    }

    /// The contributions of node k to ∂²F.
    fn visit_node(&self, state: &BranchState<f64>, k: usize, push: &mut impl FnMut(usize, usize, f64)) {
        let (structure, weight) = (self.lagrangian.structure(), self.sbp.weights()[k]);
        let row = |a: usize| a * self.sbp.points();
        let n = self.bars.len();
        for a in 0..n {
            for &Term { ab, by: [_, c], value } in structure.second.iter().filter(|term| term.by[0] == a) {
                let factor = if ab[0] == ab[1] { 0.5 * weight } else { weight };
                let [u, v] = ab.map(|b| state.velocity(b, k));
                let curvature = state.samples.at(value, k) * (factor * u * v);
                push(row(a) + k, row(c) + k, curvature);
                if a != c {
                    push(row(c) + k, row(a) + k, curvature);
                }
            }
            for (column, d) in self.bars[a].row(k) {
                for &Term { ab: [_, b], value, .. } in structure.values.iter().filter(|term| term.ab[0] == a) {
                    if b == n {
                        continue;
                    }
                    let mass = state.samples.at(value, k) * weight;
                    for (other, e) in self.bars[b].row(k) {
                        push(row(a) + column, row(b) + other, d * mass * e);
                        if a != b {
                            push(row(b) + other, row(a) + column, d * mass * e);
                        }
                    }
                }
                for &Term { ab, by: [c], value } in &structure.first {
                    let Some(b) = other(ab, a) else { continue };
                    let mixed = state.samples.at(value, k) * (weight * state.velocity(b, k));
                    push(row(a) + column, row(c) + k, d * mixed);
                    push(row(c) + k, row(a) + column, d * mixed);
                }
            }
        }
    }

    /// H ∂F_a, in the rows of d^a.
    fn visit_force(&self, mean: &MeanForce<f64>, push: &mut impl FnMut(usize, usize, f64)) {
        let (n, points) = (self.bars.len(), self.sbp.points());
        for (k, &weight) in self.sbp.weights().iter().enumerate() {
            for &ForceTerm { a, by: [v], value } in &self.lagrangian.structure().force_first {
                let slope = weight * mean.force.at(value, k);
                match v.checked_sub(n) {
                    None => push(a * points + k, v * points + k, slope),
                    Some(b) => {
                        self.bars[b].row(k).for_each(|(column, d)| {
                            push(a * points + k, b * points + column, slope * d);
                        });
                    }
                }
            }
        }
    }

    /// −∂p_a at both ends, in the rows of d^a there: the weak form's boundary terms are −p_a d^a.
    fn visit_ends(&self, state: &BranchState<f64>, push: &mut impl FnMut(usize, usize, f64)) {
        let points = self.sbp.points();
        for (k, a) in [0, points - 1].into_iter().flat_map(|k| (0..self.bars.len()).map(move |a| (k, a))) {
            self.slopes_of_momentum(a, state, k, &mut |b, column, slope| {
                push(a * points + k, b * points + column, -slope);
            });
        }
    }

    /// The border of the strong form: ∂C/∂s of λ and μ in the rows below, and ∂C/∂d of ν and κ in the columns beside.
    fn visit_constraints(&self, push: &mut impl FnMut(usize, usize, f64)) {
        let (layout, points) = (self.layout(), self.sbp.points());
        let (border, last) = (layout.dimension * points, points - 1);
        let tied = border - 2 * layout.dimension;
        for a in 0..layout.dimension {
            push(border + layout.lambda(a), a * points, 1.0);
            self.sbp.row(0).for_each(|(column, d)| push(border + layout.mu(a), a * points + column, d));
            push(a * points + last, tied + layout.nu(a), 1.0);
            self.sbp.row(last).for_each(|(row, d)| push(a * points + row, tied + layout.kappa(a), d));
        }
    }
}
