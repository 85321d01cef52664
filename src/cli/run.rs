//! `run CASE`.

use std::process::ExitCode;
use std::time::Instant;

use anyhow::Context;
use geodesic_ivp::Case;
use geodesic_ivp::number::{Extended, Real};
use geodesic_ivp::output::streamed::StreamedTable;
use geodesic_ivp::output::tables::{write_events, write_samples};
use geodesic_ivp::output::{CASE, Chart, OutputSet, SUMMARY, failure_summary, pictures, run_summary};
use geodesic_ivp::solve::Setup;
use geodesic_ivp::study::run::{Before, NoRun, Wanted};

use super::judge::{NO_ERROR, NO_PROOF, PROOF};
use super::piped::{takes_windows, to_standard_output};
use super::run_args::{RunArgs, explained, solved};
use super::run_tables::{EVENTS, HULL, tables, write_table, write_tables};
use super::together::Together;
use super::told::Told;
use super::{memory, out, report};

const UNTIL_FAILURE: &str = "until_failure.csv";
const PICTURE_OF_HULL: &str = "hull.svg";

pub(super) fn run(args: &RunArgs) -> anyhow::Result<ExitCode> {
    if args.more.is_empty() {
        let help = "name further cases, or let --vary give a key several values";
        return match args.together {
            true => Err(report::refused("--together draws several runs in one picture, and this is one", help)),
            false => run_case(&args.case.read()?, args, &mut Vec::new()),
        };
    }
    // All are read before the first is run: a mistake in the last one is found at once.
    let each = args.each()?;
    let cases: Vec<Case> = each.iter().map(|args| args.case.read()).collect::<anyhow::Result<_>>()?;
    let named: Vec<(String, &Case)> = each.iter().map(|args| args.named(&each)).zip(&cases).collect();
    let mut together = if args.together { Some(Together::open(&args.output, &named)?) } else { None };
    let mut worst = 0;
    for ((case, args), (name, _)) in cases.iter().zip(&each).zip(&named) {
        let mut charts = Vec::new();
        match run_case(case, args, &mut charts) {
            Ok(_) => together.iter_mut().for_each(|together| together.add(name, case, std::mem::take(&mut charts))),
            Err(error) => worst = worst.max(report::explain(&error)),
        }
    }
    together.map_or(Ok(()), |together| together.finish(args.case.quiet))?;
    Ok(ExitCode::from(worst))
}

/// Runs one case, the one of `args`. Its pictures, if there are any, are also kept in `charts`.
fn run_case(case: &Case, args: &RunArgs, charts: &mut Vec<Chart>) -> anyhow::Result<ExitCode> {
    match case.settings.is_extended() {
        true => execute::<Extended>(case, args, charts),
        false => execute::<f64>(case, args, charts),
    }
}

fn execute<S: Real>(case: &Case, args: &RunArgs, charts: &mut Vec<Chart>) -> anyhow::Result<ExitCode> {
    let setup = case.setup::<S>();
    args.samples.check(args.stdout)?;
    check_options(case, args)?;
    let samples = args.samples.stream(case)?;
    case.warnings().iter().for_each(|warning| report::warn(warning));
    let is_streamed = args.samples.samples_only || args.stdout && takes_windows(&setup, args);
    memory::check(&setup, is_streamed, args.samples.count().unwrap_or(0))?;
    if args.stdout {
        return to_standard_output(case, &setup, args, Wanted { samples, is_streamed, ..Wanted::default() });
    }
    let wanted = Wanted { samples, is_streamed, sums: true, ..Wanted::default() };
    let target = args.output.target(&args.case, "run")?;
    out::keep_source(case, &target)?;
    let directory = target.folder.clone();
    let mut tables = tables(case, !args.samples.samples_only, args.samples.count().is_some());
    tables.extend(case.has_hull().then_some(HULL));
    let all = [&tables[..], &[UNTIL_FAILURE]].concat();
    let drawn = if args.plot { pictures::names_of_run(case) } else { Vec::new() };
    let drawn_hull = (args.plot && case.has_hull()).then_some(PICTURE_OF_HULL);
    let others = [SUMMARY, CASE].into_iter().chain(drawn_hull).collect::<Vec<_>>();
    let files = OutputSet::open(target, &[&args.format.files(&all)[..], &others, &drawn].concat())?;
    // The expectations hold for the case as it is in its file.
    let is_own = args.case.set.iter().all(|set| [PROOF, NO_PROOF, NO_ERROR].contains(&set.as_str()));
    let effective = if is_own { case.to_toml() } else { case.without_expectations().to_toml() };
    files.write_text(CASE, &effective)?;
    let (result, solve_seconds) = solved(case, &setup, args, wanted);
    let run = match result {
        Ok(run) => run,
        Err(none) => return Err(failed(case, &setup, args, files, (none, solve_seconds))),
    };
    let judged = args.judge.judged(case, &setup, &run, args.case.quiet);
    // People read in the summary what is doubtful.
    if args.output.json || args.case.quiet {
        judged.suspicions.iter().for_each(|warning| report::warn(warning));
    }
    let start = Instant::now();
    write_tables(&files, &tables, &args.format, &|name, out| {
        write_table(name, out, case, (&run, Some(&judged)), args.every)
    })?;
    let title = args.case.headed(case.title.as_deref());
    let json = run_summary(case, &run, &judged, [solve_seconds, start.elapsed().as_secs_f64()]);
    files.write_text(SUMMARY, &json)?;
    if args.plot {
        *charts = pictures::of_run(&title, case, &run);
        drawn.iter().zip(&*charts).try_for_each(|(name, chart)| files.write_text(name, &chart.to_svg()))?;
    }
    if let Some(hull) = judged.hull.as_ref().filter(|_| args.plot) {
        files.write_text(PICTURE_OF_HULL, &pictures::of_hull(&title, case, hull).to_svg())?;
    }
    let of_failure = args.format.files(&[UNTIL_FAILURE]);
    files.commit(&|name| !of_failure.contains(&name))?;
    args.output.tell(args.case.quiet, &json, || {
        let told = Told { title: &title, case, run: &run, judged: &judged, solve_seconds };
        told.lines(&directory) + &if args.verbose { told.details() } else { String::new() }
    })?;
    Ok(ExitCode::SUCCESS)
}

