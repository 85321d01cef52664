//! Runs that end at a physical time: the γ_f at which t at the last node is t_f.

use super::solution::Solution;
use super::solve_to;
use super::status::{NoSolution, Status};
use crate::case::Case;

/// Solves allowed for the search; Newton's method needs about five.
const MOST_SOLVES: usize = 60;
/// |t_N − t_f| that counts as equal, relative to t_f − t_i.
const TOLERANCE: f64 = 1e-14;
/// The same where rounding ends the search first.
const LOOSE_TOLERANCE: f64 = 1e-12;

/// Newton's method on γ_f with dt/dγ at the end of each solution, kept inside the bracket found so far: t_N grows with
/// γ_f as long as g00 > 0. A γ_f that has no solution (a horizon on the way) is an upper bound like one that ends too
/// late.
pub(super) fn solve(case: &Case, duration: f64) -> Result<Solution, NoSolution> {
    let mut length = duration / case.initial.t_dot;
    let (mut below, mut above) = (0.0, f64::INFINITY);
    let mut best: Option<(f64, Solution)> = None;
    let mut failure = None;
    for _ in 0..MOST_SOLVES {
        match solve_to(case, length) {
            Ok(solution) => {
                let excess = solution.elapsed.last().copied().unwrap_or(0.0) - duration;
                let slope = solution.end.q_t / solution.metric.at(solution.end.x).g00;
                if excess < 0.0 {
                    below = length;
                } else {
                    above = length;
                }
                let improved = best.as_ref().is_none_or(|(least, _)| excess.abs() < *least);
                let good_enough = |least: f64, share: f64| least <= share * duration;
                if improved {
                    best = Some((excess.abs(), solution));
                }
                let least = best.as_ref().map_or(f64::INFINITY, |(least, _)| *least);
                if good_enough(least, TOLERANCE) || (!improved && good_enough(least, LOOSE_TOLERANCE)) {
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
            length = if above.is_finite() { 0.5 * (below + above) } else { 2.0 * below };
        }
        if length <= below || length >= above || !length.is_finite() {
            break;
        }
    }
    match (best, failure) {
        (Some((excess, solution)), _) if excess <= LOOSE_TOLERANCE * duration => Ok(solution),
        (_, Some(failure)) => Err(failure),
        (best, None) => {
            let (_, solution) = best.expect("a search without a failure has a solution");
            Err(not_reached(solution))
        }
    }
}

/// The solution that came closest.
fn not_reached(closest: Solution) -> NoSolution {
    NoSolution {
        status: Status::EndTimeNotReached,
        gamma: closest.gamma_f(),
        x: closest.end.x,
        g00: closest.metric.at(closest.end.x).g00,
        iteration: closest.history.len(),
        residual: closest.gradient_norm,
        initial_guess: closest.initial_guess,
        history: closest.history,
    }
}
