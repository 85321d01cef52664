//! Trying settings one after the other, and timing those that succeed in turns.

use super::{Arena, Budget, Method, OUTPUTS, Progress, Row, RowStatus};
use crate::case::{Form, SbpName, on_grid};
use crate::methods::{Failure, Output, Prepared, Setting, States, Step, Trajectory};
use crate::solve::{Joint, WorldLine, solve};
use crate::study::subject::timed;

/// Runs shorter than this many seconds are repeated within a round until they take that long.
const BATCH: f64 = 5e-5;
/// A method ends after this many settings whose errors are no longer smaller. Only errors below the second number times
/// the size of t or x count: those are due to rounding, and not to an irregularity of coarse settings.
const PLATEAU: usize = 3;
const ROUNDING: f64 = 1e-9;
/// The loosest tolerance that is tried for an iteration is the error divided by the first number, and the tightest one
/// is ten to the power of the second. A tolerance is accepted if the error grows by at most the third number, a factor.
const LOOSEST: f64 = 100.0;
const TIGHTEST: f64 = -15.0;
const SPOILT: f64 = 1.5;

/// A row, and the job to run it again.
pub(super) struct Trial<'a> {
    pub(super) row: Row,
    job: Job<'a>,
    /// Seconds of the first run.
    tried: f64,
    /// Seconds of a run in each of the rounds.
    samples: Vec<f64>,
}

impl Trial<'_> {
    /// Runs it again. Its results are not looked at: a run that succeeded once succeeds again.
    fn repeat(&mut self) {
        // The time of the trial includes warming up. From the second round on, that of the first round shows better how
        // many runs make a batch.
        let known = self.samples.first().copied().unwrap_or(self.tried);
        let runs = (BATCH / known.max(1e-9)).ceil().clamp(1.0, 1000.0) as u32;
        let ((), seconds) = timed(|| (0..runs).for_each(|_| drop(std::hint::black_box((self.job)()))));
        self.samples.push(seconds / f64::from(runs));
        let mut samples = self.samples.clone();
        samples.sort_by(f64::total_cmp);
        (self.row.seconds_min, self.row.seconds_median) = (samples[0], samples[samples.len() / 2]);
    }
}

/// Tries the settings of one method, from cheap to expensive.
pub(super) fn try_method<'a>(
    arena: &'a Arena,
    method: &Method,
    budget: &Budget,
    tried: &mut dyn FnMut(&Row),
) -> Vec<Trial<'a>> {
    let mut trials: Vec<Trial<'a>> = Vec::new();
    let (mut least, mut stale, size) = (f64::INFINITY, 0, arena.sizes.iter().copied().fold(0.0, f64::max));
    for setting in method.settings(arena.scale()).take(budget.settings) {
        let trial = try_setting(arena, method, setting);
        tried(&trial.row);
        let (rank, seconds) = (trial.row.rank(), trial.tried);
        trials.push(trial);
        if let Some(error) = rank {
            // A slightly smaller error is no progress, since settings differ by factors. Adaptive methods have only a
            // few tolerances, and may take the same steps for several of them, so that all of these are tried.
            let rounding = error < ROUNDING * size && !method.is_adaptive();
            stale = if error < 0.8 * least || !rounding { 0 } else { stale + 1 };
            least = least.min(error);
        }
        if seconds > budget.longest || stale >= PLATEAU {
            break;
        }
    }
    trials
}

/// Runs a setting. If the iteration of the method has a tolerance, it is run to rounding first, and then with tighter
/// and tighter tolerances, by factors of a hundred, until the error is about the same.
fn try_setting<'a>(arena: &'a Arena, method: &Method, setting: Setting) -> Trial<'a> {
    let to_rounding = attempt(arena, method, setting);
    let (Some(error), true) = (to_rounding.row.rank(), method.step() == Step::Iterated) else { return to_rounding };
    let mut power = (error / LOOSEST).log10().floor();
    while power >= TIGHTEST {
        let trial = attempt(arena, method, Setting { tolerance: 10.0_f64.powf(power), ..setting });
        if trial.row.rank().is_some_and(|rank| rank <= SPOILT * error) {
            return trial;
        }
        power -= 2.0;
    }
    to_rounding
}

