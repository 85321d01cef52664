//! How an error of the start travels along a run.

use std::sync::Arc;

use super::ends::{End, rates_of_momenta};
use super::sights::Sights;
use crate::case::Case;
use crate::engine::{Accuracy, Handed};
use crate::geometry::{Geometry, Start};
use crate::number::Real;
use crate::number::norm::larger;
use crate::solve::{Limit, Off, Place, Setup, WorldLine, solve_in_parts};
use crate::study::acting::chain;
use crate::trajectory::{Sample, Sampler};

/// The accuracy of the windows of two runs that are compared, at best and at worst: with windows that are to be more
/// accurate than their slopes are, a run does not get on.
const ACCURACY: [f64; 2] = [1e-13, 1e-3];
/// Windows are so many times less accurate than what rounding takes from their slopes.
const LESS: f64 = 10.0;
/// They are compared at so many places, spread evenly over the run, and at its end.
const PLACES: usize = 256;
/// From so many to twice as many nodes of a run are kept.
const KEPT: usize = 256;
/// A change of the start that is smaller than this share of the motion is made so large, and what comes of it smaller
/// again: two runs that are as accurate as doubles allow differ by some 1e-12 in any case.
const VISIBLE: f64 = 1e-6;
/// What comes of it is taken to be in proportion up to this share of the motion.
const PROPORTIONAL: f64 = 1e-2;

/// The accuracy of windows where rounding takes this share from slopes.
pub(super) fn accuracy_beside(lost: f64) -> f64 {
    (LESS * lost).clamp(ACCURACY[0], ACCURACY[1])
}

/// How far a run reaches, and what rounding takes from its slopes.
#[derive(Debug)]
pub(super) struct Extent {
    /// |γ_f − γ_i|.
    pub(super) length: f64,
    /// What ends it.
    pub(super) end: End,
    /// The share that slopes lose.
    pub(super) lost: f64,
}

/// A run of the same motion again, from its start or from near it.
#[derive(Debug)]
pub(super) struct Along {
    /// Its states at equal distances of γ.
    states: Vec<Start>,
    /// Some of its places.
    pub(super) sights: Sights,
    /// The accuracy of its windows.
    accuracy: f64,
}

/// An error along a run.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Carried {
    /// By how much the state at the end is off, of the motion as it is computed.
    pub(super) off: Off,
    /// The largest errors of coordinates along the run.
    pub(super) largest: Vec<f64>,
    /// The errors of coordinates at the end, for which the largest ones are taken: of many directions only one was
    /// looked at, and its error may just pass through 0 there.
    pub(super) end: Vec<f64>,
}

impl Carried {
    /// True if no error is above these.
    pub(super) fn is_below(&self, errors: &[f64]) -> bool {
        errors.len() >= self.largest.len() && self.largest.iter().zip(errors).all(|(own, error)| own <= error)
    }
}

impl Along {
    /// The run of `setup`, which reaches so far, from its start. `None` if it does not get to the end, also with less
    /// accurate windows: where a force is small, as at its beginning, rounding takes more from it.
    pub(super) fn new<S: Real>(case: &Case, setup: &Setup<S>, extent: &Extent) -> Option<Self> {
        let from = |accuracy: f64| Self::from(case, setup, (extent.length, accuracy), (*setup.rough.start).clone());
        let looser = |accuracy: &f64| (*accuracy < ACCURACY[1]).then_some((LESS * accuracy).min(ACCURACY[1]));
        std::iter::successors(Some(accuracy_beside(extent.lost)), looser).find_map(from)
    }

    /// The error that a start which is off by `off` makes along this run. `None` if it is not known: two runs from the
    /// two starts are compared, and one of them has no end.
    ///
    /// This is all that is known of how errors travel. It grows as errors of this motion do: linearly where the motion
    /// is regular, exponentially in chaos, also through events that act. A loss of rates that lasts for a whole run of
    /// length L is no more than an error L times as large at its start, as far as errors do not shrink on the way.
    pub(super) fn carried<S: Real>(
        &self,
        case: &Case,
        setup: &Setup<S>,
        extent: &Extent,
        off: &Off,
    ) -> Option<Carried> {
        let (geometry, base) = (&setup.rough.geometry, &self.states);
        let sizes = sizes(geometry, base);
        let share = |off: &[f64], sizes: &[f64]| {
            let shares = off.iter().zip(sizes).filter(|(_, size)| **size > 0.0).map(|(off, size)| (off / size).abs());
            shares.fold(0.0, f64::max)
        };
        let visible = VISIBLE / share(&off.q, &sizes.q).max(share(&off.p, &sizes.p));
        for factor in [visible.clamp(1.0, 1.0 / f64::MIN_POSITIVE), 1.0] {
            let other = moved(geometry, &setup.rough.start, off, factor);
            let other = other.and_then(|start| Self::from(case, setup, (extent.length, self.accuracy), start));
            let found = other.map(|other| compared(geometry, [base, &other.states], factor, &extent.end));
            let is_proportional = |found: &Carried| factor * share(&found.largest, &sizes.q) <= PROPORTIONAL;
            if factor == 1.0 || found.as_ref().is_some_and(is_proportional) {
                return found;
            }
        }
        None
    }

