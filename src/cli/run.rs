//! `run CASE`: one flow for cases of one coordinate and for scenes.

use std::path::PathBuf;
use std::process::ExitCode;
use std::thread::{Builder, ScopedJoinHandle, scope};
use std::time::{Duration, Instant};

use anyhow::Context;
use clap::{Args, ValueHint};
use geodesic_ivp::case::AnyCase;
use geodesic_ivp::diagnostics::Diagnostics;
use geodesic_ivp::diagnostics::gaps::Gaps;
use geodesic_ivp::number::Extended;
use geodesic_ivp::number::Real;
use geodesic_ivp::output::{
    CASE, Chart, OutputSet, SUMMARY, SummaryOf, write_branches, write_residuals, write_trajectory,
};
use geodesic_ivp::solve::{NoSolution, Settings, System, WorldLine};
use geodesic_ivp::study::errors::RunError;
use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;

use super::out::OutArgs;
use super::report::Refusal;
use super::run_one::OneCoordinate;
use super::run_scene::Scene;
use super::samples::SampleArgs;
use super::vary::{VaryArgs, vary};
use super::{CaseArgs, report, stdout};

const TRAJECTORY: &str = "trajectory.csv";
const RESIDUALS: &str = "residuals.csv";
const BRANCHES: &str = "branches.csv";
const SAMPLES: &str = "samples.csv";
const EVENTS: &str = "events.csv";

#[derive(Debug, Clone, Args)]
pub(super) struct RunArgs {
    #[command(flatten)]
    pub(super) case: CaseArgs,

    /// Further cases: each is run as if by itself, into a folder of its own
    #[arg(index = 2, value_name = "CASE", value_hint = ValueHint::FilePath, conflicts_with_all = ["stdout", "json"])]
    more: Vec<PathBuf>,

    #[command(flatten)]
    pub(super) output: OutArgs,

    /// Also draw SVG pictures beside the CSV files
    #[arg(long, conflicts_with = "stdout")]
    plot: bool,

    /// Write one CSV with all columns to standard output, and no files
    #[arg(long, conflicts_with_all = ["out", "force", "json"])]
    stdout: bool,

    /// Also look between the nodes: enclose the formulas on the way from each node to the next, and doubt the result
    /// where they may do what the nodes do not see. (With solver.accuracy every run does so)
    #[arg(long, conflicts_with = "vary")]
    pub(super) enclose: bool,

    /// Compare the run with the Taylor method, in place of a second solve by the engine of solver.accuracy
    #[arg(long, conflicts_with = "vary")]
    pub(super) reference: bool,

    #[command(flatten)]
    pub(super) samples: SampleArgs,

    #[command(flatten)]
    pub(super) vary: VaryArgs,
}

/// What `run` does with a case: what one of one coordinate and a scene do differently.
pub(super) trait Job {
    /// A solution with what was measured on it.
    type Solved;
    /// Its numbers in the summary.
    type Numbers: Serialize;

    /// Refuses options that this case does not have.
    fn check_options(&self) -> anyhow::Result<()>;

    /// Refuses a run that needs more memory than there is.
    fn check_memory(&self) -> anyhow::Result<()>;

    /// Solves and measures. Returns also the seconds in the solver.
    fn solve(&self) -> (anyhow::Result<Self::Solved>, f64);

    /// The summary of a solve that failed.
    fn failed(&self, failure: &NoSolution, seconds: f64) -> SummaryOf<Self::Numbers>;

    /// Warnings that the solution should not be believed, from its own numbers.
    fn suspicions(&self, solved: &Self::Solved) -> Vec<String>;

