//! The files of `work-precision`.

use std::io::{self, Read, Write};

use csv::{Reader, StringRecord};
use serde_json::json;

use super::json::study_json;
use super::tables::{decimal, write_rows};
use crate::study::work_precision::{
    Arena, DriftPoint, Family, Leader, Ratio, Row, RowErrors, RowStatus, WorkPrecision, front,
};

/// Columns before and behind those of the errors, of which every coordinate has one.
const BEFORE: [&str; 2] = ["method", "setting"];
const BEHIND: [&str; 7] =
    ["delta_k_max", "seconds_min", "seconds_median", "evaluations", "points", "status", "gamma_f"];

fn header(coordinates: &[String], behind: &[&str]) -> Vec<String> {
    let text = |name: &&str| (*name).to_owned();
    let errors = coordinates.iter().map(|name| format!("error_{name}"));
    BEFORE.iter().map(text).chain(errors).chain(behind.iter().map(text)).collect()
}

/// Writes `work_precision.csv`, one row for each method and setting. The errors are empty if there is no result.
///
/// # Errors
/// If `out` cannot be written.
pub fn write_work_precision(out: impl Write, coordinates: &[String], rows: &[Row]) -> csv::Result<()> {
    let row = |row: &Row| {
        let errors: Vec<String> = match &row.errors {
            Some(RowErrors { q, delta_k }) => q.iter().chain([delta_k]).map(|&value| decimal(value)).collect(),
            None => vec![String::new(); coordinates.len() + 1],
        };
        let times = [
            decimal(row.seconds_min),
            decimal(row.seconds_median),
            row.evaluations.to_string(),
            row.points.to_string(),
            row.status.as_str().to_owned(),
            decimal(row.gamma_f),
        ];
        [row.family.name(), row.setting.clone()].into_iter().chain(errors).chain(times).collect()
    };
    write_rows(out, header(coordinates, &BEHIND), rows.iter().map(row))
}

/// Reads rows that another program measured, from a table with the columns of `work_precision.csv`.
///
/// # Errors
/// If the table cannot be read, or does not have these columns.
pub fn read_rows(table: impl Read, coordinates: &[String]) -> csv::Result<Vec<Row>> {
    let columns = BEFORE.len() + coordinates.len() + BEHIND.len();
    let row = |record: csv::Result<StringRecord>| {
        let record = record?;
        if record.len() != columns {
            let message = format!("{} columns and not {columns}", record.len());
            return Err(io::Error::new(io::ErrorKind::InvalidData, message).into());
        }
        // The cells of a method without a result are empty.
        let value = |cell: &str| cell.parse::<f64>().unwrap_or(f64::NAN);
        let count = |cell: &str| cell.parse().unwrap_or(0);
        let behind = |place: usize| &record[BEFORE.len() + coordinates.len() + place];
        let q = (0..coordinates.len()).map(|a| value(&record[BEFORE.len() + a])).collect();
        let errors = RowErrors { q, delta_k: value(behind(0)) };
        let status = match behind(5) {
            "converged" if errors.q.iter().all(|error| error.is_finite()) => RowStatus::Converged,
            "inaccurate" => RowStatus::Inaccurate,
            "outside-domain" => RowStatus::Failed("outside-domain"),
            "too-many-steps" => RowStatus::Failed("too-many-steps"),
            _ => RowStatus::Failed("failed"),
        };
        Ok(Row {
            family: Family::Other(record[0].to_owned()),
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

/// Writes `drift.csv`, one row for each method and γ.
///
/// # Errors
/// If `out` cannot be written.
pub fn write_drift(out: impl Write, coordinates: &[String], points: &[DriftPoint]) -> csv::Result<()> {
    let mut columns = header(coordinates, &["delta_k"]);
    columns.insert(BEFORE.len(), "gamma".to_owned());
    let row = |DriftPoint { family, setting, gamma, errors }: &DriftPoint| {
        let numbers = [gamma].into_iter().chain(&errors.q).chain([&errors.delta_k]).map(|&value| decimal(value));
        [family.name(), setting.clone()].into_iter().chain(numbers).collect()
    };
    write_rows(out, columns, points.iter().map(row))
}

/// `summary.json` of `work-precision` for the case with this title: of the arenas of all lengths, the rows measured on
/// them and the table of their ratios, which are seconds of the others over those of this program.
pub fn work_precision_summary(
    title: Option<&str>,
    arenas: &[Arena],
    measured: &WorkPrecision,
    ratios: &[Ratio],
) -> String {
    let leader = |leader: &Option<Leader>| {
        let leader = leader.as_ref();
        leader.map(
            |Leader { method, setting, seconds }| json!({"method": method, "setting": setting, "seconds": seconds}),
        )
    };
    let reference = |arena: &Arena| json!({"gamma_f": arena.length(), "error_estimate": arena.reference_error()});
    let ratio = |ratio: &Ratio| {
        json!({
            "gamma_f": ratio.gamma_f,
            "error": ratio.error,
            "ratio": ratio.lead(),
            "ratio_certified": ratio.certified_lead(),
            "own": leader(&ratio.own),
            "own_certified": leader(&ratio.certified),
            "other": leader(&ratio.other),
        })
    };
    let front_row = |row: &Row| {
        json!({
            "gamma_f": row.gamma_f,
            "method": row.family.name(),
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
