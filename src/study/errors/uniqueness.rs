//! Whether the motion from a start is the only one.
//!
//! On the top of V = −|x| a body at rest may stay, and it may leave to either side at any time: the force jumps there
//! and leads away from the place. All of these motions solve the equations, and a run shows one of them, with no error
//! that a finer run could see. So what rests at the start is moved by next to nothing, in 70 digits: a force that is
//! not next to nothing then leads away or back. Just at the place the force may be any between those on both sides.
//!
//! Source: A. F. Filippov, *Differential Equations with Discontinuous Righthand Sides* (1988), §10, on uniqueness at
//! surfaces where the right side jumps.

use super::evaluated::{Evaluated, PATTERNS, side};
use super::places::Seen;
use crate::case::Case;
use crate::geometry::Start;
use crate::number::{Extended, Real};
use crate::solve::Setup;

/// What rests is moved by this, relative to its value; of one that is 0 any unit will do.
const NEXT_TO_NOTHING: f64 = 1e-50;
/// A force that changes smoothly changes by less than this part of all rates then, even if its slope is 1e20 of them.
const JUMP: f64 = 1e-30;
/// What moves has gone on for so long before: at a surface that it leaves at once there is nothing to decide.
const LATER: f64 = 1e-20;

/// The first coordinate that may leave its place at the start of a run of `case`, or stay there, as a force jumps where
/// it rests and leads away.
pub(crate) fn may_stay_or_leave<S: Real>(case: &Case, setup: &Setup<S>) -> Option<String> {
    let geometry = &setup.rough.geometry;
    geometry.jump()?;
    let Start { q, p, .. } = &*setup.rough.start;
    let place = Seen { q: q.clone(), p: p.clone(), set: Vec::new(), part: 0.0 };
    let here = Evaluated::new(case, setup, &place)?;
    // A run that is continued has its doubles from there.
    let written = setup.carried.is_none().then(|| case.start::<Extended>().q);
    let exact = |(a, &value): (usize, &f64)| {
        let near = |q: &&Extended| (**q - Extended::from(value)).abs().to_f64() <= f64::EPSILON * value.abs();
        written.as_ref().and_then(|q| q.get(a)).filter(near).copied().unwrap_or(Extended::from(value))
    };
    let state: Vec<Extended> = q.iter().enumerate().map(exact).chain(p.iter().map(|&p| Extended::from(p))).collect();
    let a = AtRest::new(here, &place, state).leaves()?;
    Some(geometry.names()[a].clone())
}

/// A state a moment after the start, and the coordinates that rest in it.
struct AtRest<'s> {
    here: Evaluated,
    place: &'s Seen,
    state: Vec<Extended>,
    rests: Vec<usize>,
    /// What counts as nothing beside all rates there.
    nothing: Extended,
}

impl<'s> AtRest<'s> {
    fn new(mut here: Evaluated, place: &'s Seen, mut state: Vec<Extended>) -> Self {
        let n = place.q.len();
        let rates = here.exact(place, |k, _| state[k]);
        let rests = (0..here.count).filter(|&a| rates[a] == Extended::ZERO).collect();
        for a in 0..n {
            state[a] += Extended::from(LATER) * rates[a];
        }
        let rates = here.exact(place, |k, _| state[k]);
        let all = rates.iter().fold(Extended::ZERO, |sum, rate| sum + rate.abs());
        Self { here, place, state, rests, nothing: Extended::from(JUMP) * all }
    }

    /// The rates where these numbers are moved by so much.
    fn moved(&mut self, by: &[(usize, Extended)]) -> Vec<Extended> {
        let Self { here, place, state, .. } = self;
        let moved = |k: usize| by.iter().find(|(moved, _)| *moved == k).map_or(state[k], |(_, by)| state[k] + *by);
        here.exact(place, |k, _| moved(k))
    }

    /// The first coordinate of those that are moved, alone or all at once, and go on by themselves.
    fn leaves(&mut self) -> Option<usize> {
        let n = self.place.q.len();
        let unit = |k: usize| match self.state[k].abs() {
            value if value == Extended::ZERO => Extended::from(NEXT_TO_NOTHING),
            value => Extended::from(NEXT_TO_NOTHING) * value,
        };
        let alone = self.rests.iter().flat_map(|&a| [vec![(a, unit(a))], vec![(n + a, unit(n + a))]]);
        let all_at_once = (0..PATTERNS).map(|pattern| {
            let signed = |&a: &usize| (a, Extended::from(side(a, pattern)) * unit(a));
            self.rests.iter().map(signed).collect()
        });
        let ways: Vec<Vec<(usize, Extended)>> =
            all_at_once.chain(alone).filter(|way: &Vec<_>| !way.is_empty()).collect();
        let found = ways.into_iter().find(|way| self.leads_away(way))?;
        found.first().map(|(k, _)| k % n)
    }

    /// True if what was moved this way is led away on one side, and not led back on the other: then the place is left
    /// there, and a force between those on both sides holds it.
    fn leads_away(&mut self, way: &[(usize, Extended)]) -> bool {
        let back: Vec<_> = way.iter().map(|&(k, by)| (k, -by)).collect();
        let nothing = self.nothing;
        let [on, back] = [way, &back].map(|way| self.least(way));
        let (least, most) = if on < back { (on, back) } else { (back, on) };
        most > nothing && least > -nothing
    }

    /// The least acceleration, in the direction in which each was moved, of coordinates that were moved by so much, or
    /// the least force on momenta.
    fn least(&mut self, way: &[(usize, Extended)]) -> Extended {
        let n = self.place.q.len();
        let rates = self.moved(way);
        let by = |k: usize| way.iter().find(|(moved, _)| *moved == k).map_or(Extended::ZERO, |(_, by)| *by);
        let later: Vec<_> = (0..2 * n).map(|k| (k, by(k) + Extended::from(LATER) * rates[k])).collect();
        let next = self.moved(&later);
        let along = way.iter().map(|&(k, by)| {
            let pushed = if k < n { (next[k] - rates[k]) / Extended::from(LATER) } else { rates[k] };
            if pushed.is_finite() { by.signum() * pushed } else { -Extended::ONE }
        });
        along.reduce(|least, along| if along < least { along } else { least }).unwrap_or(Extended::ZERO)
    }
}
