//! `run CASE`.

use std::io::{self, Write};
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use anyhow::Context;
use clap::Args;
use geodesic_ivp::case::Form;
use geodesic_ivp::diagnostics::Diagnostics;
use geodesic_ivp::geodesic::InitialData;
use geodesic_ivp::output::pictures::{self, Run};
use geodesic_ivp::output::{
    Chart, Outcome, OutputSet, Summary, write_branches, write_combined, write_residuals, write_samples,
    write_trajectory,
};
use geodesic_ivp::reference::{ReferenceTrajectory, time_parametrised};
use geodesic_ivp::scalar::{Extended, Real};
use geodesic_ivp::solve::InitialGuess;
use geodesic_ivp::{Case, Solution, solve};
use indicatif::ProgressBar;

use super::samples::SampleArgs;
use super::{CaseArgs, interrupt, report};

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

    /// Directory for the result files [default: results/<case file stem>]
    #[arg(long, value_name = "DIR", conflicts_with = "stdout")]
    out: Option<PathBuf>,

    /// Also draw SVG pictures beside the CSV files
    #[arg(long, conflicts_with = "stdout")]
    plot: bool,

    /// Write one CSV with all columns to standard output, and no files
    #[arg(long)]
    stdout: bool,

    #[command(flatten)]
    samples: SampleArgs,
}

pub(super) fn run(args: &RunArgs) -> anyhow::Result<ExitCode> {
    let case = args.case.read()?;
    if case.is_extended() { run_in::<Extended>(&case, args) } else { run_in::<f64>(&case, args) }
}

fn run_in<S: Real>(case: &Case, args: &RunArgs) -> anyhow::Result<ExitCode> {
    interrupt::end_at_once()?;
    warn_of(&case.warnings());
    if args.stdout {
        let (result, _) = timed_solve::<S>(case, args.case.quiet);
        let solution = result?;
        let diagnostics = Diagnostics::new(&solution);
        warn_of(&diagnostics.warnings(&solution));
        write_combined(io::stdout().lock(), &solution, &diagnostics)?;
        return Ok(ExitCode::SUCCESS);
    }
    let directory = args.out.clone().unwrap_or_else(|| args.case.default_output());
    let tables = [TRAJECTORY, RESIDUALS, BRANCHES, SAMPLES, SUMMARY, CASE];
    let files = OutputSet::open(&directory, &[tables.as_slice(), &PICTURES].concat())?;
    let mut effective = case.clone();
    if args.case.has_overrides() {
        // The expectations were made for the case as it is in its file.
        effective.expect = None;
    }
    files.write_text(CASE, &effective.to_toml())?;
    let (result, solve_seconds) = timed_solve::<S>(case, args.case.quiet);
    let solution = match result {
        Ok(solution) => solution,
        Err(failure) => {
            files.write_text(SUMMARY, &Summary::new::<S>(case, Err(&failure), solve_seconds).to_json())?;
            files.commit(|name| name == SUMMARY || name == CASE)?;
            return Err(failure.into());
        }
    };
    let start = Instant::now();
    let diagnostics = Diagnostics::new(&solution);
    let diagnostics_seconds = start.elapsed().as_secs_f64();
    warn_of(&diagnostics.warnings(&solution));
    let mut summary = Summary::new(case, Ok((&solution, &diagnostics)), solve_seconds);
    let start = Instant::now();
    if args.samples.wanted() {
        let samples = args.samples.take(&solution)?;
        write_samples(files.writer(SAMPLES), samples.into_iter(), solution.digits)
            .with_context(|| format!("cannot write {SAMPLES}"))?;
    }
    write_tables(&files, &solution, &diagnostics)?;
    if let Outcome::Solved(solved) = &mut summary.outcome {
        solved.diagnostics_seconds = diagnostics_seconds;
        solved.write_seconds = start.elapsed().as_secs_f64();
    }
    files.write_text(SUMMARY, &summary.to_json())?;
    if args.plot {
        let title = case.title.as_deref().unwrap_or("geodesic-ivp");
        let windows = if summary.windows > 1 { format!(", {} windows", summary.windows) } else { String::new() };
        let title = format!("{title} ({}, N = {}{windows})", summary.sbp, summary.n_gamma);
        for (name, chart) in PICTURES.into_iter().zip(pictures(&title, case, &solution, &diagnostics)) {
            files.write_text(name, &chart.to_svg())?;
        }
    }
    let doubled = solution.backward.is_some();
    files.commit(|name| match name {
        BRANCHES => doubled,
        SAMPLES => args.samples.wanted(),
        _ => args.plot || !PICTURES.contains(&name),
    })?;
    if !args.case.quiet {
        let text = readable(case, &solution, &diagnostics, &summary, args, &directory);
        io::stdout().write_all(text.as_bytes())?;
    }
    Ok(ExitCode::SUCCESS)
}

fn warn_of(warnings: &[String]) {
    warnings.iter().for_each(|warning| report::warn(warning));
}

