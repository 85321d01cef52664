//! The pictures of `work-precision`: speed against accuracy, and errors along a run. This program has solid coloured
//! lines with filled symbols; other methods have dashed grey lines with open symbols.

use std::collections::BTreeMap;

use super::look;
use crate::output::chart::{Chart, Mark, Series, Style};
use crate::study::work_precision::{DriftPoint, Row, front};

/// The quantity on the ordinate, which measures the work.
#[derive(Debug, Clone, Copy)]
pub struct Work {
    headline: &'static str,
    label: &'static str,
    of: fn(&Row) -> f64,
}

impl Work {
    /// Least seconds of a run.
    pub const SECONDS: Self = Self {
        headline: "What an accuracy costs in time: lower left is better",
        label: "seconds",
        of: |row| row.seconds_min,
    };
    /// Evaluations of the potential.
    pub const EVALUATIONS: Self = Self {
        headline: "What an accuracy costs in evaluations: lower left is better",
        label: "evaluations of the potential",
        of: |row| row.evaluations as f64,
    };
}

/// The errors that are drawn.
fn error_label(coordinates: &[String]) -> String {
    match coordinates {
        [first @ .., last] if !first.is_empty() => format!("largest error of {} and {last}", first.join(", ")),
        _ => "largest error".to_owned(),
    }
}

/// The best settings of every group of methods on one length, and behind them the front of all methods. Settings
/// without a result are not drawn.
pub fn work_precision<'a>(
    of: &str,
    coordinates: &[String],
    rows: impl IntoIterator<Item = &'a Row>,
    work: Work,
) -> Chart {
    let rows: Vec<&Row> = rows.into_iter().collect();
    let place = |row: &Row| (row.rank().unwrap_or(f64::NAN), (work.of)(row));
    let best = |rows: &[&'a Row]| front(rows.iter().copied(), work.of).into_iter().map(place).collect::<Vec<_>>();
    let mut curves: BTreeMap<(usize, String), Vec<&Row>> = BTreeMap::new();
    for row in &rows {
        curves.entry(row.method.curve()).or_default().push(row);
    }
    let mut series = vec![Series::new("", Mark::BAND, best(&rows)).with_look(Style::PALE)];
    // A method without any result has no curve and no entry in the legend.
    curves.retain(|_, rows| rows.iter().any(|row| row.rank().is_some()));
    for ((_, label), rows) in &curves {
        let method = &rows[0].method;
        let curve = Series::new(label, look::mark(method.is_own()), best(rows));
        series.push(curve.with_look(look::of_curve(method)));
    }
    let of = format!("{of}; grey band: the best of all");
    Chart::new(work.headline, &of, [&error_label(coordinates), work.label], series).log_log()
}

/// Number of points of a curve along a run. Each is the largest value over an interval of log γ; otherwise oscillations
/// would hide everything else.
const BINS: usize = 24;

/// |ΔK|, or the largest error of a coordinate, along a run. On these logarithmic axes a bounded oscillation is level, a
/// random walk has slope ½, and a drift of K slope 1; the error of the phase that a drift causes has slope 2.
pub fn drift(of: &str, coordinates: &[String], points: &[DriftPoint], of_k: bool) -> Chart {
    let end = points.iter().map(|point| point.gamma).fold(0.0, f64::max);
    let start = points.iter().map(|point| point.gamma).fold(end, f64::min);
    let bin = |gamma: f64| {
        let share = (gamma / start).ln() / (end / start).ln().max(f64::MIN_POSITIVE);
        ((share * BINS as f64) as usize).min(BINS - 1)
    };
    let mut series = Vec::new();
    for run in points.chunk_by(|a, b| a.method == b.method) {
        let method = &run[0].method;
        let mut largest: BTreeMap<usize, (f64, f64)> = BTreeMap::new();
        for point in run {
            let value = if of_k { point.errors.delta_k } else { point.errors.largest() };
            let best = largest.entry(bin(point.gamma)).or_insert((point.gamma, value));
            // A NaN is kept, and the curve ends there.
            if value > best.1 || value.is_nan() {
                *best = (point.gamma, value);
            }
        }
        let curve = Series::new(method.label(), look::mark(method.is_own()), largest.into_values().collect());
        series.push(curve.with_look(look::of_method(method)));
    }
    let (title, label) = match of_k {
        true => ("Does K drift? Level is bounded, slope ½ is rounding, slope 1 is drift", "|ΔK|".to_owned()),
        false => ("How errors grow along the run, at equal work", error_label(coordinates)),
    };
    Chart::new(title, of, ["γ − γ_i", &label], series).log_log()
}
