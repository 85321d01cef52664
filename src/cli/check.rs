//! `check CASE`.

use std::process::ExitCode;

use clap::Args;
use geodesic_ivp::case::Expect;
use geodesic_ivp::case::scene::SceneCase;
use geodesic_ivp::scalar::{Extended, Real};
use geodesic_ivp::solve::Arithmetic;
use geodesic_ivp::{Case, CaseError, NoSolution, Solution, Status, solve};

use super::input::AnyCase;
use super::{CaseArgs, memory, report, scene, stdout};

#[derive(Debug, Args)]
pub(super) struct CheckArgs {
    #[command(flatten)]
    case: CaseArgs,

    /// Also solve the case and compare the result with its [expect] table
    #[arg(long)]
    run: bool,
}

/// The error of a solved case that differs from its `[expect]` table: one phrase for each difference.
#[derive(Debug, thiserror::Error)]
#[error("the case does not meet its [expect] table: {}", .0.join("; "))]
pub(super) struct ExpectationNotMet(pub(super) Vec<String>);

pub(super) fn check(args: &CheckArgs) -> anyhow::Result<ExitCode> {
    let case = match args.case.read_any()? {
        AnyCase::One(case) => case,
        AnyCase::Scene(case) => return check_scene(&case, args),
    };
    for warning in case.warnings() {
        report::warn(&warning);
    }
    if !args.case.quiet {
        stdout::write(&case.to_toml())?;
    }
    if args.run {
        let Some(expect) = &case.expect else { return Err(without_expectations(args)) };
        memory::check(&case, None)?;
        let met = if case.is_extended() { compare::<Extended>(&case, expect)? } else { compare::<f64>(&case, expect)? };
        tell_met(args, &met)?;
    }
    Ok(ExitCode::SUCCESS)
}

fn check_scene(case: &SceneCase, args: &CheckArgs) -> anyhow::Result<ExitCode> {
    for warning in case.warnings() {
        report::warn(&warning);
    }
    if !args.case.quiet {
        stdout::write(&case.to_toml())?;
    }
    if args.run {
        let Some(expect) = case.expect() else { return Err(without_expectations(args)) };
        tell_met(args, &scene::compare(case, expect)?)?;
    }
    Ok(ExitCode::SUCCESS)
}

fn without_expectations(args: &CheckArgs) -> anyhow::Error {
    let message = "the case has no [expect] table to compare with".to_owned();
    CaseError::without_place(&args.case.name(), message).into()
}

fn tell_met(args: &CheckArgs, met: &[String]) -> anyhow::Result<()> {
    if args.case.quiet {
        return Ok(());
    }
    stdout::write(&format!("\n# expected and found: {}\n", met.join("; ")))
}

/// Solves the case and compares the result with its `[expect]` table. Returns one phrase for each number that is as
/// expected.
///
/// # Errors
/// [`ExpectationNotMet`] if anything is different.
fn compare<S: Arithmetic>(case: &Case, expect: &Expect) -> anyhow::Result<Vec<String>> {
    let result = solve::<S>(case);
    let status = result.as_ref().map_or_else(|failure| failure.status, |_| Status::Converged);
    if status != expect.status {
        let found = result.err().as_ref().map_or_else(|| status.to_string(), NoSolution::to_string);
        return Err(ExpectationNotMet(vec![format!("expected status {}, found {found}", expect.status)]).into());
    }
    let mut met = vec![format!("status {status}")];
    if let (Ok(solution), Some(tolerance)) = (&result, &expect.tolerance) {
        let mut missed = Vec::new();
        for (name, expected, found) in expected_numbers(expect, solution) {
            let difference = (found - expected).abs();
            let [found, expected] = [found, expected].map(|number| number.to_decimal(solution.digits));
            let (distance, allowed) = (difference.to_f64(), tolerance.value());
            let phrase = format!("{name} = {found} within {distance:.1e} of {expected} (tolerance {allowed:e})");
            if difference <= tolerance.to() {
                met.push(phrase)
            } else {
                missed.push(phrase.replace("within", "differs by"))
            }
        }
        if !missed.is_empty() {
            return Err(ExpectationNotMet(missed).into());
        }
    }
    Ok(met)
}

fn expected_numbers<S: Real>(expect: &Expect, solution: &Solution<S>) -> impl Iterator<Item = (&'static str, S, S)> {
    let t = expect.t_final.as_ref().map(|expected| ("t_final", expected.to(), solution.end.t));
    let x = expect.x_final.as_ref().map(|expected| ("x_final", expected.to(), solution.end.x));
    t.into_iter().chain(x)
}
