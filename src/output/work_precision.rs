//! The files of `work-precision`.

use std::io::{Read, Write};

use csv::{Reader, Writer};
use serde::Serialize;

use crate::case::Case;
use crate::study::work_precision::{
    Arena, DriftPoint, Family, Leader, Ratio, Row, RowErrors, RowStatus, WorkPrecision, front,
};

const COLUMNS: [&str; 11] = [
    "method",
    "setting",
    "error_t",
    "error_x",
    "delta_k_max",
    "seconds_min",
    "seconds_median",
    "evaluations",
    "points",
    "status",
    "gamma_f",
];

/// Writes `work_precision.csv`, one row for each method and setting. The errors are empty if there is no result.
///
/// # Errors
/// If `out` cannot be written.
pub fn write_work_precision(out: impl Write, rows: &[Row]) -> csv::Result<()> {
    let mut writer = Writer::from_writer(out);
    writer.write_record(COLUMNS)?;
    for row in rows {
        let [t, x, k] = row.errors.map_or_else(Default::default, |e| [e.t, e.x, e.delta_k].map(number));
        writer.write_record([
            row.family.name(),
            row.setting.clone(),
            t,
            x,
            k,
            number(row.seconds_min),
            number(row.seconds_median),
            row.evaluations.to_string(),
            row.points.to_string(),
            row.status.as_str().to_owned(),
            number(row.gamma_f),
        ])?;
    }
    writer.flush()?;
    Ok(())
}

/// Reads rows that another program measured, from a table with the columns of `work_precision.csv`.
///
/// # Errors
/// If the table cannot be read, or does not have these columns.
pub fn read_rows(table: impl Read) -> csv::Result<Vec<Row>> {
    let row = |record: csv::Result<[String; 11]>| {
        let [method, setting, t, x, k, least, median, evaluations, points, status, gamma_f] = record?;
        // The cells of a method without a result are empty.
        let value = |cell: &str| cell.parse::<f64>().unwrap_or(f64::NAN);
        let count = |cell: &str| cell.parse().unwrap_or(0);
        let errors = RowErrors { t: value(&t), x: value(&x), delta_k: value(&k) };
        let status = match status.as_str() {
            "converged" if errors.largest().is_finite() => RowStatus::Converged,
            "inaccurate" => RowStatus::Inaccurate,
            "outside-domain" => RowStatus::Failed("outside-domain"),
            "too-many-steps" => RowStatus::Failed("too-many-steps"),
            _ => RowStatus::Failed("failed"),
        };
        Ok(Row {
            family: Family::Other(method),
            setting,
            gamma_f: value(&gamma_f),
            errors: (!matches!(status, RowStatus::Failed(_))).then_some(errors),
            seconds_min: value(&least),
            seconds_median: value(&median),
            evaluations: count(&evaluations),
            points: count(&points),
            status,
        })
    };
    Reader::from_reader(table).into_deserialize().map(row).collect()
}

/// Writes `drift.csv`, one row for each method and γ.
///
/// # Errors
/// If `out` cannot be written.
pub fn write_drift(out: impl Write, points: &[DriftPoint]) -> csv::Result<()> {
    let mut writer = Writer::from_writer(out);
    writer.write_record(["method", "setting", "gamma", "error_t", "error_x", "delta_k"])?;
    for DriftPoint { family, setting, gamma, errors } in points {
        let [gamma, t, x, k] = [*gamma, errors.t, errors.x, errors.delta_k].map(number);
        writer.write_record([family.name(), setting.clone(), gamma, t, x, k])?;
    }
    writer.flush()?;
    Ok(())
}

fn number(value: f64) -> String {
    zmij::Buffer::new().format(value).to_owned()
}

/// `summary.json` of `work-precision`.
#[derive(Debug, Serialize)]
pub struct WorkPrecisionSummary<'a> {
    /// `complete` or `interrupted`.
    status: &'static str,
    version: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    title: Option<&'a str>,
    rows: usize,
    rows_without_result: usize,
    references: Vec<ReferenceSummary>,
    ratios: Vec<RatioSummary<'a>>,
    fronts: Vec<FrontRow<'a>>,
}

#[derive(Debug, Serialize)]
struct ReferenceSummary {
    gamma_f: f64,
    error_estimate: f64,
}

#[derive(Debug, Serialize)]
struct LeaderSummary<'a> {
    method: &'a str,
    setting: &'a str,
    seconds: f64,
}

#[derive(Debug, Serialize)]
struct RatioSummary<'a> {
    gamma_f: f64,
    error: f64,
    /// Seconds of the others over those of this program.
    ratio: Option<f64>,
    ratio_certified: Option<f64>,
    own: Option<LeaderSummary<'a>>,
    own_certified: Option<LeaderSummary<'a>>,
    other: Option<LeaderSummary<'a>>,
}

#[derive(Debug, Serialize)]
struct FrontRow<'a> {
    gamma_f: f64,
    method: String,
    setting: &'a str,
    error: Option<f64>,
    seconds_min: f64,
    seconds_median: f64,
}

impl<'a> WorkPrecisionSummary<'a> {
    /// The summary of the arenas of all lengths, the rows measured on them and the table of their ratios.
    pub fn new(case: &'a Case, arenas: &[Arena], measured: &'a WorkPrecision, ratios: &'a [Ratio]) -> Self {
        let leader = |leader: &'a Option<Leader>| {
            leader.as_ref().map(|Leader { method, setting, seconds }| LeaderSummary {
                method,
                setting,
                seconds: *seconds,
            })
        };
        let front_row = |row: &'a Row| FrontRow {
            gamma_f: row.gamma_f,
            method: row.family.name(),
            setting: &row.setting,
            error: row.rank(),
            seconds_min: row.seconds_min,
            seconds_median: row.seconds_median,
        };
        let rows = &measured.rows;
        let front_of = |arena: &Arena| {
            let length = arena.length();
            front(rows.iter().filter(move |row| row.gamma_f == length), |row| row.seconds_min)
        };
        Self {
            status: if measured.interrupted { "interrupted" } else { "complete" },
            version: env!("CARGO_PKG_VERSION"),
            title: case.title.as_deref(),
            rows: rows.len(),
            rows_without_result: rows.iter().filter(|row| row.rank().is_none()).count(),
            references: (arenas.iter())
                .map(|arena| ReferenceSummary { gamma_f: arena.length(), error_estimate: arena.reference_error() })
                .collect(),
            ratios: (ratios.iter())
                .map(|ratio| RatioSummary {
                    gamma_f: ratio.gamma_f,
                    error: ratio.error,
                    ratio: ratio.lead(),
                    ratio_certified: ratio.certified_lead(),
                    own: leader(&ratio.own),
                    own_certified: leader(&ratio.certified),
                    other: leader(&ratio.other),
                })
                .collect(),
            fronts: arenas.iter().flat_map(front_of).map(front_row).collect(),
        }
    }

    /// The JSON text, with a final newline.
    pub fn to_json(&self) -> String {
        super::summary::json(self)
    }
}
