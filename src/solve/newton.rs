//! Damped Newton iteration on a square system, shared by the doubled action and the physical limit.

use super::status::{IterationRecord, Status};
use crate::action::max_abs;
use crate::metric::OutsideDomain;

/// A residual at most this many rounding units is zero to working precision.
const ROUNDING_UNITS: f64 = 32.0;
/// Relative step below which quadratic convergence has nothing left to gain in `f64`.
const SMALL_STEP: f64 = 1e-8;
/// Share of the predicted decrease of the squared residual that a step must realise (Armijo).
const SUFFICIENT_DECREASE: f64 = 1e-4;
/// Smallest step length tried.
const LEAST_DAMPING: f64 = 1e-6;

/// The linearised system has no usable solution.
#[derive(Debug, Clone, Copy)]
pub(super) struct LinearFailure;

/// F(u) = 0 with a Jacobian that the system itself factors.
pub(super) trait NewtonSystem {
    /// `out` = F(u).
    fn residual(&mut self, u: &[f64], out: &mut [f64]) -> Result<(), OutsideDomain>;

    /// Rounding error to be expected in an entry of F(u).
    fn rounding(&self, u: &[f64]) -> f64;

    /// `step` = −F′(u)⁻¹ `residual`.
    fn newton_step(&mut self, u: &[f64], residual: &[f64], step: &mut [f64]) -> Result<(), LinearFailure>;

    /// The entries of u that are coordinates; only their steps decide on convergence.
    fn coordinates<'u>(&self, u: &'u [f64]) -> &'u [f64];
}

/// A zero of F.
#[derive(Debug, Clone)]
pub(super) struct Root {
    pub(super) unknowns: Vec<f64>,
    pub(super) history: Vec<IterationRecord>,
}

/// Why there is none.
#[derive(Debug, Clone)]
pub(super) struct Failure {
    pub(super) status: Status,
    /// The last accepted iterate.
    pub(super) unknowns: Vec<f64>,
    pub(super) residual: Vec<f64>,
    /// The point that left the domain, if that is what happened.
    pub(super) outside: Option<OutsideDomain>,
    pub(super) history: Vec<IterationRecord>,
}

/// Solves F(u) = 0 from `guess`, damping by |F|².
///
/// Converged means: the largest residual entry is at the rounding level, and either the last coordinate step was below
/// the square root of the precision or the residual had already been at that level before the step.
pub(super) fn solve(system: &mut impl NewtonSystem, guess: Vec<f64>, max_iterations: usize) -> Result<Root, Failure> {
    let mut u = guess;
    let mut residual = vec![0.0; u.len()];
    let mut history = Vec::new();
    if let Err(outside) = system.residual(&u, &mut residual) {
        residual.fill(f64::INFINITY);
        return Err(Failure { status: Status::OutsideDomain, unknowns: u, residual, outside: Some(outside), history });
    }
    let mut step = vec![0.0; u.len()];
    let mut trial = u.clone();
    let mut trial_residual = residual.clone();
    let mut was_at_rounding = false;
    for iteration in 1..=max_iterations {
        if system.newton_step(&u, &residual, &mut step).is_err() || !max_abs(&step).is_finite() {
            return Err(Failure { status: Status::Singular, unknowns: u, residual, outside: None, history });
        }
        let before = sum_of_squares(&residual);
        let mut damping = 1.0;
        let mut outside;
        let at_rounding = loop {
            for ((trial, u), step) in trial.iter_mut().zip(&u).zip(&step) {
                *trial = u + damping * step;
            }
            match system.residual(&trial, &mut trial_residual) {
                Ok(()) => {
                    outside = None;
                    let at_rounding = max_abs(&trial_residual) <= ROUNDING_UNITS * system.rounding(&trial);
                    let enough = (1.0 - 2.0 * SUFFICIENT_DECREASE * damping) * before;
                    if at_rounding || sum_of_squares(&trial_residual) <= enough {
                        break at_rounding;
                    }
                }
                Err(point) => outside = Some(point),
            }
            damping *= 0.5;
            if damping < LEAST_DAMPING {
                let status = if outside.is_some() { Status::OutsideDomain } else { Status::Stalled };
                return Err(Failure { status, unknowns: u, residual, outside, history });
            }
        };
        std::mem::swap(&mut u, &mut trial);
        std::mem::swap(&mut residual, &mut trial_residual);
        let change = damping * max_abs(system.coordinates(&step));
        history.push(IterationRecord { iteration, residual: max_abs(&residual), step: change, damping });
        let small = change <= SMALL_STEP * (1.0 + max_abs(system.coordinates(&u)));
        if at_rounding && (was_at_rounding || (small && damping == 1.0)) {
            return Ok(Root { unknowns: u, history });
        }
        was_at_rounding = at_rounding;
    }
    Err(Failure { status: Status::MaxIterations, unknowns: u, residual, outside: None, history })
}

fn sum_of_squares(u: &[f64]) -> f64 {
    u.iter().map(|v| v * v).sum()
}
