//! `summary.json` of `run`: what was solved, how the solve ended, and the numbers that a study needs.

mod numbers;

use std::collections::BTreeMap;

use serde::Serialize;
use serde_json::{Value, json};

use crate::case::{Case, Form, System};
use crate::diagnostics::gaps::Gaps;
use crate::diagnostics::verdict::Verdict;
use crate::engine::{Accuracy, GOOD_DIGITS};
use crate::geometry::Geometry;
use crate::number::Real;
use crate::output::json;
use crate::solve::{
    Continuation, Domain, InitialGuess, IterationRecord, Iterations, NoSolution, Settings, Status, WorldLine,
};
use crate::study::run::{Judged, Run};

/// The whole summary; keys that do not apply are absent.
#[derive(Debug, Clone, Serialize)]
pub struct Summary {
    /// The status with which the solve ended.
    pub status: Status,
    /// The verdict on the result.
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
    /// True if the action has D̄ or, without the regularisation, D.
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
    pub initial_guess: InitialGuess,
    /// Newton iterations.
    pub iterations: usize,
    /// Seconds spent in the solver.
    pub solve_seconds: f64,
    /// The numbers of the result, or of the failure.
    #[serde(flatten)]
    outcome: Value,
    /// The measures after the solve, if it has a result.
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

/// The numbers of a critical point.
#[derive(Serialize)]
struct Solved {
    #[serde(flatten)]
    numbers: Value,
    /// The end, from which `initial.from` continues the run.
    end_state: Box<Continuation>,
    /// With an accuracy: the estimated error of every coordinate at the nodes, relative to its size.
    #[serde(skip_serializing_if = "Option::is_none")]
    error_estimate: Option<f64>,
    /// With a tolerance: γ until which 3, 6 and 9 digits of all coordinates are good by that estimate.
    #[serde(skip_serializing_if = "Option::is_none")]
    good_until: Option<BTreeMap<String, f64>>,
    /// With an accuracy: windows of which it is not proved that nothing steep hides between their nodes.
    #[serde(skip_serializing_if = "Option::is_none")]
    windows_unproved: Option<usize>,
    /// With a sensitivity: the largest Lyapunov exponent and MEGNO.
    #[serde(skip_serializing_if = "Option::is_none")]
    sensitivity: Option<Value>,
    /// The number of events that have acted.
    #[serde(skip_serializing_if = "Option::is_none")]
    acting_events: Option<usize>,
    /// The gaps between nodes, if they were looked at.
    #[serde(flatten)]
    gaps: Option<Gaps>,
}

impl Summary {
    /// The summary of a run of `case`, which is judged so.
    pub fn new<S: Real>(case: &Case, run: &Run<S>, judged: &Judged, solve_seconds: f64) -> Self {
        let Run { line, diagnostics, .. } = run;
        let error = judged.error.as_ref();
        let numbers = match &diagnostics.of_x {
            Some(of_x) => numbers::of_paper(line, diagnostics, of_x, error),
            None => numbers::by_name(run, case.events(), error),
        };
        let solved = Solved {
            numbers,
            end_state: Box::new(Continuation::new(line)),
            error_estimate: line.error_estimate,
            good_until: good_until(line),
            windows_unproved: line.windows_unproved,
            sensitivity: line.sensitivity.as_ref().map(|it| json!({"lyapunov": it.lyapunov(), "megno": it.megno()})),
            acting_events: case.has_acting_events().then_some(run.acting_events),
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
        let summary = Self::of(case, geometry, settings, &line.iterations, json!(solved));
        let warnings = [summary.warnings.as_slice(), &judged.suspicions].concat();
        let seconds = Some(Seconds { diagnostics: run.seconds, write: 0.0 });
        let (status, verdict) = (Status::Converged, judged.verdict.clone());
        Self { status, verdict, solve_seconds, seconds, warnings, ..summary }
    }

    /// The summary of a solve that failed.
    pub fn failed<S: Real>(case: &Case, geometry: &Geometry<S>, failure: &NoSolution, solve_seconds: f64) -> Self {
        let outcome = of_failure(failure);
        let mut summary = Self::of(case, geometry, case.settings(), &failure.iterations, outcome);
        if case.is_of_x() {
            // Evaluations of the force up to a limit are not counted.
            summary.iterations = failure.iterations.history.len();
        }
        Self { status: failure.status, solve_seconds, ..summary }
    }

    /// The case, and the iterations.
    fn of<S: Real>(
        case: &Case,
        geometry: &Geometry<S>,
        settings: Settings,
        iterations: &Iterations,
        outcome: Value,
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
            initial_guess: iterations.initial_guess,
            iterations: iterations.count,
            solve_seconds: 0.0,
            seconds: None,
            outcome,
            warnings: case.warnings(),
            history: iterations.history.clone(),
        }
    }

    /// The JSON text, with a final newline.
    pub fn to_json(&self) -> String {
        json::json(self)
    }
}

/// The place to which a solve without a result came, in words and numbers.
fn of_failure(failure: &NoSolution) -> Value {
    let mut found = json!({"message": failure.to_string(), "advice": failure.advice(), "gamma": failure.gamma});
    match failure.domain {
        Domain::G00(g00) | Domain::Overflow(g00) => {
            found["x"] = json!(failure.point.first().map(|(_, x)| x));
            found["g00"] = json!(g00);
        }
        Domain::Determinant { .. } | Domain::Scene => {
            found["point"] = json!(failure.point.iter().cloned().collect::<BTreeMap<_, _>>());
        }
    }
    found["residual"] = json!(failure.residual);
    if failure.status == Status::AccuracyNotReached {
        found["accuracy_asked"] = json!(failure.asked);
        found["accuracy_estimated"] = json!(failure.residual);
    }
    found
}

/// In a run to a tolerance γ until which so many digits are good, by their number.
fn good_until<S: Real>(line: &WorldLine<S>) -> Option<BTreeMap<String, f64>> {
    let gamma = |until: f64| line.gamma_at(S::from(until)).to_f64();
    let until = GOOD_DIGITS.iter().zip(line.good_until);
    let has_tolerance = line.accuracy.is_some_and(|accuracy| !accuracy.is_promised());
    has_tolerance.then(|| until.map(|(digits, until)| (digits.to_string(), gamma(until))).collect())
}
