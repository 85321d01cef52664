//! The numbers of a run in a potential of x alone, by the paper's names.

use serde::Serialize;

use super::super::number::Number;
use crate::action::MULTIPLIERS;
use crate::diagnostics::{Diagnostics, OfX};
use crate::number::Real;
use crate::solve::WorldLine;
use crate::study::errors::RunError;

/// Numbers of a critical point.
#[derive(Debug, Clone, Serialize)]
pub struct PaperNumbers {
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

impl PaperNumbers {
    pub(super) fn new<S: Real>(solution: &WorldLine<S>, diagnostics: &Diagnostics<S>, of_x: &OfX<S>) -> Self {
        let number = |value: S| Number::new(value, solution.digits);
        let (charge, norm) = (&diagnostics.charges[0], &diagnostics.norm);
        Self {
            gradient_norm: number(solution.gradient_norm),
            multipliers: solution.multipliers().map(|lambda| lambda.map(number)),
            gamma_final: number(solution.gamma_f()),
            t_final: number(solution.end_state().t),
            x_final: number(solution.end_state().x),
            x_dot_final: number(solution.end_state().x_dot),
            q_t: number(solution.q_t()),
            k: number(solution.norm()),
            max_abs_delta_q_t_interior: number(charge.max_interior),
            delta_q_t_last: number(charge.last),
            max_abs_delta_q_t_corrected: number(charge.max_corrected),
            max_abs_delta_g_interior: number(diagnostics.max_delta_g),
            max_abs_delta_k: number(norm.max_interior),
            max_abs_delta_k_ends: number(norm.max_ends),
            sawtooth: diagnostics.sawtooth[0].1.amplitude.map(number),
            h_bvp: number(of_x.bound.h_bvp),
            h_bvp_bound: number(of_x.bound.h_bvp_bound),
            h_bvp_bound_kept: of_x.bound.is_kept(),
            h_bvp_defect: number(of_x.bound.defect()),
            branch_distance: diagnostics.branch_distance.map(number),
            max_abs_delta_q_x: of_x.free_particle.map(|f| number(f.max_abs_delta_q_x)),
            max_abs_delta_q_eta: of_x.free_particle.map(|f| number(f.max_abs_delta_q_eta)),
            error: None,
            newtonian_deviation: of_x.newtonian.deviation,
            newtonian_c: of_x.newtonian.c(),
        }
    }
}
