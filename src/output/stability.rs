//! The files of `stability`.

use std::io::Write;

use serde::Serialize;
use serde_json::{Value, json};

use super::json::study_json;
use super::tables::{decimal, write_rows};
use crate::case::Form;
use crate::study::stability::{
    ACCURATE, Arena, Atlas, Cell, CellStatus, DIVERGED, DRIFTING, Limit, Method, Plan, ROUGHER, SAWTOOTH,
};

/// The columns before those of the charge and the error, and those behind them.
const BEFORE: [&str; 8] =
    ["method", "form", "n_gamma", "gamma_f", "t_dot", "delta_gamma_omega", "status", "delta_k_max"];
const BEHIND: [&str; 3] = ["sawtooth", "iterations", "seconds"];

/// The columns of one coordinate have its charge and its error in the middle. Those of a scene have the errors of all
/// coordinates, the charges and the energy at the end.
fn columns(arena: &Arena) -> Vec<String> {
    let text = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>();
    if !arena.is_scene() {
        return [text(&BEFORE), text(&["delta_q_t_max", "error_x_max"]), text(&BEHIND)].concat();
    }
    let names = arena.coordinates();
    let errors = names.iter().map(|name| format!("error_{name}")).collect();
    let charges = arena.charges().map(|a| format!("delta_q_{}", names[a])).collect();
    let energy = if arena.has_energy() { text(&["delta_energy_max"]) } else { Vec::new() };
    [text(&BEFORE), text(&BEHIND), errors, charges, energy].concat()
}

/// Writes `stability.csv`, one row per cell. Numbers that do not apply, were not measured or are not finite are left
/// empty.
///
/// # Errors
/// If `out` cannot be written.
pub fn write_stability(out: impl Write, arena: &Arena, cells: &[Cell]) -> csv::Result<()> {
    write_rows(out, columns(arena), cells.iter().map(|cell| row(arena, cell)))
}

fn row(arena: &Arena, cell: &Cell) -> Vec<String> {
    let numbers = cell.numbers.as_ref();
    let whole = |value: Option<usize>| value.map(|value| value.to_string()).unwrap_or_default();
    let method = match cell.method.is_adaptive() {
        true => format!("{} tol={:e}", cell.method.name(), cell.setting),
        false => cell.method.name(),
    };
    let before = vec![
        method,
        cell.method.form().map_or("", Form::as_str).to_owned(),
        whole(cell.n_gamma),
        number(Some(cell.gamma_f)),
        number(cell.t_dot),
        number(cell.delta_gamma_omega),
        cell.status.as_str().to_owned(),
        number(numbers.map(|n| n.delta_k_max)),
    ];
    let behind = vec![number(numbers.and_then(|n| n.sawtooth)), whole(cell.iterations), number(Some(cell.seconds))];
    let error = |a: usize| number(numbers.and_then(|n| Some(n.errors.as_ref()?[a])));
    let charge = |place: usize| number(numbers.and_then(|n| Some(n.charges.as_ref()?[place])));
    if !arena.is_scene() {
        return [before, vec![charge(0), error(1)], behind].concat();
    }
    let errors = (0..arena.coordinates().len()).map(error).collect();
    let charges = (0..arena.charges().count()).map(charge).collect();
    let energy = || number(numbers.and_then(|n| n.delta_energy_max));
    [before, behind, errors, charges, arena.has_energy().then(energy).into_iter().collect()].concat()
}

fn number(value: Option<f64>) -> String {
    value.filter(|value| value.is_finite()).map(decimal).unwrap_or_default()
}

/// The border of the accurate cells, for one length.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Border {
    /// γ_f − γ_i times ṫ_i, where ṫ_i is in units of the case's own.
    pub length: f64,
    /// Δγω; null if not even the finest cell is accurate.
    pub delta_gamma_omega: Option<f64>,
}

/// Where along the world-line a sawtooth begins.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Onset {
    /// Method and form.
    pub method: String,
    /// Δγω.
    pub delta_gamma_omega: f64,
    /// γ − γ_i.
    pub gamma: f64,
}

