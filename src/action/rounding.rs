//! The size of the rounding error in the gradient, below which no gradient can be brought.

use super::DoubledAction;
use super::state::BranchState;
use crate::geometry::{Lagrangian, Term};
use crate::norm::max_abs;
use crate::scalar::Real;

/// Rounding errors to be expected in ∇E_IVP, for each coordinate.
#[derive(Debug, Clone, PartialEq)]
pub struct GradientRounding {
    /// Of ∂E/∂q^a.
    pub rows: Vec<f64>,
    /// Of a value of q^a: the constraints of λ_a and ν_a; divided by h those of μ_a and κ_a.
    pub values: Vec<f64>,
}

impl<S: Real, L: Lagrangian<S>> DoubledAction<'_, S, L> {
    /// The size of the rounding error to be expected in the entries of ∇E_IVP at `u`, by kind of row. Differences of q
    /// are divided by h, so it grows like N.
    ///
    /// # Errors
    /// The first node of either branch that lies outside the domain.
    pub fn gradient_rounding(&self, u: &[S]) -> Result<GradientRounding, L::Outside> {
        let (layout, structure) = (self.layout(), self.lagrangian.structure());
        let n = layout.dimension();
        let multipliers = layout.multipliers(u);
        let h = self.sbp.spacing().to_f64();
        let size = |u: &[S]| max_abs(u).to_f64();
        // The larger |multiplier| of the given places; 0 in the weak form, which has none.
        let of = |places: [usize; 2]| {
            places.map(|j| multipliers.get(j).map_or(0.0, |l| l.to_f64().abs())).into_iter().fold(0.0, f64::max)
        };
        let mut values = vec![0.0_f64; n];
        // λ_a and ν_a enter the gradient directly; μ_a and κ_a are multiplied by a row of D.
        let mut rows: Vec<f64> =
            (0..n).map(|a| of([layout.lambda(a), layout.nu(a)]) + of([layout.mu(a), layout.kappa(a)]) / h).collect();
        let mut state = BranchState::zeros(self.lagrangian, self.sbp.points());
        for branch in 0..2 {
            let q = layout.branch(u, branch);
            state.evaluate(self.lagrangian, &self.bars, &q)?;
            let mut q_dot: Vec<f64> =
                (0..n).map(|a| size(state.velocities.row(a)).max(self.initial.q_dot[a].to_f64().abs())).collect();
            q_dot.push(1.0);
            let component = |ab: [usize; 2]| {
                let term = structure.values.iter().find(|term| term.ab == ab);
                term.map_or(0.0, |term| state.size(term.value))
            };
            // Where q^c is zero at the start, perhaps at rest, rounding acts on the distances h q̇ and ½h²q̈ of a step.
            let mut fall = vec![0.0_f64; n];
            for &Term { ab: [a, b], by: [c], value } in &structure.first {
                let force = 0.5 * h * h * state.size(value) * q_dot[a] * q_dot[b];
                fall[c] = fall[c].max(force / component([c, c]).max(f64::MIN_POSITIVE));
            }
            let sizes: Vec<f64> =
                (0..n).map(|a| size(q[a]).max(h * q_dot[a]).max(fall[a]).max(f64::MIN_POSITIVE)).collect();
            values.iter_mut().zip(&sizes).for_each(|(value, &size)| *value = value.max(size));
            for &Term { ab: [a, b], value, .. } in &structure.values {
                let component = state.size(value);
                for (row, other) in [(a, b), (b, a)].into_iter().filter(|(row, _)| *row < n) {
                    let velocity = if other < n { component * sizes[other] / h } else { component };
                    rows[row] = rows[row].max(velocity);
                }
            }
            // H f_c inherits the relative error of every q̇, which is ε|q|/(h q̇).
            let weight = size(self.sbp.weights());
            for &Term { ab: [a, b], by: [c], value } in &structure.first {
                let slope = weight * state.size(value);
                for (a, b) in [(a, b), (b, a)].into_iter().filter(|(_, b)| *b < n) {
                    rows[c] = rows[c].max(slope * q_dot[a] * sizes[b] / h);
                }
            }
        }
        let epsilon = S::EPSILON.to_f64();
        // Rows of D with larger coefficients amplify the rounding of q; ∇E applies D twice.
        let once = epsilon * self.sbp.stiffness();
        let twice = once * self.sbp.stiffness();
        Ok(GradientRounding {
            rows: rows.into_iter().map(|row| twice * row).collect(),
            values: values.into_iter().map(|value| once * value).collect(),
        })
    }
}
