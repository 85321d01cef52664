//! The numbers of a run in n coordinates, by their names.

use std::collections::BTreeMap;

use serde::Serialize;

use super::super::number::Number;
use crate::diagnostics::{ChargeDeviation, Diagnostics, InvariantDeviation};
use crate::geometry::ConservedSum;
use crate::number::Real;
use crate::solve::WorldLine;
use crate::study::errors::RunError;

/// A number for each of several coordinates.
type ByName = BTreeMap<String, Number>;

/// Numbers of a world-line.
#[derive(Debug, Clone, Serialize)]
pub struct NumbersByName {
    /// Largest entry of ∇E_IVP.
    pub gradient_norm: Number,
    /// γ of the last node.
    pub gamma_final: Number,
    /// Every coordinate at the last node.
    #[serde(rename = "final")]
    pub position: ByName,
    /// dq/dγ of every coordinate with which the world-line can be continued.
    pub q_dot_final: ByName,
    /// The momenta with which the world-line can be continued.
    pub p_final: ByName,
    /// The charges of the ignorable coordinates.
    pub charges: ByName,
    /// max |Δp_a| of each over all nodes but the last of each window (weak form: over all nodes).
    pub max_abs_delta_q_interior: ByName,
    /// Largest |Δp_a| of each at the last node of a window.
    pub max_abs_delta_q_last: ByName,
    /// max |Δp_a + κ_a/H_N e_N| of each, over all nodes.
    pub max_abs_delta_q_corrected: ByName,
    /// Conserved sums of momenta of active coordinates, with the largest deviation of each where it is exact.
    pub conserved_sums: ByName,
    /// The largest deviation of each at the ends of the windows, for the values with which the world-line is continued.
    pub conserved_sums_ends: ByName,
    /// K at the start.
    pub k: Number,
    /// max |ΔG| over the nodes whose row of D does not reach the last node of the window (weak form: over all nodes).
    pub max_abs_delta_g_interior: Number,
    /// max |ΔK| over all nodes but the last of each window (weak form: over all nodes).
    pub max_abs_delta_k: Number,
    /// max |ΔK| at the ends of the windows, for the values with which the world-line is continued.
    pub max_abs_delta_k_ends: Number,
    /// With Newton's law: the charge p_t/p_s, the energy, at the start.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub energy: Option<Number>,
    /// Largest difference between that and the energy of positions and velocities at the nodes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_abs_delta_energy: Option<Number>,
    /// The same at the ends of the windows, for the values with which the world-line is continued.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_abs_delta_energy_ends: Option<Number>,
    /// Amplitude of the even–odd oscillation of every active coordinate; null with too few nodes and for spectral
    /// elements.
    pub sawtooth: BTreeMap<String, Option<Number>>,
    /// The work of a force on the charge of a coordinate.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub work: ByName,
    /// What p_a at the end differs from p_a at the start plus that work.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub work_defect: ByName,
    /// The invariants of the case at the start.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub invariants: ByName,
    /// The largest deviation of each from that.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub max_abs_delta_invariant: ByName,
    /// The same at the ends of the windows, for the values with which the world-line is continued.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub max_abs_delta_invariant_ends: ByName,
    /// How often each event of the case was met.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub events: BTreeMap<String, usize>,
    /// Largest distance of the two branches (doubled system).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub branch_distance: Option<Number>,
    /// The errors; absent if no second solve reaches the end.
    #[serde(flatten)]
    pub error: Option<ErrorByName>,
}

/// The error of a run, see [`crate::study::errors`], in the units of the coordinates.
#[derive(Debug, Clone, Serialize)]
pub struct ErrorByName {
    /// That of every coordinate at the last node; 0 of one whose value ended the run.
    pub error_final: BTreeMap<String, f64>,
    /// The largest of every coordinate over the nodes.
    pub error_max: BTreeMap<String, f64>,
    /// How they were found.
    pub error_from: String,
    /// The estimated relative error of the reference itself, if the run was compared with one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reference_error: Option<f64>,
}

impl ErrorByName {
    /// The errors of the coordinates with these names.
    pub(super) fn new(names: &[String], error: &RunError) -> Self {
        let by_name = |values: Vec<f64>| names.iter().cloned().zip(values).collect();
        Self {
            error_final: by_name(error.at_most_at_end()),
            error_max: by_name(error.at_most()),
            error_from: error.judge.describe(),
            reference_error: error.judge.reference_error(),
        }
    }
}

impl NumbersByName {
    pub(super) fn new<S: Real>(line: &WorldLine<S>, diagnostics: &Diagnostics<S>, sums: &[ConservedSum]) -> Self {
        let names = line.geometry().names();
        let number = |value: S| Number::new(value, line.digits);
        let all = |values: &[S]| -> ByName { names.iter().cloned().zip(values.iter().map(|&v| number(v))).collect() };
        let of_charges = |value: fn(&ChargeDeviation<S>) -> S| -> ByName {
            let charges = diagnostics.charges.iter();
            charges.map(|charge| (names[charge.terms[0].0].clone(), number(value(charge)))).collect()
        };
        let of_sums = |value: fn(&ChargeDeviation<S>) -> S| -> ByName {
            let sums = sums.iter().zip(&diagnostics.sums);
            sums.map(|(sum, charge)| (sum.formula(names), number(value(charge)))).collect()
        };
        let work = diagnostics.work.iter();
        let of_invariants = |value: fn(&InvariantDeviation<S>) -> S| -> ByName {
            let invariants = diagnostics.invariants.iter();
            invariants.map(|invariant| (invariant.name.clone(), number(value(invariant)))).collect()
        };
        let end = line.end();
        Self {
            gradient_norm: number(line.gradient_norm),
            gamma_final: number(line.gamma_f()),
            position: all(&end.q),
            q_dot_final: all(&end.q_dot),
            p_final: all(&end.p),
            charges: of_charges(|charge| charge.value),
            max_abs_delta_q_interior: of_charges(|charge| charge.max_interior),
            max_abs_delta_q_last: of_charges(|charge| charge.max_last),
            max_abs_delta_q_corrected: of_charges(|charge| charge.max_corrected),
            conserved_sums: of_sums(|charge| charge.max_interior),
            conserved_sums_ends: of_sums(|charge| charge.max_ends),
            k: number(diagnostics.norm.value),
            max_abs_delta_g_interior: number(diagnostics.max_delta_g),
            max_abs_delta_k: number(diagnostics.norm.max_interior),
            max_abs_delta_k_ends: number(diagnostics.norm.max_ends),
            energy: diagnostics.energy.map(|energy| number(energy.value)),
            max_abs_delta_energy: diagnostics.energy.map(|energy| number(energy.max)),
            max_abs_delta_energy_ends: diagnostics.energy.map(|energy| number(energy.max_ends)),
            sawtooth: (diagnostics.sawtooth.iter())
                .map(|(a, sawtooth)| (names[*a].clone(), sawtooth.amplitude.map(number)))
                .collect(),
            work: work.clone().map(|work| (names[work.coordinate].clone(), number(work.work))).collect(),
            work_defect: work.map(|work| (names[work.coordinate].clone(), number(work.defect))).collect(),
            invariants: of_invariants(|invariant| invariant.value),
            max_abs_delta_invariant: of_invariants(|invariant| invariant.max),
            max_abs_delta_invariant_ends: of_invariants(|invariant| invariant.max_ends),
            events: BTreeMap::new(),
            branch_distance: diagnostics.branch_distance.map(number),
            error: None,
        }
    }
}
