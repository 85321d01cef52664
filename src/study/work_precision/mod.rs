//! Speed against accuracy: every scheme of this program beside other methods, on the world-line of one case.
//!
//! # What is measured
//!
//! Every method has to hand out t, x and w = dx/dγ at [`OUTPUTS`] equally spaced values of γ, the end included, by its own
//! means: a dense output where it has one, steps or windows that divide the intervals between them where it has not
//! ([`crate::methods`] says which; of this program march and `accuracy` have one). The errors are the largest absolute differences of t and x from the
//! reference at these points, which is a Taylor trajectory in extended precision with enough digits for the length of
//! the run; |ΔK| is formed from (x, w, Q_t) alone. Q_t itself is *not* compared: it is a constant of the other
//! methods' equations, and its drift would prove nothing.
//!
//! This program's schemes are timed as [`crate::solve()`], with its certificate and everything it stores; `accuracy` as
//! [`crate::solve::solve_window_by_window`] with its certificate and its samples; `march` is [`crate::lobatto`] without
//! those.
//!
//! # How it is timed
//!
//! One process, one thread. Each setting is tried once, which warms the machine up and says what it costs and how
//! accurate it is. Then come rounds over all settings that arrived, in turns, so that a disturbance hits all methods alike;
//! short runs are repeated within a round until the clock can resolve them. Handed out are the minimum and the median
//! over the rounds: their distance is the noise. A setting that failed or is inaccurate keeps the time of its trial and
//! never enters the front.
//!
//! # Settings
//!
//! Constant steps, nodes and windows grow geometrically, tolerances shrink; a family ends when a setting costs more than
//! [`Budget::longest`] or its errors have stopped falling. Iterated methods with a tolerance of their own (march, Gauss) get
//! the loosest one that leaves the error of the same setting as it is when it iterates to rounding: a hundredth of it, or
//! less by powers of a hundred where errors of the iteration pile up. That is the best a user could choose, for both alike.

mod drift;
mod family;
mod front;
mod run;

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

pub use drift::{DriftPoint, drift};
pub use family::{Family, Group, Setting};
pub use front::{Leader, Ratio, front, ratios};

use self::run::{Job, Outcome};
use crate::case::{Case, End};
use crate::geodesic::Invariants;
use crate::methods::{Output, Problem, State};
use crate::reference::{ReferenceEnds, ReferencePoint, ReferenceTrajectory};
use crate::scalar::{Extended, Real};

/// Points at which every method hands out its state.
pub const OUTPUTS: usize = 10;

/// An error of this share of the largest |x|, or of t_f − t_i, is no result.
const INACCURATE: f64 = 0.1;
/// Runs shorter than this many seconds are repeated in a round until they take it.
const BATCH: f64 = 5e-5;
/// A family ends after so many settings whose errors are no longer smaller, if they are below this share of the size of t
/// or x: rounding, and no hesitation of coarse settings.
const PLATEAU: usize = 3;
const ROUNDING: f64 = 1e-9;
/// The loosest tolerance of an iteration is the error over this, and the tightest one this power of ten; the error may become
/// larger by this factor.
const LOOSEST: f64 = 100.0;
const TIGHTEST: f64 = -15.0;
const SPOILT: f64 = 1.5;

/// How much is measured.
#[derive(Debug, Clone, PartialEq)]
pub struct Budget {
    /// Seconds that a single run may take; the next setting of its family is not tried.
    pub longest: f64,
    /// Most rounds, for short runs; those of a millisecond get half and longer ones a fifth of it, but three at least.
    pub rounds: usize,
    /// Most settings of a family.
    pub settings: usize,
}

impl Default for Budget {
    fn default() -> Self {
        Self { longest: 0.15, rounds: 15, settings: 40 }
    }
}

/// How a setting ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RowStatus {
    /// With a result.
    Converged,
    /// With errors of the size of the result: a tenth of the largest |x|, or of t_f − t_i.
    Inaccurate,
    /// Without one; the word is that of [`crate::Status`] or of [`crate::methods::Failure`].
    Failed(&'static str),
}

impl RowStatus {
    /// The name used in files.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Converged => "converged",
            Self::Inaccurate => "inaccurate",
            Self::Failed(word) => word,
        }
    }
}

/// Largest errors at the points of output.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RowErrors {
    /// Of t.
    pub t: f64,
    /// Of x.
    pub x: f64,
    /// max |K − K(start)|.
    pub delta_k: f64,
}

impl RowErrors {
    /// The larger one of t and x: what rows are ranked by.
    pub fn largest(&self) -> f64 {
        self.t.max(self.x)
    }
}

/// One method in one setting.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// The method.
    pub family: Family,
    /// Its setting, for people.
    pub setting: String,
    /// γ_f − γ_i.
    pub gamma_f: f64,
    /// The errors, if there is a result.
    pub errors: Option<RowErrors>,
    /// Least seconds of a run.
    pub seconds_min: f64,
    /// Median over the rounds.
    pub seconds_median: f64,
    /// Evaluations of the potential: one a node and sweep, or iteration of Newton's method (without those of its first guess
    /// and of the certificate); of a series its coefficients.
    pub evaluations: usize,
    /// Nodes, or steps.
    pub points: usize,
    /// How it ended.
    pub status: RowStatus,
}

