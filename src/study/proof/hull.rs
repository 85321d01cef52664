//! Where the motions are, and where they end, whose starts and parameters lie in intervals.

use super::acting::Acting;
use super::events::Watching;
use super::pieces::Through;
use super::starts::Starts;
use crate::case::Case;
use crate::geometry::value_of;
use crate::number::{Extended, Real};
use crate::proof::{Coordinate, Generator, Motion, Progress, Proof, Reason, Until, prove};
use crate::solve::{Limit, Quantity};

/// The place of t by Newton's law.
const T: usize = 0;
/// Where motions meet events, the way of a set is shown at so many places.
const PLACES: usize = 64;

/// What is proved of a set of motions: the hulls of the places where they are.
#[derive(Debug, Clone, PartialEq)]
pub struct Hull {
    /// The coordinates, with the least and the largest value that they may have at the end; or why these are not known.
    pub ends: Result<Vec<(String, [f64; 2])>, String>,
    /// The same on the way, as far as it is proved.
    pub way: Vec<OnWay>,
    /// The number of windows of the proof.
    pub windows: usize,
}

/// The hull at some γ.
#[derive(Debug, Clone, PartialEq)]
pub struct OnWay {
    /// γ, which doubles may be too few digits for.
    pub gamma: Extended,
    /// The least and the largest value of every coordinate, `None` if they are not known.
    pub ends: Vec<Option<[f64; 2]>>,
}

/// Proves where the motions of a case with intervals are. `goes_on` hears after every window which part of the motion
/// is done, and may stop the proof.
pub fn hull(case: &Case, goes_on: &mut dyn FnMut(f64) -> bool) -> Hull {
    proved(case, goes_on).unwrap_or_else(|reason| Hull { ends: Err(reason), way: Vec::new(), windows: 0 })
}

fn proved(case: &Case, goes_on: &mut dyn FnMut(f64) -> bool) -> Result<Hull, String> {
    let parameters = &case.geometry_text.parameters;
    let end = |text: &String| value_of::<Extended>(text, parameters).map_err(|error| error.to_string());
    let (mut keys, mut middles, mut radii) = (Vec::new(), Vec::new(), Vec::new());
    for interval in &case.intervals {
        let [low, high] = [end(&interval.ends[0])?, end(&interval.ends[1])?];
        keys.push(interval.key.clone());
        middles.push((low + high).half());
        // A little more than it is.
        radii.push((high - low).half().to_f64().next_up());
    }
    let starts = Starts::new(case.text_of_run(), keys, middles)?;
    let generators = starts.generators(&radii)?;
    if starts.may_meet_events() || starts.case.arguments().is_some() {
        return in_pieces(&starts, &generators, goes_on);
    }
    let geometry = starts.geometry(&generators)?;
    let motion = starts.motion(&geometry, &generators);
    let length = starts.length().to_f64();
    let is_length = match motion.until {
        Until::Length(_) => true,
        Until::Value(coordinate, _) => geometry.is_steady(coordinate),
    };
    // All of the motions are there as long as the shortest is. Those to a value end in the last window.
    let late: f64 = generators.iter().map(|generator| generator.length.abs()).sum();
    let shortest = if late > 0.0 && is_length { (length - late).next_down() } else { f64::INFINITY };
    let motion = Motion { keeps_way: true, ..motion };
    let Proof { end, state, way, windows, .. } = prove(&motion, &mut |progress| goes_on(progress.reached / length));
    let names = starts.case.coordinates();
    let of_end = |(a, name): (usize, &String)| {
        let spread = state[a].as_ref()?;
        Some((name.clone(), within(spread.value + starts.setup.origin_of(a), spread.reach())))
    };
    let of_way = |(length, found): &(f64, Vec<Coordinate>)| {
        let of = |a: usize| {
            let found = found.iter().find(|found| found.coordinate == a)?;
            // What moves at a constant velocity is as far apart as it was at the start.
            let columns = generators.iter().filter(|_| found.is_steady).map(|generator| generator.q[a].abs());
            let reach = (found.radius + columns.sum::<f64>()).next_up() * (1.0 + 8.0 * f64::EPSILON);
            Some(within(found.value + starts.setup.origin_of(a), reach))
        };
        let length = Extended::from(if starts.setup.is_backward { -length } else { *length });
        OnWay { gamma: starts.setup.gamma_i + length, ends: (0..names.len()).map(of).collect() }
    };
    Ok(Hull {
        ends: end.map(|_| names.iter().enumerate().filter_map(of_end).collect()).map_err(told),
        way: way.iter().filter(|(length, _)| *length <= shortest).map(of_way).collect(),
        windows,
    })
}

