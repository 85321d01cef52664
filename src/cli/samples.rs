//! `run --sample-t` and `--sample-gamma`: where samples are wanted.

use clap::Args;
use geodesic_ivp::number::Real;
use geodesic_ivp::trajectory::{Coordinate, NoSamples, OutsideRun, SampleStream};
use geodesic_ivp::{Case, CaseError};

use super::out::RESULTS;
use super::report;

/// More rows than this are taken for a typing mistake.
const MOST_SAMPLES: f64 = 1e8;
/// The option that takes samples by time.
const BY_TIME: &str = "sample-t";

#[derive(Debug, Clone, Args)]
#[command(next_help_heading = RESULTS)]
pub(super) struct SampleArgs {
    /// Also write samples.csv at these times, e.g. 0:10:0.1
    ///
    /// TIMES is START:STOP:STEP, a list as 0,1,2.5, or a column of a table as @times.csv:t.
    #[arg(
        long,
        value_name = "TIMES",
        value_parser = Range::parse,
        conflicts_with = "sample_gamma",
        allow_hyphen_values = true
    )]
    sample_t: Option<Range>,

    /// The same at values of gamma
    #[arg(long, value_name = "GAMMAS", value_parser = Range::parse, allow_hyphen_values = true)]
    sample_gamma: Option<Range>,

    /// Write no other table, and keep one window in memory
    #[arg(long, conflicts_with = "plot")]
    pub(super) samples_only: bool,
}

/// Where samples are wanted. Numbers are kept as text, so that a step of 0.1 is one tenth in every precision.
#[derive(Debug, Clone)]
struct Range {
    text: String,
    numbers: Numbers,
}

#[derive(Debug, Clone)]
enum Numbers {
    Steps { start: String, step: String, count: usize },
    List(Vec<String>),
}

fn number(text: &str) -> Option<f64> {
    text.parse().ok().filter(|number: &f64| number.is_finite())
}

impl Range {
    fn parse(text: &str) -> Result<Self, String> {
        let numbers = match text.strip_prefix('@') {
            Some(column) => Self::list(&read_column(column)?)?,
            None if text.contains(':') => Self::steps(text)?,
            None => Self::list(&text.split(',').map(|part| part.trim().to_owned()).collect::<Vec<_>>())?,
        };
        Ok(Self { text: text.to_owned(), numbers })
    }

    fn steps(text: &str) -> Result<Numbers, String> {
        let parts: Vec<&str> = text.split(':').map(str::trim).collect();
        let numbers: Option<Vec<f64>> = parts.iter().map(|part| number(part)).collect();
        let (Some(&[start, stop, step]), &[from, _, by]) = (numbers.as_deref(), parts.as_slice()) else {
            return Err("expected START:STOP:STEP, three numbers, for example 0:10:0.1".to_owned());
        };
        let steps = if step == 0.0 { f64::NAN } else { (stop - start) / step };
        if steps.is_nan() || steps < 0.0 {
            return Err("a STEP that leads from START to STOP is needed".to_owned());
        }
        if steps > MOST_SAMPLES {
            return Err(format!("more than {MOST_SAMPLES:e} samples"));
        }
        // STOP belongs to the range even if rounding makes the last step end just short of it.
        let count = (steps * (1.0 + 16.0 * f64::EPSILON)).floor() as usize + 1;
        Ok(Numbers::Steps { start: from.to_owned(), step: by.to_owned(), count })
    }

    fn list(texts: &[String]) -> Result<Numbers, String> {
        let wrong = |text: &str| {
            format!("'{text}' is not a finite number (a list is written 0,1,2.5, a column of a table @FILE.csv:COLUMN)")
        };
        let values = texts.iter().map(|text| number(text).ok_or_else(|| wrong(text)));
        let values = values.collect::<Result<Vec<f64>, String>>()?;
        if !values.is_sorted() && !values.is_sorted_by(|a, b| a >= b) {
            return Err("the numbers of a list must be in order, ascending or descending".to_owned());
        }
        Ok(Numbers::List(texts.to_vec()))
    }

    fn count(&self) -> usize {
        match &self.numbers {
            Numbers::Steps { count, .. } => *count,
            Numbers::List(list) => list.len(),
        }
    }

    fn values<S: Real>(&self) -> Vec<S> {
        let read = |text: &str| S::from_decimal(text).unwrap_or_else(|| S::from(f64::NAN));
        match &self.numbers {
            Numbers::Steps { start, step, count } => {
                let (start, step): (S, S) = (read(start), read(step));
                (0..*count).map(|k| start + S::from(k as f64) * step).collect()
            }
            Numbers::List(list) => list.iter().map(|text| read(text)).collect(),
        }
    }
}

