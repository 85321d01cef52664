//! `merge PART… --out DIR`: the table that `run --vary` would have written at once.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, ValueHint};
use geodesic_ivp::output::runs::{Part, join, joined};
use geodesic_ivp::output::{CASE, Origin, OutputSet, SUMMARY, origin_of};

use super::format::FormatArgs;
use super::out::{self, OutArgs};
use super::study::Placed;
use super::vary;

#[derive(Debug, Args)]
pub(super) struct MergeArgs {
    /// Folders with parts of one table, as `run --vary … --part K/N` writes them
    #[arg(value_name = "PART", required = true, value_hint = ValueHint::DirPath)]
    parts: Vec<PathBuf>,

    #[command(flatten)]
    format: FormatArgs,

    #[command(flatten)]
    output: OutArgs,

    /// Print no summary; warnings remain
    #[arg(long, short, help_heading = out::RESULTS)]
    quiet: bool,
}

pub(super) fn merge(args: &MergeArgs) -> anyhow::Result<ExitCode> {
    let mut parts: Vec<Part> = args.parts.iter().map(|folder| Part::open(folder)).collect::<anyhow::Result<_>>()?;
    let mut summary = joined(&parts)?;
    let first = &parts[0];
    let case = origin_of(&first.folder)?.map_or_else(|| first.folder.display().to_string(), |from| from.case);
    let target = args
        .output
        .target_in(args.output.out.clone().unwrap_or_default(), Origin { command: out::VARY.to_owned(), case })?;
    let tables = first.table_names().to_vec();
    let files = OutputSet::open(target, &[&args.format.files(&tables)[..], &[SUMMARY, CASE]].concat())?;
    join(&mut parts, tables.iter().map(|name| (*name, files.writer(name))).collect(), &mut summary)?;
    tables.iter().try_for_each(|table| args.format.write_array(&files, table))?;
    files.write_text(CASE, &parts[0].case)?;
    let text = vary::summary_text(summary.title.as_deref().unwrap_or("Many runs"), &summary, "");
    let json = summary.to_json();
    let placed = Placed::new(files, &json, None)?;
    args.output.tell(args.quiet, &json, || text + &placed.written)?;
    Ok(ExitCode::from(vary::ending(&summary)))
}
