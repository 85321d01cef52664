//! Windows of the weak form on spectral elements, solved by the fixed-point iterations of [`crate::engine`]: as long as
//! an accuracy needs, or equal ones.
//!
//! It is the same collocation system that Newton's method solves window by window, and every window is certified on the
//! same action; the iteration is just some fifty times faster. Where it does not converge, because a window is too long
//! for it, Newton's method takes over equal ones.

mod watch;

use self::watch::Watches;
use super::failure::{At, Narrow, NoSolution, Reasons};
use super::run::{Arithmetic, Observer, Run, has_finite_action};
use super::setup::{Limit, Settings, Setup, System};
use super::status::{InitialGuess, MOST_NODES, MOST_SWEEPS, Status};
use super::world_line::{Joint, Place, WorldLine};
use crate::action::Form;
use crate::engine::{Accuracy, Engine, Failure, MOST_POINTS, POINTS, State, Window};
use crate::geometry::{Geometry, Start};
use crate::number::Real;
use crate::sbp::SbpName;

/// A coordinate that is below this part of its size may be on its way to 0.
const SMALL: f64 = 1e-4;
/// A place is narrow if windows there are shorter than this share of the longest one.
const NARROW: f64 = 1e-3;
/// Changes of sign are at one place if they shorten a window by no more than this share of γ.
const AT_ONE_PLACE: f64 = 1e-14;
/// A forecast from the beginning of a run may be too high by this factor.
const FORECAST: f64 = 3.0;

/// The run of a setup whose windows are chosen for an accuracy or a tolerance.
///
/// # Errors
/// [`NoSolution`], if the accuracy is not reached.
pub(super) fn to_accuracy<S: Arithmetic>(
    setup: &Setup<S>,
    wanted: Accuracy,
    observer: Option<Observer<'_, S>>,
) -> Result<WorldLine<S>, NoSolution> {
    let (geometry, start) = (&*setup.rough.geometry, &*setup.rough.start);
    let goal = Goal::new(setup, start);
    let mut engine = begun(setup, goal, wanted);
    let is_kept = observer.is_none();
    let settings = Settings { system: System::PhysicalLimit, form: Form::Weak, ..setup.settings };
    let mut run = Run::new(setup, &Settings { sbp: SbpName::Gll(POINTS as u8), ..settings }, observer);
    run.line.accuracy = Some(wanted);
    let mut joint = joint_at(start);
    let mut watches = Watches::new(geometry, start, &setup.until, &setup.sides);
    let mut lengths = Lengths::default();
    loop {
        let mut window = match engine.next() {
            Ok(Some(window)) => window,
            Ok(None) => break,
            Err(Failure::BeginAgain) => {
                engine.begin_again();
                continue;
            }
            Err(failure) => return Err(failed(setup, (&engine, wanted), failure, &lengths)),
        };
        if window.index == 0 {
            lengths = Lengths::default();
            run.clear();
            watches.begin();
            (run.line.ended_by, run.line.ended_at) = (None, None);
        }
        if !setup.until.is_empty() {
            if let Err(failure) = cut(&mut engine, &mut watches, &mut run.line.ended_by) {
                return Err(failed(setup, (&engine, wanted), failure, &lengths));
            }
            window = engine.window();
        }
        watches.accept();
        if !window.is_last {
            lengths.see(window.length, window.gamma, || window.start().positions());
        }
        if let (Limit::Value { coordinate, value }, true) = (setup.limit, window.is_last && run.line.ended_by.is_none())
        {
            // t_i + (t_f − t_i), rounded twice, may be the neighbouring number.
            run.line.ended_at = Some((coordinate, value));
        }
        let end = window.gamma + window.length;
        let operator = run.line.operators.element(POINTS, S::from(window.length));
        append(&mut run, &mut window, &mut joint, (geometry, operator), S::from(end))?;
        let (nodes, done) = (run.line.window_count * POINTS, goal.done(end, &joint[0]));
        within_limits(setup, &engine, (is_kept.then_some(nodes), done))?;
    }
    run.line.handed = engine.window().handed();
    Ok(ended(setup, &engine, goal, run.line))
}

