//! `run CASE --vary KEY=VALUES`: many runs of one case, a row of a table for each.
//!
//! Rows are computed by as many workers as there are cores, and each takes the next row when it has finished one. The
//! main thread keeps every row in a journal as soon as it is there. When all are, they are sorted into the table, which
//! appears as the files of every command do, and the journal is removed. A table that is interrupted, or killed, is
//! continued by the same command.

use std::process::ExitCode;
use std::str::FromStr;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use clap::Args;
use geodesic_ivp::Case;
use geodesic_ivp::case::{key_of, overridden};
use geodesic_ivp::number::Extended;
use geodesic_ivp::output::runs::{
    Columns, Ended, Identity, Journal, NotResumable, RUNS, RUNS_EVENTS, RunRow, RunsSummary,
};
use geodesic_ivp::output::{CASE, OutputSet, SUMMARY};
use geodesic_ivp::solve::Arithmetic;
use geodesic_ivp::solve::{Settings, Status};
use geodesic_ivp::study::many::{Axis, ManyRuns, Outcome};

use super::interrupt::{self, INTERRUPTED};
use super::lines::{row, wrapped};
use super::report::{self, INVALID_CASE, NO_CRITICAL_POINT, Refusal};
use super::run::RunArgs;
use super::study::{self, Finished};
use super::{memory, out};

/// The statuses of runs that are not begun.
const INVALID: &str = "invalid-case";
const TOO_LARGE: &str = "too-large";

/// Runs of so few nodes fit any machine. To look for the memory that there is costs as much as a short run.
const FEW_NODES: usize = 100_000;

#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Many runs")]
pub(super) struct VaryArgs {
    /// Run for each value of a key: one table, with a row for each run
    ///
    /// VALUES is a list (scheme.sbp=SBP21,SBP42), or START:STOP:COUNT for equidistant values with both ends among them
    /// (initial.x=0.1:0.9:9). Given several times, every combination is run.
    #[arg(
        long,
        value_name = "KEY=VALUES",
        conflicts_with_all = ["more", "stdout", "plot", "sample_t", "sample_gamma", "samples_only"]
    )]
    vary: Vec<Axis>,

    /// Compute only the K-th of N shares of the rows, for `merge`
    ///
    /// These are the rows K, K + N, K + 2N and so on.
    #[arg(long, value_name = "K/N", requires_all = ["vary", "out"])]
    part: Option<Share>,
}

impl VaryArgs {
    /// Returns true if anything varies.
    pub(super) fn is_given(&self) -> bool {
        !self.vary.is_empty()
    }
}

/// The K-th of N shares of the rows. Neighbouring rows, which take similar times, are in different shares.
#[derive(Debug, Clone, Copy)]
struct Share {
    k: usize,
    n: usize,
}

impl FromStr for Share {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parsed = text.split_once('/').and_then(|(k, n)| Some((k.trim().parse().ok()?, n.trim().parse().ok()?)));
        parsed
            .filter(|(k, n)| (1..=*n).contains(k))
            .map(|(k, n)| Self { k, n })
            .ok_or_else(|| "expected K/N with 1 <= K <= N, for example 2/4".to_owned())
    }
}

