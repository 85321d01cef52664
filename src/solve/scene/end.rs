//! Runs that end where a coordinate reaches a value or a formula changes its sign: the length of γ at which the last node
//! is there.

use super::crossing;
use super::failure::NoWorldLine;
use super::run::solve_to;
use super::setup::{SceneSetup, Until};
use super::world_line::WorldLine;
use crate::scalar::Real;
use crate::solve::refinement;
use crate::solve::status::Status;

/// Solves allowed for the search; Newton's method needs about five.
const MOST_SOLVES: usize = 60;
/// The share of the length that counts as none, in `f64`; with more digits, all of them must agree.
const DOUBLE_DIGITS: u32 = 15;
/// Where rounding ends the search first, this many digits fewer than requested are enough.
const SPARE_DIGITS: u32 = 4;

/// The world-line that ends where `coordinate` is `value`.
pub(super) fn at_value<S: Real>(
    setup: &SceneSetup<S>,
    coordinate: usize,
    value: S,
) -> Result<WorldLine<S>, NoWorldLine> {
    let way = value - setup.place.start.q[coordinate];
    let length = if S::IS_EXTENDED {
        S::from(at_value::<f64>(&setup.in_f64(), coordinate, value.to_f64())?.length)
    } else {
        way / setup.place.start.q_dot[coordinate]
    };
    // Positive beyond the end.
    let excess = |line: &WorldLine<S>| (line.end().q[coordinate] - value) * way.signum();
    let slope = |line: &WorldLine<S>| Some(line.end().q_dot[coordinate] * way.signum());
    search(setup, length, S::from(f64::INFINITY), excess, slope)
}

/// The world-line that ends where the formula of the setup first changes its sign, or after the length `whole`.
pub(super) fn until<S: Real>(setup: &SceneSetup<S>, whole: S) -> Result<WorldLine<S>, NoWorldLine> {
    let Some(Until { formula, rough }) = &setup.until else { return solve_to(setup, whole) };
    let Some(near) = crossing::first(setup, rough, whole.to_f64()) else { return solve_to(setup, whole) };
    let length =
        if S::IS_EXTENDED { S::from(until::<f64>(&setup.in_f64(), whole.to_f64())?.length) } else { near.into() };
    let start = &setup.place.start;
    let k = setup.place.geometry.norm(&start.q, &start.q_dot);
    let mut formula = formula.clone();
    let side = S::from(crossing::side_before(setup, rough));
    let excess = |line: &WorldLine<S>| {
        let end = line.end();
        -side * formula.at(&end.q, &end.q_dot, &end.p, k)
    };
    search(setup, length, whole, excess, |_| None)
}

/// Looks for the length at which `excess` changes its sign from minus to plus: by Newton's method with `slope` or, where
/// there is none, by secants, kept inside the bracket found so far. A length that has no solution (a horizon on the way)
/// is an upper bound like one that is too long.
fn search<S: Real>(
    setup: &SceneSetup<S>,
    guess: S,
    limit: S,
    mut excess: impl FnMut(&WorldLine<S>) -> S,
    slope: impl Fn(&WorldLine<S>) -> Option<S>,
) -> Result<WorldLine<S>, NoWorldLine> {
    let digits = if S::IS_EXTENDED { setup.digits } else { DOUBLE_DIGITS };
    let [tolerance, loose] = [digits, setup.digits.min(digits) - SPARE_DIGITS].map(refinement::tolerance::<S>);
    let (mut length, mut below, mut above) = (guess, S::ZERO, limit);
    let mut best: Option<(S, WorldLine<S>)> = None;
    let mut failure = None;
    // The last length and excess, for secants.
    let mut last: Option<(S, S)> = None;
    for _ in 0..MOST_SOLVES {
        if !(length > below && length <= above) {
            // No upper bound yet: the run is longer than any tried.
            length = if above.is_finite() { (below + above).half() } else { below + below };
        }
        if length <= below || length > above || !length.is_finite() {
            break;
        }
        let line = match solve_to(setup, length) {
            Ok(line) => line,
            Err(error) => {
                above = length;
                failure = Some(error);
                length = below;
                continue;
            }
        };
        let here = excess(&line);
        if here < S::ZERO {
            below = length
        } else {
            above = length
        }
        // Without two points the step of a secant is a small part of the length.
        let share = S::from(1e-6);
        let step = match (slope(&line), last) {
            (Some(slope), _) => here / slope,
            (None, Some((before, value))) if value != here => here * (length - before) / (here - value),
            (None, Some(_)) => S::ZERO,
            (None, None) => {
                if here < S::ZERO {
                    -share * length
                } else {
                    share * length
                }
            }
        };
        last = Some((length, here));
        let improved = best.as_ref().is_none_or(|(least, _)| step.abs() < *least);
        if improved {
            best = Some((step.abs(), line));
        }
        let least = best.as_ref().map_or(step.abs(), |(least, _)| *least);
        if least <= tolerance * length || (!improved && least <= loose * length) || above - below <= tolerance * length
        {
            break;
        }
        length += -step;
    }
    match (best, failure) {
        (Some((step, line)), _) if step <= loose * line.length => Ok(line),
        (_, Some(failure)) => Err(failure),
        (best, None) => {
            let gamma = best.map_or(setup.gamma_i, |(_, line)| line.gamma_f());
            Err(NoWorldLine::at(Status::EndTimeNotReached, gamma.to_f64()))
        }
    }
}
