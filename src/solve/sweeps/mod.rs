//! Windows of the weak form on spectral elements, solved by the fixed-point iterations of [`crate::engine`]: as long as
//! an accuracy needs, or equal ones.
//!
//! It is the same collocation system that Newton's method solves window by window, and every window is certified on the
//! same action; the iteration is just some fifty times faster. Where it does not converge, because a window is too long
//! for it, Newton's method takes over equal ones.

mod judge;
mod watch;

use std::sync::Arc;

use self::judge::{Judge, Operators, next};
use self::watch::Watches;
use super::failure::{Narrow, NoSolution, Reasons, Unfinished, point};
use super::grid::WindowOperator;
use super::run::{Observer, Run};
use super::setup::{Limit, Settings, Setup, System};
use super::signs::Watched;
use super::status::{InitialGuess, MOST_NODES, MOST_SWEEPS, Status};
use super::world_line::{Place, WorldLine};
use crate::action::Form;
use crate::engine::{Accuracy, Engine, Failure, MOST_POINTS, POINTS, State, Window};
use crate::number::Real;
use crate::sbp::SbpName;

/// A coordinate that is below this part of its size may be on its way to 0.
const SMALL: f64 = 1e-4;
/// A place is narrow if windows there are shorter than this share of the longest one.
const NARROW: f64 = 1e-3;
/// Windows are as long as the motion's own time allows. Where they are shorter by more than ten times what that is
/// shorter by, something else makes them so, rounding for example, and no encounter and no pole.
const OF_MOTION: f64 = 0.1;
/// Changes of sign are at one place if they shorten a window by no more than this share of γ.
const AT_ONE_PLACE: f64 = 1e-14;
/// Places between which a formula changes its sign are looked for this many times as far apart, and so many times: from
/// last digits to the whole window.
const WIDER: f64 = 64.0;
const MOST_WIDER: i32 = 9;
/// A forecast from the beginning of a run may be too high by this factor.
const FORECAST: f64 = 3.0;
/// The run of a setup whose windows are chosen for an accuracy or a tolerance. `of_judge` sees the windows of the march
/// that judges it.
///
/// # Errors
/// [`Unfinished`], if the accuracy is not reached.
pub(super) fn to_accuracy<S: Real>(
    setup: &Setup<S>,
    wanted: Accuracy,
    observer: Option<Observer<'_, S>>,
    of_judge: Option<Observer<'_, S>>,
) -> Result<WorldLine<S>, Box<Unfinished<S>>> {
    let mut march = March::new(setup, wanted);
    let is_kept = observer.is_none();
    let (system, form, sbp, accuracy) = (System::PhysicalLimit, Form::Weak, SbpName::Gll(POINTS as u8), Some(wanted));
    let settings = Settings { system, form, sbp, accuracy, ..setup.settings };
    let mut run = Run::new(setup, &settings, observer);
    let mut judge = of_judge.map(|observer| Judge::new(Run::new(setup, &settings, Some(observer))));
    let ended = march.go(&mut run, judge.as_mut(), is_kept);
    judge.iter_mut().for_each(Judge::show);
    // The window before a failure is one of the run, too.
    run.judge_window(march.engine.errors());
    run.show();
    if let Err(failure) = ended {
        return Err(Unfinished::new(failure, run.line));
    }
    run.line.handed = march.engine.window().handed();
    Ok(march.ended(run.line))
}

/// The windows of the run of `setup` on γ − γ_i ∈ [0, `length`]. There are none if they are no elements in the weak
/// form, if the numbers have more digits or windows more nodes than the engine has, or if it does not get to the end:
/// Newton's method takes over there, and knows why.
pub(super) fn equal<S: Real>(setup: &Setup<S>, length: S, observer: Option<Observer<'_, S>>) -> Option<WorldLine<S>> {
    let Settings { n_gamma: points, windows, form, system, sbp, .. } = setup.settings;
    let is_weak = form == Form::Weak && system == System::PhysicalLimit && matches!(sbp, SbpName::Gll(_));
    let window_length = length.to_f64() / windows as f64;
    // Tables hold the square of the length, and half as many digits of it again.
    let square = window_length * window_length;
    let is_in_range = square.is_finite() && square > f64::MIN_POSITIVE / f64::EPSILON / f64::EPSILON;
    if S::IS_EXTENDED || !is_weak || !is_in_range || points > MOST_POINTS {
        return None;
    }
    let Place { geometry, start } = &setup.rough;
    let mut engine = Engine::equal(geometry, start, length.to_f64(), windows, points).ok()?;
    engine.resume(setup.handed());
    let mut run = Run::new(setup, &setup.settings, observer);
    run.expect(windows, points);
    run.line.length = length;
    let operator = WindowOperator::element(points, S::from(window_length));
    for index in 1..=windows {
        let mut window = engine.next().ok()??;
        let gamma = if index == windows { length } else { S::from(index as f64 * window_length) };
        run.line.iterations.count += window.sweeps;
        if index == windows {
            run.line.handed = window.handed();
        }
        append(&mut run, &mut window, &operator, gamma).ok()?;
        run.end_window();
    }
    run.show();
    Some(run.line)
}

