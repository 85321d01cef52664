//! The files of `converge`.

use serde_json::{Value, json};

use super::json;
use super::study_table::StudyTable;
use crate::number::Real;
use crate::study::convergence::{Convergence, ConvergencePoint, Quantity, Slope};

/// `convergence.csv`, one row per grid; cells of a grid without a solution are empty. Every coordinate has two columns,
/// and every charge has one.
pub fn convergence_table<S>(convergence: &Convergence<S>) -> StudyTable<'_, ConvergencePoint> {
    let Convergence { points, coordinates, charges, .. } = convergence;
    let grids = StudyTable::of(points)
        .with("sbp", |point| point.sbp.to_string())
        .with("form", |point| point.form.as_str().to_owned())
        .with("n_gamma", |point| point.n_gamma.to_string())
        .with_number("delta_gamma", |point| Some(point.delta_gamma));
    Quantity::all(coordinates.len())
        .into_iter()
        .fold(grids, |table, of| {
            table.with_number(of.name(coordinates), move |point| Some(of.of(point.errors.as_ref()?)))
        })
        .with_each(charges.iter().map(|name| format!("delta_q_{name}_last")), |point, k| {
            Some(point.errors.as_ref()?.charges_last[k])
        })
        .with_number("delta_k_max", |point| Some(point.errors.as_ref()?.delta_k_max))
        .with("iterations", |point| point.iterations.to_string())
        .with_number("seconds", |point| Some(point.seconds))
        .with("status", |point| point.status.to_string())
}

/// `slopes.csv`, one row for each operator, form and quantity.
pub fn slopes_table(slopes: &[Slope]) -> StudyTable<'_, Slope> {
    let bound = |n: Option<usize>| n.map(|n| n.to_string()).unwrap_or_default();
    StudyTable::of(slopes)
        .with("sbp", |slope| slope.sbp.to_string())
        .with("form", |slope| slope.form.as_str().to_owned())
        .with("quantity", |slope| slope.name.clone())
        .with_number("slope", |slope| Some(slope.fit.as_ref()?.slope))
        .with_number("standard_error", |slope| slope.fit.as_ref()?.standard_error)
        .with_number("slope_vs_inverse_n", |slope| Some(slope.fit.as_ref()?.slope_vs_inverse_n))
        .with("n_min", move |slope| bound(slope.n_range.map(|range| range.0)))
        .with("n_max", move |slope| bound(slope.n_range.map(|range| range.1)))
        .with("points", |slope| slope.points.to_string())
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
            "sbp": slope.sbp.to_string(),
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