/// The numbers below a heading of a CSV, which `column` names as FILE.csv:COLUMN.
fn read_column(column: &str) -> Result<Vec<String>, String> {
    let example = "expected @FILE.csv:COLUMN, for example @times.csv:t";
    let (path, name) = column.rsplit_once(':').ok_or(example)?;
    let cannot = |error: csv::Error| format!("cannot read {path}: {error}");
    let mut table = csv::ReaderBuilder::new().trim(csv::Trim::All).from_path(path).map_err(cannot)?;
    let headings = table.headers().map_err(cannot)?.clone();
    let place = headings.iter().position(|heading| heading == name).ok_or_else(|| {
        let headings = headings.iter().collect::<Vec<_>>().join(", ");
        format!("{path} has no column '{name}'; its columns are {headings}")
    })?;
    let rows: Result<Vec<String>, _> = table.records().map(|row| Ok(row?[place].to_owned())).collect();
    let rows = rows.map_err(cannot)?;
    if rows.is_empty() { Err(format!("{path} has no rows")) } else { Ok(rows) }
}

impl SampleArgs {
    /// Refuses combinations of options that make no sense.
    ///
    /// # Errors
    /// [`CaseError`] that says which options they are.
    pub(super) fn check(&self, stdout: bool) -> Result<(), CaseError> {
        let message = match (self.wanted(), self.samples_only) {
            (false, true) => "--samples-only needs --sample-t or --sample-gamma",
            (true, false) if stdout => {
                "--stdout writes one table: with --sample-t or --sample-gamma it needs --samples-only"
            }
            _ => return Ok(()),
        };
        Err(CaseError::without_place("command line", message.to_owned()))
    }

    /// Returns true if samples are asked for.
    pub(super) fn wanted(&self) -> bool {
        self.sample_t.is_some() || self.sample_gamma.is_some()
    }

    /// The number of samples that are asked for.
    pub(super) fn count(&self) -> usize {
        self.range().map_or(0, |(_, range)| range.count())
    }

    /// The stream that takes the samples, if any are asked for.
    ///
    /// # Errors
    /// A refusal if the coordinate by which they are asked for is none of the case's.
    pub(super) fn stream<S: Real>(&self, case: &Case) -> anyhow::Result<Option<SampleStream<S>>> {
        let Some((option, range)) = self.range() else { return Ok(None) };
        let values = range.values();
        if option != BY_TIME {
            return Ok(Some(SampleStream::new(Coordinate::Gamma, values, case.is_backward())));
        }
        let t = case.coordinates().iter().position(|name| name == "t").ok_or_else(|| {
            report::refused(
                "--sample-t needs a coordinate t, and the scene has none",
                "take samples with --sample-gamma",
            )
        })?;
        let backwards = (case.start::<f64>().q_dot[t] < 0.0) != case.is_backward();
        Ok(Some(SampleStream::new(Coordinate::Value(t), values, backwards)))
    }

    /// The option by which samples are taken, and where.
    fn range(&self) -> Option<(&'static str, &Range)> {
        let by_time = self.sample_t.as_ref().map(|range| (BY_TIME, range));
        by_time.or(self.sample_gamma.as_ref().map(|range| ("sample-gamma", range)))
    }

    /// The error where there are no samples.
    pub(super) fn refuse<S: Real>(&self, none: NoSamples<S>, digits: u32) -> anyhow::Error {
        let ((option, range), OutsideRun { range: (from, to) }) = match (self.range(), none) {
            (Some(asked), NoSamples::Outside(outside)) => (asked, outside),
            _ => {
                let message = "t does not grow, or fall, all the way: a time is not one place of the world-line";
                return report::refused(message, "take samples with --sample-gamma");
            }
        };
        let starts_before = range.values::<S>().iter().any(|value| *value < from);
        let [from, to] = [from, to].map(|end| end.to_decimal(digits));
        let message = format!("--{option} {} goes beyond the run, which covers {from} to {to}", range.text);
        let longer = if option == BY_TIME { "--set grid.t_f=…" } else { "--set grid.gamma_f=…" };
        let help = match starts_before {
            true => format!("take samples from {from} to {to}"),
            false => format!("the run ends at {to}: end the samples there, or make it longer with {longer}"),
        };
        CaseError { help: Some(help), ..CaseError::without_place("command line", message) }.into()
    }
}