    /// Writes the table of `--stdout`.
    fn write_combined(&self, solved: Self::Solved, out: std::io::StdoutLock<'static>) -> csv::Result<()>;

    /// Compares with a reference.
    fn judge(&self, solved: &Self::Solved) -> Judged<Self::Numbers>;

    /// Writes the tables.
    fn write_tables(&self, solved: &Self::Solved, files: &Tables<'_>) -> anyhow::Result<()>;

    /// The names of its pictures.
    fn picture_names(&self) -> &'static [&'static str];

    /// The pictures, in the order of their names.
    fn pictures(&self, title: &str, solved: &Self::Solved) -> Vec<Chart>;

    /// The summary for people, without files and verdict.
    fn readable(&self, title: &str, solved: &Self::Solved, judged: &Judged<Self::Numbers>) -> String;
}

/// What every judge of a result adds to, where it looks between the nodes.
pub(super) fn doubt_gaps<N>(summary: &mut SummaryOf<N>, gaps: &Gaps, suspicions: &mut Vec<String>) {
    if let Some(reason) = gaps.reason() {
        summary.warnings.push(reason.to_string());
        suspicions.push(reason.to_string());
        summary.verdict.doubt(reason);
    }
}

/// How good a solution is.
pub(super) struct Judged<N> {
    pub(super) summary: SummaryOf<N>,
    /// How far it is from what it was compared with.
    pub(super) error: Option<RunError>,
    /// What is to be warned of.
    pub(super) suspicions: Vec<String>,
}

pub(super) fn run(args: &RunArgs) -> anyhow::Result<ExitCode> {
    if args.vary.is_given() {
        return vary(args);
    }
    if args.more.is_empty() {
        return run_case(args.case.read_any()?, args);
    }
    // All are read before the first is run: a mistake in the last one is found at once.
    let each = args.each()?;
    let cases: Vec<AnyCase> = each.iter().map(|args| args.case.read_any()).collect::<anyhow::Result<_>>()?;
    let mut worst = 0;
    for (case, args) in cases.into_iter().zip(&each) {
        if let Err(error) = run_case(case, args) {
            worst = worst.max(report::explain(&error));
        }
    }
    Ok(ExitCode::from(worst))
}

impl RunArgs {
    /// The arguments of each case by itself. With `--out` every case has the folder of its name in that one.
    fn each(&self) -> anyhow::Result<Vec<Self>> {
        let mut each: Vec<Self> = Vec::new();
        for path in self.case.case.iter().chain(&self.more) {
            let mut args = Self { more: Vec::new(), ..self.clone() };
            args.case.case = Some(path.clone());
            let stem = args.case.stem().to_owned();
            args.output.go_below(&stem);
            if each.iter().any(|other| other.case.identity() == args.case.identity()) {
                let message = format!("{} is named twice", args.case.name());
                return Err(Refusal::usage(message).help("name every case once").into());
            }
            if self.output.is_named() && each.iter().any(|other| other.case.stem() == stem) {
                let message = format!("with --out two cases called {} would have the same folder", stem.display());
                return Err(Refusal::usage(message).help("leave --out out, or run them one after the other").into());
            }
            each.push(args);
        }
        Ok(each)
    }
}

/// Runs one case, the one of `args`.
fn run_case(case: AnyCase, args: &RunArgs) -> anyhow::Result<ExitCode> {
    match &case {
        AnyCase::One(one) if case.is_extended() => execute(&OneCoordinate::<Extended>::new(one, args), &case, args),
        AnyCase::One(one) => execute(&OneCoordinate::<f64>::new(one, args), &case, args),
        AnyCase::Scene(scene) if case.is_extended() => execute(&Scene::<Extended>::new(scene, args), &case, args),
        AnyCase::Scene(scene) => execute(&Scene::<f64>::new(scene, args), &case, args),
    }
}

fn execute(job: &impl Job, case: &AnyCase, args: &RunArgs) -> anyhow::Result<ExitCode> {
    args.samples.check(args.stdout)?;
    job.check_options()?;
    warn_of(&case.warnings());
    job.check_memory()?;
    if args.stdout {
        // Checked before the computation, whose result would otherwise be lost.
        drop(stdout::for_data()?);
        let solved = with_spinner(job, case, args).0?;
        // What hides between nodes is compared with the error of the run.
        let suspicions = if args.enclose { job.judge(&solved).suspicions } else { job.suspicions(&solved) };
        warn_of(&suspicions);
        job.write_combined(solved, stdout::for_data()?)?;
        return Ok(ExitCode::SUCCESS);
    }
    args.output.check_standard_output()?;
    let target = args.output.target(&args.case, "run")?;
    let directory = target.folder.clone();
    let files = OutputSet::open(target, &file_names(job, case, args))?;
    files.write_text(CASE, &effective(case, args))?;
    let (result, solve_seconds) = with_spinner(job, case, args);
    let solved = match result {
        Ok(solved) => solved,
        Err(error) => {
            if let Some(failure) = error.downcast_ref() {
                let summary = job.failed(failure, solve_seconds).to_json();
                files.write_text(SUMMARY, &summary)?;
                files.commit(&|name| name == SUMMARY || name == CASE)?;
                // The error of the run matters more than one in writing its summary, and is the one that is reported.
                let _ = args.output.tell(args.case.quiet, &summary, String::new);
            }
            return Err(error);
        }
    };
    let mut judged = job.judge(&solved);
    warn_of(&judged.suspicions);
    let start = Instant::now();
    job.write_tables(&solved, &Tables { files: &files })?;
    if let Some(seconds) = &mut judged.summary.seconds {
        seconds.write = start.elapsed().as_secs_f64();
    }
    let (summary, title) = (&judged.summary, args.case.headed(case.title()));
    let json = summary.to_json();
    files.write_text(SUMMARY, &json)?;
    if args.plot {
        let windows = if summary.windows > 1 { format!(", {} windows", summary.windows) } else { String::new() };
        let title = format!("{title} ({}, N = {}{windows})", summary.sbp, summary.n_gamma);
        for (name, chart) in job.picture_names().iter().zip(job.pictures(&title, &solved)) {
            files.write_text(name, &chart.to_svg())?;
        }
    }
    let kept = files.commit(&|_| true)?;
    args.output.tell(args.case.quiet, &json, || {
        let written = report::written(&directory, &kept);
        format!("{}{written}{}\n", job.readable(&title, &solved, &judged), summary.verdict.line())
    })?;
    Ok(ExitCode::SUCCESS)
}

/// The files that a run writes.
fn file_names(job: &impl Job, case: &AnyCase, args: &RunArgs) -> Vec<&'static str> {
    let mut names = vec![TRAJECTORY, RESIDUALS, BRANCHES, SAMPLES, EVENTS, SUMMARY, CASE];
    names.extend(job.picture_names());
    names.retain(|name| match *name {
        TRAJECTORY | RESIDUALS => !args.samples.only(),
        BRANCHES => !args.samples.only() && case.settings().system == System::Doubled,
        SAMPLES => args.samples.wanted(),
        EVENTS => case.has_events(),
        SUMMARY | CASE => true,
        _ => args.plot,
    });
    names
}