pub(super) fn vary(args: &RunArgs) -> anyhow::Result<ExitCode> {
    let VaryArgs { vary: axes, part } = &args.vary;
    check_keys(axes, &args.case.set)?;
    interrupt::start_threads();
    let (name, text, set) = (args.case.name(), args.case.read_text()?, &args.case.set);
    let runs = ManyRuns::new(&name, &text, set, axes.clone()).map_err(|error| args.case.of_another_kind(error))?;
    args.output.check_standard_output()?;
    let case = overridden(&name, &text, set).map_err(|error| args.case.of_another_kind(error))?;
    let asked = axes.iter().map(|axis| axis.text().to_owned()).collect();
    let identity = Identity::new(case, asked, part.map(|Share { k, n }| format!("{k}/{n}")));
    runs.first().warnings().iter().for_each(|warning| report::warn(warning));

    let columns = Columns::new(&runs);
    let target = args.output.target(&args.case, out::VARY)?;
    let force = target.force;
    let mut names = vec![RUNS, RUNS_EVENTS, SUMMARY, CASE];
    names.retain(|name| *name != RUNS_EVENTS || columns.has_events());
    let files = OutputSet::open(target, &names)?;
    let mut journal = Journal::open(files.folder(), &identity, &columns, force).map_err(explained)?;

    let Share { k, n } = part.unwrap_or(Share { k: 1, n: 1 });
    let share = (k - 1..runs.len()).step_by(n);
    let (all, there) = (share.len(), journal.count());
    let todo: Vec<usize> = share.filter(|run| !journal.has(run + 1)).collect();
    if there > 0 && !args.case.quiet {
        report::note(&format!("{there} of {all} rows are there already"));
    }
    let (runs, columns) = (Arc::new(runs), Arc::new(columns));
    if compute(&runs, &columns, todo, &mut journal, args.case.quiet)? {
        let (there, path) = (journal.count(), journal.path().display());
        report::warn(&format!(
            "interrupted: {there} of {all} rows are kept in {path}; the same command goes on from there"
        ));
        return Ok(ExitCode::from(INTERRUPTED));
    }

    let mut summary = RunsSummary::new(runs.first().title(), &identity, runs.len());
    let events = columns.has_events().then(|| files.writer(RUNS_EVENTS));
    journal.write((files.writer(RUNS), events), &mut summary)?;
    files.write_text(CASE, &identity.case)?;
    let text = readable(&args.case.headed(runs.first().title()), &summary, &varied(&runs));
    let done = Finished { summary: summary.to_json(), text, interrupted: None, files }.commit()?;
    journal.remove()?;
    done.tell(args.case.quiet, &args.output, || ending(&summary))
}

/// Warns of what the rows of a table say, and returns its exit code.
pub(super) fn ending(summary: &RunsSummary) -> u8 {
    if summary.doubtful > 0 {
        let doubtful = summary.doubtful;
        report::warn(&format!("{doubtful} of the solved rows are doubtful: their column message says why"));
    }
    if summary.solved == 0 && summary.rows > 0 {
        report::warn("no row has a solution: the column message says why");
        return NO_CRITICAL_POINT;
    }
    0
}

/// Refuses keys that are given twice.
fn check_keys(axes: &[Axis], set: &[String]) -> anyhow::Result<()> {
    for (place, axis) in axes.iter().enumerate() {
        let key = axis.key();
        if axes[..place].iter().any(|other| other.key() == key) {
            return Err(Refusal::usage(format!("--vary {key} is given twice"))
                .help("give all its values at once")
                .into());
        }
        if set.iter().any(|setting| key_of(setting).is_some_and(|other| other == key)) {
            let message = format!("{key} is both in --set and in --vary");
            return Err(Refusal::usage(message).help("leave one of them out").into());
        }
    }
    Ok(())
}

/// The error with what to do about it.
fn explained(error: anyhow::Error) -> anyhow::Error {
    let Some(reason) = error.downcast_ref::<NotResumable>() else { return error };
    let (refusal, help) = match reason {
        NotResumable::Other { .. } => (
            Refusal::usage as fn(String) -> Refusal,
            "give the command that began that table to finish it, choose another folder with --out, or remove the file",
        ),
        NotResumable::NotOurs { .. } => {
            (Refusal::input_output as _, "move it away, choose another folder with --out, or replace it with --force")
        }
        NotResumable::Busy { .. } => (Refusal::input_output as _, "wait for it, or choose another folder with --out"),
    };
    refusal(reason.to_string()).help(help).into()
}

