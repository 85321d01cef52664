//! `summary.json` of `run`: what was solved, how the solve ended, and the numbers that a study needs.

mod one;
mod scene;

use std::collections::BTreeMap;

use serde::Serialize;

use crate::case::{Form, System};
use crate::diagnostics::verdict::Verdict;
use crate::engine::{Accuracy, GOOD_DIGITS};
use crate::number::Real;
use crate::solve::{Domain, IterationRecord, Iterations, NoSolution, Settings, Status, WorldLine};

pub use one::{Error, Solved};
pub use scene::SolvedScene;

/// The summary of a case of one coordinate.
pub type Summary = SummaryOf<Solved>;

/// The summary of a scene.
pub type SceneSummary = SummaryOf<SolvedScene>;

/// The whole summary, with `R` as the numbers of a result; keys that do not apply are absent.
#[derive(Debug, Clone, Serialize)]
pub struct SummaryOf<R> {
    /// How the solve ended.
    pub status: Status,
    /// How far the result is to be believed.
    #[serde(flatten)]
    pub verdict: Verdict,
    /// Version of this program.
    pub version: &'static str,
    /// The case's title.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub title: Option<String>,
    /// The coordinates of a scene.
    #[serde(flatten)]
    pub coordinates: Option<Coordinates>,
    /// Operator.
    pub sbp: String,
    /// Form of the action.
    pub form: Form,
    /// System solved.
    pub system: System,
    /// In one coordinate: whether the action has D̄ or, without the regularisation, D.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub regularised: Option<bool>,
    /// Significant digits of the arithmetic.
    pub digits: u32,
    /// Number of nodes of each window.
    pub n_gamma: usize,
    /// Number of windows.
    pub windows: usize,
    /// The accuracy asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub accuracy: Option<f64>,
    /// The tolerance asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tolerance: Option<f64>,
    /// First guess of the Newton iteration.
    pub initial_guess: &'static str,
    /// Newton iterations.
    pub iterations: usize,
    /// Seconds spent in the solver.
    pub solve_seconds: f64,
    /// The numbers of the result, or of the failure.
    #[serde(flatten)]
    pub outcome: Outcome<R>,
    /// What came after the solve, if it has a result.
    #[serde(flatten)]
    pub seconds: Option<Seconds>,
    /// The warnings that were printed.
    pub warnings: Vec<String>,
    /// The iterations; with several windows, those of the window that took most.
    pub history: Vec<IterationRecord>,
}

/// The names of a scene's coordinates.
#[derive(Debug, Clone, Serialize)]
pub struct Coordinates {
    /// All of them.
    pub coordinates: Vec<String>,
    /// Those that nothing depends on.
    pub ignorable: Vec<String>,
    /// The others.
    pub active: Vec<String>,
}

/// Times that a run takes after the solve.
#[derive(Debug, Clone, Copy, Default, Serialize)]
pub struct Seconds {
    /// Seconds spent in measuring the result.
    #[serde(rename = "diagnostics_seconds")]
    pub diagnostics: f64,
    /// Seconds spent in formatting and writing the CSV files.
    #[serde(rename = "write_seconds")]
    pub write: f64,
}

/// The part of the summary that depends on how the solve ended.
#[derive(Debug, Clone, Serialize)]
#[serde(untagged)]
pub enum Outcome<R> {
    /// A critical point was found.
    Solved(Box<R>),
    /// No critical point was found.
    Failed(Failed),
}

/// How far a solve without a result came.
#[derive(Debug, Clone, Serialize)]
pub struct Failed {
    /// The message for people.
    pub message: String,
    /// What to try.
    pub advice: &'static str,
    /// γ of the point that the message is about.
    pub gamma: f64,
    /// What is known of that point.
    #[serde(flatten)]
    pub point: Point,
    /// Largest residual entry of the last iterate; null if there was none.
    pub residual: f64,
}

/// Where a solve failed.
#[derive(Debug, Clone, Serialize)]
#[serde(untagged)]
pub enum Point {
    /// In one coordinate.
    One {
        /// x.
        x: f64,
        /// g00 there.
        g00: f64,
    },
    /// In a scene.
    Scene {
        /// The active coordinates, where they are known.
        point: BTreeMap<String, f64>,
    },
}

