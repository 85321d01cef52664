//! Runs that end at a physical time: the γ_f at which t at the last node is t_f.

use super::arithmetic::Arithmetic;
use super::refinement;
use super::run::Observer;
use super::setup::Setup;
use super::solution::Solution;
use super::solve_to;
use super::status::{NoSolution, Status};
use crate::scalar::Real;

/// Solves allowed for the search; Newton's method needs about five.
const MOST_SOLVES: usize = 60;
/// The |t_N − t_f| that counts as equal, relative to t_f − t_i, in `f64`; with more digits, all of them must agree.
const DOUBLE_DIGITS: u32 = 14;
/// Where rounding ends the search first, this many digits fewer than requested are enough.
const SPARE_DIGITS: u32 = 4;

/// Newton's method on γ_f with dt/dγ at the end of each solution, kept inside the bracket found so far: t_N grows with
/// γ_f as long as g00 > 0. A γ_f that has no solution (a horizon on the way) is an upper bound like one that ends too
/// late.
///
/// Where the windows are observed, the search keeps no more than one, and the run that was found is repeated once.
pub(super) fn solve<S: Arithmetic>(
    setup: &Setup<S>,
    duration: S,
    observer: Option<Observer<'_, S>>,
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
    let digits = setup.digits;
    let tolerance = refinement::tolerance::<S>(if S::IS_EXTENDED { digits } else { DOUBLE_DIGITS }) * duration;
    let loose_tolerance = refinement::tolerance::<S>(digits - SPARE_DIGITS) * duration;
    let mut length = if S::IS_EXTENDED {
        // Most of the search is cheapest in f64.
        S::from(solve::<f64>(&setup.in_f64(), duration.to_f64(), Some(&mut |_| ()))?.length)
    } else {
        duration / setup.scene.initial.t_dot
    };
    let (mut below, mut above) = (S::ZERO, S::from(f64::INFINITY));
    let mut best: Option<(S, Solution<S>)> = None;
    let mut failure = None;
    for _ in 0..MOST_SOLVES {
        match solve_to(length) {
            Ok(solution) => {
                let excess = solution.duration() - duration;
                let slope = solution.end.q_t / solution.metric.at(solution.end.x).g00;
                if excess < S::ZERO {
                    below = length;
                } else {
                    above = length;
                }
                let improved = best.as_ref().is_none_or(|(least, _)| excess.abs() < *least);
                if improved {
                    best = Some((excess.abs(), solution));
                }
                let least = best.as_ref().map_or(S::from(f64::INFINITY), |(least, _)| *least);
                if least <= tolerance || (!improved && least <= loose_tolerance) {
                    break;
                }
                length -= excess / slope;
            }
            Err(error) => {
                above = length;
                failure = Some(error);
                length = below;
            }
        }
        if !(length > below && length < above) {
            // No upper bound yet: the run is longer than any tried.
            length = if above.is_finite() { (below + above).half() } else { below + below };
        }
        if length <= below || length >= above || !length.is_finite() {
            break;
        }
    }
    match (best, failure) {
        (Some((excess, solution)), _) if excess <= loose_tolerance => Ok(solution),
        (_, Some(failure)) => Err(failure),
        (best, None) => {
            let (_, solution) = best.expect("a search without a failure has a solution");
            Err(not_reached(solution))
        }
    }
}

/// The solution that came closest.
fn not_reached<S: Real>(closest: Solution<S>) -> NoSolution {
    NoSolution {
        status: Status::EndTimeNotReached,
        gamma: closest.gamma_f().to_f64(),
        x: closest.end.x.to_f64(),
        g00: closest.metric.at(closest.end.x).g00.to_f64(),
        iteration: closest.history.len(),
        residual: closest.gradient_norm.to_f64(),
        initial_guess: closest.initial_guess,
        history: closest.history,
        needed: 0.0,
        adaptive: false,
    }
}