impl Row {
    /// The error it is ranked by, if it may be ranked.
    pub fn rank(&self) -> Option<f64> {
        self.errors.filter(|_| self.status == RowStatus::Converged).map(|errors| errors.largest())
    }
}

/// What all methods are compared on: the world-line over one length, and where it really goes.
pub struct Arena {
    problem: Problem,
    case: Case,
    invariants: Invariants,
    reference: ReferenceTrajectory<Extended>,
    /// Largest |x| and |t − t_i| at the points of output.
    sizes: (f64, f64),
}

impl Arena {
    /// The case's own world-line, or that of another length in γ.
    ///
    /// # Errors
    /// [`ReferenceEnds`] if the geodesic does not go so far.
    pub fn new(case: &Case, length: Option<f64>) -> Result<Self, ReferenceEnds> {
        let metric = case.metric::<Extended>();
        let initial = case.initial_data::<Extended>();
        // Sixteen digits of t at the end, and four to judge by. Errors of the phase grow with the square of the length.
        let digits = |length: f64| (20.0 + (2.0 * length.max(1.0).log10()).ceil()) as u32;
        let length = match (length, case.end::<Extended>()) {
            (Some(length), _) => length,
            (None, End::Length(length)) => length.to_f64(),
            (None, End::Duration(duration)) => {
                ReferenceTrajectory::length_of(&metric, initial, duration, digits(duration.to_f64()))?.to_f64()
            }
        };
        let reference = ReferenceTrajectory::new(&metric, initial, length.into(), digits(length))?;
        let problem = Problem { metric: case.metric(), initial: case.initial_data(), length };
        let at = |gamma: f64| reference.at(gamma.into());
        let sizes = Output::even(OUTPUTS).gamma(length).map(at).fold((0.0_f64, 0.0_f64), |(x, t), point| {
            (x.max(point.x.to_f64().abs()), t.max(point.elapsed.to_f64().abs()))
        });
        let invariants = problem.initial.invariants(&problem.metric);
        Ok(Self { invariants, problem, case: run::plain(case), reference, sizes })
    }

    /// γ_f − γ_i.
    pub fn length(&self) -> f64 {
        self.problem.length
    }

    /// The reference's own estimate of its relative error.
    pub fn reference_error(&self) -> f64 {
        self.reference.error_estimate()
    }

    /// Number of pieces of the world-line in which little happens: what settings are measured out with.
    fn scale(&self) -> f64 {
        self.reference.steps() as f64
    }

    /// The errors of `states` at the points of `output`.
    fn errors(&self, output: &Output, states: &[State]) -> RowErrors {
        let mut largest = RowErrors { t: 0.0, x: 0.0, delta_k: 0.0 };
        for (gamma, state) in output.gamma(self.problem.length).zip(states) {
            let RowErrors { t, x, delta_k } = self.error(gamma, state);
            // `f64::max` would drop a NaN.
            let larger = |a: f64, b: f64| if b <= a { a } else { b };
            largest = RowErrors {
                t: larger(largest.t, t),
                x: larger(largest.x, x),
                delta_k: larger(largest.delta_k, delta_k),
            };
        }
        largest
    }

    fn error(&self, gamma: f64, state: &State) -> RowErrors {
        let ReferencePoint { elapsed, x, .. } = self.reference.at(gamma.into());
        let Invariants { q_t, k } = self.invariants;
        let here = q_t * (q_t / self.problem.metric.at(state.x).g00) - state.w * state.w;
        RowErrors {
            t: (Extended::from(state.elapsed) - elapsed).to_f64().abs(),
            x: (Extended::from(state.x) - x).to_f64().abs(),
            delta_k: (here - k).abs(),
        }
    }

    fn judge(&self, errors: &RowErrors) -> RowStatus {
        let (x, t) = self.sizes;
        // Written so that a NaN is inaccurate.
        let good = errors.x <= INACCURATE * x && errors.t <= INACCURATE * t && errors.delta_k.is_finite();
        if good { RowStatus::Converged } else { RowStatus::Inaccurate }
    }
}

/// A measured chart, of one length or several.
#[derive(Debug, Clone, Default)]
pub struct WorkPrecision {
    /// All rows: families in order, settings from cheap to dear.
    pub rows: Vec<Row>,
    /// Whether it was cancelled before it was complete.
    pub interrupted: bool,
}

/// What is being done, for a progress bar.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Progress<'a> {
    /// A setting of this family was tried.
    Tried(&'a Family),
    /// So many of all rounds are done.
    Timed(usize, usize),
}

