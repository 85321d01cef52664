//! `run` for scenes of n coordinates.

use std::process::ExitCode;
use std::time::Instant;

use anyhow::Context;
use geodesic_ivp::case::scene::SceneCase;
use geodesic_ivp::diagnostics::scene::SceneDiagnostics;
use geodesic_ivp::geometry::ConservedSum;
use geodesic_ivp::output::{
    OutputSet, SceneSummary, write_branches, write_combined, write_residuals, write_trajectory,
};
use geodesic_ivp::scalar::{Extended, Real};
use geodesic_ivp::solve::System;
use geodesic_ivp::solve::scene::{NoWorldLine, SceneSetup, WorldLine, solve_scene};
use geodesic_ivp::study::scene_error::scene_error;

use super::out::OutArgs;
use super::scene_readable::readable;
use super::{CaseArgs, memory, report, stdout};

const TRAJECTORY: &str = "trajectory.csv";
const RESIDUALS: &str = "residuals.csv";
const BRANCHES: &str = "branches.csv";
const SUMMARY: &str = "summary.json";
const CASE: &str = "case.toml";

/// A world-line with what is measured on it.
struct Solved<S> {
    line: WorldLine<S>,
    sums: Vec<ConservedSum>,
    diagnostics: SceneDiagnostics<S>,
    seconds: [f64; 2],
}

/// `run` of a scene: its files, or with `to_stdout` one table on standard output.
pub(super) fn run(case: &SceneCase, args: &CaseArgs, output: &OutArgs, to_stdout: bool) -> anyhow::Result<ExitCode> {
    for warning in case.warnings() {
        report::warn(&warning);
    }
    match case.is_extended() {
        true => run_in::<Extended>(case, args, output, to_stdout),
        false => run_in::<f64>(case, args, output, to_stdout),
    }
}

fn run_in<S: Real>(case: &SceneCase, args: &CaseArgs, output: &OutArgs, to_stdout: bool) -> anyhow::Result<ExitCode> {
    let setup = case.setup::<S>();
    memory::check_scene(&setup)?;
    if to_stdout {
        // Checked before the computation, whose result would otherwise be lost.
        drop(stdout::for_data()?);
        let Solved { line, diagnostics, .. } = solved(case, &setup)?;
        diagnostics.warnings().iter().for_each(|warning| report::warn(warning));
        write_combined(stdout::for_data()?, &line, &diagnostics)?;
        return Ok(ExitCode::SUCCESS);
    }
    output.check_standard_output()?;
    let target = output.target(args, "run")?;
    let directory = target.folder.clone();
    let mut names = vec![TRAJECTORY, RESIDUALS, SUMMARY, CASE];
    if case.system() == System::Doubled {
        names.push(BRANCHES);
    }
    let files = OutputSet::open(target, &names)?;
    files.write_text(CASE, &case.to_toml())?;
    let start = Instant::now();
    let Solved { line, sums, diagnostics, seconds } = match solved(case, &setup) {
        Ok(solved) => solved,
        Err(failure) => {
            let seconds = start.elapsed().as_secs_f64();
            let summary = SceneSummary::new(case, &setup.place.geometry, Err(&failure), seconds).to_json();
            files.write_text(SUMMARY, &summary)?;
            files.commit(|name| name == SUMMARY || name == CASE)?;
            // The error of the run matters more than one in writing its summary, and is the one that is reported.
            let _ = output.tell(args, &summary, String::new);
            return Err(failure.into());
        }
    };
    let mut summary = SceneSummary::new(case, line.geometry(), Ok((&line, &diagnostics, &sums)), seconds[0]);
    let error = scene_error(&line);
    if let Some(solved) = &mut summary.solved {
        solved.diagnostics_seconds = seconds[1];
        error.iter().for_each(|error| solved.set_error(line.geometry().names(), error));
    }
    summary.warnings = case.warnings();
    summary.warnings.extend(diagnostics.warnings());
    diagnostics.warnings().iter().for_each(|warning| report::warn(warning));
    write_trajectory(files.writer(TRAJECTORY), &line, &diagnostics)
        .with_context(|| format!("cannot write {TRAJECTORY}"))?;
    write_residuals(files.writer(RESIDUALS), &line, &diagnostics)
        .with_context(|| format!("cannot write {RESIDUALS}"))?;
    if line.is_doubled() {
        write_branches(files.writer(BRANCHES), &line).with_context(|| format!("cannot write {BRANCHES}"))?;
    }
    let json = summary.to_json();
    files.write_text(SUMMARY, &json)?;
    let kept = files.commit(|_| true)?;
    let title = case.title().map_or_else(|| args.stem().to_string_lossy().into_owned(), str::to_owned);
    output.tell(args, &json, || {
        readable(&title, &line, &diagnostics, &sums, error.as_ref()) + &report::written(&directory, &kept)
    })?;
    Ok(ExitCode::SUCCESS)
}

fn solved<S: Real>(case: &SceneCase, setup: &SceneSetup<S>) -> Result<Solved<S>, NoWorldLine> {
    let start = Instant::now();
    let line = solve_scene(setup)?;
    let solve_seconds = start.elapsed().as_secs_f64();
    let start = Instant::now();
    let sums = setup.rough.geometry.conserved_sums(&setup.rough.start.q, &setup.rough.start.q_dot);
    let terms: Vec<Vec<(usize, S)>> =
        sums.iter().map(|sum| sum.terms.iter().map(|&(a, c)| (a, S::from(c))).collect()).collect();
    let diagnostics = SceneDiagnostics::new(&line, &terms, &mut case.observables(), case.is_lifted());
    Ok(Solved { line, sums, diagnostics, seconds: [solve_seconds, start.elapsed().as_secs_f64()] })
}
