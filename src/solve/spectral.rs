//! Windows of the weak form on spectral elements, marched by the fixed-point iteration of [`crate::lobatto`].
//!
//! It is the same collocation system that Newton's method solves window by window, and every window is certified on the
//! same action; the iteration is just some fifty times faster. Where it does not converge, because a window is too long
//! for it, Newton's method takes over.

use std::ops::ControlFlow;

use super::problem::Problem;
use super::run::{Observer, Piece, Place, Run};
use super::setup::Setup;
use super::solution::Solution;
use super::status::{InitialGuess, NoSolution, Status};
use crate::action::GradientRoom;
use crate::lobatto::{March, MarchFailure, State, Twofold, WeakRule, WindowView};

/// The windows of the run that starts with `problem`; none if the iteration does not converge.
pub(super) fn march(
    problem: &Problem,
    setup: &Setup,
    length: f64,
    observer: Option<Observer<'_, f64>>,
) -> Result<Option<Solution>, NoSolution> {
    let windows = setup.windows;
    let rule = WeakRule::shared(problem.sbp.points());
    let window_length = Twofold::from(length) / Twofold::from(windows as f64);
    let q_t = problem.invariants().q_t;
    // The tables hold the square of the length, and half as many digits of it again.
    let square = problem.length * problem.length;
    if !(square.is_finite() && square > f64::MIN_POSITIVE / f64::EPSILON / f64::EPSILON) {
        return Ok(None);
    }
    let run = Run::new(problem, setup, length, windows * problem.sbp.points(), observer);
    let mut certified = CertifiedRun::new(problem.clone(), run);
    let march = March::new(&problem.metric, q_t, rule, window_length);
    let marched = march.run(State::from(problem.initial), windows, &mut |view| {
        let end = if view.index + 1 == windows { length } else { (view.gamma + view.length).hi };
        certified.append(view, end)
    });
    let mut run = certified.finish()?;
    match marched {
        Ok(marched) => {
            run.iterations = marched.statistics.evaluations;
            Ok(Some(run))
        }
        Err(MarchFailure::OutsideDomain { gamma, x, g00, .. }) => {
            Err(no_solution(Status::OutsideDomain, problem.gamma_i + gamma, x, g00))
        }
        Err(_) => Ok(None),
    }
}

/// A march that ended without a result at this point.
pub(super) fn no_solution(status: Status, gamma: f64, x: f64, g00: f64) -> NoSolution {
    NoSolution {
        status,
        gamma,
        x,
        g00,
        iteration: 0,
        residual: f64::INFINITY,
        history: Vec::new(),
        initial_guess: InitialGuess::Extrapolation,
        needed: 0.0,
        adaptive: false,
    }
}

/// Collects marched windows, each as a critical point of its action.
pub(super) struct CertifiedRun<'o> {
    /// The problem of the next window.
    pub(super) problem: Problem,
    gamma_i: f64,
    pub(super) run: Run<'o, f64>,
    room: GradientRoom<f64>,
    failure: Option<NoSolution>,
}

impl<'o> CertifiedRun<'o> {
    pub(super) fn new(problem: Problem, run: Run<'o, f64>) -> Self {
        let room = GradientRoom::new(problem.sbp.points());
        Self { gamma_i: problem.gamma_i, problem, run, room, failure: None }
    }

    /// Forgets everything: the march begins again from `start`.
    pub(super) fn begin_again(&mut self, start: State) {
        self.run.clear();
        let State { x, w, .. } = start;
        self.problem.continue_from(self.gamma_i, x.hi, w.hi);
    }

    /// Adds a window that ends at γ − γ_i = `end`.
    pub(super) fn append(&mut self, view: &WindowView<'_>, end: f64) -> ControlFlow<()> {
        let problem = &mut self.problem;
        if view.index > 0 {
            problem.continue_from(self.gamma_i + view.gamma.hi, view.start.x.hi, view.start.w.hi);
        }
        let elapsed = view.elapsed();
        self.room.fit(elapsed.len());
        let norm = problem.action().weak_gradient_norm_at_limit(&elapsed, view.x(), &mut self.room);
        let piece = Piece {
            gradient_norm: norm.unwrap_or(f64::INFINITY),
            elapsed,
            x: view.x().to_vec(),
            backward: None,
            multipliers: None,
            end: [view.end.x.hi, view.end.w.hi],
            q_t: problem.invariants().q_t,
            initial_guess: InitialGuess::Extrapolation,
            history: Vec::new(),
        };
        let place = Place { gamma: [view.gamma.hi, end], time: [view.start.t.hi, view.end.t.hi] };
        match self.run.append(problem, place, piece) {
            Ok(()) => ControlFlow::Continue(()),
            Err(failure) => {
                self.failure = Some(failure);
                ControlFlow::Break(())
            }
        }
    }

    /// The run.
    ///
    /// # Errors
    /// Why a window could not be added.
    pub(super) fn finish(self) -> Result<Solution, NoSolution> {
        match self.failure {
            Some(failure) => Err(failure),
            None => Ok(self.run.solution),
        }
    }
}
