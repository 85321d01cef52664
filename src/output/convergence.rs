//! The files of `converge`.

use std::io::Write;

use csv::Writer;
use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};

use super::number::Number;
use crate::number::Real;
use crate::study::convergence::{Convergence, Errors, Quantity, ReferenceInfo, Slope};

/// Writes `convergence.csv`, one row per grid; cells of a grid without a solution are empty. Every coordinate has two
/// columns, and every charge has one.
///
/// # Errors
/// If `out` cannot be written.
pub fn write_convergence<S>(out: impl Write, convergence: &Convergence<S>) -> csv::Result<()> {
    let Convergence { points, coordinates, charges, .. } = convergence;
    let mut writer = Writer::from_writer(out);
    let text = |names: &[&str]| names.iter().map(|&name| name.to_owned()).collect::<Vec<String>>();
    let mut header = text(&["sbp", "form", "n_gamma", "delta_gamma"]);
    header.extend(Quantity::all(coordinates.len()).into_iter().map(|quantity| quantity.name(coordinates)));
    header.extend(charges.iter().map(|name| format!("delta_q_{name}_last")));
    header.extend(text(&["delta_k_max", "iterations", "seconds", "status"]));
    writer.write_record(&header)?;
    for point in points {
        let measured: Vec<String> = match &point.errors {
            Some(Errors { at_end, l2, charges_last, delta_k_max }) => {
                let all = at_end.iter().chain(l2).chain(charges_last).chain([delta_k_max]);
                all.map(|&value| number(value)).collect()
            }
            None => vec![String::new(); 2 * coordinates.len() + charges.len() + 1],
        };
        let grid =
            [point.sbp.into(), point.form.as_str().to_owned(), point.n_gamma.to_string(), number(point.delta_gamma)];
        let solve = [point.iterations.to_string(), number(point.seconds), point.status.to_string()];
        writer.write_record(grid.into_iter().chain(measured).chain(solve))?;
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
            slope.name.clone(),
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

/// The reference against which the errors are measured: a key for the end and one for the size of every coordinate.
#[derive(Debug)]
struct ReferenceSummary {
    error_estimate: f64,
    steps: usize,
    gamma_final: Number,
    end: Vec<(String, Number)>,
    sizes: Vec<(String, f64)>,
}

impl ReferenceSummary {
    fn new<S: Real>(reference: &ReferenceInfo<S>, coordinates: &[String], digits: u32) -> Self {
        let ends = coordinates.iter().zip(&reference.end);
        let sizes = coordinates.iter().zip(&reference.sizes);
        Self {
            error_estimate: reference.error_estimate,
            steps: reference.steps,
            gamma_final: Number::new(reference.gamma_final, digits),
            end: ends.map(|(name, &end)| (format!("{name}_final"), Number::new(end, digits))).collect(),
            sizes: sizes.map(|(name, &size)| (format!("{name}_size"), size)).collect(),
        }
    }
}

impl Serialize for ReferenceSummary {
    fn serialize<T: Serializer>(&self, serializer: T) -> Result<T::Ok, T::Error> {
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("error_estimate", &self.error_estimate)?;
        map.serialize_entry("steps", &self.steps)?;
        map.serialize_entry("gamma_final", &self.gamma_final)?;
        self.end.iter().try_for_each(|(name, end)| map.serialize_entry(name, end))?;
        self.sizes.iter().try_for_each(|(name, size)| map.serialize_entry(name, size))?;
        map.end()
    }
}

#[derive(Debug, Serialize)]
struct SlopeSummary {
    sbp: String,
    form: &'static str,
    quantity: String,
    slope: Option<f64>,
    standard_error: Option<f64>,
    slope_vs_inverse_n: Option<f64>,
    n_range: Option<(usize, usize)>,
    local_slopes: Vec<f64>,
    rounding_plateau_from_n: Option<usize>,
}

impl<'a> ConvergenceSummary<'a> {
    /// The summary of a sweep and its slopes, with the title and the warnings of its case.
    pub fn new<S: Real>(
        title: Option<&'a str>,
        warnings: Vec<String>,
        convergence: &Convergence<S>,
        slopes: &[Slope],
    ) -> Self {
        let of_slope = |slope: &Slope| SlopeSummary {
            sbp: slope.sbp.into(),
            form: slope.form.as_str(),
            quantity: slope.name.clone(),
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
            title,
            digits: convergence.digits,
            reference: ReferenceSummary::new(&convergence.reference, &convergence.coordinates, convergence.digits),
            grids: convergence.points.len(),
            grids_without_solution: convergence.points.iter().filter(|point| point.errors.is_none()).count(),
            slopes: slopes.iter().map(of_slope).collect(),
            warnings: warnings.into_iter().chain(slopes.iter().filter_map(Slope::warning)).collect(),
        }
    }

    /// The JSON text, with a final newline.
    pub fn to_json(&self) -> String {
        super::summary::json(self)
    }
}
