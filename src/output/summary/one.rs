//! The summary of a case of one coordinate.

use std::collections::BTreeMap;

use serde::Serialize;

use super::super::number::Number;
use super::{Ended, Outcome, Summary, good_until};
use crate::action::MULTIPLIERS;
use crate::case::Case;
use crate::diagnostics::Measures;
use crate::diagnostics::gaps::Gaps;
use crate::diagnostics::verdict::Verdict;
use crate::number::Real;
use crate::solve::{NoSolution, Settings, Solution, Status};
use crate::study::errors::RunError;
use crate::study::verdict::of_solution;

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
    /// With an accuracy: the estimated error of t and x at the nodes, relative to their sizes.
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
    /// The errors of t and x at the last node and at most, and how they were found; absent if there was nothing to
    /// compare with.
    #[serde(flatten)]
    pub error: Option<Error>,
    /// The largest share by which the acceleration differs from Newton's, 2v²/g00.
    pub newtonian_deviation: f64,
    /// The speed of light that would make that about 1e-6; absent if the particle does not move.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub newtonian_c: Option<f64>,
}

/// The error of a run, see [`crate::study::errors`], in the units of t and x.
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

impl From<&RunError> for Error {
    fn from(error: &RunError) -> Self {
        let (end, largest) = (error.at_most_at_end(), error.at_most());
        Self {
            error_t_final: end[0],
            error_x_final: end[1],
            error_t_max: largest[0],
            error_x_max: largest[1],
            error_from: error.judge.describe(),
        }
    }
}

impl Summary {
    /// The summary of `case` and of its solution or failure. The error of a solution is not known to it, so that its
    /// verdict is doubtful until [`Self::set_error`].
    pub fn new<S: Real>(
        case: &Case,
        result: Result<(&Solution<S>, &Measures<S>), &NoSolution>,
        solve_seconds: f64,
    ) -> Self {
        let settings = case.settings();
        let ended = match result {
            Ok((solution, measures)) => Ended {
                status: Status::Converged,
                verdict: of_solution(solution, measures, None),
                settings: Settings {
                    sbp: solution.sbp_name,
                    form: solution.form,
                    n_gamma: solution.sbp().points(),
                    windows: solution.window_count,
                    ..settings
                },
                iterations: solution.iterations.clone(),
                outcome: Outcome::Solved(Box::new(Solved::new(solution, measures))),
                suspicions: measures.warnings(solution).into_iter().chain(measures.newtonian_warning()).collect(),
            },
            Err(failure) => {
                let mut ended = Ended::without(failure, settings);
                // Evaluations of the force up to a limit are not counted.
                ended.iterations.count = failure.iterations.history.len();
                ended
            }
        };
        let summary = Self::of(case.title.as_deref(), case.warnings(), ended, solve_seconds);
        Self { regularised: Some(case.scheme.regularised), ..summary }
    }

    /// Adds the error of the solution, and the verdict that it was made with.
    pub fn set_error(&mut self, error: Option<&RunError>, verdict: Verdict) {
        if let Some(solved) = self.solved_mut() {
            solved.error = error.map(Into::into);
        }
        self.verdict = verdict;
    }
}

impl Solved {
    fn new<S: Real>(solution: &Solution<S>, measures: &Measures<S>) -> Self {
        let number = |value: S| Number::new(value, solution.digits);
        Self {
            gradient_norm: number(solution.gradient_norm),
            multipliers: solution.multipliers().map(|lambda| lambda.map(number)),
            gamma_final: number(solution.gamma_f()),
            t_final: number(solution.end_state().t),
            x_final: number(solution.end_state().x),
            x_dot_final: number(solution.end_state().x_dot),
            q_t: number(solution.q_t()),
            k: number(solution.norm()),
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
            good_until: good_until(solution),
            windows_unproved: solution.windows_unproved,
            gaps: None,
            error: None,
            newtonian_deviation: measures.newtonian.deviation,
            newtonian_c: measures.newtonian.c(),
        }
    }
}
