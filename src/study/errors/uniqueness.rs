//! States from which there are several motions.
//!
//! On the top of V = −|x| a body at rest may stay, and it may leave to either side at any time: the force jumps there
//! and leads away from the place. All of these motions solve the equations, and a run shows one of them, with no error
//! that a finer run could see. Motions that begin beside such a state part at once, see [`beside`](super::beside).
//!
//! The start is looked at in 71 digits, since a surface need be no double; the end, what events leave, and where a run
//! comes in short windows, as it does beside a surface, are off by rounding.
//!
//! On the way back friction leads away from rest: what rests now may have moved before.
//!
//! A force like √|x| has no jump, and leads away from 0 all the same, as it grows faster than any multiple of x.
//!
//! Source: A. F. Filippov, *Differential Equations with Discontinuous Righthand Sides* (1988), §10, on uniqueness at
//! surfaces where the right side jumps.

use super::beside::part_at_once;
use super::evaluated::{Evaluated, at_point};
use super::places::Seen;
use super::sights::Sights;
use crate::case::Case;
use crate::geometry::Start;
use crate::number::{Extended, Real};
use crate::solve::Setup;

/// Motions begin so far beside the start, relative to the sizes of its numbers: a difference that 71 digits show, and
/// of which the seventh power is a number.
const BESIDE: f64 = 1e-40;
/// The same of a state in doubles, which may be beside a surface that is no double.
const OF_DOUBLES: f64 = 4.0 * f64::EPSILON;
/// They are followed for these parts of a window: what forces make of them is the square of it at least, far more than
/// they are off by, and what they grow by is next to nothing.
const MOMENT: f64 = 1e-4;
const OF_DOUBLES_MOMENT: f64 = 1e-3;
/// In short windows they are followed for so many times their length, and for this part of a mean window at least:
/// what a high jump does while a motion passes it is none of what the motion may do.
const TURNED: f64 = 4.0;
const PASSED: f64 = 1e-7;
/// The velocity that a momentum makes is looked at with one so large.
const STEP: f64 = 1e-25;
/// A coordinate at rest is moved by these: a force that grows like a power below 1 falls by less than they do, by this
/// part of their powers of ten at least, as numbers of 71 digits tell.
const MOVED: [f64; 3] = [1e-40, 1e-50, 1e-60];
const BELOW_ONE: f64 = 1e-6;
/// A force like x ln|x|, from which there is one motion, comes the nearer to x the smaller x is: what its power lacks
/// to 1 falls like 1/ln|x| at least, from the first two of these to the last two to 0.82 of it.
const STAYS: f64 = 0.9;

/// γ at a state in which there may be several motions: the start of a run of which this was seen, with windows of this
/// mean length, one of those that are `behind`, with the parameters that events have set before, or where it came in
/// short windows.
pub(crate) fn several_motions<S: Real>(
    (case, setup): (&Case, &Setup<S>),
    sights: &Sights,
    behind: impl Iterator<Item = (f64, Start, Vec<(usize, f64)>)>,
    window: f64,
) -> Option<f64> {
    let geometry = &setup.rough.geometry;
    let (jumps, grows) = (geometry.jump().is_some(), geometry.may_grow_like_a_root());
    if !jumps && !grows {
        return None;
    }
    let first = match setup.carried {
        None if setup.is_backward => case.start::<Extended>().reversed(),
        None => case.start::<Extended>(),
        Some(_) => extended(&setup.rough.start),
    };
    let mut here = None;
    let mut has_several = |start: &Start<Extended>, set: &[(usize, f64)], is_exact: bool| {
        let Start { q, q_dot, p } = start.in_f64();
        let seen = Seen { q, p, set: set.to_vec(), part: 0.0 };
        let Some(rates) = Evaluated::where_set(&mut here, (case, setup), &seen) else { return false };
        grows && is_led_away_by_a_power(rates, &seen, (start, &q_dot))
            || jumps && motions_part(rates, (start, &seen), sights, (window, is_exact))
    };
    if has_several(&first, &[], setup.carried.is_none()) {
        return Some(setup.gamma_i.to_f64());
    }
    let mut behind = behind;
    let found = behind.find(|(_, start, set)| has_several(&extended(start), set, false));
    found.map(|(gamma, ..)| gamma).or_else(|| {
        let mut short = sights.places.short();
        let mut part = |seen: &Seen| {
            let rates = Evaluated::where_set(&mut here, (case, setup), seen);
            // Where it turned is known to the length of the window there. What just passes has passed in a moment.
            let moment = (TURNED * seen.part).max(PASSED * window);
            rates.is_some_and(|rates| motions_part_in_doubles(rates, seen, sights, moment))
        };
        short.find(|(_, seen)| jumps && part(seen)).map(|(gamma, _)| *gamma)
    })
}

