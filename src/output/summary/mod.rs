//! `summary.json` of `run`: what was solved, how the solve ended, and the numbers that a study needs.

mod by_name;
mod paper;

use std::collections::BTreeMap;

use serde::Serialize;

use crate::case::{Case, Form, System};
use crate::diagnostics::gaps::Gaps;
use crate::diagnostics::verdict::Verdict;
use crate::engine::{Accuracy, GOOD_DIGITS};
use crate::geometry::Geometry;
use crate::number::Real;
use crate::solve::{Continuation, Domain, IterationRecord, Iterations, NoSolution, Settings, Status, WorldLine};
use crate::study::run::{Judged, Run};

pub use by_name::{ErrorByName, NumbersByName};
pub use paper::{Error, PaperNumbers};

/// The whole summary; keys that do not apply are absent.
#[derive(Debug, Clone, Serialize)]
pub struct Summary {
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
    /// Whether the action has D̄ or, without the regularisation, D.
    pub regularised: bool,
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
    pub outcome: Outcome,
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
pub enum Outcome {
    /// A critical point was found.
    Solved(Box<Solved>),
    /// No critical point was found.
    Failed(Failed),
}

/// The numbers of a critical point.
#[derive(Debug, Clone, Serialize)]
pub struct Solved {
    /// Those that have names of their own.
    #[serde(flatten)]
    pub numbers: Numbers,
    /// The end, from which `initial.from` continues the run.
    pub end_state: Box<Continuation>,
    /// With an accuracy: the estimated error of every coordinate at the nodes, relative to its size.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error_estimate: Option<f64>,
    /// With a tolerance: γ until which 3, 6 and 9 digits of all coordinates are good by that estimate.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub good_until: Option<BTreeMap<String, f64>>,
    /// With an accuracy: windows of which it is not proved that nothing steep hides between their nodes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub windows_unproved: Option<usize>,
    /// The gaps between nodes, if they were looked at.
    #[serde(flatten)]
    pub gaps: Option<Gaps>,
}

/// What is measured on a run.
#[derive(Debug, Clone, Serialize)]
#[serde(untagged)]
pub enum Numbers {
    /// In a potential of x alone.
    Paper(Box<PaperNumbers>),
    /// In any other space-time.
    ByName(Box<NumbersByName>),
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

impl Summary {
    /// The summary of a run of `case`, which is judged so.
    pub fn new<S: Real>(case: &Case, run: &Run<S>, judged: &Judged, solve_seconds: f64) -> Self {
        let Run { line, diagnostics, sums, .. } = run;
        let names = line.geometry().names();
        let error = judged.error.as_ref();
        let numbers = match &diagnostics.of_x {
            Some(of_x) => {
                let numbers = PaperNumbers::new(line, diagnostics, of_x);
                Numbers::Paper(Box::new(PaperNumbers { error: error.map(Into::into), ..numbers }))
            }
            None => {
                let watched = |watch: usize| run.events.iter().filter(|crossing| crossing.watch == watch).count();
                let events = case.events().iter().enumerate();
                let numbers = NumbersByName::new(line, diagnostics, sums);
                Numbers::ByName(Box::new(NumbersByName {
                    error: error.map(|error| ErrorByName::new(names, error)),
                    events: events.map(|(watch, event)| (event.name.clone(), watched(watch))).collect(),
                    ..numbers
                }))
            }
        };
        let solved = Solved {
            numbers,
            end_state: Box::new(Continuation::new(line)),
            error_estimate: line.error_estimate,
            good_until: good_until(line),
            windows_unproved: line.windows_unproved,
            gaps: judged.gaps.clone(),
        };
        // With an accuracy the scheme is the one that was chosen.
        let settings = Settings {
            sbp: line.sbp_name,
            form: line.form,
            n_gamma: line.sbp().points(),
            windows: line.window_count,
            ..case.settings()
        };
        let geometry = line.geometry();
        let summary = Self::of(case, geometry, settings, &line.iterations, Outcome::Solved(Box::new(solved)));
        let warnings = [summary.warnings.as_slice(), &judged.suspicions].concat();
        let seconds = Some(Seconds { diagnostics: run.seconds, write: 0.0 });
        let (status, verdict) = (Status::Converged, judged.verdict.clone());
        Self { status, verdict, solve_seconds, seconds, warnings, ..summary }
    }

    /// The summary of a solve that failed.
    pub fn failed<S: Real>(case: &Case, geometry: &Geometry<S>, failure: &NoSolution, solve_seconds: f64) -> Self {
        let outcome = Outcome::Failed(Failed::new(failure));
        let mut summary = Self::of(case, geometry, case.settings(), &failure.iterations, outcome);
        if case.is_of_x() {
            // Evaluations of the force up to a limit are not counted.
            summary.iterations = failure.iterations.history.len();
        }
        Self { status: failure.status, solve_seconds, ..summary }
    }

    /// What the case alone says, and what the iterations do.
    fn of<S: Real>(
        case: &Case,
        geometry: &Geometry<S>,
        settings: Settings,
        iterations: &Iterations,
        outcome: Outcome,
    ) -> Self {
        let Settings { sbp, form, n_gamma, windows, system, digits, accuracy, .. } = settings;
        let names = geometry.names();
        let some = |indices: &mut dyn Iterator<Item = usize>| indices.map(|a| names[a].clone()).collect();
        let coordinates = || Coordinates {
            coordinates: names.to_vec(),
            ignorable: some(&mut geometry.ignorable()),
            active: some(&mut geometry.active().iter().copied()),
        };
        Self {
            status: Status::Converged,
            verdict: Verdict::refused(),
            version: env!("CARGO_PKG_VERSION"),
            title: case.title().map(str::to_owned),
            coordinates: (!case.is_of_x()).then(coordinates),
            sbp: sbp.into(),
            form,
            system,
            regularised: case.scheme().regularised,
            digits,
            n_gamma,
            windows,
            accuracy: accuracy.filter(|accuracy| accuracy.is_promised()).map(Accuracy::value),
            tolerance: accuracy.filter(|accuracy| !accuracy.is_promised()).map(Accuracy::value),
            initial_guess: iterations.initial_guess.as_str(),
            iterations: iterations.count,
            solve_seconds: 0.0,
            seconds: None,
            outcome,
            warnings: case.warnings(),
            history: iterations.history.clone(),
        }
    }

    /// The numbers of the result, if there is one.
    pub fn solved(&self) -> Option<&Solved> {
        match &self.outcome {
            Outcome::Solved(solved) => Some(solved),
            Outcome::Failed(_) => None,
        }
    }

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
    let gamma = |until: f64| line.gamma_at(S::from(until)).to_f64();
    let until = GOOD_DIGITS.iter().zip(line.good_until);
    let has_tolerance = line.accuracy.is_some_and(|accuracy| !accuracy.is_promised());
    has_tolerance.then(|| until.map(|(digits, until)| (digits.to_string(), gamma(until))).collect())
}
