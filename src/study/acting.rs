//! Runs with events that act: a chain of runs, each of which starts from what an event has made of the end of the one
//! before.
//!
//! An error before an event becomes one after it, by an error of the time of the event too. So a second chain, with a
//! hundred times the tolerance, meets the events by itself, and the distance of the two is the error, as that of two
//! marches is ([`Rounds`]). Its states are shaken by their last digits, as chains may round alike.

use std::sync::Arc;

use super::errors::{RunError, chain_error, sizes_of};
use crate::case::Case;
use crate::engine::{Accuracy, Handed, Rounds};
use crate::geometry::{Direction, Saltation, Start};
use crate::number::Extended;
use crate::number::Real;
use crate::number::norm::larger;
use crate::solve::{
    Beginning, Carried, Change, LastEvent, Limit, MOST_EVENTS, NoSolution, Place, Quantity, Setup, Slack, Status,
    Unfinished, Until, WorldLine, solve_observed,
};
use crate::trajectory::{Sample, Sampler};

/// The coarse chain is shaken by this, relative to every number of the state.
const SHAKE: f64 = 2.0 * f64::EPSILON;
/// Two chains may round alike: errors are taken to be so many times their difference.
pub(super) const MARGIN: f64 = 2.0;
/// A piece is not resolved if it is shorter than this multiple of the rounding of γ,
const SHORT: f64 = 64.0 * f64::EPSILON;
/// or if the formula of its event is below this multiple of rounding at these fractions of it: at one of them it may
/// just pass zero.
const LOW: f64 = 64.0;
const INSIDE: [f64; 3] = [0.27, 0.5, 0.66];
/// So many pieces in turn that are not resolved end a run whose events are not the same.
const IN_TURN: usize = 16;

/// A piece of a run, from one event to the next.
#[derive(Debug)]
pub struct Piece<S: Real = f64> {
    /// Its world-line, whose γ counts from its own start.
    pub line: WorldLine<S>,
    /// The setup that it solves.
    pub setup: Setup<S>,
    /// The places in [`Setup::until`] of the events that acted at its end.
    pub acted: Vec<usize>,
}

/// A run that did not come to its end.
#[derive(Debug)]
pub struct Stopped<S: Real = f64> {
    /// The reason.
    pub failure: NoSolution,
    /// The pieces before, and the last one as far as it came.
    pub pieces: Vec<Piece<S>>,
}

impl<S: Real> Stopped<S> {
    /// A run that ended in the piece of `setup` behind these pieces.
    pub(super) fn at(unfinished: Unfinished<S>, setup: Setup<S>, mut pieces: Vec<Piece<S>>) -> Box<Self> {
        let Unfinished { failure, line } = unfinished;
        if let Some(mut line) = line {
            add_up(&mut line, pieces.last());
            pieces.push(Piece { line, setup, acted: Vec::new() });
        }
        Box::new(Self { failure, pieces })
    }
}

/// A run in pieces, one if no event acts.
#[derive(Debug)]
pub struct Chains<S: Real = f64> {
    /// The pieces.
    pub pieces: Vec<Piece<S>>,
    /// The error of a run with several.
    pub error: Option<RunError>,
    /// The pieces of the chain that judges it, which differ from it by half of its error; none without one.
    pub coarser: Vec<Piece<S>>,
}

impl<S: Real> Chains<S> {
    /// Pieces that no other chain judges.
    pub(super) fn alone(pieces: Vec<Piece<S>>) -> Self {
        Self { pieces, error: None, coarser: Vec::new() }
    }
}

/// Solves the setup of a case with events that act, to its accuracy or its tolerance.
///
/// # Errors
/// [`Stopped`], if the run does not come to its end, or not as accurately as was asked for.
///
/// # Panics
/// If the setup has neither an accuracy nor a tolerance.
pub fn solve_acting(case: &Case, setup: &Setup) -> Result<Chains, Box<Stopped>> {
    let wanted = setup.settings.accuracy.expect("events act in runs to an accuracy");
    if !setup.settings.is_judged {
        return chain(case, setup, wanted, false).map(Chains::alone);
    }
    let mut round = Rounds::new(wanted);
    let mut pieces = chain(case, setup, round.marches()[1], false)?;
    let mut least = f64::INFINITY;
    loop {
        let coarser = chain(case, setup, round.marches()[0], true).ok();
        let found = coarser.as_ref().and_then(|coarser| chain_error(&pieces, coarser, (MARGIN, &round)));
        let distance = found.as_ref().map_or(f64::INFINITY, |found| found.distance);
        let estimate = round.error(distance);
        least = least.min(estimate);
        if round.allows(estimate) {
            let sizes = sizes_of(&pieces);
            let line = &mut pieces.last_mut().expect("a chain has pieces").line;
            line.sizes = sizes;
            (line.accuracy, line.error_estimate) = (Some(wanted), Some(estimate));
            line.good_until = found.as_ref().map_or(line.good_until.map(|_| 0.0), |found| found.good_until);
            let (error, coarser) = (found.map(|found| found.error), coarser.unwrap_or_default());
            return Ok(Chains { pieces, error, coarser });
        }
        let next = round.next(distance);
        match next.map(|next| chain(case, setup, next.marches()[1], false)) {
            Some(Ok(finer)) => pieces = finer,
            _ => {
                let last = pieces.iter().rev().find_map(|piece| piece.acted.last().copied());
                let failure = failed(setup, Status::AccuracyNotReached, &pieces, last);
                let failure = NoSolution { residual: least, needed: least, asked: wanted.value(), ..failure };
                return Err(Box::new(Stopped { failure, pieces }));
            }
        }
        round = next.expect("a finer chain was solved");
    }
}

