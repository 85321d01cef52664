//! The files of `converge`.

use std::io::Write;

use csv::Writer;
use serde::Serialize;

use super::number::Number;
use crate::case::Case;
use crate::scalar::Real;
use crate::study::convergence::{Convergence, ConvergencePoint, Slope};

/// Writes `convergence.csv`, one row per grid; cells of a grid without a solution are empty.
///
/// # Errors
/// If `out` cannot be written.
pub fn write_convergence(out: impl Write, points: &[ConvergencePoint]) -> csv::Result<()> {
    let mut writer = Writer::from_writer(out);
    writer.write_record([
        "sbp",
        "form",
        "n_gamma",
        "delta_gamma",
        "eps_t_final",
        "eps_x_final",
        "eps_t_l2",
        "eps_x_l2",
        "delta_q_t_last",
        "delta_k_max",
        "iterations",
        "seconds",
        "status",
    ])?;
    for point in points {
        let errors = match point.errors {
            Some(e) => {
                [e.eps_t_final, e.eps_x_final, e.eps_t_l2, e.eps_x_l2, e.delta_q_t_last, e.delta_k_max].map(number)
            }
            None => Default::default(),
        };
        let [eps_t_final, eps_x_final, eps_t_l2, eps_x_l2, delta_q_t_last, delta_k_max] = errors;
        writer.write_record([
            point.sbp.into(),
            point.form.as_str().to_owned(),
            point.n_gamma.to_string(),
            number(point.delta_gamma),
            eps_t_final,
            eps_x_final,
            eps_t_l2,
            eps_x_l2,
            delta_q_t_last,
            delta_k_max,
            point.iterations.to_string(),
            number(point.seconds),
            point.status.to_string(),
        ])?;
    }
    writer.flush()?;
    Ok(())
}

/// Writes `slopes.csv`, one row for each operator, form and quantity.
///
/// # Errors
/// If `out` cannot be written.
pub fn write_slopes(out: impl Write, slopes: &[Slope]) -> csv::Result<()> {
    let mut writer = Writer::from_writer(out);
    writer.write_record([
        "sbp",
        "form",
        "quantity",
        "slope",
        "standard_error",
        "slope_vs_inverse_n",
        "n_min",
        "n_max",
        "points",
    ])?;
    for slope in slopes {
        let fit = slope.fit.as_ref();
        let optional = |value: Option<f64>| value.map(number).unwrap_or_default();
        let bound = |value: Option<usize>| value.map(|n| n.to_string()).unwrap_or_default();
        writer.write_record([
            slope.sbp.into(),
            slope.form.as_str().to_owned(),
            slope.quantity.as_str().to_owned(),
            optional(fit.map(|fit| fit.slope)),
            optional(fit.and_then(|fit| fit.standard_error)),
            optional(fit.map(|fit| fit.slope_vs_inverse_n)),
            bound(slope.n_range.map(|range| range.0)),
            bound(slope.n_range.map(|range| range.1)),
            slope.points.to_string(),
        ])?;
    }
    writer.flush()?;
    Ok(())
}

fn number(value: f64) -> String {
    zmij::Buffer::new().format(value).to_owned()
}

/// `summary.json` of `converge`.
#[derive(Debug, Serialize)]
pub struct ConvergenceSummary<'a> {
    /// `complete` or `interrupted`.
    status: &'static str,
    version: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    title: Option<&'a str>,
    digits: u32,
    reference: ReferenceSummary,
    grids: usize,
    grids_without_solution: usize,
    slopes: Vec<SlopeSummary>,
    warnings: Vec<String>,
}

/// The reference against which the errors are measured.
#[derive(Debug, Serialize)]
struct ReferenceSummary {
    error_estimate: f64,
    steps: usize,
    gamma_final: Number,
    t_final: Number,
    x_final: Number,
    t_size: f64,
    x_size: f64,
}

#[derive(Debug, Serialize)]
struct SlopeSummary {
    sbp: String,
    form: &'static str,
    quantity: &'static str,
    slope: Option<f64>,
    standard_error: Option<f64>,
    slope_vs_inverse_n: Option<f64>,
    n_range: Option<(usize, usize)>,
    local_slopes: Vec<f64>,
    rounding_plateau_from_n: Option<usize>,
}

impl<'a> ConvergenceSummary<'a> {
    /// The summary of a sweep and its slopes.
    pub fn new<S: Real>(case: &'a Case, convergence: &Convergence<S>, slopes: &[Slope]) -> Self {
        let reference = &convergence.reference;
        let number = |value: S| Number::new(value, convergence.digits);
        let of_slope = |slope: &Slope| SlopeSummary {
            sbp: slope.sbp.into(),
            form: slope.form.as_str(),
            quantity: slope.quantity.as_str(),
            slope: slope.fit.as_ref().map(|fit| fit.slope),
            standard_error: slope.fit.as_ref().and_then(|fit| fit.standard_error),
            slope_vs_inverse_n: slope.fit.as_ref().map(|fit| fit.slope_vs_inverse_n),
            n_range: slope.n_range,
            local_slopes: slope.fit.as_ref().map(|fit| fit.local_slopes.clone()).unwrap_or_default(),
            rounding_plateau_from_n: slope.plateau_from,
        };
        Self {
            status: if convergence.interrupted { "interrupted" } else { "complete" },
            version: env!("CARGO_PKG_VERSION"),
            title: case.title.as_deref(),
            digits: convergence.digits,
            reference: ReferenceSummary {
                error_estimate: reference.error_estimate,
                steps: reference.steps,
                gamma_final: number(reference.gamma_final),
                t_final: number(reference.t_final),
                x_final: number(reference.x_final),
                t_size: reference.t_size,
                x_size: reference.x_size,
            },
            grids: convergence.points.len(),
            grids_without_solution: convergence.points.iter().filter(|point| point.errors.is_none()).count(),
            slopes: slopes.iter().map(of_slope).collect(),
            warnings: case.warnings().into_iter().chain(slopes.iter().filter_map(Slope::warning)).collect(),
        }
    }

    /// The JSON text, with a final newline.
    pub fn to_json(&self) -> String {
        super::summary::json(self)
    }
}
