//! `run CASE`.

use std::path::PathBuf;
use std::process::ExitCode;
use std::thread::{Builder, ScopedJoinHandle, scope};
use std::time::{Duration, Instant};

use anyhow::Context;
use clap::{Args, ValueHint};
use geodesic_ivp::Case;
use geodesic_ivp::diagnostics::OfX;
use geodesic_ivp::number::{Extended, Real};
use geodesic_ivp::output::pictures::scene::{self, PlotAxes};
use geodesic_ivp::output::{
    CASE, Chart, OutputSet, SUMMARY, Summary, pictures, write_branches, write_combined, write_events, write_residuals,
    write_samples, write_trajectory,
};
use geodesic_ivp::reference::{ReferenceTrajectory, time_parametrised};
use geodesic_ivp::solve::{Arithmetic, Settings, Setup, System};
use geodesic_ivp::study::run::{self, NoRun, Run, Wanted};
use indicatif::{ProgressBar, ProgressStyle};

use super::out::OutArgs;
use super::readable::readable;
use super::report::Refusal;
use super::samples::SampleArgs;
use super::vary::{VaryArgs, vary};
use super::{CaseArgs, memory, report, stdout};

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

pub(super) fn run(args: &RunArgs) -> anyhow::Result<ExitCode> {
    if args.vary.is_given() {
        return vary(args);
    }
    if args.more.is_empty() {
        return run_case(&args.case.read()?, args);
    }
    // All are read before the first is run: a mistake in the last one is found at once.
    let each = args.each()?;
    let cases: Vec<Case> = each.iter().map(|args| args.case.read()).collect::<anyhow::Result<_>>()?;
    let mut worst = 0;
    for (case, args) in cases.iter().zip(&each) {
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
fn run_case(case: &Case, args: &RunArgs) -> anyhow::Result<ExitCode> {
    if case.is_extended() { execute::<Extended>(case, args) } else { execute::<f64>(case, args) }
}

fn execute<S: Arithmetic>(case: &Case, args: &RunArgs) -> anyhow::Result<ExitCode> {
    let setup = case.setup::<S>();
    args.samples.check(args.stdout)?;
    check_options(case, args)?;
    let wanted = Wanted { samples: args.samples.stream(case)?, is_streamed: args.samples.only(), sums: true };
    case.warnings().iter().for_each(|warning| report::warn(warning));
    memory::check(&setup, Some(&args.samples))?;
    if args.stdout {
        // Checked before the computation, whose result would otherwise be lost.
        drop(stdout::for_data()?);
        let run = solved(case, &setup, args, wanted).0.map_err(|none| explained(none, args, &setup))?;
        // What hides between nodes is compared with the error of the run.
        let suspicions = if args.enclose {
            run.judged(&setup, args.reference, true).suspicions
        } else {
            let newton = run.diagnostics.of_x.as_ref().and_then(OfX::newtonian_warning);
            run.diagnostics.warnings(&run.line).into_iter().chain(newton).collect()
        };
        suspicions.iter().for_each(|warning| report::warn(warning));
        match run.is_whole {
            true => write_combined(stdout::for_data()?, &run.line, &run.diagnostics)?,
            false => {
                write_samples(stdout::for_data()?, run.line.geometry().names(), &run.samples, run.line.digits)?;
            }
        }
        return Ok(ExitCode::SUCCESS);
    }
    args.output.check_standard_output()?;
    let target = args.output.target(&args.case, "run")?;
    let directory = target.folder.clone();
    let files = OutputSet::open(target, &file_names(case, args))?;
    files.write_text(CASE, &effective(case, args))?;
    let (result, solve_seconds) = solved(case, &setup, args, wanted);
    let run = match result {
        Ok(run) => run,
        Err(none) => {
            if let NoRun::Unsolved(failure) = &none {
                let summary = Summary::failed(case, &setup.place.geometry, failure, solve_seconds).to_json();
                files.write_text(SUMMARY, &summary)?;
                files.commit(&|name| name == SUMMARY || name == CASE)?;
                // The error of the run matters more than one in writing its summary, and is the one that is reported.
                let _ = args.output.tell(args.case.quiet, &summary, String::new);
            }
            return Err(explained(none, args, &setup));
        }
    };
    let judged = run.judged(&setup, args.reference, args.enclose);
    judged.suspicions.iter().for_each(|warning| report::warn(warning));
    let mut summary = Summary::new(case, &run, &judged, solve_seconds);
    let start = Instant::now();
    write_tables(&files, case, args, &run)?;
    if let Some(seconds) = &mut summary.seconds {
        seconds.write = start.elapsed().as_secs_f64();
    }
    let title = args.case.headed(case.title());
    let json = summary.to_json();
    files.write_text(SUMMARY, &json)?;
    if args.plot {
        let windows = if summary.windows > 1 { format!(", {} windows", summary.windows) } else { String::new() };
        let title = format!("{title} ({}, N = {}{windows})", summary.sbp, summary.n_gamma);
        for (name, chart) in picture_names(case).iter().zip(pictures(&title, case, &run)) {
            files.write_text(name, &chart.to_svg())?;
        }
    }
    let kept = files.commit(&|_| true)?;
    args.output.tell(args.case.quiet, &json, || {
        let written = report::written(&directory, &kept);
        let lines = readable(&title, &run, &judged, &summary, &event_names(case));
        format!("{lines}{written}{}\n", summary.verdict.line())
    })?;
    Ok(ExitCode::SUCCESS)
}

/// Refuses options that this case does not have.
fn check_options(case: &Case, args: &RunArgs) -> anyhow::Result<()> {
    if args.enclose && case.settings().accuracy.is_none() && args.samples.only() {
        let help = "leave one of them out, or ask for solver.accuracy, which looks between the nodes on the way";
        return Err(Refusal::usage("--samples-only keeps no nodes that --enclose could look between")
            .help(help)
            .into());
    }
    Ok(())
}

/// The error of a case without a run.
fn explained<S: Real>(none: NoRun<S>, args: &RunArgs, setup: &Setup<S>) -> anyhow::Error {
    match none {
        NoRun::Unsolved(failure) => failure.into(),
        NoRun::Unsampled(none) => args.samples.refuse(none, setup.settings.digits),
    }
}

fn event_names(case: &Case) -> Vec<&str> {
    case.events().iter().map(|event| event.name.as_str()).collect()
}

/// The names of a run's pictures.
fn picture_names(case: &Case) -> &'static [&'static str] {
    const OF_X: [&str; 5] = ["world_line.svg", "t_dot.svg", "trajectory.svg", "delta_q_t.svg", "delta_g.svg"];
    const OF_SCENE: [&str; 4] = ["orbit.svg", "charges.svg", "mesh.svg", "section.svg"];
    match case.is_of_x() {
        true => &OF_X,
        false if case.events().is_empty() => &OF_SCENE[..3],
        false => &OF_SCENE,
    }
}

/// The pictures, in the order of their names.
fn pictures<S: Real>(title: &str, case: &Case, run: &Run<S>) -> Vec<Chart> {
    let Run { line, diagnostics, sums, events, .. } = run;
    if case.is_of_x() {
        let runs = [pictures::Run { label: "", solution: line, diagnostics }];
        // If the reference does not reach the end, the picture is drawn without it. For a line f64 is precise enough.
        let (geometry, start) = (case.geometry(), case.start());
        let reference = ReferenceTrajectory::new(&geometry, &start, line.length.to_f64(), f64::MOST_DIGITS).ok();
        let duration = (line.end_state().t - line.t_i()).to_f64();
        let in_time = time_parametrised(&geometry, &start, duration, 400);
        return vec![
            pictures::world_line(title, line),
            pictures::time_mesh(title, &runs),
            pictures::trajectory(title, &runs, reference.as_ref(), &in_time),
            pictures::noether_charge(title, &runs),
            pictures::geodesic_residuals(title, &runs),
        ];
    }
    let (formulas, labels) = case.plot_axes(line.geometry());
    let axes = PlotAxes { formulas, labels };
    let mut drawn = vec![
        scene::orbit(title, line, &axes),
        scene::charges(title, line, diagnostics, sums),
        scene::mesh(title, line),
    ];
    if !case.events().is_empty() {
        drawn.push(scene::section(title, line, &axes, &event_names(case), events));
    }
    drawn
}

/// The files that a run writes.
fn file_names(case: &Case, args: &RunArgs) -> Vec<&'static str> {
    let mut names = vec![TRAJECTORY, RESIDUALS, BRANCHES, SAMPLES, EVENTS, SUMMARY, CASE];
    names.extend(picture_names(case));
    names.retain(|name| match *name {
        TRAJECTORY | RESIDUALS => !args.samples.only(),
        BRANCHES => !args.samples.only() && case.settings().system == System::Doubled,
        SAMPLES => args.samples.wanted(),
        EVENTS => !case.events().is_empty(),
        SUMMARY | CASE => true,
        _ => args.plot,
    });
    names
}