/// The failure of a run at the end of its last piece, where the event `place` was the last one.
fn failed(setup: &Setup, status: Status, pieces: &[Piece], place: Option<usize>) -> NoSolution {
    let line = &pieces.last().expect("a chain has pieces").line;
    let change = place.and_then(|place| setup.until[place].change.as_ref());
    let name = change.map_or_else(String::new, |change| change.name.clone());
    let event = LastEvent { name, count: pieces.iter().map(|piece| piece.acted.len()).sum() };
    NoSolution::at_event(status, &setup.place.geometry, line.gamma_f(), &line.end().q, event)
}

/// The pieces of a run to an accuracy, each to it by itself. A chain that `is_shaken` is off by its last digits
/// at every event.
pub(super) fn chain(
    case: &Case,
    setup: &Setup,
    accuracy: Accuracy,
    is_shaken: bool,
) -> Result<Vec<Piece>, Box<Stopped>> {
    let (mut pieces, mut here): (Vec<Piece>, _) = (Vec::new(), setup.clone());
    here.settings.accuracy = Some(accuracy);
    here.settings.sensitivity &= !is_shaken;
    let saltations = saltations(case, &here);
    here.sides = sides_at(setup, &setup.place.start, setup.reach(), &[]).iter().map(Beginning::known).collect();
    let (mut unresolved, mut count) = (0, 0);
    loop {
        let mut line = match solve_observed(&here, None, None) {
            Ok(line) => line,
            Err(unfinished) => return Err(Stopped::at(*unfinished, here, pieces)),
        };
        add_up(&mut line, pieces.last());
        let (met, at_end) = met(&here, &line);
        let acting = |place: &&usize| here.until[**place].change.is_some();
        let (ending, first) = (met.iter().find(|place| !acting(place)), met.iter().find(acting));
        let (None, Some(&first), Some(limit)) = (ending, first, rest_of(&here, &line)) else {
            // What acts at the end of the run changes nothing.
            line.ended_by = ending.copied();
            pieces.push(Piece { line, setup: here, acted: Vec::new() });
            return Ok(pieces);
        };
        let is_short = line.length <= SHORT * line.gamma_f().abs().max(line.gamma_i.abs());
        unresolved = if is_short { unresolved + 1 } else { 0 };
        let is_longer = |before: &Piece| before.acted.contains(&first) && line.length < before.line.length;
        let shrinks_again = pieces.last().is_some_and(is_longer);
        let piles_up = unresolved > IN_TURN
            || shrinks_again && (unresolved > 0 || is_low(&here, &line, first))
            || count >= MOST_EVENTS;
        let changed =
            if piles_up { Err((Status::EventsPileUp, first)) } else { changed(case, &here, &line, (&met, &at_end)) };
        let (behind, start, acted) = match changed {
            Ok(changed) => changed,
            Err((status, first)) => {
                pieces.push(Piece { line, setup: here, acted: Vec::new() });
                let failure = failed(setup, status, &pieces, Some(first));
                return Err(Box::new(Stopped { failure, pieces }));
            }
        };
        let mut next = going_on(behind, start, &line, limit, is_shaken);
        let saltation = saltations.iter().find(|(place, _)| acted == [*place]).map(|(_, saltation)| saltation);
        carry(&mut next, (&here, &line), saltation);
        count += acted.len();
        pieces.push(Piece { line, setup: std::mem::replace(&mut here, next), acted });
    }
}