/// How a solve ended, with what was measured on its result.
struct Ended<R> {
    status: Status,
    verdict: Verdict,
    /// With an accuracy the scheme is the one that was chosen; if the solve failed, none was.
    settings: Settings,
    iterations: Iterations,
    outcome: Outcome<R>,
    /// Warnings about the result.
    suspicions: Vec<String>,
}

impl<R> Ended<R> {
    /// Without a result.
    fn without(failure: &NoSolution, settings: Settings) -> Self {
        Self {
            status: failure.status,
            verdict: Verdict::refused(),
            settings,
            iterations: (*failure.iterations).clone(),
            outcome: Outcome::Failed(Failed::new(failure)),
            suspicions: Vec::new(),
        }
    }
}

impl<R> SummaryOf<R> {
    /// The summary of a solve of a case with this title and these warnings.
    fn of(title: Option<&str>, mut warnings: Vec<String>, ended: Ended<R>, solve_seconds: f64) -> Self {
        let Settings { sbp, form, n_gamma, windows, system, digits, accuracy, .. } = ended.settings;
        warnings.extend(ended.suspicions);
        Self {
            status: ended.status,
            verdict: ended.verdict,
            version: env!("CARGO_PKG_VERSION"),
            title: title.map(str::to_owned),
            coordinates: None,
            sbp: sbp.into(),
            form,
            system,
            regularised: None,
            digits,
            n_gamma,
            windows,
            accuracy: accuracy.filter(|accuracy| accuracy.is_promised()).map(Accuracy::value),
            tolerance: accuracy.filter(|accuracy| !accuracy.is_promised()).map(Accuracy::value),
            initial_guess: ended.iterations.initial_guess.as_str(),
            iterations: ended.iterations.count,
            solve_seconds,
            seconds: matches!(ended.outcome, Outcome::Solved(_)).then(Seconds::default),
            outcome: ended.outcome,
            warnings,
            history: ended.iterations.history,
        }
    }

    /// The numbers of the result, if there is one.
    pub fn solved(&self) -> Option<&R> {
        match &self.outcome {
            Outcome::Solved(solved) => Some(solved),
            Outcome::Failed(_) => None,
        }
    }

    /// The same, to change them.
    pub fn solved_mut(&mut self) -> Option<&mut R> {
        match &mut self.outcome {
            Outcome::Solved(solved) => Some(solved),
            Outcome::Failed(_) => None,
        }
    }
}

impl<R: Serialize> SummaryOf<R> {
    /// The JSON text, with a final newline.
    pub fn to_json(&self) -> String {
        json(self)
    }
}

impl Failed {
    fn new(failure: &NoSolution) -> Self {
        let point = || failure.point.iter().cloned().collect();
        Self {
            message: failure.to_string(),
            advice: failure.advice(),
            gamma: failure.gamma,
            point: match failure.domain {
                Domain::G00(g00) | Domain::Overflow(g00) => {
                    Point::One { x: failure.point.first().map_or(f64::NAN, |(_, x)| *x), g00 }
                }
                Domain::Determinant { .. } | Domain::Scene => Point::Scene { point: point() },
            },
            residual: failure.residual,
        }
    }
}

/// Indented JSON with a final newline.
pub(super) fn json(summary: &impl Serialize) -> String {
    let mut text = serde_json::to_string_pretty(summary).expect("a summary has string keys only");
    text.push('\n');
    text
}

/// One indented JSON object, with a final newline, from several JSON texts and their names.
pub fn json_object(members: &[(&str, String)]) -> String {
    // Strings of JSON contain no line breaks, so all lines can be indented.
    let member = |(name, text): &(&str, String)| format!("  \"{name}\": {}", text.trim_end().replace('\n', "\n  "));
    format!("{{\n{}\n}}\n", members.iter().map(member).collect::<Vec<_>>().join(",\n"))
}

/// In a run to a tolerance γ until which so many digits are good, by their number.
fn good_until<S: Real>(line: &WorldLine<S>) -> Option<BTreeMap<String, f64>> {
    let gamma_i = line.gamma_i.to_f64();
    let until = GOOD_DIGITS.iter().zip(line.good_until);
    let has_tolerance = line.accuracy.is_some_and(|accuracy| !accuracy.is_promised());
    has_tolerance.then(|| until.map(|(digits, until)| (digits.to_string(), gamma_i + until)).collect())
}
