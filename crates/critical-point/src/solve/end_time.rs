//! Runs that end at a physical time: the γ_f at which t at the last node is t_f.

use super::arithmetic::Arithmetic;
use super::failure::{At, NoSolution};
use super::run::Observer;
use super::search::{self, Excess, NotFound, Search};
use super::setup::Setup;
use super::solution::Solution;
use super::solve_to;
use super::status::{InitialGuess, Iterations, Status};
use crate::metric::Metric;
use crate::scalar::Real;

/// The |t_N − t_f| that counts as equal, relative to t_f − t_i, has this many digits in `f64`; with more digits, all of
/// them must agree.
const DOUBLE_DIGITS: u32 = 14;

/// Newton's method on γ_f with dt/dγ at the end of each solution, kept inside the bracket found so far: t_N grows with
/// γ_f as long as g00 > 0. A γ_f that has no solution (a horizon on the way) is an upper bound like one that ends too
/// late.
///
/// Where the windows are observed, the search keeps no more than one, and the run that was found is repeated once.
pub(super) fn solve<S: Arithmetic>(
    setup: &Setup<S>,
    duration: S,
    observer: Option<Observer<'_, S, Metric<S>>>,
) -> Result<Solution<S>, NoSolution> {
    match observer {
        None => search(setup, duration, &mut |length| solve_to(setup, length, None)),
        Some(observer) => {
            let found = search(setup, duration, &mut |length| solve_to(setup, length, Some(&mut |_| ())))?;
            solve_to(setup, found.length, Some(observer))
        }
    }
}

fn search<S: Arithmetic>(
    setup: &Setup<S>,
    duration: S,
    solve_to: &mut dyn FnMut(S) -> Result<Solution<S>, NoSolution>,
) -> Result<Solution<S>, NoSolution> {
    let guess = if S::IS_EXTENDED {
        // Most of the search is cheapest in f64.
        S::from(solve::<f64>(&setup.in_f64(), duration.to_f64(), Some(&mut |_| ()))?.length)
    } else {
        duration / setup.scene.initial.t_dot
    };
    let asked = Search {
        guess,
        limit: S::from(f64::INFINITY),
        digits: if S::IS_EXTENDED { setup.settings.digits } else { DOUBLE_DIGITS },
        digits_of_runs: setup.settings.digits,
        scale: Some(duration),
    };
    let excess =
        |solution: &Solution<S>| Excess { value: solution.duration() - duration, slope: Some(solution.end().q_dot[0]) };
    search::search(asked, solve_to, excess).map_err(|error| match error {
        NotFound::Failed(failure) => failure,
        NotFound::Missed(closest) => not_reached(setup, closest),
    })
}

/// The failure of a search, of which `closest` came closest to its end.
fn not_reached<S: Real>(setup: &Setup<S>, closest: Option<Solution<S>>) -> NoSolution {
    let (x, gamma) = match &closest {
        Some(closest) => (closest.end_state().x, closest.gamma_f()),
        None => (setup.scene.initial.x, setup.scene.gamma_i),
    };
    let at = At::x(gamma.to_f64(), x.to_f64(), setup.scene.metric.g00(x).to_f64());
    let iterations = closest.as_ref().map_or(Iterations::from(InitialGuess::None), |closest| {
        let Iterations { initial_guess, history, .. } = &closest.iterations;
        Iterations::of(*initial_guess, history.clone())
    });
    NoSolution {
        iterations: Box::new(iterations),
        residual: closest.as_ref().map_or(f64::INFINITY, |closest| closest.gradient_norm.to_f64()),
        ..NoSolution::new(Status::EndTimeNotReached, at)
    }
}
