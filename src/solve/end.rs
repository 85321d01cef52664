//! Runs that end where a coordinate reaches a value or a formula changes its sign: the length of γ at which the last
//! node is there.

use super::failure::NoSolution;
use super::run::Observer;
use super::search::{NotFound, Search, search};
use super::setup::{Limit, Setup};
use super::solve_to;
use super::status::{Iterations, Status};
use super::sweeps;
use super::world_line::{Joint, WorldLine};
use crate::engine::Accuracy;
use crate::number::Real;

/// The share of the whole way that counts as none has this many digits in `f64`.
const DIGITS_OF_WAY: u32 = 14;
/// The same of the length of γ.
const DIGITS_OF_LENGTH: u32 = 15;
/// The accuracy of the windows that tell roughly where a formula changes its sign.
const NEAR: f64 = 1e-9;

/// The run of `setup`, with what it ended by, where its length is to be searched for: all of its windows, or the last
/// one.
pub(super) fn solve<S: Real>(setup: &Setup<S>, is_kept: bool) -> Result<WorldLine<S>, NoSolution> {
    let mut ignore = |_: &WorldLine<S>| ();
    let mut solve_to = |length: S| {
        let observer: Option<Observer<'_, S>> = if is_kept { None } else { Some(&mut ignore) };
        solve_to(setup, length, observer)
    };
    let (coordinate, value) = match setup.limit {
        Limit::Length(length) => return until(setup, length, &mut solve_to),
        Limit::Value { coordinate, value } => (coordinate, value),
    };
    let mut line = at_value(setup, coordinate, value, &mut solve_to)?;
    if !setup.until.is_empty() {
        line = until(setup, line.length, &mut solve_to)?;
    }
    // A search meets the value but for rounding. Rows that count from an origin are rounded once more when they are
    // shown, at the end as anywhere else.
    if line.ended_by.is_none() && !setup.counts_from_origin(coordinate) {
        line.ended_at = Some((coordinate, line.last_joint().q[coordinate]));
    }
    Ok(line)
}

/// Solves a setup up to a length.
type SolveTo<'s, S> = &'s mut dyn FnMut(S) -> Result<WorldLine<S>, NoSolution>;

/// The length of the same run in `f64`, where most of a search is cheapest.
fn rough_length<S: Real>(setup: &Setup<S>) -> Result<S, NoSolution> {
    Ok(S::from(solve(&setup.in_f64(), false)?.length))
}

/// The world-line that ends where `coordinate` is `value`, by Newton's method on γ_f with the velocity at the end of
/// each solution: the coordinate grows, or falls, with γ_f. A share of the whole way counts as none of what counts from
/// an origin, or else one of the length of γ.
fn at_value<S: Real>(
    setup: &Setup<S>,
    coordinate: usize,
    value: S,
    solve_to: SolveTo<'_, S>,
) -> Result<WorldLine<S>, NoSolution> {
    let (start, is_of_way) = (&setup.place.start, setup.counts_from_origin(coordinate));
    let value = value - setup.origin_of(coordinate);
    let way = value - start.q[coordinate];
    let asked = Search {
        guess: if S::IS_EXTENDED {
            rough_length(&Setup { until: Vec::new(), ..setup.clone() })?
        } else {
            // The length that would do at constant speed.
            way / start.q_dot[coordinate]
        },
        limit: S::from(f64::INFINITY),
        digits: if is_of_way { DIGITS_OF_WAY } else { DIGITS_OF_LENGTH },
        digits_of_runs: setup.settings.digits,
        scale: is_of_way.then(|| way.abs()),
    };
    let excess = |line: &WorldLine<S>| {
        let end = line.last_joint();
        let [excess, slope] = [end.q[coordinate] - value, line.velocities(end)[coordinate]];
        (excess * way.signum(), Some(slope * way.signum()))
    };
    search(asked, solve_to, excess).map_err(|error| not_reached(error, setup))
}

/// The world-line that ends where one of the formulas of the setup first changes its sign in its direction, or after
/// the length `whole`.
fn until<S: Real>(setup: &Setup<S>, whole: S, solve_to: SolveTo<'_, S>) -> Result<WorldLine<S>, NoSolution> {
    let Some((index, gamma, to_positive)) = near(setup, whole) else { return solve_to(whole) };
    let start = &setup.place.start;
    let k = setup.place.geometry.norm(&start.q, &start.q_dot);
    let mut formula = setup.until[index].formula.clone();
    let asked = Search {
        guess: if S::IS_EXTENDED {
            rough_length(&Setup { limit: Limit::Length(whole), ..setup.clone() })?
        } else {
            gamma
        },
        limit: whole,
        digits: DIGITS_OF_LENGTH,
        digits_of_runs: setup.settings.digits,
        scale: None,
    };
    let excess = |line: &WorldLine<S>| {
        let end = line.end_inside();
        let value = formula.at(&end.q, &end.q_dot, &end.p, k);
        (if to_positive { value } else { -value }, None)
    };
    let line = search(asked, solve_to, excess).map_err(|error| not_reached(error, setup))?;
    Ok(WorldLine { ended_by: Some(index), ..line })
}

/// The first change of sign within the length `whole`, by the engine; `None` if it finds none: the place of the formula
/// among those that end the run, γ − γ_i roughly, and true if the formula is positive after it.
fn near<S: Real>(setup: &Setup<S>, whole: S) -> Option<(usize, S, bool)> {
    let rough = Setup { limit: Limit::Length(whole.to_f64()), ..setup.in_f64() };
    let line = sweeps::to_accuracy(&rough, Accuracy::Local(NEAR), Some(&mut |_| ())).ok()?;
    let (index, view, start) = (line.ended_by?, line.views().last()?, &rough.place.start);
    // The node before the change.
    let node = view.window.points() - 2;
    let q: Vec<f64> = (0..start.q.len()).filter_map(|a| view.absolute(a, &line.q[a]).nth(node)).collect();
    let mut p = view.start.p.to_vec();
    line.geometry().active().iter().zip(&line.p).for_each(|(&a, row)| p[a] = row[view.window.nodes()][node]);
    let q_dot = line.velocities(Joint { q: &q, p: &p });
    let k = line.geometry().norm(&start.q, &start.q_dot);
    let before = rough.until[index].formula.clone().at(&q, &q_dot, &p, k);
    Some((index, S::from(line.length), before < 0.0))
}

/// The failure of a search for the end of the run of `setup`.
fn not_reached<S: Real>(error: NotFound<WorldLine<S>, NoSolution>, setup: &Setup<S>) -> NoSolution {
    let (geometry, status) = (&setup.place.geometry, Status::EndTimeNotReached);
    match error {
        NotFound::Failed(failure) => failure,
        NotFound::Missed(None) => NoSolution::new(status, geometry, setup.gamma_i.to_f64(), &setup.place.start.q),
        NotFound::Missed(Some(closest)) => {
            let gamma = closest.gamma_f().to_f64();
            let failure = NoSolution::new(status, geometry, gamma, closest.last_joint().q);
            let Iterations { initial_guess, history, .. } = closest.iterations;
            NoSolution {
                iterations: Box::new(Iterations::of(initial_guess, history)),
                residual: closest.gradient_norm.to_f64(),
                ..failure
            }
        }
    }
}
