//! Windows as long as an accuracy needs, by [`crate::engine`].

mod watch;

use self::watch::Watches;
use super::arithmetic::Arithmetic;
use super::failure::NoSolution;
use super::narrow::{Lengths, Reasons};
use super::places;
use super::run::{Observer, Run, has_finite_action};
use super::setup::{Limit, Settings, Setup, System};
use super::status::{InitialGuess, MOST_NODES, Status};
use super::world_line::{Joint, WorldLine};
use crate::action::Form;
use crate::engine::{Accuracy, Engine, Failure, POINTS, State, Window};
use crate::geometry::{Geometry, Start};
use crate::number::Real;
use crate::sbp::SbpName;

/// A coordinate that is below this part of its size may be on its way to 0.
const SMALL: f64 = 1e-4;
/// Changes of sign are at one place if they shorten a window by no more than this share of γ.
const AT_ONE_PLACE: f64 = 1e-14;
/// A forecast from the beginning of a run may be too high by this factor.
const FORECAST: f64 = 3.0;
/// The most sweeps that a run may need: a day. At its pace a run that needs more is ended early.
pub(super) const MOST_SWEEPS: f64 = 1e12;

/// The run of a setup whose windows are chosen for an accuracy or a tolerance.
///
/// # Errors
/// [`NoSolution`], if the accuracy is not reached.
pub(super) fn solve<S: Arithmetic>(
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
    let mut joint = JointOf::new(start);
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
        let (nodes, done) = (run.line.window_count * POINTS, goal.done(end, &joint.q));
        within_limits(setup, &engine, (is_kept.then_some(nodes), done))?;
    }
    run.line.handed = engine.window().handed();
    Ok(ended(setup, &engine, goal, run.line))
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

/// The end of a window in all coordinates. Momenta of ignorable ones are those of the start.
pub(super) struct JointOf<S> {
    q: Vec<S>,
    p: Vec<S>,
}

impl<S: Real> JointOf<S> {
    pub(super) fn new(start: &Start) -> Self {
        let of = |values: &[f64]| values.iter().map(|&value| S::from(value)).collect();
        Self { q: of(&start.q), p: of(&start.p) }
    }
}

/// Adds a window with this operator of the run, which ends at γ − γ_i = `end`.
///
/// # Errors
/// Numbers that are not finite are not a result: an overflow anywhere makes the gradient or the action infinite.
pub(super) fn append<S: Real>(
    run: &mut Run<'_, S>,
    window: &mut Window<'_>,
    JointOf { q, p }: &mut JointOf<S>,
    (geometry, operator): (&Geometry, usize),
    end: S,
) -> Result<(), NoSolution> {
    q.iter_mut().zip(&window.end().q).for_each(|(to, q)| *to = S::from(q.high));
    geometry.active().iter().zip(&window.end().p).for_each(|(&a, end)| p[a] = S::from(end.high));
    let (joint, length, line) = (Joint { q, p }, window.length, &mut run.line);
    let gradient_norm = window.gradient_norm().unwrap_or(f64::INFINITY);
    if !(gradient_norm.is_finite() && has_finite_action(line.geometry(), joint, S::from(length))) {
        let gamma = line.gamma_i.to_f64() + window.gamma;
        let failure = NoSolution::marched(Status::OutsideDomain, places::place_of_overflow(line.geometry(), gamma, q));
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
        places::place(&setup.place.geometry, setup.gamma_i.to_f64() + gamma, &q)
    };
    let sweeps = engine.sweeps();
    let needed = sweeps as f64 / done.max(0.0);
    if needed > MOST_SWEEPS && sweeps > 10_000 {
        return Err(NoSolution { needed, ..NoSolution::adaptive(Status::EvaluationLimit, at()).after(sweeps) });
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
        Failure::OutsideDomain(outside) => (Status::OutsideDomain, places::place_beyond(geometry, gamma, &q, &outside)),
        Failure::NotConverged | Failure::TooShort => (Status::Stalled, places::place(geometry, gamma, &q)),
        Failure::ValueNotReached => (Status::EndTimeNotReached, places::place(geometry, gamma, &q)),
        Failure::Rounding | Failure::BeginAgain => (Status::AccuracyNotReached, places::place(geometry, gamma, &q)),
    };
    let failure = NoSolution::adaptive(status, at);
    if status != Status::AccuracyNotReached {
        return NoSolution { reasons: Box::new(Reasons { towards_zero, ..Reasons::default() }), ..failure };
    }
    let place = |gamma: f64, q: &[f64]| places::place(&setup.rough.geometry, setup.gamma_i.to_f64() + gamma, q);
    NoSolution {
        residual: engine.error_estimate().unwrap_or(f64::INFINITY),
        needed: engine.reachable().unwrap_or(0.0),
        asked: wanted.value(),
        reasons: Box::new(Reasons { narrow: lengths.narrow(place), towards_zero, event: None }),
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
