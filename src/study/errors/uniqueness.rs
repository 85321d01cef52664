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
//! A force like √|x| has no jump, and leads away from 0 all the same, as it grows faster than any multiple of x.
//!
//! Source: A. F. Filippov, *Differential Equations with Discontinuous Righthand Sides* (1988), §10, on uniqueness at
//! surfaces where the right side jumps.

use super::evaluated::Evaluated;
use super::places::Seen;
use crate::case::Case;
use crate::geometry::{Arguments, Geometry, Side, Start};
use crate::number::ball::{Ball, OFF};
use crate::number::{Extended, Real};
use crate::solve::Setup;

/// A number is 0 if it is below this share of all rates: constants have some 71 digits.
const ZERO: f64 = 1e-60;
/// What ȧ changes by is looked at over this part of the length of a run, some way behind the state: what is 0 just
/// there, as t² from t = 0, may lead on in the next moment.
const STEP: f64 = 1e-25;
const BEHIND: f64 = 1e-8;
/// An acceleration is 0 below this share of all rates, as it is a difference over such a step.
const STILL: f64 = 1e-42;
/// More arguments than these are not 0 at one place by more than chance, and all of their sides are looked at.
const MOST: usize = 4;
/// A coordinate at 0 is moved by these: a force that grows like a power below 1 falls by less than they do.
const MOVED: [f64; 2] = [1e-50, 1e-60];
const SMOOTH: f64 = 1e-9;

/// γ at a state in which there may be several motions: the start of a run of this length, or one of those that are
/// `behind`, with the parameters that events have set before.
pub(crate) fn several_motions<S: Real>(
    case: &Case,
    setup: &Setup<S>,
    behind: impl Iterator<Item = (f64, Start, Vec<(usize, f64)>)>,
    length: f64,
) -> Option<f64> {
    if is_led_away_by_a_power(case, setup) {
        return Some(setup.gamma_i.to_f64());
    }
    setup.rough.geometry.jump()?;
    // The sides of a motion on its way back are not followed.
    if setup.is_backward {
        return None;
    }
    let first = if setup.carried.is_none() { case.start::<Extended>() } else { extended(&setup.rough.start) };
    if Surfaces::new(case)?.has_several_motions(&first, length) {
        return Some(setup.gamma_i.to_f64());
    }
    let mut others = behind.filter(|(_, here, set)| {
        let changed = if set.is_empty() { None } else { case.with_parameters(set, &here.q) };
        let surfaces = Surfaces::new(changed.as_ref().unwrap_or(case));
        surfaces.is_some_and(|surfaces| surfaces.has_several_motions(&extended(here), length))
    });
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
    /// Those of a case, if each of them can be followed by itself, and no table has knots.
    fn new(case: &'c Case) -> Option<Self> {
        let arguments = case.arguments().filter(|all| all.tables.iter().all(Option::is_none))?;
        Some(Self { case, arguments })
    }

    fn has_several_motions(&self, state: &Start<Extended>, length: f64) -> bool {
        self.ways(state, length).is_some_and(|ways| {
            let led = ways.iter().filter(|ways| ways.iter().all(|way| *way > 0.0)).count();
            // With one argument there are two sides: it is held where none pushes it to the other one.
            let is_held = ways.len() == 2 && ways.iter().all(|way| way[0] >= 0.0);
            led > 1 || led == 1 && is_held
        })
    }

    /// For each choice of sides of the arguments that are 0 in a state, which way each of these goes in the scene of
    /// these sides: 1 is to its own side, −1 away from it, and 0 neither. `None` if none is 0, or too many are.
    fn ways(&self, Start { q, p, .. }: &Start<Extended>, length: f64) -> Option<Vec<Vec<f64>>> {
        let Arguments { jets, .. } = &self.arguments;
        let ball = |value: &Extended| Ball::of(*value, OFF);
        let start = vec![Ball::exact(0.0); 2 * q.len()];
        let values = jets.at(&q.iter().chain(p).map(ball).chain(start).collect::<Vec<Ball>>());
        let is_zero = |value: Ball, size: f64| (value.hi + value.lo).abs() <= value.rad + ZERO * size;
        let size = q.iter().chain(p).fold(1.0, |size: f64, value| size.max(value.abs().to_f64()));
        let at: Vec<usize> = (0..values.len()).filter(|&k| is_zero(values[k].value, size)).collect();
        if at.is_empty() || at.len() > MOST {
            return None;
        }
        let mut sides: Vec<Side> =
            values.iter().map(|jet| if jet.value.hi > 0.0 { Side::Positive } else { Side::Negative }).collect();
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
        let (n, m) = (q.len(), sides.len());
        let geometry = self.case.watching(&[], (&[], sides), Extended::ZERO);
        let [q, p] = [q, p].map(|row| [row, &vec![Extended::ZERO; m]].concat());
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
        let way = |k: usize| match sign(here.q[n + k], ZERO) {
            0.0 => sign((next.q[n + k] - there.q[n + k]) / step, STILL),
            way => way,
        };
        Some((0..m).map(way).collect())
    }
}

/// True if a coordinate rests at 0 at the start, no force is on it, and one that grows like a power below 1 leads away.
fn is_led_away_by_a_power<S: Real>(case: &Case, setup: &Setup<S>) -> bool {
    let (geometry, Start { q, q_dot, p }) = (&setup.rough.geometry, &*setup.rough.start);
    if !q.iter().zip(q_dot).any(|(q, q_dot)| *q == 0.0 && *q_dot == 0.0) || !geometry.may_grow_like_a_root() {
        return false;
    }
    let place = Seen { q: q.clone(), p: p.clone(), set: Vec::new(), part: 0.0 };
    let Some(mut here) = Evaluated::new(case, setup, &place) else { return false };
    let (n, numbers) = (q.len(), q.iter().chain(p).map(|&value| Extended::from(value)).collect::<Vec<Extended>>());
    let rates = here.exact(&place, |k, _| numbers[k]);
    let rests =
        |a: &usize| rates[*a] == Extended::ZERO && rates[n + a] == Extended::ZERO && numbers[*a] == Extended::ZERO;
    let at_rest: Vec<usize> = (0..here.count).filter(rests).collect();
    at_rest.into_iter().any(|a| {
        [1.0, -1.0].into_iter().any(|side| {
            let [far, near] = MOVED.map(|by| {
                let by = Extended::from(side * by);
                let pushed = here.exact(&place, |k, _| if k == a { numbers[k] + by } else { numbers[k] });
                // With a little of its momentum it moves to where the force points.
                let little = Extended::from(STEP) * pushed[n + a];
                let moved = here.exact(&place, |k, _| match k {
                    k if k == a => numbers[k] + by,
                    k if k == n + a => numbers[k] + little,
                    k => numbers[k],
                });
                (Extended::from(side) * (moved[a] - pushed[a]) / Extended::from(STEP)).to_f64()
            });
            far > 0.0 && near > SMOOTH * far && near < 0.5 * far
        })
    })
}