    fn from<S: Real>(case: &Case, setup: &Setup<S>, (length, accuracy): (f64, f64), start: Start) -> Option<Self> {
        let of = (case, setup);
        let mut setup = setup.in_f64();
        let place = Place { start: Arc::new(start), ..setup.rough.clone() };
        (setup.rough, setup.place, setup.carried) = (place.clone(), place, None);
        setup.dropped = Handed::default();
        setup.limit = Limit::Length(length);
        setup.until.retain(|until| until.change.is_some());
        setup.settings.sensitivity = false;
        let (mut states, mut sights, from): (Vec<Start>, Sights, f64) = (Vec::new(), Sights::of(KEPT), setup.gamma_i);
        let mut see = |part: &WorldLine, set: &[(usize, f64)]| {
            sights.see(of, part, set);
            let (mut sampler, before) = (Sampler::new(part), part.signed(part.gamma_i - from));
            // The first window of a run that begins again makes all that was seen of it void.
            if part.windows.len() == part.window_count {
                states.clear();
            }
            while states.len() <= PLACES {
                let here = length * (states.len() as f64 / PLACES as f64) - before;
                let Ok(Sample { q, q_dot, p, .. }) = sampler.at_gamma(part.gamma_at(here)) else { break };
                states.push(part.turned(Start { q, q_dot, p }));
            }
        };
        let windows = Accuracy::Estimated(accuracy);
        if setup.has_acting_events() {
            chain(case, &setup, windows, false).ok()?.iter().for_each(|piece| see(&piece.line, &piece.setup.set));
        } else {
            setup.settings.accuracy = Some(windows);
            solve_in_parts(&setup, &mut |part| see(part, &setup.set)).ok()?;
        }
        (states.len() > PLACES).then_some(Self { states, sights, accuracy })
    }
}

/// The sizes of coordinates and momenta along a run. Ignorable coordinates count from its start.
fn sizes(geometry: &Geometry, states: &[Start]) -> Off {
    let size = |of: &dyn Fn(&Start) -> f64| states.iter().fold(0.0_f64, |size, state| size.max(of(state).abs()));
    let origin = |a: usize| if geometry.active().contains(&a) { 0.0 } else { states[0].q[a] };
    let each = 0..geometry.dimension();
    let q: Vec<f64> = each.clone().map(|a| size(&|state| state.q[a] - origin(a))).collect();
    Off { q: geometry.shared(&states[0].q, &q), p: each.map(|a| size(&|state| state.p[a])).collect() }
}

/// The start, off by so many times an error.
fn moved(geometry: &Geometry, start: &Start, off: &Off, factor: f64) -> Option<Start> {
    let add = |values: &[f64], off: &[f64]| values.iter().zip(off).map(|(value, off)| value + factor * off).collect();
    let (q, p): (Vec<f64>, Vec<f64>) = (add(&start.q, &off.q), add(&start.p, &off.p));
    let q_dot = geometry.velocities(&q, &p).ok()?;
    Some(Start { q, q_dot, p })
}

/// What two runs differ by, of which the second one began off by `factor` times the error that is looked for. Where
/// something else than a length ends the run, the places where it ends each are compared.
fn compared(geometry: &Geometry, [base, other]: [&[Start]; 2], factor: f64, end_of_run: &End) -> Carried {
    let off = |one: &[f64], two: &[f64]| one.iter().zip(two).map(|(one, two)| (two - one) / factor).collect();
    let mut all: Vec<Off> =
        base.iter().zip(other).map(|(one, two)| Off { q: off(&one.q, &two.q), p: off(&one.p, &two.p) }).collect();
    let (mut last, end) = (all.pop().expect("a run has an end"), &base[base.len() - 1]);
    let late = end_of_run.late(&last, &end.q_dot);
    last.q.iter_mut().zip(&end.q_dot).for_each(|(off, rate)| *off -= late * rate);
    last.p.iter_mut().zip(rates_of_momenta(geometry, end)).for_each(|(off, rate)| *off -= late * rate);
    end_of_run.coordinate().into_iter().for_each(|coordinate| last.q[coordinate] = 0.0);
    let largest = |a: usize| all.iter().chain([&last]).fold(0.0, |most, off| larger(most, off.q[a].abs()));
    let largest: Vec<f64> = (0..end.q.len()).map(largest).collect();
    let mut at_end = largest.clone();
    end_of_run.coordinate().into_iter().for_each(|coordinate| at_end[coordinate] = 0.0);
    Carried { off: last, largest, end: at_end }
}
