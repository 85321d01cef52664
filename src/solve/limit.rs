//! The physical limit of a window: both branches are equal.
//!
//! With D̄ᵀH = −HD + E_N the critical point of the doubled action is
//!
//! ```text
//! strong    (Dq^a)_k = g^ab (p*_b − A_b),   (Dp*_a)_k = f_a + F_a    on k = 1 … N−1,    q_1 = q_i,  p*_1 = p_i
//! weak       D̄q^a    = g^ab (p_b − A_b),     D̄p_a     = f_a + F_a    on all nodes
//! ```
//!
//! with λ_a = μ_a = 0, κ_a = H_N (p*_a − p_a)[N] and ν_a = (HDp*_a − H(f_a + F_a))_N − p*_a[N] in the strong form. An
//! ignorable p*_a is constant. Only active coordinates are unknowns; ignorable ones are integrals afterwards.

use super::status::{InitialGuess, IterationRecord};
use super::window::Window;
use crate::number::Real;

/// A solution of the collocation system of a window.
#[derive(Debug, Clone)]
pub(super) struct Limit<S> {
    /// q^a on the nodes, a row for each coordinate.
    pub(super) q: Vec<Vec<S>>,
    /// p*_a on the nodes, a row for each active coordinate.
    pub(super) p: Vec<Vec<S>>,
    pub(super) history: Vec<IterationRecord>,
    pub(super) initial_guess: InitialGuess,
}

impl<S: Real> Limit<S> {
    /// p*_a of all coordinates at the last node.
    pub(super) fn last_momenta(&self, window: &Window<'_, S>) -> Vec<S> {
        let mut momenta = window.start.p.clone();
        for (place, &a) in window.geometry.active().iter().enumerate() {
            momenta[a] = self.p[place][window.points() - 1];
        }
        momenta
    }

    /// The multipliers of the doubled action at this solution, in the order of its layout; none in the weak form.
    pub(super) fn multipliers(&self, window: &Window<'_, S>) -> Vec<S> {
        let layout = window.layout();
        let mut multipliers = vec![S::ZERO; layout.multiplier_range().len()];
        if multipliers.is_empty() {
            return multipliers;
        }
        let last = window.points() - 1;
        let weight = window.sbp.weights()[last];
        let q: Vec<S> = self.q.iter().map(|row| row[last]).collect();
        let slopes: Vec<S> = self.q.iter().map(|row| window.sbp.derivative_at(row, last)).collect();
        let (p, momenta) = (self.last_momenta(window), window.geometry.momenta(&q, &slopes));
        let forces = window.geometry.forces(&q, &slopes);
        for a in 0..q.len() {
            let place = window.geometry.active().iter().position(|&active| active == a);
            let slope = place.map_or(S::ZERO, |place| window.sbp.derivative_at(&self.p[place], last));
            multipliers[layout.nu(a)] = weight * (slope - forces[a]) - p[a];
            multipliers[layout.kappa(a)] = weight * (p[a] - momenta[a]);
        }
        multipliers
    }
}
