//! States from which there are several motions.
//!
//! On the top of V = −|x| a body at rest may stay, and it may leave to either side at any time: the force jumps there
//! and leads away from the place. All of these motions solve the equations, and a run shows one of them, with no error
//! that a finer run could see.
//!
//! So the arguments a of abs, sign and step are looked at in 71 digits: where some are 0, and the motion does not pass
//! there, as ȧ is 0 on both sides, ä tells for each side whether a motion leads on there. If it does on two, or on one
//! while a force between those on both sides could hold it, there are several motions. On each side all is smooth, so
//! that ä is what ȧ changes by on the way of that side.
//!
//! On the way back friction leads away from rest: what rests now may have moved before.
//!
//! A force like √|x| has no jump, and leads away from 0 all the same, as it grows faster than any multiple of x.
//!
//! Source: A. F. Filippov, *Differential Equations with Discontinuous Righthand Sides* (1988), §10, on uniqueness at
//! surfaces where the right side jumps.

use super::evaluated::Evaluated;
use super::places::Seen;
use crate::case::Case;
use crate::geometry::{Arguments, Geometry, Jet, Side, Start};
use crate::number::ball::{Ball, OFF};
use crate::number::spline::Table;
use crate::number::{Extended, Real};
use crate::solve::Setup;

/// A number is 0 if it is below this share of all rates: constants have some 71 digits.
const ZERO: f64 = 1e-60;
/// The same of an argument in a state in doubles, which may be beside a surface that is no double.
const OF_DOUBLES: f64 = 4.0 * f64::EPSILON;
/// What ȧ changes by is looked at over this part of the length of a run, some way behind the state: what is 0 just
/// there, as t² from t = 0, may lead on in the next moment.
const STEP: f64 = 1e-25;
const BEHIND: f64 = 1e-8;
/// An acceleration is 0 below this share of all rates, as it is a difference over such a step.
const STILL: f64 = 1e-42;
/// More arguments than these are not 0 at one place by more than chance, and all of their sides are looked at.
const MOST: usize = 4;
/// A coordinate at rest is moved by these: a force that grows like a power below 1 falls by less than they do, by this
/// part of their powers of ten at least, as numbers of 71 digits tell.
const MOVED: [f64; 3] = [1e-40, 1e-50, 1e-60];
const BELOW_ONE: f64 = 1e-6;
/// A force like x ln|x|, from which there is one motion, comes the nearer to x the smaller x is: what its power lacks
/// to 1 falls like 1/ln|x| at least, from the first two of these to the last two to 0.82 of it.
const STAYS: f64 = 0.9;

/// γ at a state in which there may be several motions: the start of a run of this length, or one of those that are
/// `behind`, with the parameters that events have set before.
pub(crate) fn several_motions<S: Real>(
    case: &Case,
    setup: &Setup<S>,
    behind: impl Iterator<Item = (f64, Start, Vec<(usize, f64)>)>,
    length: f64,
) -> Option<f64> {
    let geometry = &setup.rough.geometry;
    let (jumps, grows) = (geometry.jump().is_some(), geometry.may_grow_like_a_root());
    if !jumps && !grows {
        return None;
    }
    let has_several = |here: &Start<Extended>, set: &[(usize, f64)], zero: f64| {
        let changed = if set.is_empty() || !jumps { None } else { case.with_parameters(set, &here.in_f64().q) };
        let surfaces = if jumps { Surfaces::new(changed.as_ref().unwrap_or(case)) } else { None };
        // Where arguments stand in others, states beside the place tell as much as can be told: a jump is a power of 0.
        let by_power = grows || jumps && surfaces.is_none();
        by_power && is_led_away_by_a_power((case, setup), here, set)
            || surfaces.is_some_and(|surfaces| surfaces.has_several_motions((here, zero), length))
    };
    let first = match setup.carried {
        None if setup.is_backward => case.start::<Extended>().reversed(),
        None => case.start::<Extended>(),
        Some(_) => extended(&setup.rough.start),
    };
    let zero = if setup.carried.is_none() { ZERO } else { OF_DOUBLES };
    if has_several(&first, &[], zero) {
        return Some(setup.gamma_i.to_f64());
    }
    let mut others = behind.filter(|(_, here, set)| has_several(&extended(here), set, OF_DOUBLES));
    others.next().map(|(gamma, ..)| gamma)
}

fn extended(Start { q, q_dot, p }: &Start) -> Start<Extended> {
    let [q, q_dot, p] = [q, q_dot, p].map(|row| row.iter().map(|&value| Extended::from(value)).collect());
    Start { q, q_dot, p }
}

/// The rates of a state, q̇^a and ṗ_a, the arguments last among the coordinates.
struct Rates {
    q: Vec<Extended>,
    p: Vec<Extended>,
}

impl Rates {
    fn new(geometry: &Geometry<Extended>, [q, p]: [&[Extended]; 2]) -> Option<Self> {
        let mut point = geometry.point();
        point.evaluate(q, p).ok()?;
        let mut rates = vec![Extended::ZERO; q.len()];
        geometry.active().iter().enumerate().for_each(|(place, &a)| rates[a] = point.p_dot(place));
        Some(Self { q: (0..q.len()).map(|a| point.q_dot(a)).collect(), p: rates })
    }

    /// The state after a step of γ.
    fn after(&self, [q, p]: [&[Extended]; 2], step: Extended) -> [Vec<Extended>; 2] {
        let go = |from: &[Extended], rates: &[Extended]| from.iter().zip(rates).map(|(x, v)| *x + step * *v).collect();
        [go(q, &self.q), go(p, &self.p)]
    }
}

