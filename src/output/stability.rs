//! The files of `stability`.

use serde_json::{Value, json};

use super::json::{merged, present, study_json};
use super::study_table::StudyTable;
use crate::case::Form;
use crate::study::stability::{
    ACCURATE, Arena, Atlas, Cell, CellStatus, DIVERGED, DRIFTING, Limit, Method, Plan, ROUGHER, SAWTOOTH,
};

/// `stability.csv`, one row per cell. Numbers that do not apply, were not measured or are not finite are left empty.
/// The columns of one coordinate have its charge and its error in the middle. Those of a scene have the errors of all
/// coordinates, the charges and the energy at the end.
pub fn stability_table<'a>(arena: &'a Arena, cells: &'a [Cell]) -> StudyTable<'a, Cell> {
    let whole = |value: Option<usize>| value.map(|value| value.to_string()).unwrap_or_default();
    let finite = |value: Option<f64>| value.filter(|value| value.is_finite());
    let charge = move |cell: &Cell, place: usize| finite(Some(cell.numbers.as_ref()?.charges.as_ref()?[place]));
    let error = move |cell: &Cell, a: usize| finite(Some(cell.numbers.as_ref()?.errors.as_ref()?[a]));
    let only = |name: &str, is_there: bool| is_there.then(|| name.to_owned()).into_iter();
    let is_scene = arena.geometry().c_squared.is_none();
    let names = if is_scene { arena.geometry().names() } else { &[] };
    let charges = arena.geometry().ignorable().filter(|_| is_scene).map(|a| format!("delta_q_{}", names[a]));
    StudyTable::of(cells)
        .with("method", |cell| match cell.method.is_adaptive() {
            true => format!("{} tol={:e}", cell.method.name(), cell.setting),
            false => cell.method.name(),
        })
        .with("form", |cell| cell.method.form().map_or("", Form::as_str).to_owned())
        .with("n_gamma", move |cell| whole(cell.n_gamma))
        .with_number("gamma_f", move |cell| finite(Some(cell.gamma_f)))
        .with_number("t_dot", move |cell| finite(cell.t_dot))
        .with_number("delta_gamma_omega", move |cell| finite(cell.delta_gamma_omega))
        .with("status", |cell| cell.status.as_str().to_owned())
        .with_number("delta_k_max", move |cell| finite(Some(cell.numbers.as_ref()?.delta_k_max)))
        .with_each(only("delta_q_t_max", !is_scene), charge)
        .with_each(only("error_x_max", !is_scene), move |cell, _| error(cell, 1))
        .with_number("sawtooth", move |cell| finite(cell.numbers.as_ref()?.sawtooth))
        .with("iterations", move |cell| whole(cell.iterations))
        .with_number("seconds", move |cell| finite(Some(cell.seconds)))
        .with_each(names.iter().map(|name| format!("error_{name}")), error)
        .with_each(charges, charge)
        .with_each(only("delta_energy_max", is_scene && arena.has_energy()), move |cell, _| {
            finite(cell.numbers.as_ref()?.delta_energy_max)
        })
}

/// For each length, the largest Δγω up to which all cells of `method` are accurate; null if not even the finest cell
/// is. A length is γ_f − γ_i times ṫ_i in units of the case's own.
fn borders(cells: &[Cell], method: &Method) -> Vec<Value> {
    let mut cells: Vec<&Cell> = cells.iter().filter(|cell| cell.method == *method).collect();
    cells.sort_by(|a, b| a.length().total_cmp(&b.length()).then(a.setting.total_cmp(&b.setting)));
    let border = |row: &[&Cell]| {
        let accurate = row.iter().take_while(|cell| cell.status == CellStatus::Accurate);
        let last = accurate.filter_map(|cell| cell.delta_gamma_omega).last();
        json!({"length": row[0].length(), "delta_gamma_omega": last})
    };
    cells.chunk_by(|a, b| a.length() == b.length()).map(border).collect()
}

/// Where the sawtooth begins, for each method and step: on the longest world-line that has one, and γ − γ_i there.
pub(super) fn onsets<'c>(cells: impl Iterator<Item = &'c Cell>) -> Vec<(&'c Cell, f64)> {
    let step = |cell: &Cell| cell.setting * cell.tangent;
    let mut all: Vec<(&Cell, f64)> = Vec::new();
    for cell in cells.filter(|cell| cell.delta_gamma_omega.is_some()) {
        let Some(from) = cell.numbers.as_ref().and_then(|numbers| numbers.sawtooth_from) else { continue };
        let onset = (cell, from * cell.tangent);
        let same = |other: &Cell| other.method == cell.method && step(other) == step(cell);
        match all.iter_mut().find(|(other, _)| same(other)) {
            Some(known) if known.0.length() < cell.length() => *known = onset,
            Some(_) => {}
            None => all.push(onset),
        }
    }
    all
}

/// The charges at the last node of a cell, with and without the correction.
fn last_nodes(arena: &Arena, cell: &Cell) -> Vec<Value> {
    let last = cell.numbers.as_ref().and_then(|numbers| numbers.last_node.clone()).unwrap_or_default();
    let Cell { n_gamma, gamma_f, t_dot, .. } = *cell;
    let of = |(a, [last, corrected]): (usize, [f64; 2])| {
        let (key, value, charge) = match arena.geometry().c_squared.is_none() {
            true => ("charge", json!(arena.geometry().names()[a]), "delta_q"),
            false => ("t_dot", json!(t_dot), "delta_q_t"),
        };
        json!({
            "method": cell.method.label(),
            "n_gamma": n_gamma,
            "gamma_f": gamma_f,
            key: value,
            format!("{charge}_last"): last,
            format!("{charge}_last_corrected"): corrected,
        })
    };
    arena.geometry().ignorable().zip(last).map(of).collect()
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
        // The limit of hω is null if there is none, and absent for adaptive methods.
        let limit = match method.limit() {
            Limit::Step(step) => json!({"linear_limit": step}),
            Limit::None => json!({"linear_limit": null}),
            Limit::Adaptive => Value::Null,
        };
        let found = json!({"cells": counts, "accurate_up_to": borders(&atlas.cells, method)});
        merged([json!({"method": method.label()}), limit, found])
    };
    let onset = |(cell, gamma): (&Cell, f64)| {
        let (method, delta_gamma_omega) = (cell.method.label(), cell.delta_gamma_omega);
        json!({"method": method, "delta_gamma_omega": delta_gamma_omega, "gamma": gamma})
    };
    let found = merged([
        json!({"omega": arena.omega(), "reference_error_estimate": arena.reference_error()}),
        present(json!({"geodesic_ends": arena.ends.as_ref().map(|end| end.to_string())})),
        json!({
            "thresholds": {
                "accurate": ACCURATE,
                "diverged": DIVERGED,
                "sawtooth": SAWTOOTH,
                "sawtooth_above_smooth": ROUGHER,
                "drifting": DRIFTING,
            },
            "cells": atlas.cells.len(),
            "methods": plan.methods.iter().map(of_method).collect::<Vec<_>>(),
            "last_node": atlas.cells.iter().flat_map(|cell| last_nodes(arena, cell)).collect::<Vec<_>>(),
            "sawtooth": onsets(atlas.cells.iter()).into_iter().map(onset).collect::<Vec<_>>(),
            "warnings": warnings,
        }),
    ]);
    study_json(atlas.interrupted, title, found)
}
