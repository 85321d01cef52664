//! The summary of a scene of n coordinates.

use std::collections::BTreeMap;

use serde::Serialize;

use super::super::number::Number;
use super::{Coordinates, Ended, Outcome, SceneSummary, good_until};
use crate::case::scene::SceneCase;
use crate::diagnostics::gaps::Gaps;
use crate::diagnostics::scene::{InvariantDeviation, SceneMeasures};
use crate::diagnostics::verdict::Verdict;
use crate::diagnostics::{ChargeDeviation, Diagnostics};
use crate::geometry::{ConservedSum, Geometry};
use crate::number::Real;
use crate::number::norm::max_abs;
use crate::solve::{NoSolution, Settings, Status, WorldLine};
use crate::study::errors::RunError;
use crate::study::verdict::of_world_line;

/// A world-line with what was measured on it.
type Measured<'m, S> = (&'m WorldLine<S>, &'m Diagnostics<S, SceneMeasures<S>>, &'m [ConservedSum]);

/// A number for each of several coordinates.
type ByName = BTreeMap<String, Number>;

/// Numbers of a world-line.
#[derive(Debug, Clone, Serialize)]
pub struct SolvedScene {
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
    fn new(names: &[String], error: &RunError) -> Self {
        let by_name = |values: Vec<f64>| names.iter().cloned().zip(values).collect();
        Self {
            error_final: by_name(error.at_most_at_end()),
            error_max: by_name(error.at_most()),
            error_from: error.judge.describe(),
            reference_error: error.judge.reference_error(),
        }
    }
}

impl SceneSummary {
    /// The summary of `case`, whose compiled geometry is `geometry`, and of its world-line or failure. The verdict is
    /// the one without a reference; [`Self::set_error`] changes it.
    pub fn new<S: Real>(
        case: &SceneCase,
        geometry: &Geometry<S>,
        result: Result<Measured<'_, S>, &NoSolution>,
        solve_seconds: f64,
    ) -> Self {
        let settings = case.settings();
        let ended = match result {
            Ok((line, diagnostics, sums)) => Ended {
                status: Status::Converged,
                verdict: of_world_line(line, diagnostics, None, None),
                settings: Settings {
                    sbp: line.sbp_name,
                    form: line.form,
                    n_gamma: line.sbp().points(),
                    windows: line.windows.len(),
                    ..settings
                },
                iterations: line.iterations.clone(),
                outcome: Outcome::Solved(Box::new(SolvedScene::new(line, diagnostics, sums))),
                suspicions: diagnostics.warnings(line),
            },
            Err(failure) => Ended::without(failure, settings),
        };
        let names = geometry.names();
        let some = |indices: &mut dyn Iterator<Item = usize>| indices.map(|a| names[a].clone()).collect();
        let coordinates = Coordinates {
            coordinates: names.to_vec(),
            ignorable: some(&mut geometry.ignorable()),
            active: some(&mut geometry.active().iter().copied()),
        };
        let summary = Self::of(case.title(), case.warnings(), ended, solve_seconds);
        Self { coordinates: Some(coordinates), ..summary }
    }

    /// Adds the errors of the coordinates, and the verdict that was made with them.
    pub fn set_error(&mut self, error: Option<&RunError>, verdict: Verdict) {
        let names = self.coordinates.as_ref().map_or(Vec::new(), |names| names.coordinates.clone());
        if let (Some(solved), Some(error)) = (self.solved_mut(), error) {
            solved.error = Some(ErrorByName::new(&names, error));
        }
        self.verdict = verdict;
    }
}

impl SolvedScene {
    fn new<S: Real>(
        line: &WorldLine<S>,
        diagnostics: &Diagnostics<S, SceneMeasures<S>>,
        sums: &[ConservedSum],
    ) -> Self {
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
        let work = diagnostics.measures.work.iter();
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
            energy: diagnostics.measures.energy.map(|energy| number(energy.value)),
            max_abs_delta_energy: diagnostics.delta_energy.as_ref().map(|delta| number(max_abs(delta))),
            max_abs_delta_energy_ends: diagnostics.measures.energy.map(|energy| number(energy.max_ends)),
            sawtooth: (diagnostics.measures.sawtooth.iter())
                .map(|(a, sawtooth)| (names[*a].clone(), sawtooth.amplitude.map(number)))
                .collect(),
            work: work.clone().map(|work| (names[work.coordinate].clone(), number(work.work))).collect(),
            work_defect: work.map(|work| (names[work.coordinate].clone(), number(work.defect))).collect(),
            invariants: of_invariants(|invariant| invariant.value),
            max_abs_delta_invariant: of_invariants(|invariant| max_abs(&invariant.delta)),
            max_abs_delta_invariant_ends: of_invariants(|invariant| invariant.max_ends),
            events: BTreeMap::new(),
            branch_distance: line.is_doubled().then(|| number(line.branch_distance())),
            error_estimate: line.error_estimate,
            good_until: good_until(line),
            windows_unproved: line.windows_unproved,
            gaps: None,
            error: None,
        }
    }
}