/// Tries all settings of `families` and times those that arrive. A true `cancel` ends it with what is there.
pub fn measure(
    arena: &Arena,
    families: &[Family],
    budget: &Budget,
    cancel: &AtomicBool,
    progress: &mut dyn FnMut(Progress<'_>),
) -> WorkPrecision {
    let is_cancelled = || cancel.load(Ordering::Relaxed);
    let mut trials = Vec::new();
    for family in families {
        if is_cancelled() {
            break;
        }
        trials.extend(try_family(arena, family, budget, &is_cancelled, &mut || progress(Progress::Tried(family))));
    }
    time(&mut trials, budget, &is_cancelled, progress);
    WorkPrecision { rows: trials.into_iter().map(|trial| trial.row).collect(), interrupted: is_cancelled() }
}

/// A row with what it takes to run it again.
struct Trial<'a> {
    row: Row,
    job: Job<'a>,
}

/// One family from cheap to dear.
fn try_family<'a>(
    arena: &'a Arena,
    family: &Family,
    budget: &Budget,
    is_cancelled: &dyn Fn() -> bool,
    tried: &mut dyn FnMut(),
) -> Vec<Trial<'a>> {
    let mut trials: Vec<Trial<'a>> = Vec::new();
    let (mut least, mut stale) = (f64::INFINITY, 0);
    for setting in family.settings(arena.scale()).take(budget.settings) {
        if is_cancelled() {
            break;
        }
        let trial = try_setting(arena, family, setting);
        tried();
        let (rank, seconds) = (trial.row.rank(), trial.row.seconds_min);
        trials.push(trial);
        if let Some(error) = rank {
            // A little less is no progress: settings differ by factors. Tolerances are few, and steps may ignore them.
            let rounding = error < ROUNDING * arena.sizes.0.max(arena.sizes.1) && !family.is_adaptive();
            stale = if error < 0.8 * least || !rounding { 0 } else { stale + 1 };
            least = least.min(error);
        }
        if seconds > budget.longest || stale >= PLATEAU {
            break;
        }
    }
    trials
}

/// Runs a setting; where the method has a tolerance for its iteration, to rounding first and then with the loosest one, in
/// steps of a hundred, that leaves about the same error.
fn try_setting<'a>(arena: &'a Arena, family: &Family, setting: Setting) -> Trial<'a> {
    let to_rounding = attempt(arena, family, setting);
    let (Some(error), true) = (to_rounding.row.rank(), family.has_inner_tolerance()) else { return to_rounding };
    let mut power = (error / LOOSEST).log10().floor();
    while power >= TIGHTEST {
        let trial = attempt(arena, family, setting.with_inner(10.0_f64.powf(power)));
        if trial.row.rank().is_some_and(|rank| rank <= SPOILT * error) {
            return trial;
        }
        power -= 2.0;
    }
    to_rounding
}

fn attempt<'a>(arena: &'a Arena, family: &Family, setting: Setting) -> Trial<'a> {
    let output = Output::even(OUTPUTS);
    let job = Job::new(arena, family, setting, output.clone());
    let start = Instant::now();
    let result = job.run();
    let seconds = start.elapsed().as_secs_f64();
    let (status, errors, evaluations, points) = match result.and_then(|raw| raw.outcome(&output)) {
        Ok(Outcome { states, evaluations, points }) => {
            let errors = arena.errors(&output, &states);
            (arena.judge(&errors), Some(errors), evaluations, points)
        }
        Err(word) => (RowStatus::Failed(word), None, 0, 0),
    };
    let row = Row {
        family: family.clone(),
        setting: family.label(&setting),
        gamma_f: arena.length(),
        errors,
        seconds_min: seconds,
        seconds_median: seconds,
        evaluations,
        points,
        status,
    };
    Trial { row, job }
}

/// Rounds over all that arrived, in turns.
fn time(
    trials: &mut [Trial<'_>],
    budget: &Budget,
    is_cancelled: &dyn Fn() -> bool,
    progress: &mut dyn FnMut(Progress<'_>),
) {
    let rounds = |seconds: f64| match seconds {
        ..1e-3 => budget.rounds,
        ..1e-2 => budget.rounds.div_ceil(2),
        _ => budget.rounds.div_ceil(5),
    };
    let mut samples: Vec<Vec<f64>> = vec![Vec::new(); trials.len()];
    for round in 0..budget.rounds {
        for (trial, samples) in trials.iter().zip(&mut samples) {
            if trial.row.status != RowStatus::Converged || round >= rounds(trial.row.seconds_min).max(3) {
                continue;
            }
            if is_cancelled() {
                break;
            }
            // The trial was cold: the first round says how often a run fits into a batch.
            let known = samples.first().copied().unwrap_or(trial.row.seconds_min);
            let repetitions = (BATCH / known.max(1e-9)).ceil().clamp(1.0, 1000.0) as u32;
            let start = Instant::now();
            for _ in 0..repetitions {
                // A run that arrived once arrives again.
                drop(std::hint::black_box(trial.job.run()));
            }
            samples.push(start.elapsed().as_secs_f64() / f64::from(repetitions));
        }
        progress(Progress::Timed(round + 1, budget.rounds));
    }
    for (trial, mut samples) in trials.iter_mut().zip(samples) {
        samples.sort_by(f64::total_cmp);
        if let Some(&least) = samples.first() {
            trial.row.seconds_min = least;
            trial.row.seconds_median = samples[samples.len() / 2];
        }
    }
}