/// Adds a window with this operator to the run, which ends at γ − γ_i = `end`, and does not show it yet. Momenta of
/// ignorable coordinates stay those of the start.
fn append<S: Real>(
    run: &mut Run<'_, S>,
    window: &mut Window<'_>,
    operator: &Arc<WindowOperator<S>>,
    end: S,
) -> Result<(), NoSolution> {
    let (line, here) = (&run.line, &mut run.here);
    here.q.iter_mut().zip(&window.end().q).for_each(|(to, q)| *to = S::from(q.high));
    line.geometry().active().iter().zip(&window.end().p).for_each(|(&a, end)| here.p[a] = S::from(end.high));
    let gradient_norm = window.gradient_norm().unwrap_or(f64::INFINITY);
    if !run.begin_window(operator, end, (S::from(gradient_norm), &[])) {
        let gamma = run.line.gamma_i.to_f64() + window.gamma;
        let failure = NoSolution::overflow(run.line.geometry(), gamma, &run.here.q).marched();
        return Err(NoSolution { residual: gradient_norm, ..failure });
    }
    let (line, nodes) = (&mut run.line, window.nodes());
    line.iterations.initial_guess = InitialGuess::Extrapolation;
    let copy = |to: &mut Vec<S>, row: &[f64]| to.extend(row.iter().map(|&value| S::from(value)));
    line.q.iter_mut().enumerate().for_each(|(a, to)| copy(to, nodes.q(a)));
    line.p.iter_mut().enumerate().for_each(|(place, to)| copy(to, nodes.p(place)));
    line.sensitivity.iter_mut().for_each(|sensitivity| window.carry(sensitivity));
    Ok(())
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
        let (near, whole) = (watches.near(&change, &window), window.length);
        let mut value = |state: &State| {
            let value = watches.at(change.place, state);
            let is_none = change.none.is_some_and(|none| value.abs() <= none);
            if is_none { -change.side * f64::MIN_POSITIVE } else { value }
        };
        let mut end_where = |between| engine.end_where(between, change.side, &mut value);
        let is_near = near.map_or(Ok(false), &mut end_where)?;
        // Windows of another length are off by another error, beside which a kink may be narrow.
        let [low, high] = change.between;
        let widths = (0..MOST_WIDER).map(|power| (high - low) * WIDER.powi(power) - (high - low));
        let mut wider = widths.take_while(|width| *width < whole).map(|w| [(low - w).max(0.0), (high + w).min(whole)]);
        let mut is_met = is_near;
        while !is_met && let Some(between) = wider.next() {
            is_met = end_where(between)?;
        }
        if !is_met {
            break;
        }
        *ended_by = Some(change.place);
        window = engine.window();
    }
    Ok(())
}

/// The lengths of the longest and of the shortest window so far, with γ and the state where they begin.
#[derive(Default)]
struct Extremes {
    longest: Option<(f64, f64, State)>,
    shortest: Option<(f64, f64, State)>,
}

impl Extremes {
    fn see(&mut self, window: &Window<'_>) {
        let (h, seen) = (window.length, || Some((window.length, window.gamma, window.start().clone())));
        if self.longest.as_ref().is_none_or(|(longest, ..)| h > *longest) {
            self.longest = seen();
        }
        if self.shortest.as_ref().is_none_or(|(shortest, ..)| h < *shortest) {
            self.shortest = seen();
        }
    }
}

/// A run to an accuracy on its way.
struct March<'s, S: Real> {
    setup: &'s Setup<S>,
    wanted: Accuracy,
    engine: Engine<'s>,
    extremes: Extremes,
    /// The number of sweeps before the run was begun again for the last time.
    before: usize,
}

