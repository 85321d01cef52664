//! The files of `work-precision`.

use std::io::{self, Read};

use csv::{Reader, StringRecord};
use serde_json::json;

use super::json::study_json;
use super::study_table::StudyTable;
use crate::study::work_precision::{Arena, DriftPoint, Method, Ratio, Row, RowErrors, RowStatus, WorkPrecision, front};

/// The numbers of columns before and behind those of the errors, of which every coordinate has one.
const BEFORE: usize = 2;
const BEHIND: usize = 7;

/// `work_precision.csv`, one row for each method and setting. The errors are empty if there is no result.
pub fn work_precision_table<'r>(coordinates: &[String], rows: &'r [Row]) -> StudyTable<'r, Row> {
    let errors = coordinates.iter().map(|name| format!("error_{name}"));
    StudyTable::of(rows)
        .with("method", |row| row.method.label())
        .with("setting", |row| row.setting.clone())
        .with_each(errors, |row, a| Some(row.errors.as_ref()?.q[a]))
        .with_number("delta_k_max", |row| Some(row.errors.as_ref()?.delta_k))
        .with_number("seconds_min", |row| Some(row.seconds_min))
        .with_number("seconds_median", |row| Some(row.seconds_median))
        .with("evaluations", |row| row.evaluations.to_string())
        .with("points", |row| row.points.to_string())
        .with("status", |row| row.status.as_str().to_owned())
        .with_number("gamma_f", |row| Some(row.gamma_f))
}

/// Reads rows that another program measured, from a table with the columns of `work_precision.csv`.
///
/// # Errors
/// If the table cannot be read, or does not have these columns.
pub fn read_rows(table: impl Read, coordinates: &[String]) -> csv::Result<Vec<Row>> {
    let columns = BEFORE + coordinates.len() + BEHIND;
    let row = |record: csv::Result<StringRecord>| {
        let record = record?;
        if record.len() != columns {
            let message = format!("{} columns and not {columns}", record.len());
            return Err(io::Error::new(io::ErrorKind::InvalidData, message).into());
        }
        // The cells of a method without a result are empty.
        let value = |cell: &str| cell.parse::<f64>().unwrap_or(f64::NAN);
        let count = |cell: &str| cell.parse().unwrap_or(0);
        let behind = |place: usize| &record[BEFORE + coordinates.len() + place];
        let q = (0..coordinates.len()).map(|a| value(&record[BEFORE + a])).collect();
        let errors = RowErrors { q, delta_k: value(behind(0)) };
        let status = match behind(5) {
            "converged" if errors.q.iter().all(|error| error.is_finite()) => RowStatus::Converged,
            "inaccurate" => RowStatus::Inaccurate,
            "outside-domain" => RowStatus::Failed("outside-domain"),
            "too-many-steps" => RowStatus::Failed("too-many-steps"),
            _ => RowStatus::Failed("failed"),
        };
        Ok(Row {
            method: Method::Other(record[0].to_owned()),
            setting: record[1].to_owned(),
            gamma_f: value(behind(6)),
            errors: (!matches!(status, RowStatus::Failed(_))).then_some(errors),
            seconds_min: value(behind(1)),
            seconds_median: value(behind(2)),
            evaluations: count(behind(3)),
            points: count(behind(4)),
            status,
        })
    };
    Reader::from_reader(table).into_records().map(row).collect()
}

/// `drift.csv`, one row for each method and γ.
pub fn drift_table<'p>(coordinates: &[String], points: &'p [DriftPoint]) -> StudyTable<'p, DriftPoint> {
    StudyTable::of(points)
        .with("method", |point| point.method.label())
        .with("setting", |point| point.setting.clone())
        .with_number("gamma", |point| Some(point.gamma))
        .with_each(coordinates.iter().map(|name| format!("error_{name}")), |point, a| Some(point.errors.q[a]))
        .with_number("delta_k", |point| Some(point.errors.delta_k))
}

/// `summary.json` of `work-precision` for the case with this title: of the arenas of all lengths, the rows measured on
/// them and the table of their ratios, which are seconds of the others over those of this program.
pub fn work_precision_summary(
    title: Option<&str>,
    arenas: &[Arena],
    measured: &WorkPrecision,
    ratios: &[Ratio<'_>],
) -> String {
    let leader = |row: Option<&Row>| {
        row.map(|row| json!({"method": row.method.label(), "setting": row.setting, "seconds": row.seconds_min}))
    };
    let reference = |arena: &Arena| json!({"gamma_f": arena.length(), "error_estimate": arena.reference_error()});
    let ratio = |ratio: &Ratio<'_>| {
        json!({
            "gamma_f": ratio.gamma_f,
            "error": ratio.error,
            "ratio": ratio.lead(),
            "ratio_certified": ratio.certified_lead(),
            "own": leader(ratio.own),
            "own_certified": leader(ratio.certified),
            "other": leader(ratio.other),
        })
    };
    let front_row = |row: &Row| {
        json!({
            "gamma_f": row.gamma_f,
            "method": row.method.label(),
            "setting": row.setting,
            "error": row.rank(),
            "seconds_min": row.seconds_min,
            "seconds_median": row.seconds_median,
        })
    };
    let rows = &measured.rows;
    let front_of = |arena: &Arena| {
        let length = arena.length();
        front(rows.iter().filter(move |row| row.gamma_f == length), |row| row.seconds_min)
    };
    let found = json!({
        "rows": rows.len(),
        "rows_without_result": rows.iter().filter(|row| row.rank().is_none()).count(),
        "references": arenas.iter().map(reference).collect::<Vec<_>>(),
        "ratios": ratios.iter().map(ratio).collect::<Vec<_>>(),
        "fronts": arenas.iter().flat_map(front_of).map(front_row).collect::<Vec<_>>(),
    });
    study_json(measured.interrupted, title, found)
}
