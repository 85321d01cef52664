//! `run CASE`.

use std::process::ExitCode;
use std::time::{Duration, Instant};

use anyhow::Context;
use clap::Args;
use geodesic_ivp::case::System;
use geodesic_ivp::diagnostics::{Diagnostics, Measures};
use geodesic_ivp::geodesic::InitialData;
use geodesic_ivp::output::pictures::{self, Run};
use geodesic_ivp::output::{
    Chart, Outcome, OutputSet, Summary, write_branches, write_combined, write_residuals, write_samples,
    write_trajectory,
};
use geodesic_ivp::reference::{ReferenceTrajectory, time_parametrised};
use geodesic_ivp::sampling::Sample;
use geodesic_ivp::scalar::{Extended, Real};
use geodesic_ivp::solve::{Arithmetic, solve_window_by_window};
use geodesic_ivp::study::run_error::run_error;
use geodesic_ivp::{Case, Solution, solve};
use indicatif::{ProgressBar, ProgressStyle};

use super::input::AnyCase;
use super::out::OutArgs;
use super::readable::readable;
use super::report::Refusal;
use super::samples::SampleArgs;
use super::second_opinion::second_opinion;
use super::{CaseArgs, memory, report, scene, stdout};

const TRAJECTORY: &str = "trajectory.csv";
const RESIDUALS: &str = "residuals.csv";
const BRANCHES: &str = "branches.csv";
const SAMPLES: &str = "samples.csv";
const SUMMARY: &str = "summary.json";
const PICTURES: [&str; 5] = ["world_line.svg", "t_dot.svg", "trajectory.svg", "delta_q_t.svg", "delta_g.svg"];
const CASE: &str = "case.toml";

#[derive(Debug, Args)]
pub(super) struct RunArgs {
    #[command(flatten)]
    case: CaseArgs,

    #[command(flatten)]
    output: OutArgs,

    /// Also draw SVG pictures beside the CSV files
    #[arg(long, conflicts_with = "stdout")]
    plot: bool,

    /// Write one CSV with all columns to standard output, and no files
    #[arg(long, conflicts_with_all = ["out", "force", "json"])]
    stdout: bool,

    #[command(flatten)]
    samples: SampleArgs,
}

pub(super) fn run(args: &RunArgs) -> anyhow::Result<ExitCode> {
    let case = match args.case.read_any()? {
        AnyCase::One(case) => case,
        AnyCase::Scene(case) => {
            if args.samples.wanted() || args.samples.only() || args.plot {
                let message = "samples and pictures of scenes are not there yet";
                return Err(Refusal::usage(message).help("trajectory.csv has every node").into());
            }
            return scene::run(&case, &args.case, &args.output, args.stdout);
        }
    };
    if case.is_extended() { run_in::<Extended>(&case, args) } else { run_in::<f64>(&case, args) }
}

/// The result of a solve.
struct Solved<S> {
    /// The whole run, or only its last window with `--samples-only`.
    solution: Solution<S>,
    /// `None` with `--samples-only`.
    diagnostics: Option<Diagnostics<S>>,
    measures: Measures<S>,
    samples: Vec<Sample<S>>,
    seconds: Seconds,
}

#[derive(Debug, Clone, Copy, Default)]
struct Seconds {
    solve: f64,
    diagnostics: f64,
}

