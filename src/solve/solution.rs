//! What a successful solve returns.

use super::status::{InitialGuess, IterationRecord};
use crate::action::MULTIPLIERS;
use crate::geodesic::{InitialData, Invariants};
use crate::metric::Metric;
use crate::sbp::SbpOperator;

/// The backward branch of a doubled solution.
#[derive(Debug, Clone)]
pub struct Backward {
    /// t₂ − t_i on the nodes.
    pub elapsed: Vec<f64>,
    /// x₂ on the nodes.
    pub x: Vec<f64>,
}

/// The values to continue the trajectory with. (Dt)_N and (Dx)_N are not: the last node takes up the compatibility
/// defect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EndState {
    /// t at the last node.
    pub t: f64,
    /// x at the last node.
    pub x: f64,
    /// w*_N = (Dx)_N − λ8/H_N.
    pub x_dot: f64,
    /// Q_t = −λ5.
    pub q_t: f64,
}

/// A converged critical point with the problem it solves.
#[derive(Debug, Clone)]
pub struct Solution {
    /// Initial time, kept apart from [`Self::elapsed`] so that it costs no digits.
    pub t_i: f64,
    /// t − t_i on the nodes (forward branch).
    pub elapsed: Vec<f64>,
    /// x on the nodes (forward branch).
    pub x: Vec<f64>,
    /// The backward branch, if the doubled system was solved.
    pub backward: Option<Backward>,
    /// λ1 … λ8.
    pub multipliers: [f64; MULTIPLIERS],
    /// Largest entry of ∇E_IVP of the doubled action at this solution: its certificate.
    pub gradient_norm: f64,
    /// What to continue with.
    pub end: EndState,
    /// Where the iteration started.
    pub initial_guess: InitialGuess,
    /// The iterations (none if the equations are explicit).
    pub history: Vec<IterationRecord>,
    /// γ of the first node.
    pub gamma_i: f64,
    /// γ_f − γ_i.
    pub length: f64,
    /// The operator.
    pub sbp: SbpOperator,
    /// The metric.
    pub metric: Metric,
    /// The initial data, with time counted from the start (t = 0).
    pub initial: InitialData,
}

impl Solution {
    /// γ on the nodes.
    pub fn gamma(&self) -> impl Iterator<Item = f64> + '_ {
        let last = self.x.len() - 1;
        let node =
            move |k: usize| if k == last { self.gamma_f() } else { self.gamma_i + k as f64 * self.sbp.spacing() };
        (0..=last).map(node)
    }

    /// t on the nodes.
    pub fn t(&self) -> impl ExactSizeIterator<Item = f64> + '_ {
        self.elapsed.iter().map(|elapsed| self.t_i + elapsed)
    }

    /// γ of the last node.
    pub fn gamma_f(&self) -> f64 {
        self.gamma_i + self.length
    }

    /// The continuum's Q_t and K of the initial data.
    pub fn invariants(&self) -> Invariants {
        self.initial.invariants(&self.metric)
    }

    /// Largest distance between the branches in t or x; 0 in the physical limit.
    pub fn branch_distance(&self) -> f64 {
        let distance = |a: &[f64], b: &[f64]| a.iter().zip(b).fold(0.0_f64, |d, (a, b)| d.max((a - b).abs()));
        self.backward.as_ref().map_or(0.0, |b| distance(&self.elapsed, &b.elapsed).max(distance(&self.x, &b.x)))
    }
}