/// What the events of a setup do to small changes, by their places there; none if that is not asked for.
fn saltations(case: &Case, setup: &Setup) -> Vec<(usize, Saltation)> {
    if !setup.settings.sensitivity {
        return Vec::new();
    }
    let Place { geometry, start } = &setup.place;
    let norm = Extended::from(geometry.norm(&start.q, &start.q_dot));
    let first = setup.until.iter().position(|until| until.change.is_some()).unwrap_or(setup.until.len());
    let of = |(k, event)| Some((first + k, case.saltation(event, norm).ok()?));
    case.events.iter().filter(|event| !event.set.is_empty()).enumerate().filter_map(of).collect()
}

/// Carries small changes from the end of a piece behind what has acted there. Several events at one place are met one
/// after the other in neighbouring motions, and nothing is carried behind them.
fn carry(next: &mut Setup, (here, line): (&Setup, &WorldLine), saltation: Option<&Saltation>) {
    let before = (&*here.place.geometry, &line.end_inside());
    let matrix = saltation.map(|saltation| saltation.matrix(before, (&next.place.geometry, &next.place.start)));
    let behind = line.sensitivity.as_ref().zip(matrix).map(|(before, matrix)| Box::new(before.behind(&matrix)));
    next.settings.sensitivity = behind.is_some();
    if let Some(carried) = &mut next.carried {
        carried.sensitivity = behind;
    }
}

/// The way from the end of a piece to that of the run; `None` if it is no longer than the rounding of γ or of the
/// coordinate.
fn rest_of(setup: &Setup, line: &WorldLine) -> Option<Limit> {
    let is_left = |rest: f64, size: f64| rest.abs() > SHORT * size.abs();
    match setup.limit {
        Limit::Length(length) => {
            let rest = length - line.length;
            (rest > 0.0 && is_left(rest, line.gamma_f())).then_some(Limit::Length(rest))
        }
        Limit::Value { coordinate, value } => {
            is_left(value - line.last_joint().q[coordinate], value).then_some(setup.limit)
        }
    }
}

/// Counts windows, iterations and what is not proved from the start of the run on.
fn add_up<S: Real>(line: &mut WorldLine<S>, before: Option<&Piece<S>>) {
    let Some(Piece { line: before, .. }) = before else { return };
    line.window_count += before.window_count;
    line.iterations.count += before.iterations.count;
    line.gradient_norm = larger(line.gradient_norm, before.gradient_norm);
    line.touched = before.touched.or(line.touched);
    line.windows_unproved = line.windows_unproved.zip(before.windows_unproved).map(|(one, other)| one + other);
}

/// Returns true if the formula of an event is zero inside of a piece, up to rounding of its end.
fn is_low(setup: &Setup, line: &WorldLine, place: usize) -> bool {
    let (Place { geometry, start }, mut formula) = (&setup.place, setup.until[place].formula.clone());
    let norm = geometry.norm(&start.q, &start.q_dot);
    let at_end = beginning(setup, &line.end_inside(), place, norm, Slack::of_run(line.length));
    let (mut sampler, mut value) =
        (Sampler::new(line), |Sample { q, q_dot, p, .. }: Sample| formula.at(&q, &q_dot, &p, norm));
    INSIDE.into_iter().all(|share| {
        let inside = sampler.at_gamma(line.gamma_i + share * line.length);
        inside.is_ok_and(|inside| value(inside).abs() <= LOW * at_end.noise)
    })
}

/// A formula of a setup at a state, where K was `norm` at the start of the run.
fn beginning(setup: &Setup, start: &Start, place: usize, norm: f64, slack: Slack<f64>) -> Beginning {
    let mut formula = setup.until[place].formula.clone();
    let of_state = &mut |q: &[f64], q_dot: &[f64], p: &[f64]| formula.at(q, q_dot, p, norm);
    Beginning::new((&setup.place.geometry, start, f64::EPSILON), of_state, slack)
}

/// All formulas of a setup at a state behind a piece of this length, at whose end these events acted where their
/// formulas had these values.
fn sides_at(setup: &Setup, start: &Start, before: f64, acted: &[(usize, f64)]) -> Vec<Beginning> {
    let norm = setup.place.geometry.norm(&start.q, &start.q_dot);
    let zero = |place: usize| acted.iter().find(|(other, _)| *other == place).map_or(0.0, |(_, value)| value.abs());
    let slack = |place: usize| Slack { zero: zero(place), ..Slack::of_run(before) };
    (0..setup.until.len()).map(|place| beginning(setup, start, place, norm, slack(place))).collect()
}