fn run_in<S: Arithmetic>(case: &Case, args: &RunArgs) -> anyhow::Result<ExitCode> {
    args.samples.check(args.stdout)?;
    warn_of(&case.warnings());
    memory::check(case, Some(&args.samples))?;
    if args.stdout {
        // Checked before the computation, whose result would otherwise be lost.
        drop(stdout::for_data()?);
        let (result, _) = solved::<S>(case, args);
        let Solved { solution, diagnostics, measures, samples, .. } = result?;
        warn_of(&measures.warnings(&solution));
        warn_of(&Vec::from_iter(measures.newtonian_warning()));
        let out = stdout::for_data()?;
        match diagnostics {
            Some(diagnostics) => write_combined(out, &solution, &diagnostics)?,
            None => write_samples(out, samples.into_iter(), solution.digits)?,
        }
        return Ok(ExitCode::SUCCESS);
    }
    args.output.check_standard_output()?;
    let target = args.output.target(&args.case, "run")?;
    let directory = target.folder.clone();
    let mut names = vec![TRAJECTORY, RESIDUALS, BRANCHES, SAMPLES, SUMMARY, CASE];
    names.extend(PICTURES);
    names.retain(|name| match *name {
        TRAJECTORY | RESIDUALS => !args.samples.only(),
        BRANCHES => !args.samples.only() && case.solver.system == System::Doubled,
        SAMPLES => args.samples.wanted(),
        SUMMARY | CASE => true,
        _ => args.plot,
    });
    let files = OutputSet::open(target, &names)?;
    let mut effective = case.clone();
    if args.case.has_overrides() {
        // The expectations hold for the case as it is in its file.
        effective.expect = None;
    }
    files.write_text(CASE, &effective.to_toml())?;
    let (result, solve_seconds) = solved::<S>(case, args);
    let solved = match result {
        Ok(solved) => solved,
        Err(error) => {
            if let Some(failure) = error.downcast_ref() {
                let summary = Summary::new::<S>(case, Err(failure), solve_seconds).to_json();
                files.write_text(SUMMARY, &summary)?;
                files.commit(|name| name == SUMMARY || name == CASE)?;
                // The error of the run matters more than one in writing its summary, and is the one that is reported.
                let _ = args.output.tell(&args.case, &summary, String::new);
            }
            return Err(error);
        }
    };
    let Solved { solution, diagnostics, measures, samples, seconds } = solved;
    let mut summary = Summary::new(case, Ok((&solution, &measures)), seconds.solve);
    let error = run_error(case, &solution);
    if let Outcome::Solved(solved) = &mut summary.outcome {
        solved.error = error.map(Into::into);
    }
    let mut suspicions = measures.warnings(&solution);
    if !suspicions.is_empty() {
        let opinion = second_opinion(case, &solution);
        summary.warnings.extend(opinion.clone());
        suspicions.extend(opinion);
    }
    suspicions.extend(measures.newtonian_warning());
    warn_of(&suspicions);
    let start = Instant::now();
    if args.samples.wanted() {
        write_samples(files.writer(SAMPLES), samples.into_iter(), solution.digits)
            .with_context(|| format!("cannot write {SAMPLES}"))?;
    }
    if let Some(diagnostics) = &diagnostics {
        write_tables(&files, &solution, diagnostics)?;
    }
    if let Outcome::Solved(solved) = &mut summary.outcome {
        solved.diagnostics_seconds = seconds.diagnostics;
        solved.write_seconds = start.elapsed().as_secs_f64();
    }
    let json = summary.to_json();
    files.write_text(SUMMARY, &json)?;
    if let Some(diagnostics) = diagnostics.as_ref().filter(|_| args.plot) {
        let title = args.case.title(case);
        let windows = if summary.windows > 1 { format!(", {} windows", summary.windows) } else { String::new() };
        let title = format!("{title} ({}, N = {}{windows})", summary.sbp, summary.n_gamma);
        for (name, chart) in PICTURES.into_iter().zip(pictures(&title, case, &solution, diagnostics)) {
            files.write_text(name, &chart.to_svg())?;
        }
    }
    let kept = files.commit(|_| true)?;
    args.output.tell(&args.case, &json, || {
        readable(&args.case.title(case), &solution, &measures, &summary, error.as_ref())
            + &report::written(&directory, &kept)
    })?;
    Ok(ExitCode::SUCCESS)
}

fn warn_of(warnings: &[String]) {
    warnings.iter().for_each(|warning| report::warn(warning));
}