/// True if motions from beside a state part at once: beside it in 71 digits, if it `is_exact`, or in doubles.
fn motions_part(
    rates: &mut Evaluated,
    (Start { q, p, .. }, seen): (&Start<Extended>, &Seen),
    sights: &Sights,
    (window, is_exact): (f64, bool),
) -> bool {
    if !is_exact {
        return motions_part_in_doubles(rates, seen, sights, OF_DOUBLES_MOMENT * window);
    }
    let off = sights.places.sizes(seen).map(|size| BESIDE * size).collect::<Vec<_>>();
    let state = [&q[..], &p[..]].concat();
    part_at_once(|q, p| Some(rates.exact_at(q, p)), &state, &off, MOMENT * window)
}

fn motions_part_in_doubles(rates: &Evaluated, seen: &Seen, sights: &Sights, moment: f64) -> bool {
    let off = sights.places.sizes(seen).map(|size| OF_DOUBLES * size).collect::<Vec<_>>();
    let (mut point, state) = (rates.rough.point(), [&seen.q[..], &seen.p[..]].concat());
    part_at_once(|q, p| at_point(&rates.rough, &mut point, [q, p]), &state, &off, moment)
}

fn extended(Start { q, q_dot, p }: &Start) -> Start<Extended> {
    let [q, q_dot, p] = [q, q_dot, p].map(|row| row.iter().map(|&value| Extended::from(value)).collect());
    Start { q, q_dot, p }
}

/// True if a coordinate rests in a state, no force is on it there, and one that grows like a power below 1 leads away.
fn is_led_away_by_a_power(rates: &mut Evaluated, seen: &Seen, (here, q_dot): (&Start<Extended>, &[f64])) -> bool {
    if q_dot.iter().all(|&rate| rate != 0.0) {
        return false;
    }
    let (n, count) = (here.q.len(), rates.count);
    let numbers: Vec<Extended> = here.q.iter().chain(&here.p).copied().collect();
    // The rates where some of these numbers are changed.
    let mut at = |changes: &[(usize, Extended)]| {
        let change = |k: usize| changes.iter().filter(|(place, _)| *place == k).fold(numbers[k], |sum, c| sum + c.1);
        rates.exact(seen, |k, _| change(k))
    };
    let still = at(&[]);
    let little = Extended::from(STEP);
    (0..count).filter(|a| still[*a] == Extended::ZERO && still[n + a] == Extended::ZERO).any(|a| {
        [1.0, -1.0].into_iter().any(|side| {
            let size = numbers[a].abs().to_f64().max(1.0);
            // The acceleration to this side: what its momentum makes of its velocity, times the force on it.
            let forces = MOVED.map(|by| {
                let moved = (a, Extended::from(side * by * size));
                let [pushed, moving] = [at(&[moved]), at(&[moved, (n + a, little)])];
                (Extended::from(side) * pushed[n + a] * (moving[a] - pushed[a]) / little).to_f64()
            });
            let lacks = [0, 1].map(|k| 1.0 - (forces[k] / forces[k + 1]).log10() / (MOVED[k] / MOVED[k + 1]).log10());
            forces.iter().all(|force| *force > 0.0) && lacks[0] > BELOW_ONE && lacks[1] >= STAYS * lacks[0]
        })
    })
}
