//! What a successful solve returns.

use std::sync::Arc;

use super::operator::{Operators, WindowGrid};
use super::status::Iterations;
use crate::action::Form;
use crate::action::MULTIPLIERS;
use crate::geodesic::{InitialData, Invariants};
use crate::metric::Metric;
use crate::sbp::SbpName;
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

/// The values from which to continue the trajectory. In the strong form these are not (Dt)_N and (Dx)_N: the last node
/// takes up the compatibility defect.
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

/// The start and the end of one window of a run.
#[derive(Debug, Clone)]
pub struct Window<S = f64> {
    /// γ − γ_i at its first and its last node.
    pub gamma: [S; 2],
    /// What it continues.
    pub start: Joint<S>,
    /// What the next window continues from.
    pub end: Joint<S>,
    /// λ1 … λ8 of its action; the weak form has none.
    pub multipliers: Option<Box<[S; MULTIPLIERS]>>,
    /// Index of its first node in the arrays of the [`Solution`], and of its operator there.
    pub(crate) first_node: usize,
    pub(crate) operator: usize,
}

/// What one window hands to the next besides Q_t.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Joint<S = f64> {
    /// t − t_i.
    pub t: S,
    /// x.
    pub x: S,
    /// ẋ_i at the start of a run, w* at the last node of a window.
    pub x_dot: S,
}

impl<S: Real> Window<S> {
    /// γ from its first to its last node.
    pub fn length(&self) -> S {
        self.gamma[1] - self.gamma[0]
    }
}

/// A converged critical point with the problem it solves; for a run in several windows, one for each, end to end.
///
/// The nodes are stored window by window: the joint of two windows appears in both. Where windows are handed out one by
/// one ([`solve_window_by_window`](super::solve_window_by_window)) it is that window alone, at its place in the run.
#[derive(Debug, Clone)]
pub struct Solution<S = f64> {
    /// Initial time, kept separate from [`Self::elapsed`] so that no digits are lost.
    pub t_i: S,
    /// t on the nodes (forward branch), counted from the start of their window.
    pub elapsed: Vec<S>,
    /// x on the nodes (forward branch).
    pub x: Vec<S>,
    /// The backward branch, if the doubled system was solved.
    pub backward: Option<Backward<S>>,
    /// The windows, in order.
    pub windows: Vec<Window<S>>,
    /// Number of windows of the run so far; more than [`Self::windows`] holds where they are handed out one by one.
    pub window_count: usize,
    /// Largest entry of the gradient of the doubled action at this solution (in any window): its certificate.
    pub gradient_norm: S,
    /// What to continue from.
    pub end: EndState<S>,
    /// The iterations; their corrections are those of t and x (physical limit: of x and w*).
    pub iterations: Iterations,
    /// γ of the first node.
    pub gamma_i: S,
    /// γ_f − γ_i.
    pub length: S,
    /// Significant decimal digits that were asked for; 16 for `f64`.
    pub digits: u32,
    /// The estimated error of t and x at the nodes, relative to max(1, largest |t − t_i|) and max(1, largest |x|), if
    /// the windows were chosen for an accuracy.
    pub error_estimate: Option<f64>,
    /// With an accuracy: the number of windows of which it is not proved that nothing steep hides between their nodes.
    pub windows_unproved: Option<usize>,
    /// The accuracy that was asked for, if there was one.
    pub accuracy: Option<f64>,
    /// The form of the action.
    pub form: Form,
    /// The name of the operator.
    pub sbp_name: SbpName,
    /// The operators of the windows: one if all have the same length.
    pub(crate) operators: Operators<S>,
    /// The metric.
    pub metric: Arc<Metric<S>>,
    /// The initial data, with time counted from the start (t = 0).
    pub initial: InitialData<S>,
}

/// A read-only view of one window of a [`Solution`].
#[derive(Debug, Clone, Copy)]
pub(crate) struct WindowNodes<'a, S> {
    pub(crate) window: &'a Window<S>,
    /// t from the start of the window, and x.
    pub(crate) elapsed: &'a [S],
    pub(crate) x: &'a [S],
    pub(crate) grid: WindowGrid<'a, S>,
}

impl<S: Real> Solution<S> {
    /// The operator of the first window.
    pub fn sbp(&self) -> &SbpOperator<S> {
        self.operators.first()
    }

    /// The windows in order.
    pub(crate) fn views(&self) -> impl ExactSizeIterator<Item = WindowNodes<'_, S>> + Clone {
        self.windows.iter().map(|window| self.view(window))
    }

    /// The grids of the windows in order.
    #[doc(hidden)]
    pub fn grids(&self) -> impl ExactSizeIterator<Item = WindowGrid<'_, S>> + Clone {
        self.views().map(|view| view.grid)
    }

    /// A read-only view of one of the windows.
    pub(crate) fn view<'a>(&'a self, window: &'a Window<S>) -> WindowNodes<'a, S> {
        let grid = self.operators.grid(window.operator, self.form, window.gamma, window.first_node);
        WindowNodes { window, elapsed: &self.elapsed[grid.nodes()], x: &self.x[grid.nodes()], grid }
    }

    /// γ − γ_i on the nodes, window by window, joints twice.
    pub fn gamma_from_start(&self) -> impl Iterator<Item = S> + '_ {
        self.views().flat_map(|view| (0..view.x.len()).map(move |k| view.grid.gamma_at(k)))
    }

    /// γ on the nodes, window by window, joints twice.
    pub fn gamma(&self) -> impl Iterator<Item = S> + '_ {
        self.gamma_from_start().map(|gamma| self.gamma_i + gamma)
    }

    /// t on the nodes, window by window, joints twice.
    pub fn t(&self) -> impl Iterator<Item = S> + '_ {
        let last = self.x.len();
        let times = self.views().flat_map(|view| {
            let Window { start, end, .. } = view.window;
            let points = view.elapsed.len();
            (0..points).map(move |k| if k + 1 == points { end.t } else { start.t + view.elapsed[k] })
        });
        times.enumerate().map(move |(k, t)| if k + 1 == last { self.end.t } else { self.t_i + t })
    }

    /// t − t_i for times `elapsed` on the nodes that count from the start of their window.
    #[doc(hidden)]
    pub fn time_from_start<'a>(&'a self, elapsed: &'a [S]) -> impl Iterator<Item = S> + 'a {
        self.views().flat_map(move |view| elapsed[view.grid.nodes()].iter().map(move |&t| view.window.start.t + t))
    }

    /// t_N − t_i.
    pub fn duration(&self) -> S {
        self.windows.last().map_or(S::ZERO, |window| window.end.t)
    }

    /// γ of the last node.
    pub fn gamma_f(&self) -> S {
        self.gamma_i + self.length
    }

    /// λ1 … λ8 of the last window; the weak form has none.
    pub fn multipliers(&self) -> Option<&[S; MULTIPLIERS]> {
        self.windows.last()?.multipliers.as_deref()
    }

    /// The continuum's Q_t and K of the initial data.
    pub fn invariants(&self) -> Invariants<S> {
        self.initial.invariants(&self.metric)
    }

    /// Largest distance between the branches in t or x; 0 in the physical limit.
    pub fn branch_distance(&self) -> S {
        let distance = |a: &[S], b: &[S]| a.iter().zip(b).fold(S::ZERO, |d, (&a, &b)| d.max((a - b).abs()));
        let of = |b: &Backward<S>| distance(&self.elapsed, &b.elapsed).max(distance(&self.x, &b.x));
        self.backward.as_ref().map_or(S::ZERO, of)
    }
}
