//! The physical limit t₁ = t₂, x₁ = x₂: the first-order collocation system that the critical point of E_IVP is.
//!
//! Subtracting the two branches' stationarity conditions leaves λ1 = … = λ4 = 0. With u = Dt, v = g00∘u, w = Dx and the
//! identity D̄ᵀH = −HD + E_N that the regularisation provides, what remains is
//!
//! ```text
//! −HDv + e_N v_N + λ5 e_N + λ7 Dᵀe_N = 0,      ½H g00′∘u∘u + HDw − e_N w_N + λ6 e_N + λ8 Dᵀe_N = 0.
//! ```
//!
//! HD e_N = e_N − H_N Dᵀe_N, so a multiple of Dᵀe_N is a shift of the last node. Hence, for every diagonal-norm
//! operator,
//!
//! ```text
//! (Dt)_k = Q_t/g00(x_k),   (Dx)_k = w*_k,   (Dw*)_k = −½ g00′(x_k) (Q_t/g00(x_k))²,     k = 1 … N−1,
//! t_1 = t_i,  x_1 = x_i,  w*_1 = ẋ_i
//! ```
//!
//! and the multipliers follow ([`PhysicalLimit::multipliers`]). In the weak form, with the invertible D̄ in place of D,
//! it is the same system at *all* nodes,
//!
//! ```text
//! D̄t = Q_t/g00(x) + H⁻¹e_1 t_i,    D̄x = w + H⁻¹e_1 x_i,    D̄w = −½ g00′(x) (Q_t/g00(x))² + H⁻¹e_1 ẋ_i
//! ```
//!
//! (D̄ linear here): an SBP–SAT scheme in γ, which meets the initial data up to its truncation error. The solution is
//! not taken on trust: the caller evaluates ∇E_IVP of the doubled action at it.

use super::arithmetic::Arithmetic;
use super::collocation;
use super::march;
use super::newton::Failure;
use super::problem::Problem;
use super::setup::Setup;
use super::status::{InitialGuess, IterationRecord};
use crate::action::Form;
use crate::action::MULTIPLIERS;
use crate::scalar::Real;

/// A solution of the collocation system.
#[derive(Debug, Clone)]
pub(super) struct PhysicalLimit<S> {
    /// t − t_i on the nodes.
    pub(super) elapsed: Vec<S>,
    /// x on the nodes.
    pub(super) x: Vec<S>,
    /// w* on the nodes: dx/dγ, also at the last node.
    pub(super) x_dot: Vec<S>,
    pub(super) history: Vec<IterationRecord>,
    pub(super) initial_guess: InitialGuess,
}

/// In the strong form SBP21 is explicit and is marched; wider operators, and the weak form, are solved as one banded
/// system.
pub(super) fn solve<S: Arithmetic>(
    problem: &Problem<S>,
    setup: &Setup<S>,
) -> Result<PhysicalLimit<S>, (Failure, InitialGuess)> {
    if problem.form == Form::Strong && problem.sbp.is_two_step() {
        march::two_step(problem).map_err(|failure| (failure, InitialGuess::None))
    } else {
        collocation::solve(problem, setup).map_err(|failure| (failure, InitialGuess::Nystrom4))
    }
}

impl<S: Real> PhysicalLimit<S> {
    /// λ1 … λ8 of the strong doubled action at this solution:
    /// (0, 0, 0, 0, −Q_t, w*_N − r_N, −H_N ΔE_N, H_N((Dx)_N − w*_N)), r_N = (HDw* + ½H g00′(Dt)²)_N.
    pub(super) fn multipliers(&self, problem: &Problem<S>) -> [S; MULTIPLIERS] {
        let last = self.x.len() - 1;
        let slope = |u: &[S]| problem.sbp.derivative_at(u, last);
        let weight = problem.sbp.weights()[last];
        let q_t = problem.invariants().q_t;
        let end = problem.metric.at(self.x[last]);
        let (t_dot, x_dot) = (slope(&self.elapsed), slope(&self.x));
        let remainder = weight * (slope(&self.x_dot) + end.first.half() * t_dot * t_dot);
        let delta_e = end.g00 * t_dot - q_t;
        let w_end = self.x_dot[last];
        let zero = S::ZERO;
        [zero, zero, zero, zero, -q_t, w_end - remainder, -weight * delta_e, weight * (x_dot - w_end)]
    }
}
