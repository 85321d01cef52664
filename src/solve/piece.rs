//! The critical point of one window, in the physical limit or with both branches.

use super::critical_point::CriticalPointSolver;
use super::explicit;
use super::failure::NoSolution;
use super::first_guess::{self, WindowFailure};
use super::limit;
use super::newton::Failure;
use super::places::Places;
use super::status::{InitialGuess, IterationRecord};
use super::window::Window;
use crate::action::{Form, Layout, MULTIPLIERS_PER_COORDINATE};
use crate::number::Real;

/// The critical point of one window, in which ignorable coordinates are counted from its start.
pub(super) struct Piece<S> {
    /// q^a on the nodes, a row for each coordinate.
    pub(super) q: Vec<Vec<S>>,
    /// p*_a on the nodes, a row for each active coordinate; nothing in the doubled system.
    pub(super) p: Vec<Vec<S>>,
    /// p*_a of all coordinates at the end.
    pub(super) end: Vec<S>,
    /// The backward branch in the rows of `q`; nothing in the physical limit.
    pub(super) backward: Vec<Vec<S>>,
    /// Those of the action; the weak form has none.
    pub(super) multipliers: Vec<S>,
    pub(super) gradient_norm: S,
    pub(super) initial_guess: InitialGuess,
    pub(super) history: Vec<IterationRecord>,
}

/// A window with the same in `f64`, and γ at its start.
#[derive(Clone, Copy)]
pub(super) struct Pair<'w, S, G, R> {
    pub(super) window: Window<'w, S, G>,
    pub(super) rough: Window<'w, f64, R>,
    pub(super) gamma: f64,
    pub(super) max_iterations: usize,
}