/// The places where abs, sign and step of a case change.
struct Surfaces<'c> {
    case: &'c Case,
    arguments: Arguments,
}

impl<'c> Surfaces<'c> {
    /// Those of a case, if each of them can be followed by itself.
    fn new(case: &'c Case) -> Option<Self> {
        Some(Self { case, arguments: case.arguments()? })
    }

    fn has_several_motions(&self, state: (&Start<Extended>, f64), length: f64) -> bool {
        self.ways(state, length).is_some_and(|ways| {
            let led = ways.iter().filter(|ways| ways.iter().all(|way| *way > 0.0)).count();
            // With one argument there are two sides: it is held where none pushes it to the other one.
            let is_held = ways.len() == 2 && ways.iter().all(|way| way[0] >= 0.0);
            led > 1 || led == 1 && is_held
        })
    }

    /// For each choice of sides of the arguments that are 0 in a state, which way each of these goes in the scene of
    /// these sides: 1 is to its own side, −1 away from it, and 0 neither. `None` if none is 0, up to this share of all
    /// numbers, or too many are.
    fn ways(&self, (Start { q, p, .. }, zero): (&Start<Extended>, f64), length: f64) -> Option<Vec<Vec<f64>>> {
        let Arguments { jets, tables } = &self.arguments;
        let ball = |value: &Extended| Ball::of(*value, OFF);
        let start = vec![Ball::exact(0.0); 2 * q.len()];
        let values = jets.at(&q.iter().chain(p).map(ball).chain(start).collect::<Vec<Ball>>());
        let is_zero = |value: Ball, size: f64| (value.hi + value.lo).abs() <= value.rad + zero * size;
        let size = q.iter().chain(p).fold(1.0, |size: f64, value| size.max(value.abs().to_f64()));
        let is_at = |&k: &usize| tables[k].is_none() && is_zero(values[k].value, size);
        let at: Vec<usize> = (0..values.len()).filter(is_at).collect();
        if at.is_empty() || at.len() > MOST {
            return None;
        }
        // No force jumps at a knot, and either of the pieces that meet there tells what it is.
        let side = |(jet, table): (&Jet, &Option<Table>)| match table {
            Some(table) => table.piece(jet.value.hi).map(Side::Piece),
            None => Some(if jet.value.hi > 0.0 { Side::Positive } else { Side::Negative }),
        };
        let mut sides: Vec<Side> = values.iter().zip(tables).map(side).collect::<Option<_>>()?;
        (0..1_usize << at.len())
            .map(|choice| {
                let is_up = |place: usize| choice >> place & 1 == 1;
                for (place, &k) in at.iter().enumerate() {
                    sides[k] = if is_up(place) { Side::Positive } else { Side::Negative };
                }
                let ways = self.ways_on(&sides, [q, p], length)?;
                let own = |(place, &k): (usize, &usize)| if is_up(place) { ways[k] } else { -ways[k] };
                Some(at.iter().enumerate().map(own).collect())
            })
            .collect()
    }

    /// The signs of ȧ, or of ä where ȧ is 0, of all arguments in the scene of these sides.
    fn ways_on(&self, sides: &[Side], [q, p]: [&[Extended]; 2], length: f64) -> Option<Vec<f64>> {
        let (n, geometry) = (q.len(), self.case.watching(&[], (&[], sides), Extended::ZERO));
        // A table has two ends, the knots of a piece.
        let ends = |side: &Side| if let Side::Piece(_) = side { 2 } else { 1 };
        let first = |k: usize| n + sides[..k].iter().map(ends).sum::<usize>();
        let [q, p] = [q, p].map(|row| [row, &vec![Extended::ZERO; first(sides.len()) - n]].concat());
        let here = Rates::new(&geometry, [&q, &p])?;
        let all = here.q[..n].iter().chain(&here.p).fold(Extended::ZERO, |sum, rate| sum + rate.abs());
        let [behind, step] = [BEHIND, STEP].map(|part| Extended::from(part * length));
        let [q, p] = here.after([&q, &p], behind);
        let there = Rates::new(&geometry, [&q, &p])?;
        let [q, p] = there.after([&q, &p], step);
        let next = Rates::new(&geometry, [&q, &p])?;
        let sign = |value: Extended, least: f64| match value.abs() > Extended::from(least) * all {
            true => value.signum().to_f64(),
            false => 0.0,
        };
        let way = |k: usize| match sign(here.q[k], ZERO) {
            0.0 => sign((next.q[k] - there.q[k]) / step, STILL),
            way => way,
        };
        Some((0..sides.len()).map(|k| way(first(k))).collect())
    }
}

/// True if a coordinate rests in a state, where events have set these parameters, no force is on it there, and one that
/// grows like a power below 1 leads away.
fn is_led_away_by_a_power<S: Real>(
    (case, setup): (&Case, &Setup<S>),
    here: &Start<Extended>,
    set: &[(usize, f64)],
) -> bool {
    let Start { q, q_dot, p } = here.in_f64();
    if q_dot.iter().all(|&rate| rate != 0.0) {
        return false;
    }
    let place = Seen { q, p, set: set.to_vec(), part: 0.0 };
    let Some(mut rates) = Evaluated::new(case, setup, &place) else { return false };
    let (n, count) = (here.q.len(), rates.count);
    let numbers: Vec<Extended> = here.q.iter().chain(&here.p).copied().collect();
    // The rates where some of these numbers are changed.
    let mut at = |changes: &[(usize, Extended)]| {
        let change = |k: usize| changes.iter().filter(|(place, _)| *place == k).fold(numbers[k], |sum, c| sum + c.1);
        rates.exact(&place, |k, _| change(k))
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