/// The windows of the run of `setup` on γ − γ_i ∈ [0, `length`]. There are none if they are no elements in the weak
/// form, if the numbers have more digits or windows more nodes than the engine has, or if it does not get to the end:
/// Newton's method takes over there, and knows why.
pub(super) fn equal<S: Arithmetic>(
    setup: &Setup<S>,
    length: S,
    observer: Option<Observer<'_, S>>,
) -> Option<WorldLine<S>> {
    let Settings { n_gamma: points, windows, form, system, sbp, .. } = setup.settings;
    let is_weak = form == Form::Weak && system == System::PhysicalLimit && matches!(sbp, SbpName::Gll(_));
    let window_length = length.to_f64() / windows as f64;
    // Tables hold the square of the length, and half as many digits of it again.
    let square = window_length * window_length;
    let is_in_range = square.is_finite() && square > f64::MIN_POSITIVE / f64::EPSILON / f64::EPSILON;
    if S::IS_EXTENDED || !is_weak || !is_in_range || points > MOST_POINTS {
        return None;
    }
    let Place { geometry, start, .. } = &setup.rough;
    let mut engine = Engine::equal(geometry, start, length.to_f64(), windows, points).ok()?;
    if let Some(carried) = &setup.carried {
        engine.resume(&carried.handed);
    }
    let mut run = Run::new(setup, &setup.settings, observer);
    run.expect(windows, points);
    run.reserve();
    run.line.length = length;
    let operator = run.line.operators.element(points, S::from(window_length));
    let mut joint = joint_at(start);
    for index in 1..=windows {
        let mut window = engine.next().ok()??;
        let gamma = if index == windows { length } else { S::from(index as f64 * window_length) };
        run.line.iterations.count += window.sweeps;
        if index == windows {
            run.line.handed = window.handed();
        }
        if append(&mut run, &mut window, &mut joint, (geometry, operator), gamma).is_err() {
            return None;
        }
    }
    Some(run.line)
}

/// The narrowest windows of a run so far.
#[derive(Default)]
struct Lengths {
    longest: f64,
    /// The shortest, its γ, and q^a there.
    shortest: Option<(f64, f64, Vec<f64>)>,
}

impl Lengths {
    /// Takes a window into account that begins at this γ and these q^a.
    fn see(&mut self, length: f64, gamma: f64, q: impl FnOnce() -> Vec<f64>) {
        self.longest = self.longest.max(length);
        if self.shortest.as_ref().is_none_or(|(shortest, ..)| length < *shortest) {
            self.shortest = Some((length, gamma, q()));
        }
    }

    /// The narrowest place, if there is one that is narrow, in a run from `gamma_i`.
    fn narrow(&self, geometry: &Geometry, gamma_i: f64) -> Option<Narrow> {
        let (shortest, gamma, q) = self.shortest.as_ref()?;
        let share = shortest / self.longest;
        (share < NARROW).then(|| {
            let At { gamma, point, .. } = At::new(geometry, gamma_i + gamma, q);
            Narrow { share, gamma, point }
        })
    }
}

/// Cuts the window that was solved last where the first formula changes its sign, if one does.
fn cut(engine: &mut Engine<'_>, watches: &mut Watches<'_>, ended_by: &mut Option<usize>) -> Result<(), Failure> {
    let (mut window, mut length) = (engine.window(), f64::INFINITY);
    while let Some(change) = watches.change(&mut window).filter(|change| *ended_by != Some(change.place)) {
        // Formulas that are zero at one place are behind each other by rounding, in turns.
        if window.length + AT_ONE_PLACE * (window.gamma + window.length) >= length {
            break;
        }
        length = if ended_by.is_some() { window.length } else { length };
        let near = watches.near(&change, &window);
        let mut value = |state: &State| watches.at(change.place, state);
        let mut end_where = |between| engine.end_where(between, change.side, &mut value);
        let is_near = near.map_or(Ok(false), &mut end_where)?;
        if !(is_near || end_where(change.between)?) {
            break;
        }
        *ended_by = Some(change.place);
        window = engine.window();
    }
    Ok(())
}

