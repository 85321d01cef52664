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

/// What one window of a run starts from and ends with.
#[derive(Debug, Clone)]
pub struct Window<S = f64> {
    /// Position and tangent that it continues, with time counted from the start of the run.
    pub start: InitialData<S>,
    /// x and w* at its last node.
    pub end: (S, S),
    /// λ1 … λ8 of its action; the weak form has none.
    pub multipliers: Option<[S; MULTIPLIERS]>,
}

/// A converged critical point with the problem it solves; of a run in several windows one for each, end to end.
///
/// The nodes stand window by window, N each: the joint of two windows appears in both.
#[derive(Debug, Clone)]
pub struct Solution<S = f64> {
    /// Initial time, kept apart from [`Self::elapsed`] so that it costs no digits.
    pub t_i: S,
    /// t on the nodes (forward branch), counted from the start of their window.
    pub elapsed: Vec<S>,
    /// x on the nodes (forward branch).
    pub x: Vec<S>,
    /// The backward branch, if the doubled system was solved.
    pub backward: Option<Backward<S>>,
    /// The windows, in order.
    pub windows: Vec<Window<S>>,
    /// Largest entry of the gradient of the doubled action at this solution (in any window): its certificate.
    pub gradient_norm: S,
    /// What to continue with.
    pub end: EndState<S>,
    /// Where the iteration started.
    pub initial_guess: InitialGuess,
    /// Iterations of all windows: of Newton's method, or for the fixed-point iteration evaluations of the force.
    pub iterations: usize,
    /// The iterations (none if the equations are explicit) of the window that took most.
    pub history: Vec<IterationRecord>,
    /// Largest change of t or x (physical limit: of x or w*) that the last iteration of a window still made, relative to
    /// their sizes. 0 if the equations are explicit.
    pub last_correction: f64,
    /// γ of the first node.
    pub gamma_i: S,
    /// γ_f − γ_i.
    pub length: S,
    /// Significant decimal digits that were asked for; 16 for `f64`.
    pub digits: u32,
    /// The form of the action.
    pub form: Form,
    /// The operator of a window.
    pub sbp: SbpOperator<S>,
    /// The metric.
    pub metric: Metric<S>,
    /// The initial data, with time counted from the start (t = 0).
    pub initial: InitialData<S>,
}

/// One window of a [`Solution`], to read.
#[derive(Debug, Clone, Copy)]
pub(crate) struct WindowView<'a, S> {
    pub(crate) start: InitialData<S>,
    /// t from the start of the window, and x.
    pub(crate) elapsed: &'a [S],
    pub(crate) x: &'a [S],
    pub(crate) sbp: &'a SbpOperator<S>,
    form: Form,
}

impl<S: Real> WindowView<'_, S> {
    /// d/dγ as the form of the action means it: Du (strong), or D̄u of a field `u` that starts at `initial` (weak).
    pub(crate) fn derivative(&self, u: &[S], initial: S) -> Vec<S> {
        FormDerivative::new(self.sbp, self.form).derivative(u, initial)
    }
}

impl<S: Real> Solution<S> {
    /// The windows in order.
    pub(crate) fn views(&self) -> impl ExactSizeIterator<Item = WindowView<'_, S>> {
        let nodes = self.sbp.points();
        self.windows.iter().enumerate().map(move |(index, window)| WindowView {
            start: window.start,
            elapsed: &self.elapsed[index * nodes..(index + 1) * nodes],
            x: &self.x[index * nodes..(index + 1) * nodes],
            sbp: &self.sbp,
            form: self.form,
        })
    }

    /// γ_f − γ_i of one window.
    pub fn window_length(&self) -> S {
        self.length / S::from(self.windows.len() as f64)
    }

    /// γ − γ_i at node k of a window, both counted from 0.
    #[inline]
    pub(crate) fn gamma_at(&self, window: usize, k: usize) -> S {
        if k + 1 < self.sbp.points() {
            let within = self.sbp.node(k);
            return if window == 0 { within } else { S::from(window as f64) * self.window_length() + within };
        }
        match window + 1 == self.windows.len() {
            true => self.length,
            false => S::from((window + 1) as f64) * self.window_length(),
        }
    }

    /// γ − γ_i on the nodes: N values a window, joints twice.
    pub fn gamma_from_start(&self) -> impl Iterator<Item = S> + '_ {
        let nodes = self.sbp.points();
        (0..self.windows.len()).flat_map(move |window| (0..nodes).map(move |k| self.gamma_at(window, k)))
    }

    /// γ on the nodes: N values a window, joints twice.
    pub fn gamma(&self) -> impl Iterator<Item = S> + '_ {
        self.gamma_from_start().map(|gamma| self.gamma_i + gamma)
    }

    /// t on the nodes: N values a window, joints twice.
    pub fn t(&self) -> impl Iterator<Item = S> + '_ {
        self.time_from_start(&self.elapsed).map(|t| self.t_i + t)
    }

    /// t − t_i for times `elapsed` on the nodes that count from the start of their window.
    pub(crate) fn time_from_start<'a>(&'a self, elapsed: &'a [S]) -> impl Iterator<Item = S> + 'a {
        let chunks = elapsed.chunks_exact(self.sbp.points()).zip(&self.windows);
        chunks.flat_map(move |(elapsed, window)| elapsed.iter().map(move |&t| window.start.t + t))
    }

    /// t_N − t_i.
    pub fn duration(&self) -> S {
        self.windows.last().map_or(S::ZERO, |window| window.start.t) + self.elapsed.last().copied().unwrap_or(S::ZERO)
    }

    /// γ of the last node.
    pub fn gamma_f(&self) -> S {
        self.gamma_i + self.length
    }

    /// λ1 … λ8 of the last window; the weak form has none.
    pub fn multipliers(&self) -> Option<&[S; MULTIPLIERS]> {
        self.windows.last()?.multipliers.as_ref()
    }

    /// The continuum's Q_t and K of the initial data.
    pub fn invariants(&self) -> Invariants<S> {
        self.initial.invariants(&self.metric)
    }

    /// Number of nodes of each window, from its first, at which Q_t is exact: all but the last (strong), or all (weak).
    pub(crate) fn exact_nodes(&self) -> usize {
        match self.form {
            Form::Strong => self.sbp.points() - 1,
            Form::Weak => self.sbp.points(),
        }
    }

    /// Largest distance between the branches in t or x; 0 in the physical limit.
    pub fn branch_distance(&self) -> S {
        let distance = |a: &[S], b: &[S]| a.iter().zip(b).fold(S::ZERO, |d, (&a, &b)| d.max((a - b).abs()));
        let of = |b: &Backward<S>| distance(&self.elapsed, &b.elapsed).max(distance(&self.x, &b.x));
        self.backward.as_ref().map_or(S::ZERO, of)
    }
}
