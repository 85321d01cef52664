//! Runs that end where a coordinate reaches a value: the length of γ at which it does at the last node.

use super::failure::NoWorldLine;
use super::run::solve_to;
use super::setup::SceneSetup;
use super::world_line::WorldLine;
use crate::scalar::Real;
use crate::solve::refinement;
use crate::solve::status::Status;

/// Solves allowed for the search; Newton's method needs about five.
const MOST_SOLVES: usize = 60;
/// The difference that counts as none, relative to the way to the value, in `f64`; with more digits, all must agree.
const DOUBLE_DIGITS: u32 = 14;
/// Where rounding ends the search first, this many digits fewer than requested are enough.
const SPARE_DIGITS: u32 = 4;

/// Newton's method on the length with dq/dγ at the end of each solution, kept inside the bracket found so far.
pub(super) fn solve<S: Real>(
    setup: &SceneSetup<S>,
    coordinate: usize,
    value: S,
    within: Option<S>,
) -> Result<WorldLine<S>, NoWorldLine> {
    let way = value - setup.place.start.q[coordinate];
    let digits = if S::IS_EXTENDED { setup.digits } else { DOUBLE_DIGITS };
    let tolerance = refinement::tolerance::<S>(digits) * way.abs();
    let loose = refinement::tolerance::<S>(setup.digits - SPARE_DIGITS) * way.abs();
    let mut length = if S::IS_EXTENDED {
        let within = within.map(S::to_f64);
        S::from(solve::<f64>(&setup.in_f64(), coordinate, value.to_f64(), within)?.length)
    } else {
        way / setup.place.start.q_dot[coordinate]
    };
    let limit = within.unwrap_or(S::from(f64::INFINITY));
    let (mut below, mut above) = (S::ZERO, limit);
    let mut best: Option<(S, WorldLine<S>)> = None;
    let mut failure = None;
    for _ in 0..MOST_SOLVES {
        if !(length > below && length < above) {
            // No upper bound yet: the run is longer than any tried.
            length = if above.is_finite() { (below + above).half() } else { below + below };
        }
        if length <= below || length >= above || !length.is_finite() {
            break;
        }
        match solve_to(setup, length) {
            Ok(line) => {
                let excess = line.end().q[coordinate] - value;
                let slope = line.end().q_dot[coordinate];
                if excess * way.signum() < S::ZERO { below = length } else { above = length }
                let improved = best.as_ref().is_none_or(|(least, _)| excess.abs() < *least);
                if improved {
                    best = Some((excess.abs(), line));
                }
                let least = best.as_ref().map_or(S::from(f64::INFINITY), |(least, _)| *least);
                if least <= tolerance || (!improved && least <= loose) {
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
    }
    match (best, failure) {
        (Some((excess, line)), _) if excess <= loose => Ok(line),
        (_, Some(failure)) => Err(failure),
        (best, None) => {
            let gamma = best.map_or(setup.gamma_i, |(_, line)| line.gamma_f());
            Err(NoWorldLine::at(Status::EndTimeNotReached, gamma.to_f64()))
        }
    }
}
