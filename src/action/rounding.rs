//! The size of the rounding error in the gradient, below which no gradient can be brought.

use super::DoubledAction;
use super::state::BranchState;
use crate::geometry::{OutsideGeometry, Samples, Term, other};
use crate::number::Real;
use crate::number::norm::max_abs;

/// Rounding errors to be expected in ∇E_IVP, for each coordinate.
#[derive(Debug, Clone, PartialEq)]
pub struct GradientRounding {
    /// The rounding of ∂E/∂q^a.
    pub rows: Vec<f64>,
    /// The rounding of a value of q^a: of the constraints of λ_a and ν_a; divided by h of those of μ_a and κ_a.
    pub values: Vec<f64>,
    /// The size of q^a that this is relative to.
    pub sizes: Vec<f64>,
}

impl<S: Real> DoubledAction<'_, S> {
    /// The size of the rounding error to be expected in the entries of ∇E_IVP at `u`, by kind of row. Differences of q
    /// are divided by h, so it grows like N.
    ///
    /// # Errors
    /// The first node of either branch that lies outside the domain.
    pub fn gradient_rounding(&self, u: &[S]) -> Result<GradientRounding, OutsideGeometry> {
        let (layout, structure) = (self.layout(), self.lagrangian.structure());
        let n = layout.dimension;
        let multipliers = layout.multipliers(u);
        let h = self.sbp.spacing().to_f64();
        let largest = |u: &[S]| max_abs(u).to_f64();
        // The larger |multiplier| of the given places; 0 in the weak form, which has none.
        let of = |places: [usize; 2]| {
            places.map(|j| multipliers.get(j).map_or(0.0, |l| l.to_f64().abs())).into_iter().fold(0.0, f64::max)
        };
        let mut values = vec![0.0_f64; n];
        // λ_a and ν_a enter the gradient directly; μ_a and κ_a are multiplied by a row of D.
        let mut rows: Vec<f64> =
            (0..n).map(|a| of([layout.lambda(a), layout.nu(a)]) + of([layout.mu(a), layout.kappa(a)]) / h).collect();
        let mut forces = vec![0.0_f64; n];
        let mut state = BranchState::zeros(self.lagrangian, self.sbp.points());
        for branch in 0..2 {
            let q = layout.branch(u, branch);
            state.evaluate(self.lagrangian, &self.bars, &q)?;
            let mut q_dot: Vec<f64> =
                (0..n).map(|a| largest(state.velocities.row(a)).max(self.initial.q_dot[a].to_f64().abs())).collect();
            q_dot.push(1.0);
            let fall = self.falls(&state, &q, &q_dot);
            let mut sizes: Vec<f64> = (0..n).map(|a| largest(q[a]).max(h * q_dot[a]).max(fall[a])).collect();
            // At rest a force is what is left of terms that cancel: it rounds like what rounded places change it by.
            let places: Vec<f64> = q.iter().map(|row| largest(row)).collect();
            let weight = largest(self.sbp.weights());
            for &Term { ab: [a, b], by: [c, d], value } in &structure.second {
                let slope = weight * state.samples.size(value) * q_dot[a] * q_dot[b];
                forces[c] = forces[c].max(slope * places[d]);
                forces[d] = forces[d].max(slope * places[c]);
            }
            let of_forces = forces.iter().zip(&places).map(|(force, place)| force * place).fold(0.0, f64::max);
            self.raise(&mut sizes, &state, of_forces);
            values.iter_mut().zip(&sizes).for_each(|(value, &size)| *value = value.max(size));
            for &Term { ab: [a, b], value, .. } in &structure.values {
                let component = state.samples.size(value);
                for (row, other) in [(a, b), (b, a)].into_iter().filter(|(row, _)| *row < n) {
                    let velocity = if other < n { component * sizes[other] / h } else { component };
                    rows[row] = rows[row].max(velocity);
                }
            }
            // H f_c inherits the relative error of every q̇, which is ε|q|/(h q̇).
            for &Term { ab: [a, b], by: [c], value } in &structure.first {
                let slope = weight * state.samples.size(value);
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
            rows: rows.into_iter().zip(forces).map(|(row, force)| (twice * row).max(once * force)).collect(),
            values: values.iter().map(|value| once * value).collect(),
            sizes: values,
        })
    }

    /// Raises the size of a coordinate that stays next to 0 to where it acts by ε of what the others or the forces act
    /// by in a step: no size is known better.
    fn raise(&self, sizes: &mut [f64], state: &BranchState<S>, of_forces: f64) {
        let (n, h) = (sizes.len(), self.sbp.spacing().to_f64());
        let terms: Vec<([usize; 2], f64)> = (self.lagrangian.structure().values.iter())
            .map(|term| (term.ab, state.samples.size(term.value) / h))
            .filter(|&([_, b], mass)| b < n && mass > 0.0)
            .collect();
        let actions = terms.iter().map(|&([a, b], mass)| mass * sizes[a] * sizes[b]);
        let least = S::EPSILON.to_f64() * actions.fold(of_forces, f64::max);
        for ([a, b], mass) in terms {
            if a == b {
                sizes[a] = sizes[a].max((least / mass).sqrt());
            }
            for (a, b) in [(a, b), (b, a)] {
                if a != b && sizes[b] > 0.0 {
                    sizes[a] = sizes[a].max(least / (mass * sizes[b]));
                }
            }
        }
    }

    /// ½h²|q̈^a|, the distance that a coordinate falls in a step from rest. Where it is zero at the start, perhaps at
    /// rest, rounding acts on the distances h q̇ and ½h²q̈ of a step. `q_dot` are the sizes of the velocities, and 1.
    fn falls(&self, state: &BranchState<S>, q: &[&[S]], q_dot: &[f64]) -> Vec<f64> {
        let structure = self.lagrangian.structure();
        let (n, h) = (structure.dimension, self.sbp.spacing().to_f64());
        let mut forces = vec![0.0_f64; n];
        // A change of g_ab or A_a along the way acts on p_a and p_b like a force.
        for &Term { ab: [a, b], by: [c], value } in &structure.first {
            let slope = 0.5 * h * h * state.samples.size(value);
            for (row, force) in [(c, slope * q_dot[a] * q_dot[b]), (a, slope * q_dot[b] * q_dot[c])] {
                forces[row] = forces[row].max(force);
            }
            if b < n {
                forces[b] = forces[b].max(slope * q_dot[a] * q_dot[c]);
            }
        }
        if !structure.force.is_empty() {
            let velocities: Vec<&[S]> = (0..n).map(|a| state.velocities.row(a)).collect();
            let mut samples = Samples::zeros(structure.force_rows, self.sbp.points());
            self.lagrangian.fill_force(q, &velocities, &mut samples);
            for term in &structure.force {
                forces[term.a] = forces[term.a].max(0.5 * h * h * samples.size(term.value));
            }
        }
        // Coordinates that are coupled accelerate each other.
        let fall = |a: usize| {
            let coupled =
                structure.values.iter().filter_map(|term| Some((other(term.ab, a)?, state.samples.size(term.value))));
            let (force, mass) = coupled
                .filter(|(b, _)| *b < n)
                .fold((0.0_f64, 0.0_f64), |(force, mass), (b, size)| (force.max(forces[b]), mass.max(size)));
            force / mass.max(f64::MIN_POSITIVE)
        };
        (0..n).map(fall).collect()
    }
}
