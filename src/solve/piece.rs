//! The critical point of one window, in the physical limit or with both branches.

use super::critical_point::CriticalPointSolver;
use super::explicit;
use super::failure::NoSolution;
use super::guess::{self, Edge, Guess};
use super::leap;
use super::limit::{self, Limit};
use super::newton::Failure;
use super::places;
use super::status::{InitialGuess, IterationRecord};
use super::window::Window;
use crate::action::{Form, Layout};
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
pub(super) struct Pair<'w, S> {
    pub(super) window: Window<'w, S>,
    pub(super) rough: Window<'w, f64>,
    pub(super) gamma: f64,
    pub(super) max_iterations: usize,
}

impl<S: Real> Pair<'_, S> {
    /// The solution of the collocation system that holds where both branches are equal.
    pub(super) fn physical_limit(&self) -> Result<Piece<S>, NoSolution> {
        let Self { window, rough, max_iterations, .. } = self;
        let fields = 2 * window.geometry.active().len();
        let is_explicit = window.form == Form::Strong && window.sbp.is_two_step();
        if let Some(guess) = if is_explicit { None } else { guess::by_steps(rough) }
            && let Ok(limit) = limit::solve(window, rough, Some(guess), *max_iterations)
            && leap::outside(window.geometry, &limit.q).is_none()
        {
            return Ok(self.of_limit(limit));
        }
        let guess = if is_explicit { None } else { Some(self.guess()?) };
        let solved = limit::solve(window, rough, guess, *max_iterations).and_then(|limit| {
            // Other rules begin with a guess that follows the geodesic as closely as it needs.
            let leap = if is_explicit { leap::outside(window.geometry, &limit.q) } else { None };
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
            let guess = if is_explicit { InitialGuess::None } else { InitialGuess::Engine };
            self.no_solution(failure, guess, locate)
        })?;
        Ok(self.of_limit(limit))
    }

    /// Makes a piece of a solution of the collocation system.
    fn of_limit(&self, limit: Limit<S>) -> Piece<S> {
        let window = &self.window;
        let multipliers = limit.multipliers(window);
        let rows: Vec<&[S]> = limit.q.iter().map(Vec::as_slice).collect();
        Piece {
            gradient_norm: window.regularised_action().gradient_norm_in_limit(&rows, &multipliers),
            end: limit.last_momenta(window),
            q: limit.q,
            p: limit.p,
            backward: Vec::new(),
            multipliers,
            initial_guess: limit.initial_guess,
            history: limit.history,
        }
    }

    /// The critical point of the doubled action in all its unknowns. Where Newton's method does not find one from the
    /// first guess, it starts once more, from the physical limit.
    pub(super) fn doubled(&self) -> Result<Piece<S>, NoSolution> {
        if self.window.is_at_rest() {
            let rest = self.physical_limit()?;
            return Ok(Piece { backward: rest.q.clone(), p: Vec::new(), ..rest });
        }
        let (rough, guess) = (&self.rough, self.guess()?);
        let failure = match self.doubled_from(&guess.q, &vec![0.0; rough.layout().multiplier_range().len()]) {
            Ok(piece) => return Ok(piece),
            Err(failure) => self.not_found(failure),
        };
        let Self { gamma, max_iterations, .. } = *self;
        let start = Pair { window: *rough, rough: *rough, gamma, max_iterations };
        let found = start.physical_limit().ok().map(|limit| self.doubled_from(&limit.q, &limit.multipliers));
        let found = found.and_then(Result::ok).ok_or(failure)?;
        Ok(Piece { initial_guess: InitialGuess::PhysicalLimit, ..found })
    }

    /// Returns the first guess of Newton's method.
    fn guess(&self) -> Result<Guess, NoSolution> {
        guess::guess(&self.rough).map_err(|Edge { gamma, point }| {
            let at = places::place_outside(self.rough.geometry, &point, &|_| self.gamma + gamma);
            NoSolution::iterated(explicit::outside(point), InitialGuess::Engine, |_, _, _| at)
        })
    }

    /// The critical point that Newton's method finds from equal branches with these positions.
    fn doubled_from(&self, q: &[Vec<f64>], multipliers: &[f64]) -> Result<Piece<S>, Failure> {
        let Self { window, rough, max_iterations, .. } = self;
        let rows: Vec<&[f64]> = q.iter().map(Vec::as_slice).collect();
        let (action, rough_action, layout) = (window.action(), rough.action(), window.layout());
        let solver = CriticalPointSolver::new(&rough_action);
        let root = solver
            .solve(&rough_action, layout.physical_limit(&rows, multipliers), *max_iterations)
            .and_then(|root| solver.refine(&action, &rough_action, root, (window.digits, *max_iterations)))?;
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
            initial_guess: InitialGuess::Engine,
            history: root.history,
        })
    }

    /// A failed iteration for the doubled action, in terms of the scene.
    fn not_found(&self, failure: Failure) -> NoSolution {
        let layout = self.window.layout();
        let locate = |unknown: usize, u: &[f64]| on_forward_branch(layout, unknown, u);
        self.no_solution(failure, InitialGuess::Engine, locate)
    }

    /// Expresses a failed iteration in terms of the scene. `locate` maps an index of the residual, at the last iterate,
    /// to its node and q there.
    fn no_solution(
        &self,
        failure: Failure,
        initial_guess: InitialGuess,
        locate: impl Fn(usize, &[f64]) -> (usize, Vec<f64>),
    ) -> NoSolution {
        let Window { geometry, sbp, start, .. } = self.rough;
        let gamma = |node: usize| self.gamma + sbp.node(node);
        NoSolution::iterated(failure, initial_guess, |outside, worst, unknowns| match outside {
            Some(point) => places::place_outside(geometry, &point, &gamma),
            None => {
                let located = worst.filter(|_| !unknowns.is_empty()).map(|row| locate(row, unknowns));
                let (node, q) = located.unwrap_or_else(|| (0, start.q.clone()));
                places::place(geometry, gamma(node), &q)
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
fn end_momenta<S: Real>(window: &Window<'_, S>, q: &[Vec<S>], multipliers: &[S]) -> Vec<S> {
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
