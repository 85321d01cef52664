//! `check CASE`.

use std::process::ExitCode;

use clap::Args;
use geodesic_ivp::case::Expect;
use geodesic_ivp::number::{Extended, Real};
use geodesic_ivp::study::run::{NoRun, Run, Wanted, run};
use geodesic_ivp::{Case, CaseError, Status};

use super::lines::{COLUMNS, broken};
use super::report::ExpectationNotMet;
use super::{CaseArgs, memory, out, report};

#[derive(Debug, Args)]
pub(super) struct CheckArgs {
    #[command(flatten)]
    case: CaseArgs,

    /// Also solve the case, and compare the result with its [expect] table
    #[arg(long)]
    run: bool,
}

pub(super) fn check(args: &CheckArgs) -> anyhow::Result<ExitCode> {
    let case = args.case.read()?;
    for warning in case.warnings() {
        report::warn(&warning);
    }
    let compare = if case.settings.is_extended() { compare::<Extended> } else { compare::<f64> };
    let met = args.run.then(|| case.expect.as_ref().map(|expect| compare(&case, expect)).transpose()).transpose();
    if let (Ok(Some(Some(met))), false) = (&met, args.case.quiet) {
        let lines: Vec<String> = met.iter().map(|phrase| broken(&format!("#   {phrase}"), 0, COLUMNS)).collect();
        out::write(&format!("# The case meets its [expect] table:\n{}\n", lines.concat()))?;
    }
    if !args.case.quiet {
        out::write(&case.to_toml())?;
    }
    if let Some(None) = met? {
        let message = "the case has no [expect] table to compare with".to_owned();
        return Err(CaseError::without_place(&args.case.name(), message).into());
    }
    Ok(ExitCode::SUCCESS)
}

/// Solves the case and compares the result with its `[expect]` table. Returns one phrase for each number that is as
/// expected.
///
/// # Errors
/// [`ExpectationNotMet`] if anything is different, and if there is not enough memory.
fn compare<S: Real>(case: &Case, expect: &Expect) -> anyhow::Result<Vec<String>> {
    let setup = case.setup::<S>();
    memory::check(&setup, false, 0)?;
    let result = run(case, &setup, Wanted::default()).0;
    let (status, found) = match &result {
        Ok(_) => (Status::Converged, Status::Converged.to_string()),
        Err(NoRun::Unsolved(failure, _)) => (failure.status, failure.to_string()),
        Err(NoRun::Unsampled(_)) => unreachable!("no samples are asked for"),
    };
    let (mut met, mut missed) = (Vec::new(), Vec::new());
    match status == expect.status {
        true => met.push(format!("status {status}")),
        false => missed.push(format!("expected status {}, found {found}", expect.status)),
    }
    if let (Ok(Run { line, .. }), Some(tolerance), true) = (&result, &expect.tolerance, missed.is_empty()) {
        let (names, end, tolerance) = (line.geometry().names(), line.end(), case.value::<S>(tolerance));
        let gamma = expect.gamma_final.iter().map(|expected| ("gamma", line.gamma_f(), expected));
        let finals = expect.finals.iter().map(|(a, expected)| (names[*a].as_str(), end.q[*a], expected));
        for (name, found, expected) in gamma.chain(finals) {
            let expected = case.value::<S>(expected);
            let difference = (found - expected).abs();
            let [found, expected] = [found, expected].map(|number| number.to_decimal(setup.settings.digits));
            let (distance, allowed) = (difference.to_f64(), tolerance.to_f64());
            let (list, how) = match difference <= tolerance {
                true => (&mut met, format!("= {found}, off by {distance:.1e}")),
                false => (&mut missed, format!("= {found} differs by {distance:.1e} from {expected}")),
            };
            list.push(format!("{name}_final {how} (tolerance {allowed:e})"));
        }
    }
    if missed.is_empty() { Ok(met) } else { Err(ExpectationNotMet(missed).into()) }
}
