//! A non-conservative force in the doubled action.
//!
//! ```text
//! Σ_k H_k (q₁^a − q₂^a)_k F_a( ½(q₁ + q₂), ½(D̄q₁ + D̄q₂) )_k
//! ```
//!
//! is added to either form (C. R. Galley, Phys. Rev. Lett. 110 (2013) 174301). In the physical limit it adds H F_a to
//! ∂F/∂q^a.

use super::DoubledAction;
use super::layout::Unknowns;
use super::state::{BranchState, of_branch};
use crate::geometry::{ForceTerm, Samples};
use crate::number::{Real, sum};

/// The force at the mean of the branches, and their difference.
pub(super) struct MeanForce<S> {
    /// q₁^a − q₂^a, a row for each coordinate.
    gaps: Samples<S>,
    /// F_a and its derivatives.
    pub(super) force: Samples<S>,
}

impl<S: Real> MeanForce<S> {
    /// `None` if no force acts.
    pub(super) fn zeros(action: &DoubledAction<'_, S>) -> Option<Self> {
        let (structure, points) = (action.lagrangian.structure(), action.sbp.points());
        let rows = (structure.dimension, structure.force_rows);
        (!structure.force.is_empty())
            .then(|| Self { gaps: Samples::zeros(rows.0, points), force: Samples::zeros(rows.1, points) })
    }

    /// `None` if no force acts.
    pub(super) fn new(action: &DoubledAction<'_, S>, u: &Unknowns<'_, S>, states: &[BranchState<S>]) -> Option<Self> {
        let mut mean_force = Self::zeros(action)?;
        let (n, points) = (action.lagrangian.dimension(), action.sbp.points());
        let mut mean = Samples::zeros(2 * n, points);
        for a in 0..n {
            let [one, two] = [0, 1].map(|branch| u.branches[branch][a]);
            let [u, v] = [0, 1].map(|branch| of_branch(states, branch).velocities.row(a));
            for k in 0..points {
                mean_force.gaps.row_mut(a)[k] = one[k] - two[k];
                mean.row_mut(a)[k] = (one[k] + two[k]).half();
                mean.row_mut(n + a)[k] = (u[k] + v[k]).half();
            }
        }
        let rows: Vec<&[S]> = (0..2 * n).map(|row| mean.row(row)).collect();
        action.lagrangian.fill_force(&rows[..n], &rows[n..], &mut mean_force.force);
        Some(mean_force)
    }
}

impl<S: Real> DoubledAction<'_, S> {
    /// The term of the force.
    pub(super) fn force_term(&self, mean: &MeanForce<S>) -> S {
        let weights = self.sbp.weights();
        sum(self.lagrangian.structure().force.iter().map(|term| {
            sum((0..weights.len()).map(|k| weights[k] * mean.gaps.row(term.a)[k] * mean.force.at(term.value, k)))
        }))
    }

    /// Adds the gradient of the term to the branches of `out`.
    pub(super) fn add_force_gradient(&self, mean: &MeanForce<S>, out: &mut [S]) {
        let (layout, structure, weights) = (self.layout(), self.lagrangian.structure(), self.sbp.weights());
        let n = layout.dimension;
        for (branch, sign) in layout.signs(out).enumerate() {
            for &ForceTerm { a, value, .. } in &structure.force {
                let row = layout.values_mut(out, branch, a);
                for (k, out) in row.iter_mut().enumerate() {
                    *out += sign * weights[k] * mean.force.at(value, k);
                }
            }
        }
        for &ForceTerm { a, by: [v], value } in &structure.force_first {
            let gaps = mean.gaps.row(a);
            if gaps.iter().all(|&gap| gap == S::ZERO) {
                continue;
            }
            let slope = |k: usize| gaps[k].half() * mean.force.at(value, k);
            for branch in 0..2 {
                if v < n {
                    let row = layout.values_mut(out, branch, v);
                    row.iter_mut().enumerate().for_each(|(k, out)| *out += weights[k] * slope(k));
                } else {
                    let slopes: Vec<S> = (0..weights.len()).map(slope).collect();
                    let mut row = vec![S::ZERO; weights.len()];
                    self.bars[v - n].apply_transpose_weighted(&slopes, &mut row);
                    layout.values_mut(out, branch, v - n).iter_mut().zip(row).for_each(|(out, part)| *out += part);
                }
            }
        }
    }
}