impl<'s, S: Real> March<'s, S> {
    /// The run at its start.
    fn new(setup: &'s Setup<S>, wanted: Accuracy) -> Self {
        let Place { geometry, start } = &setup.rough;
        let engine = match setup.limit {
            Limit::Length(length) => Engine::accurate(geometry, start, length.to_f64(), wanted),
            Limit::Value { coordinate, value } => {
                let value = (value - setup.origin_of(coordinate)).to_f64();
                Engine::accurate_to_value(geometry, start, (coordinate, value), wanted)
            }
        };
        let mut engine = engine.expect("a run begins inside the domain");
        engine.set_floors(&setup.floors);
        engine.resume(setup.handed());
        Self { setup, wanted, engine, extremes: Extremes::default(), before: 0 }
    }

    /// Goes to the end of the run, window by window. All of them are kept, or the last few.
    fn go(
        &mut self,
        run: &mut Run<'_, S>,
        mut judge: Option<&mut Judge<'_, S>>,
        is_kept: bool,
    ) -> Result<(), NoSolution> {
        let setup = self.setup;
        let mut watches = Watches::new(setup);
        let mut operators = Operators::default();
        loop {
            let index = match next(&mut self.engine, judge.as_deref_mut()) {
                Ok(Some(window)) => window.index,
                Ok(None) => return Ok(()),
                Err(Failure::BeginAgain) => {
                    self.engine.begin_again();
                    self.before = self.engine.sweeps();
                    continue;
                }
                Err(failure) => return Err(self.failed(failure)),
            };
            // Both marches have passed the window before.
            if index > 0 {
                run.judge_window(self.engine.errors());
            } else {
                self.extremes = Extremes::default();
                run.clear();
                watches.begin();
                (run.line.ended_by, run.line.ended_at, run.line.watched) = (None, None, Watched::default());
            }
            if !setup.until.is_empty() {
                if let Err(failure) = cut(&mut self.engine, &mut watches, &mut run.line.ended_by) {
                    return Err(self.failed(failure));
                }
                watches.accept(&self.engine.window(), &mut run.line.watched);
            }
            let mut window = self.engine.window();
            if !window.is_last {
                self.extremes.see(&window);
            }
            if let (Limit::Value { coordinate, value }, true) =
                (setup.limit, window.is_last && run.line.ended_by.is_none())
            {
                // t_i + (t_f − t_i), rounded twice, may be the neighbouring number.
                run.line.ended_at = Some((coordinate, value));
            }
            let end = window.gamma + window.length;
            let operator = operators.of_length(S::from(window.length));
            append(run, &mut window, &operator, S::from(end))?;
            let nodes = is_kept.then_some(run.line.window_count * POINTS);
            self.within_limits(nodes, self.done(end, run.here.q.iter().map(|q| q.to_f64())))?;
        }
    }

    /// The part of the run that is done at this γ and q^a.
    fn done(&self, gamma: f64, mut q: impl Iterator<Item = f64>) -> f64 {
        match self.setup.limit {
            Limit::Length(length) => gamma / length.to_f64(),
            Limit::Value { coordinate, value } => {
                let value = (value - self.setup.origin_of(coordinate)).to_f64();
                let from = self.setup.rough.start.q[coordinate];
                q.nth(coordinate).map_or(0.0, |q| (q - from) / (value - from))
            }
        }
    }

    /// A failure at the place where the engine stands.
    fn stopped(&self, status: Status) -> NoSolution {
        let (gamma, q) = self.engine.place();
        let q: Vec<S> = q.into_iter().map(S::from).collect();
        NoSolution::new(status, &self.setup.place.geometry, self.setup.gamma_i.to_f64() + gamma, &q).adaptive()
    }

    /// Ends a run that memory cannot hold, or that would take too long. Windows become longer after the first few: a
    /// forecast of nodes is believed when they are a thousandth of what is allowed.
    fn within_limits(&self, nodes: Option<usize>, done: f64) -> Result<(), NoSolution> {
        let sweeps = self.engine.sweeps();
        // Sweeps before the run was begun again tell nothing of its pace.
        let own = sweeps - self.before;
        let needed = self.before as f64 + own as f64 / done.max(0.0);
        if needed > MOST_SWEEPS && own > 10_000 {
            let mut failure = NoSolution { needed, ..self.stopped(Status::EvaluationLimit) };
            failure.iterations.count = sweeps;
            return Err(failure);
        }
        let Some(nodes) = nodes.map(|nodes| nodes as f64) else { return Ok(()) };
        let needed = nodes / done;
        let is_foreseen = nodes > 1e-3 * MOST_NODES && needed > FORECAST * MOST_NODES;
        if nodes > MOST_NODES || is_foreseen {
            return Err(NoSolution { needed, ..self.stopped(Status::TooManyNodes) });
        }
        Ok(())
    }