/// Writes what there is of a case without a run, and returns the error.
fn failed<S: Real>(
    case: &Case,
    setup: &Setup<S>,
    args: &RunArgs,
    files: OutputSet,
    (none, solve_seconds): (NoRun<S>, f64),
) -> anyhow::Error {
    if let NoRun::Unsolved(failure, before) = &none {
        let summary = failure_summary(case, &setup.place.geometry, failure, solve_seconds);
        let write = || {
            let has_rows = until_failure(case, (before, setup.settings.digits), args, &files)?;
            files.write_text(SUMMARY, &summary)?;
            let of_failure = args.format.files(&[UNTIL_FAILURE, EVENTS]);
            let is_kept = |name: &str| has_rows && of_failure.contains(&name);
            files.commit(&|name| name == SUMMARY || name == CASE || is_kept(name))
        };
        if let Err(error) = write() {
            return error;
        }
        // The error of the run matters more than one in writing its summary, and is the one that is reported.
        let _ = args.output.tell(args.case.quiet, &summary, String::new);
    }
    explained(none, args, setup)
}

/// Writes the rows before a failure, which are samples if nothing else was wanted, and the events there. Returns
/// whether there is anything.
fn until_failure<S: Real>(
    case: &Case,
    (before, digits): (&Before<S>, u32),
    args: &RunArgs,
    files: &OutputSet,
) -> anyhow::Result<bool> {
    let Before { parts, events, samples } = before;
    let Some((last, _)) = parts.last() else { return Ok(false) };
    let names = last.geometry().names();
    if args.samples.samples_only {
        files.write_table(UNTIL_FAILURE, |out| write_samples(out, names, (samples, &[]), digits))?;
    } else {
        let file = files.writer(UNTIL_FAILURE).try_clone().context("cannot write until_failure.csv")?;
        let mut table = StreamedTable::new(file, 1, Some(true));
        parts.iter().for_each(|(part, measured)| table.see(part, measured));
        table.finish().context("cannot write until_failure.csv")?;
    }
    args.format.write_array(files, UNTIL_FAILURE)?;
    if !case.events.is_empty() {
        let format = (digits, case.settings.is_judged_on_its_way());
        files.write_table(EVENTS, |out| write_events(out, names, &case.event_names(), (events, &[]), format))?;
        args.format.write_array(files, EVENTS)?;
    }
    Ok(true)
}

/// Refuses options that this case does not have.
fn check_options(case: &Case, args: &RunArgs) -> anyhow::Result<()> {
    if args.judge.enclose && case.settings.accuracy.is_none() && args.samples.samples_only {
        let help = "leave one of them out, or ask for solver.accuracy, which looks between the nodes on the way";
        return Err(report::refused("--samples-only keeps no nodes that --enclose could look between", help));
    }
    if case.has_acting_events() && args.judge.reference {
        let help = "leave --reference out: such a run is compared with a second one in any case";
        return Err(report::refused("the Taylor method of --reference knows no events that act", help));
    }
    Ok(())
}
