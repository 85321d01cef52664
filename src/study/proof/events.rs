//! The formulas that a proof watches, and what it says of the events and the samples of a run.

use std::sync::Arc;

use super::acting::spreads;
use super::pieces::side_of;
use super::{REPORT, extended};
use crate::case::{Case, WatchedFormula};
use crate::diagnostics::verdict::Reason;
use crate::geometry::{Arguments, Direction, Geometry, Side, Start};
use crate::number::ball::OFF;
use crate::number::spline::Table;
use crate::number::{Extended, Real};
use crate::proof::{Coordinate, Event, Spread, Watched};
use crate::solve::{Place, Setup};
use crate::study::run::Run;
use crate::trajectory::Sample;

/// The space-time and the start of a motion with the formulas that are watched as further coordinates. Those of events
/// that act come last.
pub(super) struct Watching<'c> {
    /// The sides on which the arguments of abs, sign, step and tables begin, if they are followed. What is 0 where they
    /// end stands behind the formulas.
    pub(super) sides: Vec<Side>,
    pub(super) geometry: Arc<Geometry<Extended>>,
    pub(super) start: Arc<Start<Extended>>,
    pub(super) watched: Vec<Watched>,
    pub(super) formulas: Vec<WatchedFormula<'c>>,
    /// The place of an argument that is 0 at the start, and the side to which the motion leaves.
    pub(super) leaves: Option<(usize, f64)>,
}

impl<'c> Watching<'c> {
    /// Those of a case that may end it or act and, if it `finds`, those of the events that it looks for. Parameters
    /// that these set are unknown in `scene`. The momenta of `changed` are no constants. Arguments of abs, sign, step
    /// and tables are followed, where there are some.
    ///
    /// # Errors
    /// The reason why it is not known which sides they are on, or where formulas change their signs.
    pub(super) fn new(
        (case, scene): (&'c Case, &Case),
        setup: &Setup<Extended>,
        finds: bool,
        (changed, arguments): (&[usize], Option<&Arguments>),
    ) -> Result<Self, &'static str> {
        let Place { geometry, start } = &setup.place;
        let formulas = case.watched_formulas().filter(|of| finds || of.ends).chain(case.acting_formulas());
        let formulas: Vec<WatchedFormula<'c>> = formulas.collect();
        if formulas.iter().any(|of| case.may_jump(of.formula)) {
            return Err("an event whose formula may jump");
        }
        if formulas.is_empty() && arguments.is_none() {
            let (geometry, start) = (geometry.clone(), start.clone());
            return Ok(Self { sides: Vec::new(), geometry, start, watched: Vec::new(), formulas, leaves: None });
        }
        let norm = geometry.norm(&start.q, &start.q_dot);
        let mut with = (**start).clone();
        let unknown: Vec<Extended> = scene.geometry_text.unknown.iter().map(|name| case.value(name)).collect();
        unknown.iter().for_each(|&value| append(&mut with, value));
        let (mut watched, mut leaves) = (Vec::new(), None);
        for of in &formulas {
            let formula = case.observable(of.formula);
            let (value, off) = formula.enclosed([&start.q, &start.q_dot, &start.p], norm, OFF);
            append(&mut with, value);
            watched.push(Watched { direction: of.direction, off, ends: of.ends });
        }
        let (mut sides, mut at_zero) = (Vec::new(), None);
        let changes = "a start at which abs, sign, step or a table changes";
        let at_start = arguments.map(|of| at_start(of, (start, &unknown)).ok_or(changes)).transpose()?;
        for (argument, &table) in at_start.iter().flatten().zip(arguments.iter().flat_map(|of| &of.tables)) {
            let is_off = |table: Table| {
                table.piece(argument.value).and_then(|piece| table.polynomial::<Extended>(piece)).is_none()
            };
            if table.is_some_and(is_off) {
                return Err("a start beyond the ends of a table");
            }
            let (side, ends) = match (side_of(argument, table), table, at_zero) {
                (Some(known), ..) => known,
                (None, None, None) => {
                    at_zero = Some((sides.len(), watched.len()));
                    (Side::Positive, vec![argument.clone()])
                }
                _ => return Err(changes),
            };
            sides.push(side);
            for end in ends {
                append(&mut with, end.value);
                watched.push(Watched { direction: Direction::Both, off: end.radius, ends: true });
            }
        }
        let before = with.q.len() - watched.len();
        let scene = |sides: &[Side]| scene.watching(&formulas, (changed, sides), norm);
        if let Some((argument, place)) = at_zero {
            let (side, out) = left(&mut sides, argument, (&with, before + place), scene).ok_or(changes)?;
            sides[argument] = side;
            leaves = Some((place, out));
        }
        Ok(Self { geometry: scene(&sides).into(), start: with.into(), leaves, watched, sides, formulas })
    }
}

/// Appends a formula with this value to a start.
fn append(start: &mut Start<Extended>, value: Extended) {
    start.q.push(value);
    start.q_dot.push(Extended::ZERO);
    start.p.push(Extended::ZERO);
}

/// Rates that are smaller than this part of those on both sides may be 0.
const ROUNDED: f64 = 1e-40;

