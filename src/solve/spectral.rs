//! Windows of the weak form on spectral elements, marched by the fixed-point iteration of [`crate::lobatto`].
//!
//! It is the same collocation system that Newton's method solves window by window, and every window is certified on the
//! same action; only the way to it is some fifty times faster. Where the iteration does not converge, because a window is
//! too long for it, Newton's method has its turn.

use std::ops::ControlFlow;

use super::gradient_norm;
use super::problem::Problem;
use super::run::{Piece, Run};
use super::status::{InitialGuess, NoSolution, Status};
use crate::lobatto::{March, MarchFailure, State, Twofold, WeakRule, WindowView};

/// All windows of the run that starts with `problem`; none if the iteration does not converge.
pub(super) fn march(problem: &Problem, windows: usize, length: f64) -> Option<Result<Run<f64>, NoSolution>> {
    let rule = WeakRule::shared(problem.sbp.points());
    let window_length = Twofold::from(length) / Twofold::from(windows as f64);
    let q_t = problem.invariants().q_t;
    // The tables hold the square of the length, and half as many digits of it again.
    let square = problem.length * problem.length;
    if !(square.is_finite() && square > f64::MIN_POSITIVE / f64::EPSILON / f64::EPSILON) {
        return None;
    }
    let mut here = problem.clone();
    let mut run = Run::new(windows * problem.sbp.points());
    let mut failure = None;
    let marched = March::new(&problem.metric, q_t, rule, window_length).run(
        State::from(problem.initial),
        windows,
        &mut |view: &WindowView<'_>| {
            if view.index > 0 {
                here.continue_from(problem.gamma_i + view.gamma.hi, view.start.x.hi, view.start.w.hi);
            }
            match run.append(&here, piece(&here, view)) {
                Ok(()) => ControlFlow::Continue(()),
                Err(error) => {
                    failure = Some(error);
                    ControlFlow::Break(())
                }
            }
        },
    );
    if let Some(error) = failure {
        return Some(Err(error));
    }
    match marched {
        Ok(marched) => {
            run.set_time(marched.end.t.hi);
            run.iterations = marched.statistics.evaluations;
            Some(Ok(run))
        }
        Err(MarchFailure::OutsideDomain { gamma, x, g00, .. }) => Some(Err(NoSolution {
            status: Status::OutsideDomain,
            gamma: problem.gamma_i + gamma,
            x,
            g00,
            iteration: 0,
            residual: f64::INFINITY,
            history: Vec::new(),
            initial_guess: InitialGuess::Extrapolation,
        })),
        Err(_) => None,
    }
}

/// One window as a critical point of its action.
fn piece(problem: &Problem, view: &WindowView<'_>) -> Piece<f64> {
    let elapsed = view.elapsed();
    let unknowns = problem.layout().physical_limit(&elapsed, view.x, &[]);
    Piece {
        gradient_norm: gradient_norm(&problem.action(), &unknowns),
        elapsed,
        x: view.x.to_vec(),
        backward: None,
        multipliers: None,
        end: [view.end.x.hi, view.end.w.hi],
        q_t: problem.invariants().q_t,
        initial_guess: InitialGuess::Extrapolation,
        history: Vec::new(),
    }
}