/// Solves with a spinner on a terminal's standard error.
fn timed_solve<S: Real>(case: &Case, quiet: bool) -> (Result<Solution<S>, geodesic_ivp::NoSolution>, f64) {
    let spinner = if quiet { ProgressBar::hidden() } else { ProgressBar::new_spinner() };
    spinner.set_message(format!("solving for {} nodes", case.grid.n_gamma * case.grid.windows));
    spinner.enable_steady_tick(Duration::from_millis(200));
    let start = Instant::now();
    let result = solve(case);
    let seconds = start.elapsed().as_secs_f64();
    spinner.finish_and_clear();
    (result, seconds)
}

/// The two large tables are formatted side by side: at a million nodes that is most of what is left to do.
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
    if let Some(backward) = &solution.backward {
        write_branches(files.writer(BRANCHES), solution, backward)
            .with_context(|| format!("cannot write {BRANCHES}"))?;
    }
    Ok(())
}

/// One chart for each of `PICTURES`.
fn pictures<S: Real>(title: &str, case: &Case, solution: &Solution<S>, diagnostics: &Diagnostics<S>) -> [Chart; 5] {
    let runs = [Run { label: "", solution, diagnostics }];
    // Where the continuum has no trajectory to the end, the picture does without. For a line f64 is precise enough.
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

/// The summary a person reads.
fn readable<S: Real>(
    case: &Case,
    solution: &Solution<S>,
    diagnostics: &Diagnostics<S>,
    summary: &Summary,
    args: &RunArgs,
    directory: &std::path::Path,
) -> String {
    let invariants = solution.invariants();
    let nodes = match solution.windows.len() {
        1 => format!("{} nodes", solution.sbp.points()),
        windows => format!("{windows} windows of {} nodes", solution.sbp.points()),
    };
    let system = if solution.backward.is_some() { "doubled action" } else { "physical limit" };
    let iterations = match solution.iterations {
        0 => "explicit".to_owned(),
        count if solution.initial_guess == InitialGuess::Extrapolation => format!("{count} evaluations of the force"),
        1 => "1 Newton iteration".to_owned(),
        count => format!("{count} Newton iterations"),
    };
    let short = |number: S| number.to_f64();
    // The numbers that a person would compare with others.
    let end = |number: S| match S::IS_EXTENDED {
        true => number.to_decimal(solution.digits),
        false => format!("{:.15}", number.to_f64()),
    };
    let digits = if S::IS_EXTENDED { format!(", {} digits", solution.digits) } else { String::new() };
    let (action, but_last, charge_at_last) = match solution.form {
        Form::Weak => ("E_weak", "", String::new()),
        Form::Strong => {
            let corrected = short(diagnostics.max_abs_delta_q_t_corrected());
            let (last, but_last) = match solution.windows.len() {
                1 => (format!("{:.2e}", short(diagnostics.delta_q_t_last())), " but the last"),
                _ => (
                    format!("up to {:.2e}", short(diagnostics.max_abs_delta_q_t_last())),
                    " but the last of each window",
                ),
            };
            let at_last = format!("{but_last}, {last} there ({corrected:.1e} with the multiplier correction)");
            ("E_IVP", but_last, at_last)
        }
    };
    let ends = if solution.windows.len() == 1 { "the end" } else { "the ends" };
    let mut lines = vec![
        case.title.clone().unwrap_or_else(|| "geodesic-ivp".to_owned()),
        format!(
            "  scheme     {} {}, {system}, {nodes} on gamma in [{}, {}]{digits}: {iterations}, {:.3} ms",
            summary.sbp,
            solution.form.as_str(),
            short(solution.gamma_i),
            short(solution.gamma_f()),
            1e3 * summary.solve_seconds
        ),
        format!("  end        t = {}, x = {}", end(solution.end.t), end(solution.end.x)),
        format!(
            "  Q_t        {:.6}; |dQ_t| <= {:.1e} at all nodes{charge_at_last}",
            short(invariants.q_t),
            short(diagnostics.max_abs_delta_q_t_interior()),
        ),
        format!(
            "  K          {:.6}; |dK| <= {:.2e} at all nodes{but_last}, {:.2e} at {ends} handed on",
            short(invariants.k),
            short(diagnostics.max_abs_delta_k()),
            short(diagnostics.max_abs_delta_k_ends())
        ),
        format!(
            "  certified  |grad {action}| <= {:.1e}; sawtooth in x {}; H_BVP = {:.6}, Q_t (t_f - t_i) = {:.6}",
            short(solution.gradient_norm),
            diagnostics.sawtooth.map_or("not measurable".to_owned(), |s| format!("{:.1e}", short(s))),
            short(diagnostics.bound.h_bvp),
            short(diagnostics.bound.h_bvp_bound)
        ),
    ];
    let mut files = vec![TRAJECTORY, RESIDUALS];
    files.extend(solution.backward.is_some().then_some(BRANCHES));
    files.extend(args.samples.wanted().then_some(SAMPLES));
    files.extend([SUMMARY, CASE]);
    if args.plot {
        files.extend(PICTURES);
    }
    lines.push(format!("  written    {}: {}", directory.display(), files.join(", ")));
    lines.join("\n") + "\n"
}
