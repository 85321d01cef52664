//! The arguments of `run`, and a run by them.

use std::path::PathBuf;
use std::time::Duration;

use clap::{Args, ValueHint};
use clap_complete::engine::ArgValueCompleter;
use geodesic_ivp::Case;
use geodesic_ivp::number::Real;
use geodesic_ivp::solve::{Settings, Setup};
use geodesic_ivp::study::run::{self, NoRun, Run, Wanted};
use indicatif::{ProgressBar, ProgressStyle};
use toml_edit::Value;

use super::format::FormatArgs;
use super::judge::{JudgeArgs, NO_ERROR, NO_PROOF, PROOF};
use super::out::{OutArgs, RESULTS};
use super::samples::SampleArgs;
use super::share::VaryArgs;
use super::{CaseArgs, complete, report};

#[derive(Debug, Clone, Args)]
pub(super) struct RunArgs {
    #[command(flatten)]
    pub(super) case: CaseArgs,

    /// Further cases, each into a folder of its own
    #[arg(
        index = 2,
        value_name = "CASE",
        value_hint = ValueHint::FilePath,
        add = ArgValueCompleter::new(complete::cases),
        conflicts_with_all = ["stdout", "json"],
        help_heading = "Case",
        display_order = 1
    )]
    pub(super) more: Vec<PathBuf>,

    /// Continue an earlier run: its folder, or its summary.json
    #[arg(long, value_name = "DIR", value_hint = ValueHint::AnyPath, help_heading = "Case")]
    from: Option<PathBuf>,

    #[command(flatten)]
    pub(super) vary: VaryArgs,

    #[command(flatten)]
    pub(super) judge: JudgeArgs,

    #[command(flatten)]
    pub(super) samples: SampleArgs,

    /// Write every K-th node of each window, and its last one
    #[arg(
        long,
        value_name = "K",
        default_value_t = 1,
        hide_default_value = true,
        value_parser = whole,
        conflicts_with_all = ["vary", "samples_only"],
        help_heading = RESULTS
    )]
    pub(super) every: usize,

    /// Write one table with all columns to standard output, and no files
    #[arg(long, conflicts_with_all = ["out", "force", "json", "format"], help_heading = RESULTS)]
    pub(super) stdout: bool,

    #[command(flatten)]
    pub(super) format: FormatArgs,

    #[command(flatten)]
    pub(super) output: OutArgs,

    /// Also draw pictures
    #[arg(long, conflicts_with = "stdout", help_heading = RESULTS)]
    pub(super) plot: bool,

    /// Also draw the curves of all runs in one picture
    ///
    /// Several cases, or the rows of --vary, have the pictures of a single run together, in a colour for each.
    #[arg(long, requires = "plot", help_heading = RESULTS)]
    pub(super) together: bool,

    /// Also print every charge, the critical point and the paper's bounds
    #[arg(long, short, conflicts_with = "vary", help_heading = RESULTS)]
    pub(super) verbose: bool,
}

fn whole(text: &str) -> Result<usize, String> {
    text.parse().ok().filter(|&count| count > 0).ok_or_else(|| "expected a whole number, 1 or more".to_owned())
}

impl RunArgs {
    /// The same, in which the run that is continued and the wishes for a proof and for no judge are overrides.
    pub(super) fn continued(mut self) -> Self {
        if self.judge.prove {
            self.case.set.push(PROOF.to_owned());
        }
        if self.judge.no_prove {
            self.case.set.push(NO_PROOF.to_owned());
        }
        if self.judge.no_error {
            self.case.set.push(NO_ERROR.to_owned());
        }
        if let Some(from) = self.from.take() {
            self.case.set.push(format!("initial.from={}", Value::from(from.display().to_string())));
        }
        self
    }
}

impl RunArgs {
    /// The arguments of each case by itself. With `--out` every case has the folder of its name in that one.
    pub(super) fn each(&self) -> anyhow::Result<Vec<Self>> {
        let mut each: Vec<Self> = Vec::new();
        for path in self.case.case.iter().chain(&self.more) {
            let mut args = Self { more: Vec::new(), ..self.clone() };
            args.case.case = Some(path.clone());
            let stem = args.case.stem().to_owned();
            args.output.out = args.output.out.map(|folder| folder.join(&stem));
            if each.iter().any(|other| other.case.identity() == args.case.identity()) {
                let message = format!("{} is named twice", args.case.name());
                return Err(report::refused(message, "name every case once"));
            }
            if self.output.out.is_some() && each.iter().any(|other| other.case.stem() == stem) {
                let message = format!("with --out two cases called {} would have the same folder", stem.display());
                return Err(report::refused(message, "leave --out out, or run them one after the other"));
            }
            each.push(args);
        }
        Ok(each)
    }

    /// The name of its case beside those of the others.
    pub(super) fn named(&self, each: &[Self]) -> String {
        let is_lone = each.iter().filter(|other| other.case.stem() == self.case.stem()).count() == 1;
        if is_lone { self.case.headed(None) } else { self.case.name() }
    }
}

/// The error of a case without a run.
pub(super) fn explained<S: Real>(none: NoRun<S>, args: &RunArgs, setup: &Setup<S>) -> anyhow::Error {
    match none {
        NoRun::Unsolved(failure, _) => failure.into(),
        NoRun::Unsampled(none) => args.samples.refuse(none, setup.settings.digits),
    }
}

/// Solves, with a spinner if standard error is a terminal. Returns also the seconds in the solver.
pub(super) fn solved<S: Real>(
    case: &Case,
    setup: &Setup<S>,
    args: &RunArgs,
    wanted: Wanted<'_, S>,
) -> (Result<Run<S>, NoRun<S>>, f64) {
    let spinner = if args.case.quiet { ProgressBar::hidden() } else { ProgressBar::new_spinner() };
    let Settings { n_gamma, windows, accuracy, .. } = setup.settings;
    spinner.set_message(match accuracy {
        Some(accuracy) => format!("solving to {:e}", accuracy.value()),
        None => format!("solving for {} nodes", n_gamma * windows),
    });
    spinner.set_style(ProgressStyle::with_template("{spinner} {msg} ({elapsed})").expect("the template is valid"));
    spinner.enable_steady_tick(Duration::from_millis(200));
    let result = run::run(case, setup, wanted);
    spinner.finish_and_clear();
    result
}
