//! Tables and summary of `find`.

use std::io::Write;

use csv::Writer;
use serde_json::{Value, json};

use super::json::{json, merged, present};
use super::summary::{Seconds, value_of_run};
use crate::case::{Case, Find, Goal};
use crate::number::Real;
use crate::study::find::{Existence, Fit, Found, Iterate, Multipliers, norm};
use crate::study::proof::decimal as decimal_within;
use crate::study::run::{Judged, Run};

pub(super) fn decimal(number: f64) -> String {
    number.to_decimal(f64::MOST_DIGITS)
}

/// Writes `find.csv`: a row for each iterate with its unknowns, the residuals unless they are those of data, the root
/// of the sum of their squares, the length of the full step from there, and the part of a step that led there.
///
/// # Errors
/// If `out` cannot be written.
pub fn write_iterates(out: impl Write, wanted: &Find, iterates: &[Iterate]) -> csv::Result<()> {
    let mut writer = Writer::from_writer(out);
    let shown = if matches!(wanted.goal, Goal::Data(_)) { 0 } else { usize::MAX };
    let count = iterates.first().map_or(0, |first| first.residuals.len().min(shown));
    let keys = wanted.unknowns.iter().map(|unknown| unknown.key.clone());
    let header = std::iter::once("iteration".to_owned()).chain(keys);
    let header = header.chain((1..=count).map(|k| format!("residual_{k}")));
    writer.write_record(header.chain(["residual_norm", "step", "damping"].map(str::to_owned)))?;
    for Iterate { iteration, values, residuals, step, damping } in iterates {
        let numbers = values.iter().chain(residuals.iter().take(count)).map(|number| decimal(*number));
        let last = [decimal(norm(residuals)), decimal(*step), damping.map_or(String::new(), decimal)];
        writer.write_record(std::iter::once(iteration.to_string()).chain(numbers).chain(last))?;
    }
    Ok(writer.flush()?)
}

/// Writes `fit.csv`: for each observation its place, which is t or gamma, the coordinate, the datum, the value of the
/// run, and their difference in standard deviations, if these are known.
///
/// # Errors
/// If `out` cannot be written.
pub fn write_fit(out: impl Write, wanted: &Find, fit: &Fit) -> csv::Result<()> {
    let mut writer = Writer::from_writer(out);
    let by_time = matches!(&wanted.goal, Goal::Data(data) if data.by.is_some());
    let place = if by_time { "t" } else { "gamma" };
    writer.write_record([place, "coordinate", "observed", "computed", "residual"])?;
    for row in &fit.rows {
        let [place, observed, computed, residual] = [row.place, row.observed, row.computed, row.residual].map(decimal);
        writer.write_record([place, row.coordinate.clone(), observed, computed, residual])?;
    }
    Ok(writer.flush()?)
}

/// The summary of a search: that of the run that was found, and `find`.
pub fn find_summary(
    case: &Case,
    wanted: &Find,
    (found, steps): (&Found, usize),
    (run, judged): (&Run, &Judged),
    seconds: Seconds,
) -> String {
    let by_key = |values: &[f64]| -> Value {
        wanted.unknowns.iter().map(|unknown| unknown.key.clone()).zip(values.iter().map(|&v| Value::from(v))).collect()
    };
    let starts: Vec<f64> = wanted.unknowns.iter().map(|unknown| unknown.value).collect();
    let by_name = |value: fn(&(String, f64, f64)) -> f64| -> Value {
        found.residuals.iter().map(|all| (all.0.clone(), Value::from(value(all)))).collect()
    };
    let head = json!({
        "steps": steps,
        "is_met": found.is_met,
        "unknowns": by_key(&found.values),
        "errors": by_key(&found.errors),
        "start": by_key(&starts),
        "residuals": by_name(|(_, residual, _)| *residual),
        "residual_errors": by_name(|(.., error)| *error),
        "rank": found.rank,
        "condition": found.condition,
        "differenced": found.differenced,
    });
    let pairs = |values: &[nalgebra::Complex<f64>]| -> Value { values.iter().map(|z| json!([z.re, z.im])).collect() };
    let of_multipliers = found.multipliers.as_ref().map(|Multipliers { values, indices, krein_signs }| {
        let indices = indices.as_deref().map(pairs);
        present(json!({"multipliers": pairs(values), "stability_indices": indices, "krein_signs": krein_signs}))
    });
    let of_fit = found.fit.as_ref().map(|fit| {
        let rows = wanted.unknowns.iter().map(|unknown| unknown.key.clone());
        json!({
            "chi_squared": fit.chi_squared,
            "degrees_of_freedom": fit.degrees_of_freedom,
            "has_sigmas": fit.has_sigmas,
            "standard_errors": by_key(&fit.standard_errors()),
            "covariance": rows.zip(fit.covariance.iter().map(|row| by_key(row))).collect::<Value>(),
        })
    });
    let of_geodesic = found
        .geodesic
        .as_ref()
        .map(|geodesic| present(json!({"length": geodesic.length, "conjugate_points": geodesic.conjugate})));
    let of_proof = found.existence.as_ref().map(|existence| json!({"proof": proof(wanted, existence)}));
    let all = merged([present(head), json!(of_multipliers), json!(of_fit), json!(of_geodesic), json!(of_proof)]);
    json(&merged([value_of_run(case, run, judged, seconds), json!({"find": all})]))
}

/// A proof that there is what was found, or why there is none.
fn proof(wanted: &Find, existence: &Result<Existence, String>) -> Value {
    let existence = match existence {
        Ok(existence) => existence,
        Err(reason) => return json!({"status": "unproved", "reason": reason}),
    };
    let decimals: Vec<_> = existence.values.iter().map(|&(value, radius)| decimal_within(value, radius)).collect();
    let keys = || wanted.unknowns.iter().map(|unknown| unknown.key.clone());
    let alone_within = existence.alone_within.as_ref();
    let alone_within = alone_within.map(|radii| keys().zip(radii.iter().map(|&r| Value::from(r))).collect::<Value>());
    present(json!({
        "status": "proved",
        "unknowns": keys().zip(decimals.iter().map(|(text, _)| Value::from(text.as_str()))).collect::<Value>(),
        "radii": keys().zip(decimals.iter().map(|(_, radius)| Value::from(*radius))).collect::<Value>(),
        "alone_within": alone_within,
        "windows": existence.windows,
        "seconds": existence.seconds,
    }))
}

/// The summary of a search that found nothing.
pub fn not_found_summary(case: &Case, (message, advice): (&str, &str), steps: usize) -> String {
    json(&merged([
        json!({"status": "not-found", "version": env!("CARGO_PKG_VERSION")}),
        present(json!({"title": case.title.as_deref()})),
        json!({"message": message, "advice": advice, "find": {"steps": steps}}),
    ]))
}
