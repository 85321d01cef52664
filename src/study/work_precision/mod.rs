//! Speed against accuracy: every scheme of this program beside other methods, on the world-line of one case.
//!
//! # What is measured
//!
//! Every method has to return t, x and w = dx/dγ at [`OUTPUTS`] equally spaced values of γ, the end included. If it has
//! a dense output, it uses that; otherwise its steps or windows divide the intervals between these values.
//! ([`crate::methods`] says which methods have one; of this program, `march` and `accuracy` have.) The errors are the
//! largest absolute differences of t and x from the reference at these points. The reference is a Taylor trajectory in
//! extended precision, with enough digits for the length of the run. |ΔK| is formed from x, w and Q_t. Q_t itself is
//! *not* compared: it is a constant in the equations of the other methods, so that its drift would prove nothing.
//!
//! The schemes of this program are timed as [`crate::solve()`], with its certificate and everything that it stores.
//! `accuracy` is timed as [`crate::solve::solve_window_by_window`], with its certificate and its samples. `march` is
//! [`crate::lobatto`], without certificate and storage.
//!
//! # How it is timed
//!
//! One process and one thread are used. Each setting is tried once, which warms up the machine and shows the cost and
//! the accuracy. Then come rounds over all settings that succeeded. In each round they take turns, so that a
//! disturbance affects all methods alike. Short runs are repeated within a round until the clock can resolve them. The
//! minimum and the median over the rounds are reported; their difference shows the noise. A setting that failed or is
//! inaccurate keeps the time of its trial and is never part of the front.
//!
//! # Settings
//!
//! The numbers of steps, nodes and windows grow geometrically, and tolerances shrink. A family of settings ends when a
//! setting costs more than [`Budget::longest`] or its errors have stopped falling. Methods whose iteration has a
//! tolerance of its own (`march` and Gauss) get the loosest one that hardly changes the error of the same setting
//! iterated to rounding. The tolerances that are tried are a hundredth of that error, a ten-thousandth, and so on,
//! since errors of the iteration can accumulate. That is the best choice that a user could make, for both methods
//! alike.

mod drift;
mod family;
mod front;
mod run;
mod trial;

use std::sync::atomic::{AtomicBool, Ordering};

pub use drift::{DriftPoint, drift};
pub use family::{Family, Group};
pub use front::{Leader, Ratio, front, ratios};

use self::trial::{time, try_family};
use crate::case::{Case, End};
use crate::geodesic::Invariants;
use crate::methods::{Output, Problem, State};
use crate::norm::larger;
use crate::reference::{ReferenceEnds, ReferencePoint, ReferenceTrajectory};
use crate::scalar::{Extended, Real};

/// Number of points at which every method reports its state.
pub const OUTPUTS: usize = 10;

/// With an error above this share of the largest |x|, or of the largest |t − t_i|, a setting has no result.
const INACCURATE: f64 = 0.1;
/// How much is measured.
#[derive(Debug, Clone, PartialEq)]
pub struct Budget {
    /// Seconds that a single run may take. After a longer one, no further setting of its family is tried.
    pub longest: f64,
    /// Number of rounds for runs below a millisecond. Runs below ten milliseconds have half of them and longer runs a
    /// fifth, but at least three.
    pub rounds: usize,
    /// Largest number of settings of a family.
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
    /// With errors as large as the result: above a tenth of the largest |x| or |t − t_i|.
    Inaccurate,
    /// Without a result. The word is that of [`crate::Status`] or of [`crate::methods::Failure`].
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
    /// The largest error of t.
    pub t: f64,
    /// The largest error of x.
    pub x: f64,
    /// max |K − K(start)|.
    pub delta_k: f64,
}

impl RowErrors {
    /// The larger of the errors of t and x, by which rows are ranked.
    pub fn largest(&self) -> f64 {
        self.t.max(self.x)
    }
}

/// One method in one setting.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// The method.
    pub family: Family,
    /// Its setting, for display.
    pub setting: String,
    /// γ_f − γ_i.
    pub gamma_f: f64,
    /// The errors, if there is a result.
    pub errors: Option<RowErrors>,
    /// Least seconds of a run.
    pub seconds_min: f64,
    /// Median over the rounds.
    pub seconds_median: f64,
    /// Number of evaluations of the potential: one per node in each sweep or iteration of Newton's method, without
    /// those of the first guess and the certificate. For a series, the number of its coefficients.
    pub evaluations: usize,
    /// Number of nodes, or of steps.
    pub points: usize,
    /// How it ended.
    pub status: RowStatus,
}

impl Row {
    /// The error by which it is ranked; `None` without a result.
    pub fn rank(&self) -> Option<f64> {
        self.errors.filter(|_| self.status == RowStatus::Converged).map(|errors| errors.largest())
    }
}

/// The problem on which all methods are compared: the world-line over one length, and its reference.
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
        // Sixteen digits of t at the end, and four more to judge them. Errors of the phase grow with the square of the
        // length.
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

    /// Number of Taylor steps of the reference, by which settings are scaled.
    fn scale(&self) -> f64 {
        self.reference.steps() as f64
    }

    /// The errors of `states` at the points of `output`.
    fn errors(&self, output: &Output, states: &[State]) -> RowErrors {
        let mut largest = RowErrors { t: 0.0, x: 0.0, delta_k: 0.0 };
        for (gamma, state) in output.gamma(self.problem.length).zip(states) {
            let RowErrors { t, x, delta_k } = self.error(gamma, state);
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

/// The measured rows, for one length or several.
#[derive(Debug, Clone, Default)]
pub struct WorkPrecision {
    /// All rows: families in order, settings from cheap to expensive.
    pub rows: Vec<Row>,
    /// Whether it was cancelled before it was complete.
    pub interrupted: bool,
}

/// Reports of what has been done. They contain all rows, so that a listener has them at any time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Progress<'a> {
    /// A setting was tried, which gives another row.
    Tried(&'a Row),
    /// The row with this index has been timed again.
    Retimed(usize, &'a Row),
    /// The number of rounds that are done, and the number of all rounds.
    Round(usize, usize),
}

/// Tries all settings of `families` and times those that succeed. Once `cancel` is true, it ends with the rows so far.
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
        trials.extend(try_family(arena, family, budget, &is_cancelled, &mut |row| progress(Progress::Tried(row))));
    }
    time(&mut trials, budget, &is_cancelled, progress);
    WorkPrecision { rows: trials.into_iter().map(|trial| trial.row).collect(), interrupted: is_cancelled() }
}
