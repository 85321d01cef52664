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

use super::collocation;
use super::explicit;
use super::window::{Node, Window};
use crate::action::Form;
use crate::geometry::OutsideGeometry;
use crate::scalar::Real;
use crate::solve::newton::Failure;
use crate::solve::quadrature::Integral;
use crate::solve::status::{InitialGuess, IterationRecord};

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

/// In the strong form SBP21 is explicit; everything else is one banded system.
pub(super) fn solve<S: Real>(
    window: &Window<'_, S>,
    rough: &Window<'_>,
    max_iterations: usize,
) -> Result<Limit<S>, Failure<OutsideGeometry>> {
    if window.form == Form::Strong && window.sbp.is_two_step() {
        return explicit::two_step(window);
    }
    let (p, mut q, history) = collocation::solve(window, rough, max_iterations)?;
    // The velocities of the ignorable coordinates on the nodes, then these coordinates themselves.
    let (points, field) = (window.points(), window.geometry.field());
    let ignorable: Vec<usize> = window.geometry.ignorable().collect();
    let mut velocities = vec![vec![S::ZERO; points]; ignorable.len()];
    let (mut node, mut rates) = (Node::new(window.start), field.room());
    for k in 0..points {
        for (place, &a) in field.active().iter().enumerate() {
            (node.q[a], node.p[a]) = (q[a][k], p[place][k]);
        }
        let evaluated = field.evaluate(&node.q, &node.p, &mut rates);
        evaluated.map_err(|point| explicit::outside(OutsideGeometry { index: k, ..point }))?;
        for (&a, velocities) in ignorable.iter().zip(&mut velocities) {
            velocities[k] = field.q_dot(&rates, a);
        }
    }
    let integral = Integral { derivative: window.derivative(), rough: rough.derivative(), digits: window.digits };
    let h = window.sbp.spacing();
    for (&a, velocities) in ignorable.iter().zip(&velocities) {
        q[a] = integral.of(|k| h * velocities[k], vec![S::ZERO; points], max_iterations)?;
    }
    Ok(Limit { q, p, history, initial_guess: InitialGuess::RungeKutta4 })
}

impl<S: Real> Limit<S> {
    /// q^a and p*_a of all coordinates at node k.
    pub(super) fn node(&self, window: &Window<'_, S>, k: usize) -> Node<S> {
        let mut node = Node::new(window.start);
        for (a, row) in self.q.iter().enumerate() {
            node.q[a] = row[k];
        }
        for (place, &a) in window.geometry.active().iter().enumerate() {
            node.p[a] = self.p[place][k];
        }
        node
    }

    /// The multipliers of the strong doubled action at this solution, in the order of its layout.
    pub(super) fn multipliers(&self, window: &Window<'_, S>) -> Vec<S> {
        let layout = window.action().layout();
        let last = window.points() - 1;
        let weight = window.sbp.weights()[last];
        let end = self.node(window, last);
        let slopes: Vec<S> = self.q.iter().map(|row| window.sbp.derivative_at(row, last)).collect();
        let momenta = window.geometry.momenta(&end.q, &slopes);
        let forces = window.geometry.forces(&end.q, &slopes);
        let mut multipliers = vec![S::ZERO; layout.multiplier_range().len()];
        for a in 0..self.q.len() {
            let place = window.geometry.active().iter().position(|&active| active == a);
            let slope = place.map_or(S::ZERO, |place| window.sbp.derivative_at(&self.p[place], last));
            multipliers[layout.nu(a)] = weight * (slope - forces[a]) - end.p[a];
            multipliers[layout.kappa(a)] = weight * (end.p[a] - momenta[a]);
        }
        multipliers
    }
}
