//! `merge PART… --out DIR`: the table that `run --vary` would have written at once.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, ValueHint};
use geodesic_ivp::output::runs::{Joined, MergeError, Part, RUNS, RUNS_EVENTS, join};
use geodesic_ivp::output::{CASE, Origin, OutputSet, SUMMARY, origin_of};

use super::out::{self, OutArgs};
use super::report;
use super::study::Finished;
use super::vary;

#[derive(Debug, Args)]
pub(super) struct MergeArgs {
    /// Folders with parts of one table, as `run --vary … --part K/N` writes them
    #[arg(value_name = "PART", required = true, value_hint = ValueHint::DirPath)]
    parts: Vec<PathBuf>,

    #[command(flatten)]
    output: OutArgs,

    /// Print no summary; warnings remain
    #[arg(long, short, help_heading = out::RESULTS)]
    quiet: bool,
}

pub(super) fn merge(args: &MergeArgs) -> anyhow::Result<ExitCode> {
    args.output.check_standard_output()?;
    let mut parts: Vec<Part> =
        args.parts.iter().map(|folder| Part::open(folder)).collect::<anyhow::Result<_>>().map_err(explained)?;
    let joined = Joined::of(&parts).map_err(|error| explained(error.into()))?;
    let case = origin_of(parts[0].folder())?.map_or_else(|| parts[0].folder().display().to_string(), |from| from.case);
    let target = args
        .output
        .target_in(args.output.out.clone().unwrap_or_default(), Origin { command: out::VARY.to_owned(), case });
    let mut names = vec![RUNS, RUNS_EVENTS, SUMMARY, CASE];
    names.retain(|name| *name != RUNS_EVENTS || joined.has_events);
    let files = OutputSet::open(target, &names)?;
    let events = joined.has_events.then(|| files.writer(RUNS_EVENTS));
    join(&mut parts, (files.writer(RUNS), events)).map_err(explained)?;
    files.write_text(CASE, &joined.case)?;
    let summary = &joined.summary;
    let text = vary::readable(summary.title.as_deref().unwrap_or("Many runs"), summary, "");
    let done = Finished { summary: summary.to_json(), text, interrupted: None, files }.commit()?;
    done.tell(args.quiet, &args.output, || vary::ending(summary))
}

/// The error with what to do about it.
fn explained(error: anyhow::Error) -> anyhow::Error {
    let Some(reason) = error.downcast_ref::<MergeError>() else { return error };
    let help = match reason {
        MergeError::NoTable { .. } => "name folders that `run --vary … --part K/N --out FOLDER` has written",
        MergeError::Unfinished { .. } => "finish it with the command that began it",
        MergeError::Different { .. } => "join parts of one case, varied in one way, from one version of the program",
        MergeError::Twice { .. } => "name every part once",
        MergeError::Missing { .. } => "compute it with --part, and name all parts",
    };
    report::refused(reason.to_string(), help)
}