/// For each length, the largest Δγω up to which all cells of `method` are accurate.
pub fn borders(cells: &[Cell], method: &Method) -> Vec<Border> {
    let mut all: Vec<(f64, Vec<&Cell>)> = Vec::new();
    for cell in cells.iter().filter(|cell| cell.method == *method) {
        let length = cell.length();
        match all.iter_mut().find(|(known, _)| *known == length) {
            Some((_, row)) => row.push(cell),
            None => all.push((length, vec![cell])),
        }
    }
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    let border = |(length, mut row): (f64, Vec<&Cell>)| {
        row.sort_by(|a, b| a.setting.total_cmp(&b.setting));
        let accurate = row.iter().take_while(|cell| cell.status == CellStatus::Accurate);
        Border { length, delta_gamma_omega: accurate.filter_map(|cell| cell.delta_gamma_omega).last() }
    };
    all.into_iter().map(border).collect()
}

/// Where the sawtooth begins, for each method and step: on the longest world-line that has one.
pub fn onsets(cells: &[Cell]) -> Vec<Onset> {
    let mut all: Vec<(&Cell, Onset)> = Vec::new();
    for cell in cells {
        let from = cell.numbers.as_ref().and_then(|numbers| numbers.sawtooth_from);
        let (Some(gamma), Some(delta_gamma_omega)) = (from, cell.delta_gamma_omega) else { continue };
        let onset = Onset { method: cell.method.label(), delta_gamma_omega, gamma: gamma * cell.tangent };
        let step = |cell: &Cell| cell.setting * cell.tangent;
        let same = |other: &Cell| other.method == cell.method && step(other) == step(cell);
        match all.iter_mut().find(|(other, _)| same(other)) {
            Some(known) if known.0.length() < cell.length() => *known = (cell, onset),
            Some(_) => {}
            None => all.push((cell, onset)),
        }
    }
    all.into_iter().map(|(_, onset)| onset).collect()
}

/// The charges at the last node of a cell, with and without the correction.
fn last_nodes(arena: &Arena, cell: &Cell) -> Vec<Value> {
    let last = cell.numbers.as_ref().and_then(|numbers| numbers.last_node.clone()).unwrap_or_default();
    let Cell { n_gamma, gamma_f, t_dot, .. } = *cell;
    let method = cell.method.label();
    let of = |(a, [last, corrected]): (usize, [f64; 2])| match arena.is_scene() {
        true => json!({
            "method": method,
            "n_gamma": n_gamma,
            "gamma_f": gamma_f,
            "charge": arena.coordinates()[a],
            "delta_q_last": last,
            "delta_q_last_corrected": corrected,
        }),
        false => json!({
            "method": method,
            "n_gamma": n_gamma,
            "gamma_f": gamma_f,
            "t_dot": t_dot,
            "delta_q_t_last": last,
            "delta_q_t_last_corrected": corrected,
        }),
    };
    arena.charges().zip(last).map(of).collect()
}

/// `summary.json` of `stability`: of a plan and of the atlas that was measured, for a case with this title and these
/// warnings.
pub fn stability_summary(
    (title, warnings): (Option<&str>, Vec<String>),
    arena: &Arena,
    plan: &Plan,
    atlas: &Atlas,
) -> String {
    let of_method = |method: &Method| {
        let mut counts = std::collections::BTreeMap::new();
        for cell in atlas.cells.iter().filter(|cell| cell.method == *method) {
            *counts.entry(cell.status.as_str()).or_insert(0) += 1;
        }
        let mut summary = json!({"method": method.label()});
        // The limit of hω is null if there is none, and absent for adaptive methods.
        match method.limit() {
            Limit::Step(step) => summary["linear_limit"] = json!(step),
            Limit::None => summary["linear_limit"] = Value::Null,
            Limit::Adaptive => {}
        }
        summary["cells"] = json!(counts);
        summary["accurate_up_to"] = json!(borders(&atlas.cells, method));
        summary
    };
    let mut found = json!({"omega": arena.omega(), "reference_error_estimate": arena.reference_error()});
    if let Some(end) = arena.ends() {
        found["geodesic_ends"] = json!(end.to_string());
    }
    found["thresholds"] = json!({
        "accurate": ACCURATE,
        "diverged": DIVERGED,
        "sawtooth": SAWTOOTH,
        "sawtooth_above_smooth": ROUGHER,
        "drifting": DRIFTING,
    });
    found["cells"] = json!(atlas.cells.len());
    found["methods"] = plan.methods.iter().map(of_method).collect();
    found["last_node"] = atlas.cells.iter().flat_map(|cell| last_nodes(arena, cell)).collect();
    found["sawtooth"] = json!(onsets(&atlas.cells));
    found["warnings"] = json!(warnings);
    study_json(atlas.interrupted, title, found)
}