/// Solves the case, with a spinner if standard error is a terminal, and measures and samples the solution. Returns also
/// the seconds in the solver.
fn solved<S: Arithmetic>(case: &Case, args: &RunArgs) -> (anyhow::Result<Solved<S>>, f64) {
    let spinner = if args.case.quiet { ProgressBar::hidden() } else { ProgressBar::new_spinner() };
    spinner.set_message(match &case.solver.accuracy {
        Some(accuracy) => format!("solving to {accuracy}"),
        None => format!("solving for {} nodes", case.grid.n_gamma * case.grid.windows),
    });
    spinner.set_style(ProgressStyle::with_template("{spinner} {msg} ({elapsed})").expect("the template is valid"));
    spinner.enable_steady_tick(Duration::from_millis(200));
    let start = Instant::now();
    let mut stream = args.samples.stream(case);
    let mut measures: Option<Measures<S>> = None;
    let result = if args.samples.only() {
        solve_window_by_window(case, &mut |window: &Solution<S>| {
            let here = Diagnostics::new(window).measures;
            let before = measures.take().filter(|_| window.window_count > 1);
            measures = Some(before.map_or(here, |before| before.followed_by(here)));
            stream.iter_mut().for_each(|stream| stream.see(window));
        })
    } else {
        solve(case)
    };
    let mut seconds = Seconds { solve: start.elapsed().as_secs_f64(), diagnostics: 0.0 };
    spinner.finish_and_clear();
    let solution = match result {
        Ok(solution) => solution,
        Err(failure) => return (Err(failure.into()), seconds.solve),
    };
    let start = Instant::now();
    let (diagnostics, measures) = match measures {
        Some(measures) => (None, measures),
        None => {
            let diagnostics = Diagnostics::new(&solution);
            stream.iter_mut().for_each(|stream| stream.see(&solution));
            let measures = diagnostics.measures;
            (Some(diagnostics), measures)
        }
    };
    seconds.diagnostics = start.elapsed().as_secs_f64();
    let samples = stream.map_or(Ok(Vec::new()), |stream| stream.finish(&solution));
    let samples = samples.map_err(|outside| args.samples.refuse(outside, solution.digits).into());
    (samples.map(|samples| Solved { solution, diagnostics, measures, samples, seconds }), seconds.solve)
}

/// Writes the tables. The two large ones are written in parallel: at a million nodes that is most of the work that is
/// left after the solve.
fn write_tables<S: Real>(
    files: &OutputSet,
    solution: &Solution<S>,
    diagnostics: &Diagnostics<S>,
) -> anyhow::Result<()> {
    let (trajectory, residuals) = std::thread::scope(|scope| {
        let residuals = scope.spawn(|| write_residuals(files.writer(RESIDUALS), solution, diagnostics));
        (write_trajectory(files.writer(TRAJECTORY), solution, diagnostics), residuals.join())
    });
    trajectory.with_context(|| format!("cannot write {TRAJECTORY}"))?;
    residuals.expect("writing a table does not panic").with_context(|| format!("cannot write {RESIDUALS}"))?;
    if solution.backward.is_some() {
        write_branches(files.writer(BRANCHES), solution).with_context(|| format!("cannot write {BRANCHES}"))?;
    }
    Ok(())
}

/// One chart for each name in `PICTURES`, in that order.
fn pictures<S: Real>(title: &str, case: &Case, solution: &Solution<S>, diagnostics: &Diagnostics<S>) -> [Chart; 5] {
    let runs = [Run { label: "", solution, diagnostics }];
    // If the reference does not reach the end, the picture is drawn without it. For a line f64 is precise enough.
    let (metric, initial) = (case.metric(), InitialData { t: 0.0, ..case.initial_data() });
    let reference = ReferenceTrajectory::new(&metric, initial, solution.length.to_f64(), f64::MOST_DIGITS).ok();
    let duration = (solution.end.t - solution.t_i).to_f64();
    let in_time = time_parametrised(&metric, initial, duration, 400);
    [
        pictures::world_line(title, solution),
        pictures::time_mesh(title, &runs),
        pictures::trajectory(title, &runs, reference.as_ref(), &in_time),
        pictures::noether_charge(title, &runs),
        pictures::geodesic_residuals(title, &runs),
    ]
}