fn attempt<'a>(arena: &'a Arena, method: &Method, setting: Setting) -> Trial<'a> {
    let output = Output::even(OUTPUTS);
    let mut job = job(arena, method, setting, &output);
    let (found, seconds) = timed(&mut job);
    let (status, errors, evaluations, points) = match found {
        Ok(Trajectory { states, evaluations, steps }) => {
            let errors = arena.errors(&output, &states);
            (arena.judge(&errors), Some(errors), evaluations, steps)
        }
        Err(word) => (RowStatus::Failed(word), None, 0, 0),
    };
    let row = Row {
        method: method.clone(),
        setting: method.setting(setting),
        gamma_f: arena.length(),
        errors,
        seconds_min: seconds,
        seconds_median: seconds,
        evaluations,
        points,
        status,
    };
    Trial { row, job, tried: seconds, samples: Vec::new() }
}

/// Times all settings that succeeded, in rounds.
pub(super) fn time(trials: &mut [Trial<'_>], budget: &Budget, progress: &mut dyn FnMut(Progress)) {
    let rounds = |seconds: f64| match seconds {
        ..1e-3 => budget.rounds,
        ..1e-2 => budget.rounds.div_ceil(2),
        _ => budget.rounds.div_ceil(5),
    };
    for round in 0..budget.rounds {
        let is_due = |trial: &Trial<'_>| trial.row.status == RowStatus::Converged && round < rounds(trial.tried).max(3);
        trials.iter_mut().filter(|trial| is_due(trial)).for_each(Trial::repeat);
        for (index, trial) in trials.iter().enumerate().filter(|(_, trial)| is_due(trial)) {
            progress(Progress::Retimed(index, trial.row.clone()));
        }
        progress(Progress::Round(round + 1, budget.rounds));
    }
}

/// A run to be timed: what a user would have to do as well. It returns what it finds at the marks of its output.
type Job<'a> = Box<dyn FnMut() -> Result<Trajectory, &'static str> + 'a>;

/// A method in a setting.
pub(super) fn job<'a>(arena: &'a Arena, method: &Method, setting: Setting, output: &Output) -> Job<'a> {
    let (problem, count, output) = (&arena.problem, setting.count, output.clone());
    let ((sbp, form), nodes) = match *method {
        Method::Block(sbp, form) => ((sbp, form), count + 1),
        Method::Elements(nodes) => ((SbpName::Gll(nodes as u8), Form::Weak), count * (nodes - 1) + 1),
        _ => match method.peer() {
            Some(peer) => return stepped(peer.prepared(problem, output, setting)),
            None => return Box::new(|| Err("elsewhere")),
        },
    };
    match on_grid(&arena.setup, (sbp, form), nodes, arena.length()) {
        Ok(setup) => Box::new(move || match solve(&setup) {
            Ok(line) => Ok(at_marks(&line, &output)),
            Err(failure) => Err(failure.status.as_str()),
        }),
        Err(_) => Box::new(|| Err("no-such-grid")),
    }
}

/// A method that computes states.
fn stepped(mut run: Prepared<'_>) -> Job<'_> {
    Box::new(move || run().map_err(Failure::as_str))
}

/// The states of a world-line at the marks of an output, which coincide with ends of windows or with nodes.
fn at_marks(line: &WorldLine, Output { intervals, marks }: &Output) -> Trajectory {
    let (windows, nodes) = (line.windows.len(), line.sbp().points());
    let (active, rows, start) = (line.geometry().active(), line.view(0).rows(), &line.place.start);
    let mut states = States::new(start.q.len(), marks.len());
    for &mark in marks {
        // The number of windows per interval is whole, unless there is one window.
        let end = if windows > 1 { Some(mark * windows / intervals) } else { (mark == *intervals).then_some(1) };
        if let Some(after) = end {
            let Joint { q, p } = line.joint(after);
            states.push(q, p);
            continue;
        }
        let node = mark * (nodes - 1) / intervals;
        let (mut q, mut p) = (start.q.clone(), start.p.clone());
        for (a, (q, row)) in q.iter_mut().zip(&rows).enumerate() {
            *q = if active.contains(&a) { row[node] } else { *q + row[node] };
        }
        line.p.iter().zip(active).for_each(|(row, &a)| p[a] = row[node]);
        states.push(&q, &p);
    }
    // An explicit recursion evaluates once per node and reports no iterations; otherwise the iterations are summed over
    // the windows.
    let sweeps = line.iterations.count.max(windows);
    Trajectory { states, evaluations: sweeps * nodes, steps: windows * nodes }
}