/// Computes the rows `todo`, which count from 0, with a progress bar if standard error is a terminal, and keeps them.
/// Returns whether it was interrupted.
fn compute(
    runs: &Arc<ManyRuns>,
    columns: &Arc<Columns>,
    todo: Vec<usize>,
    journal: &mut Journal,
    quiet: bool,
) -> anyhow::Result<bool> {
    let bar = study::bar(quiet, todo.len(), "{bar:30} {pos}/{len} runs, {eta} left");
    let (next, end) = (Arc::new(AtomicUsize::new(0)), todo.len());
    let work = {
        let (runs, columns, next) = (Arc::clone(runs), Arc::clone(columns), Arc::clone(&next));
        move |tell: &(dyn Fn(RunRow) + Sync)| {
            rayon::broadcast(|_| {
                while let Some(&run) = todo.get(next.fetch_add(1, Ordering::Relaxed)) {
                    tell(computed(&runs, &columns, run));
                }
            });
        }
    };
    let mut kept = Ok(());
    let interrupted = interrupt::beside_it(work, |row| {
        bar.inc(1);
        if kept.is_ok() {
            kept = journal.keep(&row);
            if kept.is_err() {
                // What cannot be kept need not be computed.
                next.store(end, Ordering::Relaxed);
            }
        }
    });
    bar.finish_and_clear();
    kept.map(|()| interrupted)
}

/// Computes a row.
fn computed(runs: &ManyRuns, columns: &Columns, run: usize) -> RunRow {
    let refused = |status: &str, exit_code, message: &str| {
        columns.row(runs, run, Ended { status, exit_code, end: None, message })
    };
    let case = match runs.case(run) {
        Ok(case) => case,
        Err(error) => return refused(INVALID, INVALID_CASE, &error.message),
    };
    if let Err(error) = check_memory(&case) {
        return refused(TOO_LARGE, INVALID_CASE, &error.to_string());
    }
    match runs.outcome(&case) {
        Outcome::Solved(end) => {
            let status = Status::Converged.as_str();
            columns.row(runs, run, Ended { status, exit_code: 0, end: Some(&end), message: "" })
        }
        Outcome::Failed { status, message } => refused(status.as_str(), report::code_of(status), &message),
    }
}

fn check_memory(case: &Case) -> anyhow::Result<()> {
    let Settings { n_gamma, windows, .. } = case.settings();
    match case {
        _ if n_gamma * windows <= FEW_NODES => Ok(()),
        _ if case.is_extended() => check_memory_in::<Extended>(case),
        _ => check_memory_in::<f64>(case),
    }
}

fn check_memory_in<S: Arithmetic>(case: &Case) -> anyhow::Result<()> {
    memory::check(&case.setup::<S>(), false, 0)
}

/// The line that says what is varied.
fn varied(runs: &ManyRuns) -> String {
    let one = |axis: &Axis| match axis.values() {
        [one] => format!("{} = {one}", axis.key()),
        [first, .., last] => format!("{} from {first} to {last} ({} values)", axis.key(), axis.values().len()),
        [] => axis.key().to_owned(),
    };
    row("varied", &runs.axes().iter().map(one).collect::<Vec<_>>().join(", "))
}

/// The lines for people: first how many rows have which verdict, then how many have which status. The line `varied` is
/// between them.
pub(super) fn readable(title: &str, summary: &RunsSummary, varied: &str) -> String {
    let RunsSummary { rows, solved, doubtful, .. } = summary;
    let (trusted, refused) = (solved - doubtful, rows - solved);
    let counts: Vec<String> = summary.statuses.iter().map(|(status, count)| format!("{count} {status}")).collect();
    let part = summary.part.as_ref().map_or(String::new(), |part| format!(", part {part} of {}", summary.runs));
    wrapped(&format!("{title}: {trusted} trusted, {doubtful} doubtful, {refused} refused"), 2)
        + varied
        + &row("rows", &format!("{rows}{part}: {}", counts.join(", ")))
}
