//! `check CASE`.

use std::process::ExitCode;

use clap::Args;
use geodesic_ivp::case::Expect;
use geodesic_ivp::number::Extended;
use geodesic_ivp::number::Real;
use geodesic_ivp::solve::Arithmetic;
use geodesic_ivp::study::run::{NoRun, Wanted, run};
use geodesic_ivp::{Case, CaseError, Status};

use super::lines::{COLUMNS, broken};
use super::{CaseArgs, memory, report, stdout};

#[derive(Debug, Args)]
pub(super) struct CheckArgs {
    #[command(flatten)]
    case: CaseArgs,

    /// Also solve the case, and compare the result with its [expect] table
    #[arg(long)]
    run: bool,
}

/// The error of a solved case that differs from its `[expect]` table: one phrase for each difference.
#[derive(Debug, thiserror::Error)]
#[error("the case does not meet its [expect] table: {}", .0.join("; "))]
pub(super) struct ExpectationNotMet(pub(super) Vec<String>);

pub(super) fn check(args: &CheckArgs) -> anyhow::Result<ExitCode> {
    let case = args.case.read()?;
    for warning in case.warnings() {
        report::warn(&warning);
    }
    let met = args.run.then(|| met(&case)).transpose();
    if let (Ok(Some(Some(met))), false) = (&met, args.case.quiet) {
        let lines: Vec<String> = met.iter().map(|phrase| broken(&format!("#   {phrase}"), 0, COLUMNS)).collect();
        stdout::write(&format!("# The case meets its [expect] table:\n{}\n", lines.concat()))?;
    }
    if !args.case.quiet {
        stdout::write(&case.to_toml())?;
    }
    if let Some(None) = met? {
        let message = "the case has no [expect] table to compare with".to_owned();
        return Err(CaseError::without_place(&args.case.name(), message).into());
    }
    Ok(ExitCode::SUCCESS)
}

/// One phrase for each number that is as expected; nothing if the case expects nothing.
///
/// # Errors
/// [`ExpectationNotMet`] if anything is different.
fn met(case: &Case) -> anyhow::Result<Option<Vec<String>>> {
    let compare = if case.is_extended() { compare::<Extended> } else { compare::<f64> };
    let met = case.expect().map(|expect| compare(case, expect));
    met.transpose()
}

/// A number at the end of a run, and what it is expected to be.
struct Number<S> {
    name: String,
    found: S,
    expected: S,
}

/// Solves the case and compares the result with its `[expect]` table. Returns one phrase for each number that is as
/// expected.
///
/// # Errors
/// [`ExpectationNotMet`] if anything is different, and if there is not enough memory.
fn compare<S: Arithmetic>(case: &Case, expect: &Expect) -> anyhow::Result<Vec<String>> {
    let setup = case.setup::<S>();
    memory::check(&setup, false, 0)?;
    let result = match run(case, &setup, Wanted::default()).0 {
        Ok(found) => Ok(found.line),
        Err(NoRun::Unsolved(failure, _)) => Err((failure.status, failure.to_string())),
        Err(NoRun::Unsampled(_)) => unreachable!("no samples are asked for"),
    };
    let numbers = result.map(|line| {
        let gamma = expect.gamma_final.as_ref().map(|expected| ("gamma", line.gamma_f(), expected));
        let names = line.geometry().names();
        let finals = expect.finals.iter().map(|(a, expected)| (names[*a].as_str(), line.end().q[*a], expected));
        let number = |(name, found, expected)| Number {
            name: format!("{name}_final"),
            found,
            expected: case.value::<S>(expected),
        };
        gamma.into_iter().chain(finals).map(number).collect::<Vec<_>>()
    });
    judge(
        expect.status,
        numbers,
        expect.tolerance.as_ref().map(|tolerance| case.value(tolerance)),
        setup.settings.digits,
    )
}

/// Compares how a solve ended, and with which numbers, with what is expected.
fn judge<S: Real>(
    expected: Status,
    ended: Result<Vec<Number<S>>, (Status, String)>,
    tolerance: Option<S>,
    digits: u32,
) -> anyhow::Result<Vec<String>> {
    let (status, found) = match &ended {
        Ok(_) => (Status::Converged, Status::Converged.to_string()),
        Err((status, message)) => (*status, message.clone()),
    };
    if status != expected {
        return Err(ExpectationNotMet(vec![format!("expected status {expected}, found {found}")]).into());
    }
    let (mut met, mut missed) = (vec![format!("status {status}")], Vec::new());
    let numbers = ended.unwrap_or_default();
    for (Number { name, found, expected }, tolerance) in numbers.into_iter().zip(tolerance.into_iter().cycle()) {
        let difference = (found - expected).abs();
        let [found, expected] = [found, expected].map(|number| number.to_decimal(digits));
        let (distance, allowed) = (difference.to_f64(), tolerance.to_f64());
        match difference <= tolerance {
            true => met.push(format!("{name} = {found}, off by {distance:.1e} (tolerance {allowed:e})")),
            false => missed
                .push(format!("{name} = {found} differs by {distance:.1e} from {expected} (tolerance {allowed:e})")),
        }
    }
    if missed.is_empty() { Ok(met) } else { Err(ExpectationNotMet(missed).into()) }
}
