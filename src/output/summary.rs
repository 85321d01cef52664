//! `summary.json` of `run`: what was solved, how the solve ended, and the numbers that a study needs.

use serde::Serialize;

use super::number::Number;
use crate::action::MULTIPLIERS;
use crate::case::{Case, Decimal, Form, System};
use crate::diagnostics::Measures;
use crate::diagnostics::verdict::Verdict;
use crate::scalar::Real;
use crate::solve::{Domain, IterationRecord, NoSolution, Solution, Status};
use crate::study::run_error::RunError;
use crate::study::verdict::of_solution;

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
    /// First guess of the Newton iteration.
    pub initial_guess: &'static str,
    /// Newton iterations.
    pub iterations: usize,
    /// Seconds spent in the solver.
    pub solve_seconds: f64,
    /// The numbers of the result, or of the failure.
    #[serde(flatten)]
    pub outcome: Outcome,
    /// The warnings that were printed.
    pub warnings: Vec<String>,
    /// The iterations; with several windows, those of the window that took most.
    pub history: Vec<IterationRecord>,
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

/// Numbers of a critical point.
#[derive(Debug, Clone, Serialize)]
pub struct Solved {
    /// Largest entry of ∇E_IVP.
    pub gradient_norm: Number,
    /// λ1 … λ8 (strong form).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub multipliers: Option<[Number; MULTIPLIERS]>,
    /// γ of the last node.
    pub gamma_final: Number,
    /// t of the last node.
    pub t_final: Number,
    /// x of the last node.
    pub x_final: Number,
    /// w*_N (w_N in the weak form), the value of dx/dγ with which the world-line can be continued.
    pub x_dot_final: Number,
    /// Q_t of the continuum.
    pub q_t: Number,
    /// K of the continuum.
    pub k: Number,
    /// max |ΔQ_t| over all nodes but the last of each window (weak form: over all nodes).
    pub max_abs_delta_q_t_interior: Number,
    /// ΔQ_t at the last node.
    pub delta_q_t_last: Number,
    /// max |ΔQ_t| with the multiplier correction, over all nodes.
    pub max_abs_delta_q_t_corrected: Number,
    /// max |ΔG| over the nodes whose row of D does not reach the last node of the window (weak form: over all nodes).
    pub max_abs_delta_g_interior: Number,
    /// max |ΔK| over all nodes but the last of each window (weak form: over all nodes).
    pub max_abs_delta_k: Number,
    /// max |ΔK| at the ends of the windows, for the values with which the world-line is continued.
    pub max_abs_delta_k_ends: Number,
    /// Amplitude of the even–odd oscillation of x; null with too few nodes and for spectral elements.
    pub sawtooth: Option<Number>,
    /// H_BVP.
    pub h_bvp: Number,
    /// Q_t (t_N − t_i).
    pub h_bvp_bound: Number,
    /// Whether H_BVP is at most its bound.
    pub h_bvp_bound_kept: bool,
    /// H_BVP − Q_t (t_N − t_i) + ½ K (γ_f − γ_i), which is 0 in the continuum.
    pub h_bvp_defect: Number,
    /// Largest distance of the two branches (doubled system).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub branch_distance: Option<Number>,
    /// max |ΔQ_x| (free particle).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_abs_delta_q_x: Option<Number>,
    /// max |ΔQ_η| (free particle).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_abs_delta_q_eta: Option<Number>,
    /// With an accuracy: the estimated error of t and x, relative to max(1, largest |t − t_i|) and max(1, largest |x|).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error_estimate: Option<f64>,
    /// The errors of t and x at the last node and at most, and how they were found; absent if there was nothing to
    /// compare with.
    #[serde(flatten)]
    pub error: Option<Error>,
    /// The largest share by which the acceleration differs from Newton's, 2v²/g00.
    pub newtonian_deviation: f64,
    /// The speed of light that would make that about 1e-6; absent if the particle does not move.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub newtonian_c: Option<f64>,
    /// Seconds spent in measuring the solution.
    pub diagnostics_seconds: f64,
    /// Seconds spent in formatting and writing the CSV files.
    pub write_seconds: f64,
}

/// The error of a run, see [`crate::study::run_error`], in the units of t and x.
#[derive(Debug, Clone, Serialize)]
pub struct Error {
    /// The error of t at the last node; 0 if that time was given.
    pub error_t_final: f64,
    /// The error of x at the last node.
    pub error_x_final: f64,
    /// The largest error of t over the nodes.
    pub error_t_max: f64,
    /// The largest error of x over the nodes.
    pub error_x_max: f64,
    /// How the errors were found.
    pub error_from: String,
}

impl From<RunError> for Error {
    fn from(error: RunError) -> Self {
        Self {
            error_t_final: error.end[0],
            error_x_final: error.end[1],
            error_t_max: error.largest[0],
            error_x_max: error.largest[1],
            error_from: error.judge.describe(),
        }
    }
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
    /// x there.
    pub x: f64,
    /// g00 there.
    pub g00: f64,
    /// Largest residual entry of the last iterate; null if there was none.
    pub residual: f64,
}