/// Why there is no hull, and what may help.
fn told(reason: Reason) -> String {
    match reason {
        Reason::Stopped | Reason::Constant => reason.to_string(),
        _ => format!("{reason}; smaller intervals may have a proof, as of --vary KEY=START..STOP:COUNT"),
    }
}

/// The end at a time of motions to a γ, if that is the same for all: by Newton's law, where t moves at one velocity
/// whatever events act. At which γ each motion meets an event says nothing then, and behind it all that are at one time
/// are together.
fn at_a_time(starts: &Starts, generators: &[Generator]) -> Option<Until> {
    let (case, setup) = (&starts.case, &starts.setup);
    let Limit::Length(length) = setup.limit else { return None };
    let of_t =
        |quantity: &Quantity| matches!(quantity, Quantity::Position(T) | Quantity::Velocity(T) | Quantity::Momentum(T));
    let sets_t = case.events.iter().flat_map(|event| &event.set).any(|(quantity, _)| of_t(quantity));
    let is_alike = |of: &Generator| of.q[T] == 0.0 && of.p[setup.place.start.q.len() - 1] == 0.0;
    let start = &setup.place.start;
    let is_one = case.is_lifted() && !sets_t && generators.iter().all(is_alike);
    is_one.then(|| Until::Value(T, start.q[T] + start.q_dot[T] * length))
}

/// The same where motions may meet events, or surfaces at which abs, sign, step or tables change: in pieces, of which
/// the first one begins with the set of all starts.
fn in_pieces(starts: &Starts, generators: &[Generator], goes_on: &mut dyn FnMut(f64) -> bool) -> Result<Hull, String> {
    if generators.iter().any(|generator| generator.length != 0.0) {
        return Err("the length of the run depends on them, and it may meet events".to_owned());
    }
    let (setup, scene) = (&starts.setup, starts.case.with_unknown_parameters());
    let mut plain = starts.case.clone();
    plain.geometry_text.unknown.clear();
    let (acting, arguments) = (Acting::new(&scene, setup)?, scene.arguments());
    let also = [acting.changed(), starts.kept(generators)].concat();
    let Watching { sides, geometry, start, watched, formulas, leaves } =
        Watching::new((&plain, &scene), setup, false, (&also, arguments.as_ref()))?;
    let through = Through::new((&scene, setup), (&acting, &also, arguments.as_ref()), &formulas);
    let length = starts.length();
    let place = |k: usize| length * Extended::from(k as f64 / PLACES as f64);
    let places: Vec<Extended> = (0..PLACES).map(place).collect();
    let motion = starts.motion(&geometry, &[]);
    let until = at_a_time(starts, generators).unwrap_or(motion.until);
    let motion = Motion { start: &start, watched: &watched, samples: &places, is_spread: true, until, ..motion };
    let side = "the side of an event, or of where abs, sign, step or a table changes, that all starts are on";
    let behind = through.spread(&motion, generators, &sides).filter(|_| leaves.is_none()).ok_or(side)?;
    let motion = Motion { behind: &behind, ..motion };
    let far = length.to_f64();
    let proof = through.prove(&motion, &sides, &mut |progress: Progress| goes_on(progress.reached / far));
    let names = starts.case.coordinates();
    let hull = |found: &Coordinate| within(found.value + setup.origin_of(found.coordinate), found.radius);
    let of_way = |(found, length): (&Vec<Coordinate>, &Extended)| {
        let of = |a: usize| found.iter().find(|found| found.coordinate == a).map(hull);
        let length = if setup.is_backward { -*length } else { *length };
        OnWay { gamma: setup.gamma_i + length, ends: (0..names.len()).map(of).collect() }
    };
    let of_end = |found: &Coordinate| Some((names.get(found.coordinate)?.clone(), hull(found)));
    Ok(Hull {
        ends: proof.end.map(|all| all.iter().filter_map(of_end).collect()).map_err(told),
        way: proof.samples.iter().zip(&places).map(of_way).collect(),
        windows: proof.windows,
    })
}

/// The least and the largest of numbers that are no further than `reach` from a value, both rounded outwards.
fn within(value: Extended, reach: f64) -> [f64; 2] {
    let reach = Extended::from(reach.next_up());
    let [low, high] = [value - reach, value + reach].map(Extended::to_f64);
    [low.next_down().next_down(), high.next_up().next_up()]
}
