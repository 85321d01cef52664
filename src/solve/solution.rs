//! What a successful solve returns.

use super::derivative::FormDerivative;
use super::status::{InitialGuess, IterationRecord};
use crate::action::MULTIPLIERS;
use crate::case::Form;
use crate::geodesic::{InitialData, Invariants};
use crate::metric::Metric;
use crate::sbp::SbpOperator;
use crate::scalar::Real;

/// The backward branch of a doubled solution.
#[derive(Debug, Clone)]
pub struct Backward<S = f64> {
    /// t₂ − t_i on the nodes.
    pub elapsed: Vec<S>,
    /// x₂ on the nodes.
    pub x: Vec<S>,
}

/// The values to continue the trajectory with. In the strong form (Dt)_N and (Dx)_N are not: the last node takes up the
/// compatibility defect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EndState<S = f64> {
    /// t at the last node.
    pub t: S,
    /// x at the last node.
    pub x: S,
    /// w*_N = (Dx)_N − λ8/H_N; in the weak form w_N = (D̄x)_N.
    pub x_dot: S,
    /// Q_t, in the strong form as −λ5.
    pub q_t: S,
}

/// A converged critical point with the problem it solves.
#[derive(Debug, Clone)]
pub struct Solution<S = f64> {
    /// Initial time, kept apart from [`Self::elapsed`] so that it costs no digits.
    pub t_i: S,
    /// t − t_i on the nodes (forward branch).
    pub elapsed: Vec<S>,
    /// x on the nodes (forward branch).
    pub x: Vec<S>,
    /// The backward branch, if the doubled system was solved.
    pub backward: Option<Backward<S>>,
    /// λ1 … λ8; the weak form has none.
    pub multipliers: Option<[S; MULTIPLIERS]>,
    /// Largest entry of ∇E_IVP of the doubled action at this solution: its certificate.
    pub gradient_norm: S,
    /// What to continue with.
    pub end: EndState<S>,
    /// Where the iteration started.
    pub initial_guess: InitialGuess,
    /// The iterations (none if the equations are explicit).
    pub history: Vec<IterationRecord>,
    /// γ of the first node.
    pub gamma_i: S,
    /// γ_f − γ_i.
    pub length: S,
    /// Significant decimal digits that were asked for; 16 for `f64`.
    pub digits: u32,
    /// The form of the action.
    pub form: Form,
    /// The operator.
    pub sbp: SbpOperator<S>,
    /// The metric.
    pub metric: Metric<S>,
    /// The initial data, with time counted from the start (t = 0).
    pub initial: InitialData<S>,
}

impl<S: Real> Solution<S> {
    /// γ on the nodes.
    pub fn gamma(&self) -> impl Iterator<Item = S> + '_ {
        let last = self.x.len() - 1;
        let node = move |k: usize| {
            if k == last { self.gamma_f() } else { self.gamma_i + self.sbp.node(k) }
        };
        (0..=last).map(node)
    }

    /// t on the nodes.
    pub fn t(&self) -> impl ExactSizeIterator<Item = S> + '_ {
        self.elapsed.iter().map(|&elapsed| self.t_i + elapsed)
    }

    /// γ of the last node.
    pub fn gamma_f(&self) -> S {
        self.gamma_i + self.length
    }

    /// The continuum's Q_t and K of the initial data.
    pub fn invariants(&self) -> Invariants<S> {
        self.initial.invariants(&self.metric)
    }

    /// d/dγ as the form of the action means it: Du (strong), or D̄u of a field `u` that starts at `initial` (weak).
    pub(crate) fn derivative(&self, u: &[S], initial: S) -> Vec<S> {
        FormDerivative::new(&self.sbp, self.form).derivative(u, initial)
    }

    /// Number of nodes, from the first, at which Q_t is exact: all but the last (strong), or all (weak).
    pub(crate) fn exact_nodes(&self) -> usize {
        match self.form {
            Form::Strong => self.x.len() - 1,
            Form::Weak => self.x.len(),
        }
    }

    /// Largest distance between the branches in t or x; 0 in the physical limit.
    pub fn branch_distance(&self) -> S {
        let distance = |a: &[S], b: &[S]| a.iter().zip(b).fold(S::ZERO, |d, (&a, &b)| d.max((a - b).abs()));
        let of = |b: &Backward<S>| distance(&self.elapsed, &b.elapsed).max(distance(&self.x, &b.x));
        self.backward.as_ref().map_or(S::ZERO, of)
    }
}