/// The case that is run, as a text.
fn effective(case: &Case, args: &RunArgs) -> String {
    match args.case.has_overrides() {
        // The expectations hold for the case as it is in its file.
        true => case.without_expectations().to_toml(),
        false => case.to_toml(),
    }
}

/// Solves, with a spinner if standard error is a terminal. Returns also the seconds in the solver.
fn solved<S: Arithmetic>(
    case: &Case,
    setup: &Setup<S>,
    args: &RunArgs,
    wanted: Wanted<S>,
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

/// Writes the tables. The two large ones are written in parallel: at a million nodes that is most of the work that is
/// left after the solve.
fn write_tables<S: Real>(files: &OutputSet, case: &Case, args: &RunArgs, run: &Run<S>) -> anyhow::Result<()> {
    let Run { line, diagnostics, samples, events, .. } = run;
    let (names, digits) = (line.geometry().names(), line.digits);
    let cannot = |name: &'static str| move || format!("cannot write {name}");
    if args.samples.wanted() {
        write_samples(files.writer(SAMPLES), names, samples, digits).with_context(cannot(SAMPLES))?;
    }
    if !case.events().is_empty() {
        let written = write_events(files.writer(EVENTS), names, &event_names(case), events, digits);
        written.with_context(cannot(EVENTS))?;
    }
    if !run.is_whole {
        return Ok(());
    }
    let (trajectory, residuals) = scope(|scope| {
        let write = || write_residuals(files.writer(RESIDUALS), line, diagnostics);
        let residuals = Builder::new().spawn_scoped(scope, write);
        let trajectory = write_trajectory(files.writer(TRAJECTORY), line, diagnostics);
        // Where there is no room for a thread, one table follows the other.
        let join = |thread: ScopedJoinHandle<'_, _>| thread.join().expect("writing a table does not panic");
        (trajectory, residuals.map_or_else(|_| write(), join))
    });
    trajectory.with_context(cannot(TRAJECTORY))?;
    residuals.with_context(cannot(RESIDUALS))?;
    if line.is_doubled() {
        write_branches(files.writer(BRANCHES), line).with_context(cannot(BRANCHES))?;
    }
    Ok(())
}