/// The case that is run, as a text.
fn effective(case: &AnyCase, args: &RunArgs) -> String {
    match args.case.has_overrides() {
        // The expectations hold for the case as it is in its file.
        true => case.clone().without_expectations().to_toml(),
        false => case.to_toml(),
    }
}

fn warn_of(warnings: &[String]) {
    warnings.iter().for_each(|warning| report::warn(warning));
}

/// Solves, with a spinner if standard error is a terminal.
fn with_spinner<J: Job>(job: &J, case: &AnyCase, args: &RunArgs) -> (anyhow::Result<J::Solved>, f64) {
    let spinner = if args.case.quiet { ProgressBar::hidden() } else { ProgressBar::new_spinner() };
    let Settings { n_gamma, windows, accuracy, .. } = case.settings();
    spinner.set_message(match accuracy {
        Some(accuracy) => format!("solving to {:e}", accuracy.value()),
        None => format!("solving for {} nodes", n_gamma * windows),
    });
    spinner.set_style(ProgressStyle::with_template("{spinner} {msg} ({elapsed})").expect("the template is valid"));
    spinner.enable_steady_tick(Duration::from_millis(200));
    let result = job.solve();
    spinner.finish_and_clear();
    result
}

/// The files of a run that are tables.
pub(super) struct Tables<'f> {
    files: &'f OutputSet,
}

impl Tables<'_> {
    /// Writes what was computed on the nodes. The two large tables are written in parallel: at a million nodes that is
    /// most of the work that is left after the solve.
    pub(super) fn nodes<S: Real, M: Sync>(
        &self,
        run: &WorldLine<S>,
        measured: &Diagnostics<S, M>,
    ) -> anyhow::Result<()> {
        let files = self.files;
        let (trajectory, residuals) = scope(|scope| {
            let write = || write_residuals(files.writer(RESIDUALS), run, measured);
            let residuals = Builder::new().spawn_scoped(scope, write);
            let trajectory = write_trajectory(files.writer(TRAJECTORY), run, measured);
            // Where there is no room for a thread, one table follows the other.
            let join = |thread: ScopedJoinHandle<'_, _>| thread.join().expect("writing a table does not panic");
            (trajectory, residuals.map_or_else(|_| write(), join))
        });
        trajectory.with_context(|| format!("cannot write {TRAJECTORY}"))?;
        residuals.with_context(|| format!("cannot write {RESIDUALS}"))?;
        if run.is_doubled() {
            write_branches(files.writer(BRANCHES), run).with_context(|| format!("cannot write {BRANCHES}"))?;
        }
        Ok(())
    }

    /// Writes the samples.
    pub(super) fn samples(&self, write: impl FnOnce(&mut dyn std::io::Write) -> csv::Result<()>) -> anyhow::Result<()> {
        write(&mut self.files.writer(SAMPLES)).with_context(|| format!("cannot write {SAMPLES}"))
    }

    /// Writes the events.
    pub(super) fn events(&self, write: impl FnOnce(&mut dyn std::io::Write) -> csv::Result<()>) -> anyhow::Result<()> {
        write(&mut self.files.writer(EVENTS)).with_context(|| format!("cannot write {EVENTS}"))
    }
}
