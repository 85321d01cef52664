//! Runs that end where a coordinate reaches a value or a formula changes its sign: the length of γ at which the last
//! node is there.

use super::crossing::{self, Near};
use super::setup::SceneSetup;
use super::solve_to;
use crate::solve::Arithmetic;
use crate::solve::NoSolution;
use crate::solve::end::{DIGITS_OF_LENGTH, Target, not_reached};
use crate::solve::search::{self, Excess, Search};
use crate::solve::world_line::WorldLine;

/// The world-line that ends where `coordinate` is `value`.
pub(super) fn at_value<S: Arithmetic>(
    setup: &SceneSetup<S>,
    coordinate: usize,
    value: S,
) -> Result<WorldLine<S>, NoSolution> {
    let digits_of_runs = setup.settings.digits;
    let target = Target { coordinate, value, digits_of_runs, is_of_way: false };
    // Most of the search is cheapest in f64.
    let guess = if S::IS_EXTENDED {
        S::from(at_value::<f64>(&setup.in_f64(), coordinate, value.to_f64())?.length)
    } else {
        target.guess(&setup.place)
    };
    target.search(&setup.place, setup.gamma_i, guess, &mut |length| solve_to(setup, length))
}

/// The world-line that ends where one of the formulas of the setup first changes its sign in its direction, or after
/// the length `whole`.
pub(super) fn until<S: Arithmetic>(setup: &SceneSetup<S>, whole: S) -> Result<WorldLine<S>, NoSolution> {
    let Some(Near { index, gamma, to_positive }) = crossing::first(setup, whole.to_f64()) else {
        return solve_to(setup, whole);
    };
    let length =
        if S::IS_EXTENDED { S::from(until::<f64>(&setup.in_f64(), whole.to_f64())?.length) } else { gamma.into() };
    let start = &setup.place.start;
    let k = setup.place.geometry.norm_here(&start.q, &start.q_dot);
    let mut formula = setup.until[index].formula.clone();
    let digits = setup.settings.digits;
    let asked = Search {
        guess: length,
        limit: whole,
        digits: if S::IS_EXTENDED { digits } else { DIGITS_OF_LENGTH },
        digits_of_runs: digits,
        scale: None,
    };
    let excess = |line: &WorldLine<S>| {
        let end = line.end();
        let value = formula.at_here(&end.q, &end.q_dot, &end.p, k);
        Excess { value: if to_positive { value } else { -value }, slope: None }
    };
    let line = search::search(asked, |length| solve_to(setup, length), excess)
        .map_err(|error| not_reached(error, &setup.place, setup.gamma_i))?;
    Ok(WorldLine { ended_by: Some(index), ..line })
}
