//! `run --stdout`: one table, and no files.

use std::fs::File;
use std::io::Write;
use std::process::ExitCode;

use anyhow::Context;
use geodesic_ivp::Case;
use geodesic_ivp::diagnostics::Diagnostics;
use geodesic_ivp::number::Real;
use geodesic_ivp::output::streamed::{StreamedSamples, StreamedTable};
use geodesic_ivp::output::tables::write_samples;
use geodesic_ivp::solve::{Limit, Settings, Setup, WorldLine};
use geodesic_ivp::study::run::{self, Wanted};
use geodesic_ivp::trajectory::{Sample, SampleStream};

use super::out;
use super::run_args::{RunArgs, explained, solved};

/// Returns true if a pipe takes the windows of a run as they come. Where the end has to be searched for, that would
/// solve the run twice, and what hides between nodes is compared with the error of the whole run.
pub(super) fn takes_windows<S: Real>(setup: &Setup<S>, args: &RunArgs) -> bool {
    let Setup { limit, until, settings, .. } = setup;
    let is_searched = !matches!(limit, Limit::Length(_)) || !until.is_empty();
    !args.judge.enclose && (settings.accuracy.is_some() || !is_searched && settings.windows > 1)
}

/// Writes one table to standard output: the samples, or everything on the nodes.
pub(super) fn to_standard_output<S: Real>(
    case: &Case,
    setup: &Setup<S>,
    args: &RunArgs,
    wanted: Wanted<'_, S>,
) -> anyhow::Result<ExitCode> {
    // Checked before the computation, whose result would otherwise be lost.
    drop(out::for_data()?);
    // On a given grid samples are what the run is compared at.
    let is_free = setup.settings.accuracy.is_some() && !args.judge.reference;
    if args.samples.samples_only && is_free && wanted.samples.as_ref().is_some_and(SampleStream::is_in_order) {
        return samples_to_standard_output(case, setup, args, wanted);
    }
    let Settings { windows, accuracy, .. } = setup.settings;
    // A run that fails, or begins again, prints nothing: the table waits in a file without a name.
    let file = tempfile::tempfile().context("cannot write a temporary file")?;
    let mut table = StreamedTable::new(file, args.every, accuracy.is_none().then_some(windows > 1));
    let mut see = |part: &WorldLine<S>, measured: &Diagnostics<S>| table.see(part, measured);
    let observer: Option<run::Observer<'_, S>> = if args.samples.samples_only { None } else { Some(&mut see) };
    let Wanted { samples, is_streamed, .. } = wanted;
    let wanted = Wanted { samples, is_streamed, observer, ..Wanted::default() };
    let run = solved(case, setup, args, wanted).0.map_err(|none| explained(none, args, setup))?;
    args.judge.warn(case, setup, &run, args.case.quiet);
    if args.samples.samples_only {
        write_samples(out::for_data()?, run.line.geometry().names(), (&run.samples, &[]), run.line.digits)?;
        return Ok(ExitCode::SUCCESS);
    }
    copy(table.finish())
}

/// Writes the samples of a run to standard output that keeps none of them.
fn samples_to_standard_output<S: Real>(
    case: &Case,
    setup: &Setup<S>,
    args: &RunArgs,
    wanted: Wanted<'_, S>,
) -> anyhow::Result<ExitCode> {
    let file = tempfile::tempfile().context("cannot write a temporary file")?;
    let mut table = StreamedSamples::new(file, setup.place.geometry.names(), setup.settings.digits);
    let mut see = |samples: &[Sample<S>], begins: bool| table.see(samples, begins);
    let Wanted { samples, is_streamed, .. } = wanted;
    let wanted = Wanted { samples, is_streamed, of_samples: Some(&mut see), ..Wanted::default() };
    let run = solved(case, setup, args, wanted).0.map_err(|none| explained(none, args, setup))?;
    args.judge.warn(case, setup, &run, args.case.quiet);
    table.see(&run.samples, false);
    copy(table.finish())
}

/// Copies a table to standard output.
fn copy(table: csv::Result<File>) -> anyhow::Result<ExitCode> {
    let mut out = out::for_data()?;
    std::io::copy(&mut table.context("cannot write a temporary file")?, &mut out)?;
    out.flush()?;
    Ok(ExitCode::SUCCESS)
}