    /// The world-line of a run that came to its end.
    fn ended(self, mut line: WorldLine<S>) -> WorldLine<S> {
        line.length = match self.setup.limit {
            Limit::Length(length) if line.ended_by.is_none() => length,
            _ => S::from(self.engine.place().0),
        };
        if let Some(last) = line.windows.last_mut() {
            last.gamma[1] = line.length;
        }
        (line.error_estimate, line.errors) = (self.engine.error_estimate(), self.engine.errors());
        (line.sizes, line.good_until) = (self.engine.sizes(), self.engine.good_until());
        line.windows_unproved = Some(self.engine.unresolved());
        // The last window may have gone on behind the end.
        let touched = self.engine.touched().filter(|gamma| *gamma <= line.length.to_f64());
        line.touched = touched.map(|gamma| line.gamma_at(S::from(gamma)).to_f64());
        line.iterations.count = self.engine.sweeps();
        line
    }

    /// Expresses a failure of the engine in terms of the setup.
    fn failed(&mut self, failure: Failure) -> NoSolution {
        let names = self.setup.place.geometry.names();
        let of_rounding: Vec<String> = self.engine.moved_by_rounding().into_iter().map(|a| names[a].clone()).collect();
        let Setup { rough, gamma_i, place, .. } = self.setup;
        let status = match failure {
            Failure::OutsideDomain(outside) => {
                let (gamma, q) = self.engine.place();
                let (gamma, q) = (gamma_i.to_f64() + gamma, q.into_iter().map(S::from).collect::<Vec<S>>());
                return NoSolution::outside(&place.geometry, gamma, Some(&q), &outside).adaptive();
            }
            Failure::NotConverged | Failure::TooShort => Status::Stalled,
            Failure::ValueNotReached => Status::EndTimeNotReached,
            Failure::Accuracy | Failure::BeginAgain => Status::AccuracyNotReached,
        };
        let failure = self.stopped(status);
        // A run that is not accurate enough has come to its end: what made it short of that it has passed.
        if status != Status::AccuracyNotReached {
            return NoSolution {
                reasons: Box::new(Reasons { towards_zero: self.singular(), of_rounding, ..Reasons::default() }),
                ..failure
            };
        }
        let narrow =
            self.extremes.shortest.as_ref().zip(self.extremes.longest.as_ref()).and_then(|(shortest, longest)| {
                let (share, gamma) = (shortest.0 / longest.0, gamma_i.to_f64() + shortest.1);
                let is_narrow = share < NARROW && self.haste(&shortest.2) * share >= OF_MOTION * self.haste(&longest.2);
                is_narrow.then(|| Narrow { share, gamma, point: point(&rough.geometry, &shortest.2.positions()) })
            });
        NoSolution {
            residual: self.engine.error_estimate().unwrap_or(f64::INFINITY),
            needed: self.engine.reachable().unwrap_or(f64::INFINITY),
            asked: self.wanted.value(),
            reasons: Box::new(Reasons { narrow, of_rounding, ..Reasons::default() }),
            ..failure
        }
    }

    /// The fastest rate at which small errors change at a state: the largest √|J_ij J_ji| of the linearised equations,
    /// in which units cancel. Without a limit where it is no number.
    fn haste(&self, state: &State) -> f64 {
        let Place { geometry, start } = &self.setup.rough;
        let (n, mut p) = (2 * geometry.active().len(), start.p.clone());
        geometry.active().iter().zip(state.momenta()).for_each(|(&a, own)| p[a] = own);
        let mut jacobian = vec![0.0_f64; n * n];
        geometry.point().jacobian(&state.positions(), &p, |row, column, value| jacobian[row * n + column] = value);
        let pairs = (0..n * n).map(|at| (jacobian[at].abs() * jacobian[at % n * n + at / n].abs()).sqrt());
        pairs.fold(0.0, |most, rate| if rate.is_nan() { f64::INFINITY } else { f64::max(most, rate) })
    }

    /// The coordinates that are small where the engine stands, if there are no rates where they are 0.
    fn singular(&self) -> Vec<String> {
        let (Place { geometry, start }, sizes) = (&self.setup.rough, self.engine.sizes());
        let (_, mut q) = self.engine.place();
        let is_small = |&&a: &&usize| q[a].abs() < SMALL * sizes[a];
        let small: Vec<usize> = geometry.active().iter().filter(is_small).copied().collect();
        small.iter().for_each(|&a| q[a] = 0.0);
        let has_rates = geometry.point().evaluate(&q, &start.p).is_ok();
        if has_rates { Vec::new() } else { small.iter().map(|&a| geometry.names()[a].clone()).collect() }
    }
}