/// The engine at the start of the run.
fn begun<S: Real>(setup: &Setup<S>, goal: Goal, wanted: Accuracy) -> Engine<'_> {
    let (geometry, start) = (&*setup.rough.geometry, &*setup.rough.start);
    let engine = match goal {
        Goal::Length(length) => Engine::accurate(geometry, start, length, wanted, POINTS),
        Goal::Value { coordinate, value, .. } => {
            Engine::accurate_to_value(geometry, start, (coordinate, value), wanted, POINTS)
        }
    };
    let mut engine = engine.expect("a run begins inside the domain");
    engine.set_floors(&setup.floors);
    if let Some(carried) = &setup.carried {
        engine.resume(&carried.handed);
    }
    engine
}

/// Where a run ends.
#[derive(Clone, Copy)]
enum Goal {
    Length(f64),
    Value { coordinate: usize, value: f64, from: f64 },
}

impl Goal {
    fn new<S: Real>(setup: &Setup<S>, start: &Start) -> Self {
        match setup.limit {
            Limit::Length(length) => Self::Length(length.to_f64()),
            Limit::Value { coordinate, value } => {
                let value = (value - setup.origin_of(coordinate)).to_f64();
                Self::Value { coordinate, value, from: start.q[coordinate] }
            }
        }
    }

    /// The part of the run that is done at this γ and q^a.
    fn done(self, gamma: f64, q: &[impl Real]) -> f64 {
        match self {
            Self::Length(length) => gamma / length,
            Self::Value { coordinate, value, from } => (q[coordinate].to_f64() - from) / (value - from),
        }
    }
}

/// q^a and p_a of all coordinates at the start, for [`append`].
fn joint_at<S: Real>(start: &Start) -> [Vec<S>; 2] {
    [&start.q, &start.p].map(|values| values.iter().map(|&value| S::from(value)).collect())
}

/// Adds a window with this operator of the run, which ends at γ − γ_i = `end`. The joint of the window before becomes
/// that at its end; momenta of ignorable coordinates stay those of the start.
///
/// # Errors
/// Numbers that are not finite are not a result: an overflow anywhere makes the gradient or the action infinite.
fn append<S: Real>(
    run: &mut Run<'_, S>,
    window: &mut Window<'_>,
    [q, p]: &mut [Vec<S>; 2],
    (geometry, operator): (&Geometry, usize),
    end: S,
) -> Result<(), NoSolution> {
    q.iter_mut().zip(&window.end().q).for_each(|(to, q)| *to = S::from(q.high));
    geometry.active().iter().zip(&window.end().p).for_each(|(&a, end)| p[a] = S::from(end.high));
    let (joint, length, line) = (Joint { q, p }, window.length, &mut run.line);
    let gradient_norm = window.gradient_norm().unwrap_or(f64::INFINITY);
    if !(gradient_norm.is_finite() && has_finite_action(line.geometry(), joint, S::from(length))) {
        let gamma = line.gamma_i.to_f64() + window.gamma;
        let failure = NoSolution::marched(Status::OutsideDomain, At::overflow(line.geometry(), gamma, q));
        return Err(NoSolution { residual: gradient_norm, ..failure });
    }
    line.sensitivity.iter_mut().for_each(|sensitivity| window.carry(sensitivity));
    let nodes = window.nodes();
    run.begin_window(operator, end, joint, Vec::new());
    let line = &mut run.line;
    line.gradient_norm = line.gradient_norm.max(S::from(gradient_norm));
    line.iterations.initial_guess = InitialGuess::Extrapolation;
    let copy = |to: &mut Vec<S>, row: &[f64]| to.extend(row.iter().map(|&value| S::from(value)));
    line.q.iter_mut().enumerate().for_each(|(a, to)| copy(to, nodes.q(a)));
    line.p.iter_mut().enumerate().for_each(|(place, to)| copy(to, nodes.p(place)));
    run.end_window();
    Ok(())
}

