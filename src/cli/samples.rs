//! `run --sample-t` and `--sample-gamma`: where samples are wanted.

use std::path::Path;

use clap::Args;
use geodesic_ivp::Case;
use geodesic_ivp::case::{MOST_OF_TABLE, named, read_file};
use geodesic_ivp::number::Real;
use geodesic_ivp::study::{Numbers, Sampling};
use geodesic_ivp::trajectory::{NoSamples, OutsideRun, SampleStream};

use super::lines::shown;
use super::out::RESULTS;
use super::report;

/// More rows than this are taken for a typing mistake.
const MOST_SAMPLES: f64 = 1e8;
/// More rows of a file are not kept as text.
const MOST_LISTED: usize = 10_000_000;
/// The option that takes samples by time.
const BY_TIME: &str = "sample-t";
/// The remedy where that is not possible.
const BY_GAMMA: &str = "take samples with --sample-gamma";

#[derive(Debug, Clone, Args)]
#[command(next_help_heading = RESULTS)]
pub(super) struct SampleArgs {
    /// Also write samples.csv at these times, e.g. 0:10:0.1
    ///
    /// TIMES is START:STOP:STEP, a list as 0,1,2.5, or a column of a table as @times.csv:t. With --vary the samples of
    /// all rows are in runs-samples.csv.
    #[arg(
        long,
        value_name = "TIMES",
        value_parser = |times: &str| Range::parse(BY_TIME, times),
        conflicts_with = "sample_gamma",
        allow_hyphen_values = true
    )]
    sample_t: Option<Range>,

    /// The same at values of gamma
    #[arg(
        long,
        value_name = "GAMMAS",
        value_parser = |gammas: &str| Range::parse("sample-gamma", gammas),
        allow_hyphen_values = true
    )]
    sample_gamma: Option<Range>,

    /// Write no other table, and keep a few windows in memory
    #[arg(long, conflicts_with = "plot")]
    pub(super) samples_only: bool,
}

/// Where samples are wanted, and the option that says so.
#[derive(Debug, Clone)]
struct Range {
    option: &'static str,
    text: String,
    sampling: Sampling,
    /// The same text, in which a file is known by its content and not by its folder.
    asked: String,
}

fn number(text: &str) -> Option<f64> {
    text.parse().ok().filter(|number: &f64| number.is_finite())
}

impl Range {
    fn parse(option: &'static str, text: &str) -> Result<Self, String> {
        let (numbers, asked) = match text.strip_prefix('@') {
            Some(column) => read_column(column).and_then(|(list, asked)| Ok((Self::list(list)?, asked)))?,
            None if text.contains(':') => (Self::steps(text)?, text.to_owned()),
            None => (Self::list(text.split(',').map(|part| part.trim().to_owned()).collect())?, text.to_owned()),
        };
        let sampling = Sampling { by_time: option == BY_TIME, numbers };
        Ok(Self { option, text: text.to_owned(), sampling, asked })
    }

    fn steps(text: &str) -> Result<Numbers, String> {
        let parts: Vec<&str> = text.split(':').map(str::trim).collect();
        let numbers: Option<Vec<f64>> = parts.iter().map(|part| number(part)).collect();
        let Some(&[start, stop, step]) = numbers.as_deref() else {
            return Err("expected START:STOP:STEP, three numbers, for example 0:10:0.1".to_owned());
        };
        // STOP belongs to the range even if rounding makes the last step end just short of it.
        let steps = (stop - start) / step * (1.0 + 16.0 * f64::EPSILON);
        match steps {
            0.0..=MOST_SAMPLES => {
                let [start, _, step] = [0, 1, 2].map(|part| parts[part].to_owned());
                Ok(Numbers::Steps { start, step, count: steps as usize + 1 })
            }
            MOST_SAMPLES.. if step != 0.0 => Err(format!("more than {MOST_SAMPLES:e} samples")),
            _ => Err("a STEP that leads from START to STOP is needed".to_owned()),
        }
    }

    fn list(texts: Vec<String>) -> Result<Numbers, String> {
        let wrong = |text: &str| {
            format!("'{text}' is not a finite number (a list is written 0,1,2.5, a column of a table @FILE.csv:COLUMN)")
        };
        let values = texts.iter().map(|text| number(text).ok_or_else(|| wrong(text)));
        let values = values.collect::<Result<Vec<f64>, String>>()?;
        if !values.is_sorted() && !values.is_sorted_by(|a, b| a >= b) {
            return Err("the numbers of a list must be in order, ascending or descending".to_owned());
        }
        Ok(Numbers::List(texts))
    }
}

