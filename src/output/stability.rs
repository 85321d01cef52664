//! The files of `stability`.

use std::io::Write;

use csv::Writer;
use serde::Serialize;

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
    let mut writer = Writer::from_writer(out);
    writer.write_record(columns(arena))?;
    for cell in cells {
        writer.write_record(row(arena, cell))?;
    }
    writer.flush()?;
    Ok(())
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
    let finite = value.filter(|value| value.is_finite());
    finite.map(|value| zmij::Buffer::new().format(value).to_owned()).unwrap_or_default()
}

/// `summary.json` of `stability`.
#[derive(Debug, Serialize)]
pub struct StabilitySummary<'a> {
    /// `complete` or `interrupted`.
    status: &'static str,
    version: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    title: Option<&'a str>,
    omega: f64,
    reference_error_estimate: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    geodesic_ends: Option<String>,
    thresholds: Thresholds,
    cells: usize,
    methods: Vec<MethodSummary>,
    last_node: Vec<LastNode>,
    sawtooth: Vec<Onset>,
    warnings: Vec<String>,
}

#[derive(Debug, Serialize)]
struct Thresholds {
    accurate: f64,
    diverged: f64,
    sawtooth: f64,
    sawtooth_above_smooth: f64,
    drifting: f64,
}

#[derive(Debug, Serialize)]
struct MethodSummary {
    method: String,
    /// The linear limit of hω: a number, or null if there is no limit. Absent for adaptive methods.
    #[serde(skip_serializing_if = "Option::is_none")]
    linear_limit: Option<Option<f64>>,
    /// Number of cells by status.
    cells: std::collections::BTreeMap<&'static str, usize>,
    /// For each length, the largest Δγω up to which all cells are accurate.
    accurate_up_to: Vec<Border>,
}

/// The border of the accurate cells, for one length.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Border {
    /// γ_f − γ_i times ṫ_i, where ṫ_i is in units of the case's own.
    pub length: f64,
    /// Δγω; null if not even the finest cell is accurate.
    pub delta_gamma_omega: Option<f64>,
}

#[derive(Debug, Serialize)]
#[serde(untagged)]
enum LastNode {
    One {
        method: String,
        n_gamma: Option<usize>,
        gamma_f: f64,
        t_dot: Option<f64>,
        delta_q_t_last: f64,
        delta_q_t_last_corrected: f64,
    },
    Scene {
        method: String,
        n_gamma: Option<usize>,
        gamma_f: f64,
        charge: String,
        delta_q_last: f64,
        delta_q_last_corrected: f64,
    },
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

/// The charges at the last node of a cell.
fn last_nodes(arena: &Arena, cell: &Cell) -> Vec<LastNode> {
    let last = cell.numbers.as_ref().and_then(|numbers| numbers.last_node.clone()).unwrap_or_default();
    let Cell { n_gamma, gamma_f, t_dot, .. } = *cell;
    let of = |(a, [last, corrected]): (usize, [f64; 2])| {
        let method = cell.method.label();
        if arena.is_scene() {
            let charge = arena.coordinates()[a].clone();
            LastNode::Scene { method, n_gamma, gamma_f, charge, delta_q_last: last, delta_q_last_corrected: corrected }
        } else {
            let (delta_q_t_last, delta_q_t_last_corrected) = (last, corrected);
            LastNode::One { method, n_gamma, gamma_f, t_dot, delta_q_t_last, delta_q_t_last_corrected }
        }
    };
    arena.charges().zip(last).map(of).collect()
}

impl<'a> StabilitySummary<'a> {
    /// The summary of a plan and of the atlas that was measured, for a case with this title and these warnings.
    pub fn new((title, warnings): (Option<&'a str>, Vec<String>), arena: &Arena, plan: &Plan, atlas: &Atlas) -> Self {
        let of_method = |method: &Method| {
            let mut counts = std::collections::BTreeMap::new();
            for cell in atlas.cells.iter().filter(|cell| cell.method == *method) {
                *counts.entry(cell.status.as_str()).or_insert(0) += 1;
            }
            let linear_limit = match method.limit() {
                Limit::Step(step) => Some(Some(step)),
                Limit::None => Some(None),
                Limit::Adaptive => None,
            };
            let accurate_up_to = borders(&atlas.cells, method);
            MethodSummary { method: method.label(), linear_limit, cells: counts, accurate_up_to }
        };
        Self {
            status: if atlas.interrupted { "interrupted" } else { "complete" },
            version: env!("CARGO_PKG_VERSION"),
            title,
            omega: arena.omega(),
            reference_error_estimate: arena.reference_error(),
            geodesic_ends: arena.ends().map(|end| end.to_string()),
            thresholds: Thresholds {
                accurate: ACCURATE,
                diverged: DIVERGED,
                sawtooth: SAWTOOTH,
                sawtooth_above_smooth: ROUGHER,
                drifting: DRIFTING,
            },
            cells: atlas.cells.len(),
            methods: plan.methods.iter().map(of_method).collect(),
            last_node: atlas.cells.iter().flat_map(|cell| last_nodes(arena, cell)).collect(),
            sawtooth: onsets(&atlas.cells),
            warnings,
        }
    }

    /// The JSON text, with a final newline.
    pub fn to_json(&self) -> String {
        super::summary::json(self)
    }
}