/// The side to which a motion leaves from where an argument is 0: that to which its rates on both sides lead. `None` if
/// these are not two of one sign: it stays there, as a body that friction holds, or may leave to either side.
fn left(
    sides: &mut [Side],
    argument: usize,
    (start, coordinate): (&Start<Extended>, usize),
    scene: impl Fn(&[Side]) -> Geometry<Extended>,
) -> Option<(Side, f64)> {
    let mut rate = |side: Side| {
        sides[argument] = side;
        Some(scene(sides).velocities(&start.q, &start.p).ok()?[coordinate])
    };
    let [above, below] = [rate(Side::Positive)?, rate(Side::Negative)?];
    let least = Extended::from(ROUNDED) * (above.abs() + below.abs());
    match above.abs() > least && below.abs() > least && above.signum() == below.signum() {
        true if above > Extended::ZERO => Some((Side::Positive, 1.0)),
        true => Some((Side::Negative, -1.0)),
        false => None,
    }
}

/// The arguments at the start, with these values of unknown parameters; `None` if one is not known there.
fn at_start(arguments: &Arguments, (start, unknown): (&Start<Extended>, &[Extended])) -> Option<Vec<Spread>> {
    let exact = |&value: &Extended| Some(Spread { value, columns: Vec::new(), radius: 0.0, slack: 0.0 });
    let state: Vec<Option<Spread>> = start.q.iter().chain(&start.p).chain(unknown).map(exact).collect();
    spreads(&arguments.jets, &state.iter().map(Option::as_ref).collect::<Vec<_>>())
}

/// By how much the γ and the coordinates of each event of a run may be off, proved; nothing for what was not proved.
pub(super) type Radii = Vec<Option<Vec<f64>>>;

/// These, or why the run contradicts the proof: it has met another number of events.
pub(super) fn radii<S: Real>(
    case: &Case,
    setup: &Setup<Extended>,
    run: &Run<S>,
    (formulas, found): (&[WatchedFormula<'_>], &[Event]),
) -> Result<Radii, Reason> {
    let mut radii: Radii = vec![None; run.events.len()];
    for event in 0..case.events.len() {
        let is_of = |watch: usize| formulas[watch].event == Some(event);
        if !(0..formulas.len()).any(is_of) {
            continue;
        }
        let proved: Vec<&Event> = found.iter().filter(|found| is_of(found.watch)).collect();
        let own: Vec<usize> = (0..run.events.len()).filter(|&k| run.events[k].watch == event).collect();
        if proved.len() != own.len() {
            let (name, proved, own) = (&case.events[event].name, proved.len(), own.len());
            let finding =
                format!("the motion is proved to meet '{name}' {proved} times, and the run meets it {own} times");
            return Err(Reason::new(finding, REPORT));
        }
        own.into_iter().zip(proved).for_each(|(k, proved)| radii[k] = Some(radius(setup, run, k, proved)));
    }
    Ok(radii)
}

/// By how much the event `k` of a run is off at most: γ, and then every coordinate.
fn radius<S: Real>(setup: &Setup<Extended>, run: &Run<S>, k: usize, proved: &Event) -> Vec<f64> {
    let sample = &run.events[k].sample;
    let (length, radius) = proved.gamma;
    let gamma = if setup.is_backward { setup.gamma_i - length } else { setup.gamma_i + length };
    let of_gamma = off(sample.gamma, gamma, radius);
    std::iter::once(of_gamma).chain(coordinates_off(setup, sample, &proved.coordinates)).collect()
}

/// By how much a number of a run is off at most, which is printed as a double, or in all its digits.
fn off<S: Real>(own: S, value: Extended, radius: f64) -> f64 {
    let own = extended(own);
    let rounded = if S::IS_EXTENDED { 0.0 } else { f64::EPSILON * own.abs().to_f64() };
    ((own - value).abs().to_f64() + radius + rounded) * (1.0 + 8.0 * f64::EPSILON)
}

/// By how much the coordinates of a sample are off at most; NaN for those of which nothing is proved.
fn coordinates_off<'p, S: Real>(
    setup: &'p Setup<Extended>,
    sample: &'p Sample<S>,
    proved: &'p [Coordinate],
) -> impl Iterator<Item = f64> + use<'p, S> {
    (0..sample.q.len()).map(move |a| {
        let of = proved.iter().find(|found| found.coordinate == a);
        of.map_or(f64::NAN, |of| off(sample.q[a], of.value + setup.origin_of(a), of.radius))
    })
}

/// γ − γ_i of the samples of a run, if they are in order.
pub(super) fn places<S: Real>(setup: &Setup<Extended>, run: &Run<S>) -> Vec<Extended> {
    let length = |sample: &Sample<S>| {
        let way = extended(sample.gamma) - setup.gamma_i;
        if setup.is_backward { -way } else { way }
    };
    let places: Vec<Extended> = run.samples.iter().map(length).collect();
    if places.is_sorted() && places.first().is_none_or(|first| *first >= Extended::ZERO) { places } else { Vec::new() }
}

/// By how much the coordinates of each sample of a run may be off at its γ, as far as that is proved.
pub(super) fn of_samples<S: Real>(setup: &Setup<Extended>, run: &Run<S>, proved: &[Vec<Coordinate>]) -> Radii {
    let samples = run.samples.iter().enumerate();
    let of = |(k, sample): (usize, _)| Some(coordinates_off(setup, sample, proved.get(k)?.as_slice()).collect());
    samples.map(of).collect()
}