/// The first event that acts on the way in one direction, and is at its place where a run begins, which goes on that
/// way.
pub(super) fn begins_beyond<S: Real>(setup: &Setup<S>) -> Option<usize> {
    let (setup, acts) = (setup.in_f64(), |until: &Until| until.change.is_some());
    if !setup.has_acting_events() {
        return None;
    }
    let sides = sides_at(&setup, &setup.place.start, setup.reach(), &[]);
    let is_beyond = |(until, begin): (&Until, &Beginning)| {
        let goes_on = begin.is_zero && begin.side != 0.0 && until.direction.counts(begin.side > 0.0);
        acts(until) && until.direction != Direction::Both && goes_on
    };
    setup.until.iter().zip(&sides).position(is_beyond)
}

/// The events at the end of a piece, by their places in the order of the case: what ended it, and others whose formulas
/// are zero there, up to rounding, and change their sign by the motion that comes there. Returns all of them there.
fn met(setup: &Setup, line: &WorldLine) -> (Vec<usize>, Vec<Beginning>) {
    let Some(first) = line.ended_by else { return (Vec::new(), Vec::new()) };
    let at_end = sides_at(setup, &line.end_inside(), line.length, &[]);
    let is_met = |&place: &usize| {
        let (before, end) = (line.watched.sides.get(place).copied().unwrap_or(0.0), &at_end[place]);
        let crosses = before != 0.0 && end.is_zero && end.side != before;
        place == first || crosses && setup.until[place].direction.counts(before < 0.0)
    };
    ((0..setup.until.len()).filter(is_met).collect(), at_end)
}

/// The state that the events at the end of a piece make of it, each from what those before have left, with the setup
/// behind them. Returns their places last; or why there is no run behind them, and the event.
fn changed(
    case: &Case,
    setup: &Setup,
    line: &WorldLine,
    (met, at_end): (&[usize], &[Beginning]),
) -> Result<(Setup, Start, Vec<usize>), (Status, usize)> {
    let begin = &setup.place.start;
    let norm = setup.place.geometry.norm(&begin.q, &begin.q_dot);
    let (mut start, mut here, mut acted) = (line.end_inside(), setup.clone(), Vec::new());
    for &place in met {
        let outside = (Status::OutsideDomain, place);
        let Until { formula, change, .. } = &here.until[place];
        let value = formula.clone().at(&start.q, &start.q_dot, &start.p, norm);
        let mut change: Change = change.clone().ok_or(outside)?;
        let values = change.values(&start, norm);
        if values.iter().any(|(quantity, _)| matches!(quantity, Quantity::Parameter(_))) {
            here = case.with_set(&here, &values, &start.q).ok_or(outside)?;
        }
        start = change.of(&here.place.geometry, &start, &values).ok_or(outside)?;
        acted.push((place, value));
    }
    let after = sides_at(&here, &start, line.length, &acted);
    // What comes to its surface, is left there without a velocity, and is driven on to where it must not go, rests.
    let rests = |&&place: &&usize| {
        let (before, after) = (&at_end[place], &after[place]);
        let goes_on = after.is_zero && after.side == -line.watched.sides[place] && after.side != 0.0;
        goes_on && after.order > before.order && before.order > 0
    };
    if let Some(&place) = met.iter().find(rests) {
        return Err((Status::EventsRest, place));
    }
    here.sides = after.iter().map(Beginning::known).collect();
    Ok((here, start, met.to_vec()))
}

/// The setup of the run that goes on with another start, up to `limit`, behind the events at the end of a piece.
fn going_on(setup: Setup, mut start: Start, line: &WorldLine, limit: Limit, is_shaken: bool) -> Setup {
    let geometry = &setup.place.geometry;
    if is_shaken {
        let mut is_up = line.window_count.is_multiple_of(2);
        for value in start.q.iter_mut().chain(&mut start.q_dot) {
            *value *= 1.0 + if is_up { SHAKE } else { -SHAKE };
            is_up = !is_up;
        }
        start.p = geometry.momenta(&start.q, &start.q_dot);
    }
    // A number that an event leaves as it is keeps the part that rounding took from it.
    let end = line.end_inside();
    let keeps = |a: usize| end.q[a] == start.q[a];
    let low = |(a, &low): (usize, &f64)| if keeps(a) { low } else { 0.0 };
    let q_low: Vec<f64> = line.handed.q_low.iter().enumerate().map(low).collect();
    let handed = Handed { q_low, ..Handed::default() };
    let place = Place { geometry: Arc::clone(geometry), start: Arc::new(start) };
    Setup {
        rough: place.clone(),
        place,
        gamma_i: line.gamma_f(),
        carried: Some(Carried { handed, ..Carried::default() }),
        limit,
        // Errors are relative to sizes of the whole run.
        floors: line.sizes.iter().copied().enumerate().filter(|(_, size)| *size > 0.0).collect(),
        ..setup
    }
}