impl Summary {
    /// The summary of `case` and of its solution or failure. The error of a solution is not known to it, so that its
    /// verdict is doubtful until [`Self::set_error`].
    pub fn new<S: Real>(
        case: &Case,
        result: Result<(&Solution<S>, &Measures<S>), &NoSolution>,
        solve_seconds: f64,
    ) -> Self {
        // With an accuracy the scheme is the one that was chosen; if the solve failed, none was.
        let (sbp, form, n_gamma, windows) = match result {
            Ok((solution, _)) => (solution.sbp_name, solution.form, solution.sbp().points(), solution.window_count),
            Err(_) => (case.scheme.sbp, case.scheme.form, case.grid.n_gamma, case.grid.windows),
        };
        let measured = result.as_ref().map_or(Vec::new(), |(solution, measures)| {
            measures.warnings(solution).into_iter().chain(measures.newtonian_warning()).collect()
        });
        let (status, initial_guess, iterations, history, outcome) = match result {
            Ok((solution, measures)) => (
                Status::Converged,
                solution.initial_guess,
                solution.iterations,
                &solution.history,
                Outcome::Solved(Box::new(Solved::new(solution, measures))),
            ),
            Err(failure) => {
                let iterations = failure.history.len();
                let outcome = Outcome::Failed(Failed::new(failure));
                (failure.status, failure.initial_guess, iterations, &failure.history, outcome)
            }
        };
        Self {
            status,
            verdict: match result {
                Ok((solution, measures)) => of_solution(solution, measures, None),
                Err(_) => Verdict::refused(),
            },
            version: env!("CARGO_PKG_VERSION"),
            title: case.title.clone(),
            sbp: sbp.into(),
            form,
            system: case.solver.system,
            regularised: case.scheme.regularised,
            digits: case.solver.digits,
            n_gamma,
            windows,
            accuracy: case.solver.accuracy.as_ref().map(Decimal::value),
            initial_guess: initial_guess.as_str(),
            iterations,
            solve_seconds,
            outcome,
            warnings: case.warnings().into_iter().chain(measured).collect(),
            history: history.clone(),
        }
    }

    /// Adds the error of the solution, and the verdict that it was made with.
    pub fn set_error(&mut self, error: Option<RunError>, verdict: Verdict) {
        if let Outcome::Solved(solved) = &mut self.outcome {
            solved.error = error.map(Into::into);
        }
        self.verdict = verdict;
    }

    /// The JSON text, with a final newline.
    pub fn to_json(&self) -> String {
        json(self)
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

impl Solved {
    fn new<S: Real>(solution: &Solution<S>, measures: &Measures<S>) -> Self {
        let invariants = solution.invariants();
        let number = |value: S| Number::new(value, solution.digits);
        Self {
            gradient_norm: number(solution.gradient_norm),
            multipliers: solution.multipliers().map(|lambda| lambda.map(number)),
            gamma_final: number(solution.gamma_f()),
            t_final: number(solution.end.t),
            x_final: number(solution.end.x),
            x_dot_final: number(solution.end.x_dot),
            q_t: number(invariants.q_t),
            k: number(invariants.k),
            max_abs_delta_q_t_interior: number(measures.max_abs_delta_q_t_interior),
            delta_q_t_last: number(measures.delta_q_t_last),
            max_abs_delta_q_t_corrected: number(measures.max_abs_delta_q_t_corrected),
            max_abs_delta_g_interior: number(measures.max_abs_delta_g_interior),
            max_abs_delta_k: number(measures.max_abs_delta_k),
            max_abs_delta_k_ends: number(measures.max_abs_delta_k_ends),
            sawtooth: measures.sawtooth.map(number),
            h_bvp: number(measures.bound.h_bvp),
            h_bvp_bound: number(measures.bound.h_bvp_bound),
            h_bvp_bound_kept: measures.bound.is_kept(),
            h_bvp_defect: number(measures.bound.defect()),
            branch_distance: measures.branch_distance.map(number),
            max_abs_delta_q_x: measures.free_particle.map(|f| number(f.max_abs_delta_q_x)),
            max_abs_delta_q_eta: measures.free_particle.map(|f| number(f.max_abs_delta_q_eta)),
            error_estimate: solution.error_estimate,
            error: None,
            newtonian_deviation: measures.newtonian.deviation,
            newtonian_c: measures.newtonian.c(),
            diagnostics_seconds: 0.0,
            write_seconds: 0.0,
        }
    }
}

impl Failed {
    fn new(failure: &NoSolution) -> Self {
        Self {
            message: failure.to_string(),
            advice: failure.advice(),
            gamma: failure.gamma,
            x: failure.point.first().map_or(f64::NAN, |(_, x)| *x),
            g00: if let Domain::G00(g00) = failure.domain { g00 } else { f64::NAN },
            residual: failure.residual,
        }
    }
}
