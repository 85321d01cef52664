//! The files of `converge`.

use std::io::Write;

use serde_json::{Value, json};

use super::json;
use super::tables::{decimal, write_rows};
use crate::number::Real;
use crate::study::convergence::{Convergence, ConvergencePoint, Errors, Quantity, Slope};

/// Writes `convergence.csv`, one row per grid; cells of a grid without a solution are empty. Every coordinate has two
/// columns, and every charge has one.
///
/// # Errors
/// If `out` cannot be written.
pub fn write_convergence<S>(out: impl Write, convergence: &Convergence<S>) -> csv::Result<()> {
    let Convergence { points, coordinates, charges, .. } = convergence;
    let text = |names: &[&str]| names.iter().map(|&name| name.to_owned()).collect::<Vec<String>>();
    let mut header = text(&["sbp", "form", "n_gamma", "delta_gamma"]);
    header.extend(Quantity::all(coordinates.len()).into_iter().map(|quantity| quantity.name(coordinates)));
    header.extend(charges.iter().map(|name| format!("delta_q_{name}_last")));
    header.extend(text(&["delta_k_max", "iterations", "seconds", "status"]));
    let row = |point: &ConvergencePoint| {
        let measured: Vec<String> = match &point.errors {
            Some(Errors { at_end, l2, charges_last, delta_k_max }) => {
                let all = at_end.iter().chain(l2).chain(charges_last).chain([delta_k_max]);
                all.map(|&value| decimal(value)).collect()
            }
            None => vec![String::new(); 2 * coordinates.len() + charges.len() + 1],
        };
        let grid =
            [point.sbp.into(), point.form.as_str().to_owned(), point.n_gamma.to_string(), decimal(point.delta_gamma)];
        let solve = [point.iterations.to_string(), decimal(point.seconds), point.status.to_string()];
        grid.into_iter().chain(measured).chain(solve).collect()
    };
    write_rows(out, header, points.iter().map(row))
}

/// Writes `slopes.csv`, one row for each operator, form and quantity.
///
/// # Errors
/// If `out` cannot be written.
pub fn write_slopes(out: impl Write, slopes: &[Slope]) -> csv::Result<()> {
    let header =
        ["sbp", "form", "quantity", "slope", "standard_error", "slope_vs_inverse_n", "n_min", "n_max", "points"];
    let row = |slope: &Slope| {
        let fit = slope.fit.as_ref();
        let optional = |value: Option<f64>| value.map(decimal).unwrap_or_default();
        let bound = |value: Option<usize>| value.map(|n| n.to_string()).unwrap_or_default();
        vec![
            slope.sbp.into(),
            slope.form.as_str().to_owned(),
            slope.name.clone(),
            optional(fit.map(|fit| fit.slope)),
            optional(fit.and_then(|fit| fit.standard_error)),
            optional(fit.map(|fit| fit.slope_vs_inverse_n)),
            bound(slope.n_range.map(|range| range.0)),
            bound(slope.n_range.map(|range| range.1)),
            slope.points.to_string(),
        ]
    };
    write_rows(out, header.map(str::to_owned).to_vec(), slopes.iter().map(row))
}

/// The reference that the errors are measured against: a key for the end and one for the size of every coordinate.
fn reference<S: Real>(convergence: &Convergence<S>) -> Value {
    let Convergence { reference, coordinates, digits, .. } = convergence;
    let number = |value: S| json::number(value, *digits);
    let mut found = json!({
        "error_estimate": reference.error_estimate,
        "steps": reference.steps,
        "gamma_final": number(reference.gamma_final),
    });
    for (name, &end) in coordinates.iter().zip(&reference.end) {
        found[format!("{name}_final")] = number(end);
    }
    for (name, &size) in coordinates.iter().zip(&reference.sizes) {
        found[format!("{name}_size")] = size.into();
    }
    found
}

/// `summary.json` of `converge`: of a sweep and its slopes, with the title and the warnings of its case.
pub fn convergence_summary<S: Real>(
    title: Option<&str>,
    warnings: Vec<String>,
    convergence: &Convergence<S>,
    slopes: &[Slope],
) -> String {
    let of_slope = |slope: &Slope| {
        let fit = slope.fit.as_ref();
        json!({
            "sbp": String::from(slope.sbp),
            "form": slope.form.as_str(),
            "quantity": slope.name,
            "slope": fit.map(|fit| fit.slope),
            "standard_error": fit.and_then(|fit| fit.standard_error),
            "slope_vs_inverse_n": fit.map(|fit| fit.slope_vs_inverse_n),
            "n_range": slope.n_range,
            "local_slopes": fit.map(|fit| &*fit.local_slopes).unwrap_or_default(),
            "rounding_plateau_from_n": slope.plateau_from,
        })
    };
    let found = json!({
        "digits": convergence.digits,
        "reference": reference(convergence),
        "grids": convergence.points.len(),
        "grids_without_solution": convergence.points.iter().filter(|point| point.errors.is_none()).count(),
        "slopes": slopes.iter().map(of_slope).collect::<Vec<_>>(),
        "warnings": warnings.into_iter().chain(slopes.iter().filter_map(Slope::warning)).collect::<Vec<_>>(),
    });
    json::study_json(convergence.interrupted, title, found)
}
