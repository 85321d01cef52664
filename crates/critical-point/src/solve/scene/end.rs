//! Runs that end where a coordinate reaches a value or a formula changes its sign: the length of γ at which the last
//! node is there.

use super::crossing::{self, Near};
use super::setup::SceneSetup;
use super::solve_to;
use crate::solve::Arithmetic;
use crate::solve::failure::{At, NoSolution};
use crate::solve::search::{self, Excess, NotFound, Search};
use crate::solve::status::Status;
use crate::solve::world_line::WorldLine;

/// The share of the length that counts as none has this many digits in `f64`; with more digits, all of them must agree.
const DOUBLE_DIGITS: u32 = 15;

/// The world-line that ends where `coordinate` is `value`.
pub(super) fn at_value<S: Arithmetic>(
    setup: &SceneSetup<S>,
    coordinate: usize,
    value: S,
) -> Result<WorldLine<S>, NoSolution> {
    let way = value - setup.place.start.q[coordinate];
    let length = if S::IS_EXTENDED {
        S::from(at_value::<f64>(&setup.in_f64(), coordinate, value.to_f64())?.length)
    } else {
        way / setup.place.start.q_dot[coordinate]
    };
    search(setup, length, S::from(f64::INFINITY), |line| Excess {
        value: (line.end().q[coordinate] - value) * way.signum(),
        slope: Some(line.end().q_dot[coordinate] * way.signum()),
    })
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
    let line = search(setup, length, whole, |line| {
        let end = line.end();
        let value = formula.at_here(&end.q, &end.q_dot, &end.p, k);
        Excess { value: if to_positive { value } else { -value }, slope: None }
    })?;
    Ok(WorldLine { ended_by: Some(index), ..line })
}

/// The world-line whose excess is 0, from a first guess of its length.
fn search<S: Arithmetic>(
    setup: &SceneSetup<S>,
    guess: S,
    limit: S,
    excess: impl FnMut(&WorldLine<S>) -> Excess<S>,
) -> Result<WorldLine<S>, NoSolution> {
    let digits = if S::IS_EXTENDED { setup.settings.digits } else { DOUBLE_DIGITS };
    let asked = Search { guess, limit, digits, digits_of_runs: setup.settings.digits, scale: None };
    search::search(asked, |length| solve_to(setup, length), excess).map_err(|error| match error {
        NotFound::Failed(failure) => failure,
        NotFound::Missed(closest) => {
            let gamma = closest.map_or(setup.gamma_i, |line| line.gamma_f());
            NoSolution::new(Status::EndTimeNotReached, At::scene(gamma.to_f64(), Vec::new()))
        }
    })
}