impl<S: Real, G: Places<S>, R: Places<f64, Outside = G::Outside>> Pair<'_, S, G, R> {
    /// The solution of the collocation system that holds where both branches are equal.
    pub(super) fn physical_limit(&self) -> Result<Piece<S>, NoSolution> {
        let Self { window, rough, max_iterations, .. } = self;
        let fields = 2 * window.geometry.active().len();
        let is_explicit = window.form == Form::Strong && window.sbp.is_two_step();
        let solved = limit::solve(window, rough, *max_iterations).and_then(|limit| {
            // Other rules begin with a guess that follows the geodesic in ever finer steps.
            let leap = if is_explicit { window.geometry.leapt_over(&limit.q) } else { None };
            leap.map_or(Ok(limit), |point| Err(explicit::outside(point)))
        });
        let limit = solved.map_err(|failure| {
            let first = rough.derivative().first_unknown();
            // The node of a row of the residual, and the active coordinates there.
            let locate = |row: usize, u: &[f64]| {
                let (node, mut q) = (row / fields, rough.start.q.clone());
                let state = node.checked_sub(first).and_then(|unknown| u.get(unknown * fields..)?.get(..fields / 2));
                if let Some(state) = state {
                    rough.geometry.active().iter().zip(state).for_each(|(&a, &value)| q[a] = value);
                }
                (node, q)
            };
            let guess = match (is_explicit, window.geometry.has_accelerations()) {
                (true, _) => InitialGuess::None,
                (false, true) => InitialGuess::Nystrom4,
                (false, false) => InitialGuess::RungeKutta4,
            };
            self.no_solution(failure, guess, &rough.start.q, |node| rough.sbp.node(node), locate)
        })?;
        let multipliers = limit.multipliers(window);
        let rows: Vec<&[S]> = limit.q.iter().map(Vec::as_slice).collect();
        let unknowns = window.layout().physical_limit(&rows, &multipliers);
        Ok(Piece {
            gradient_norm: window.regularised_action().gradient_norm(&unknowns),
            end: limit.last_momenta(window),
            q: limit.q,
            p: limit.p,
            backward: Vec::new(),
            multipliers,
            initial_guess: limit.initial_guess,
            history: limit.history,
        })
    }

    /// The critical point of the doubled action in all its unknowns.
    pub(super) fn doubled(&self) -> Result<Piece<S>, NoSolution> {
        let Self { window, rough, max_iterations, .. } = self;
        let length = rough.sbp.node(rough.points() - 1);
        // The guess is one for the regularised action, whichever is solved.
        let start = first_guess::windowed_action(&rough.regularised_action(), rough.geometry, length)
            .map_err(|failure| self.no_guess(failure))?;
        let (action, rough_action) = (window.action(), rough.action());
        let solver = CriticalPointSolver::new(&rough_action);
        let root = solver
            .solve(&rough_action, start, *max_iterations)
            .and_then(|root| solver.refine(&action, &rough_action, root, (window.digits, *max_iterations)));
        let layout = window.layout();
        let root = root.map_err(|failure| {
            let locate = |unknown: usize, u: &[f64]| on_forward_branch(layout, unknown, u);
            let start = &rough.start.q;
            self.no_solution(failure, InitialGuess::WindowedAction, start, |node| rough.sbp.node(node), locate)
        })?;
        let rows = |branch| layout.branch(&root.unknowns, branch).into_iter().map(<[S]>::to_vec).collect::<Vec<_>>();
        let (q, backward) = (rows(0), rows(1));
        let multipliers = layout.multipliers(&root.unknowns).to_vec();
        Ok(Piece {
            gradient_norm: action.gradient_norm(&root.unknowns),
            end: end_momenta(window, &q, &multipliers),
            q,
            p: Vec::new(),
            backward,
            multipliers,
            initial_guess: InitialGuess::WindowedAction,
            history: root.history,
        })
    }

    /// A guess that failed, in terms of the scene.
    fn no_guess(&self, failed: WindowFailure<G::Outside>) -> NoSolution {
        // The window is a short grid of its own.
        let WindowFailure { failure, start, gamma, spacing } = failed;
        let (mut failure, rough) = (*failure, &self.rough);
        // A limit of iterations belonged to the short window alone; no setting of the user would help.
        rough.geometry.judge_short_window(&mut failure, &start.q, &rough.start.q);
        let n = rough.start.q.len();
        let points = failure.unknowns.len().saturating_sub(MULTIPLIERS_PER_COORDINATE * n) / (2 * n);
        let layout = Layout::new(n, points, Form::Strong);
        let locate = |unknown: usize, u: &[f64]| on_forward_branch(layout, unknown, u);
        let gamma = |node: usize| gamma + node as f64 * spacing;
        self.no_solution(failure, InitialGuess::WindowedAction, &start.q, gamma, locate)
    }

    /// Expresses a failed iteration in terms of the scene. `gamma` is γ of a node, counted from the start of the
    /// window, and `locate` maps an index of the residual, at the last iterate, to its node and q there; q is `start`
    /// where there is no iterate.
    fn no_solution(
        &self,
        failure: Failure<G::Outside>,
        initial_guess: InitialGuess,
        start: &[f64],
        gamma: impl Fn(usize) -> f64,
        locate: impl Fn(usize, &[f64]) -> (usize, Vec<f64>),
    ) -> NoSolution {
        let (geometry, gamma) = (self.rough.geometry, |node: usize| self.gamma + gamma(node));
        NoSolution::iterated(failure, initial_guess, |outside, worst, unknowns| match outside {
            Some(point) => geometry.place_outside(&point, &gamma),
            None => {
                let located = worst.filter(|_| !unknowns.is_empty()).map(|row| locate(row, unknowns));
                let (node, q) = located.unwrap_or_else(|| (0, start.to_vec()));
                geometry.place(gamma(node), &q)
            }
        })
    }
}

/// Node of an unknown of the doubled action, and q of the forward branch there.
fn on_forward_branch(layout: Layout, unknown: usize, u: &[f64]) -> (usize, Vec<f64>) {
    let node = layout.node(unknown);
    (node, layout.branch(u, 0).into_iter().map(|row| row[node]).collect())
}

/// p*_a of all coordinates at the last node of a window with these positions and multipliers: p_a + κ_a/H_N where the
/// coordinate is active, −ν_a where it is ignorable. In the weak form p_a, and what it was at the start.
fn end_momenta<S: Real, G: Places<S>>(window: &Window<'_, S, G>, q: &[Vec<S>], multipliers: &[S]) -> Vec<S> {
    let (layout, last, active) = (window.layout(), window.points() - 1, window.geometry.active());
    // D̄ is D at the last node.
    let slopes: Vec<S> = q.iter().map(|row| window.sbp.derivative_at(row, last)).collect();
    let end: Vec<S> = q.iter().map(|row| row[last]).collect();
    let mut p = window.geometry.momenta(&end, &slopes);
    for (a, p) in p.iter_mut().enumerate() {
        match (window.form, active.contains(&a)) {
            (Form::Strong, true) => *p += multipliers[layout.kappa(a)] / window.sbp.weights()[last],
            (Form::Strong, false) => *p = -multipliers[layout.nu(a)],
            (Form::Weak, true) => {}
            (Form::Weak, false) => *p = window.start.p[a],
        }
    }
    p
}