/// The numbers below a heading of a CSV, which `column` names as FILE.csv:COLUMN, and by what they are known again.
fn read_column(column: &str) -> Result<(Vec<String>, String), String> {
    let example = "expected @FILE.csv:COLUMN, for example @times.csv:t";
    let (path, name) = column.rsplit_once(':').ok_or(example)?;
    let (shown, file) = (shown(path), Path::new(path).file_name().unwrap_or_default().display());
    let bytes = read_file(Path::new(path), MOST_OF_TABLE).map_err(|error| format!("cannot read {shown}: {error}"))?;
    let cannot = |error: csv::Error| format!("cannot read {shown}: {error}");
    let mut table = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(bytes.as_slice());
    let headings = table.headers().map_err(cannot)?.clone();
    let place = headings.iter().position(|heading| heading == name).ok_or_else(|| {
        let headings = headings.iter().collect::<Vec<_>>().join(", ");
        format!("{shown} has no column '{name}'; its columns are {headings}")
    })?;
    let rows = table.records().take(MOST_LISTED + 1).map(|row| Ok(row?[place].to_owned()));
    let rows = rows.collect::<Result<Vec<String>, _>>().map_err(cannot)?;
    match rows.len() {
        0 => Err(format!("{shown} has no rows")),
        1..=MOST_LISTED => Ok((rows, named(&format!("@{file}:{name} with the content"), &bytes))),
        _ => Err(format!("{shown} has more than {MOST_LISTED} rows: give START:STOP:STEP, or several runs")),
    }
}

impl SampleArgs {
    /// Refuses combinations of options that make no sense.
    pub(super) fn check(&self, stdout: bool) -> anyhow::Result<()> {
        let message = match (self.range().is_some(), self.samples_only) {
            (false, true) => "--samples-only needs --sample-t or --sample-gamma",
            (true, false) if stdout => {
                "--stdout writes one table: with --sample-t or --sample-gamma it needs --samples-only"
            }
            _ => return Ok(()),
        };
        Err(report::refused(format!("command line: {message}"), ""))
    }

    fn range(&self) -> Option<&Range> {
        self.sample_t.as_ref().or(self.sample_gamma.as_ref())
    }

    /// The samples that are asked for, if any are.
    pub(super) fn wanted(&self) -> Option<&Sampling> {
        self.range().map(|range| &range.sampling)
    }

    /// The number of these.
    pub(super) fn count(&self) -> Option<usize> {
        self.wanted().map(Sampling::count)
    }

    /// The option by which they are asked for, and what it says.
    pub(super) fn asked(&self) -> Option<String> {
        self.range().map(|Range { option, asked, .. }| format!("--{option} {asked}"))
    }

    /// The stream that takes the samples, if any are asked for.
    ///
    /// # Errors
    /// A refusal if the coordinate by which they are asked for is none of the case's.
    pub(super) fn stream<S: Real>(&self, case: &Case) -> anyhow::Result<Option<SampleStream<S>>> {
        let Some(wanted) = self.wanted() else { return Ok(None) };
        let refuse = || report::refused("--sample-t needs a coordinate t, and the scene has none", BY_GAMMA);
        wanted.stream(case).ok_or_else(refuse).map(Some)
    }

    /// The error where there are no samples.
    pub(super) fn refuse<S: Real>(&self, none: NoSamples<S>, digits: u32) -> anyhow::Error {
        let (Some(asked), NoSamples::Outside(OutsideRun { range: (from, to) })) = (self.range(), none) else {
            let message = "t does not grow, or fall, all the way: a time is not one place of the world-line";
            return report::refused(message, BY_GAMMA);
        };
        let Range { option, text, sampling, .. } = asked;
        let starts_before = sampling.values::<S>().iter().any(|value| *value < from);
        let [from, to] = [from, to].map(|end| end.to_decimal(digits));
        let longer = if *option == BY_TIME { "--set grid.t_f=…" } else { "--set grid.gamma_f=…" };
        let help = match starts_before {
            true => format!("take samples from {from} to {to}"),
            false => format!("the run ends at {to}: end the samples there, or make it longer with {longer}"),
        };
        let message = format!("command line: --{option} {text} goes beyond the run, which covers {from} to {to}");
        report::refused(message, help)
    }
}