/// Ends a run that memory cannot hold, or that would take too long. Windows become longer after the first few: a
/// forecast of nodes is believed when they are a thousandth of what is allowed.
fn within_limits<S: Real>(
    setup: &Setup<S>,
    engine: &Engine<'_>,
    (nodes, done): (Option<usize>, f64),
) -> Result<(), NoSolution> {
    let at = || {
        let (gamma, q) = engine.place();
        let q: Vec<S> = q.into_iter().map(S::from).collect();
        At::new(&setup.place.geometry, setup.gamma_i.to_f64() + gamma, &q)
    };
    let sweeps = engine.sweeps();
    let needed = sweeps as f64 / done.max(0.0);
    if needed > MOST_SWEEPS && sweeps > 10_000 {
        let mut failure = NoSolution { needed, ..NoSolution::adaptive(Status::EvaluationLimit, at()) };
        failure.iterations.count = sweeps;
        return Err(failure);
    }
    let Some(nodes) = nodes.map(|nodes| nodes as f64) else { return Ok(()) };
    let needed = nodes / done;
    let is_foreseen = nodes > 1e-3 * MOST_NODES && needed > FORECAST * MOST_NODES;
    if nodes > MOST_NODES || is_foreseen {
        return Err(NoSolution { needed, ..NoSolution::adaptive(Status::TooManyNodes, at()) });
    }
    Ok(())
}

/// The world-line of a run that came to its end.
fn ended<S: Real>(setup: &Setup<S>, engine: &Engine<'_>, goal: Goal, mut line: WorldLine<S>) -> WorldLine<S> {
    let is_at_limit = line.ended_by.is_none();
    line.length = match (setup.limit, goal) {
        (Limit::Length(length), _) if is_at_limit => length,
        _ => S::from(engine.place().0),
    };
    if let Some(last) = line.windows.last_mut() {
        last.gamma[1] = line.length;
    }
    line.error_estimate = engine.error_estimate();
    (line.sizes, line.good_until) = (engine.sizes(), engine.good_until());
    line.windows_unproved = Some(engine.unproved());
    line.iterations.count = engine.sweeps();
    line
}

/// Expresses a failure of the engine in terms of the setup.
fn failed<S: Real>(
    setup: &Setup<S>,
    (engine, wanted): (&Engine<'_>, Accuracy),
    failure: Failure,
    lengths: &Lengths,
) -> NoSolution {
    let (gamma, q) = engine.place();
    let towards_zero =
        if matches!(failure, Failure::OutsideDomain(_)) { Vec::new() } else { singular(setup, engine, &q) };
    let (gamma, q) = (setup.gamma_i.to_f64() + gamma, q.into_iter().map(S::from).collect::<Vec<S>>());
    let geometry = &setup.place.geometry;
    let (status, at) = match failure {
        Failure::OutsideDomain(outside) => (Status::OutsideDomain, At::beyond(geometry, gamma, &q, &outside)),
        Failure::NotConverged | Failure::TooShort => (Status::Stalled, At::new(geometry, gamma, &q)),
        Failure::ValueNotReached => (Status::EndTimeNotReached, At::new(geometry, gamma, &q)),
        Failure::Rounding | Failure::BeginAgain => (Status::AccuracyNotReached, At::new(geometry, gamma, &q)),
    };
    let failure = NoSolution::adaptive(status, at);
    if status != Status::AccuracyNotReached {
        return NoSolution { reasons: Box::new(Reasons { towards_zero, ..Reasons::default() }), ..failure };
    }
    let narrow = lengths.narrow(&setup.rough.geometry, setup.gamma_i.to_f64());
    NoSolution {
        residual: engine.error_estimate().unwrap_or(f64::INFINITY),
        needed: engine.reachable().unwrap_or(0.0),
        asked: wanted.value(),
        reasons: Box::new(Reasons { narrow, towards_zero, event: None }),
        ..failure
    }
}

/// The coordinates that are small at `q`, if there are no rates where they are 0.
fn singular<S: Real>(setup: &Setup<S>, engine: &Engine<'_>, q: &[f64]) -> Vec<String> {
    let (geometry, start) = (&setup.rough.geometry, &setup.rough.start);
    let sizes = engine.sizes();
    let is_small = |&&a: &&usize| q[a].abs() < SMALL * sizes[a];
    let small: Vec<usize> = geometry.active().iter().filter(is_small).copied().collect();
    let mut there = q.to_vec();
    small.iter().for_each(|&a| there[a] = 0.0);
    let has_rates = geometry.point().evaluate(&there, &start.p).is_ok();
    if has_rates { Vec::new() } else { small.iter().map(|&a| geometry.names()[a].clone()).collect() }
}
