//! `run CASE --vary KEY=VALUES`: many runs of one case, a row of a table for each.
//!
//! Rows are computed by as many workers as there are cores, and each takes the next row when it has finished one. The
//! main thread keeps every row in a journal as soon as it is there. When all are, they are sorted into the table, which
//! appears as the files of every command do, and the journal is removed. A table that is interrupted, or killed, is
//! continued by the same command. With --stdout rows go into a pipe, in their order, and nothing is kept.

use std::collections::BTreeMap;
use std::io::Write;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use geodesic_ivp::Case;
use geodesic_ivp::case::{key_of, overridden};
use geodesic_ivp::number::Extended;
use geodesic_ivp::output::runs::{Columns, Identity, Journal, RunRow, RunsSummary};
use geodesic_ivp::output::{CASE, OutputSet, SUMMARY, pictures};
use geodesic_ivp::solve::Settings;
use geodesic_ivp::study::Sampling;
use geodesic_ivp::study::many::{Axis, ManyRuns};

use super::interrupt;
use super::lines::{row, wrapped};
use super::report::{self, INTERRUPTED, INVALID_CASE, NO_CRITICAL_POINT, refused};
use super::run_args::RunArgs;
use super::share::{Share, VaryArgs};
use super::study::{self, Placed};
use super::{memory, out, together};

/// The pictures of `--plot`: of a column over one key, over two, and of the events of all rows.
const LINE: &str = "line.svg";
const MAP: &str = "map.svg";
const SECTION: &str = "section.svg";

/// The statuses of runs that are not begun.
const INVALID: &str = "invalid-case";
const TOO_LARGE: &str = "too-large";

/// Runs of so few nodes fit any machine. To look for the memory that there is costs as much as a short run.
const FEW_NODES: usize = 100_000;
/// A row keeps its samples as text, too, which takes about as much room as so many samples.
const TEXT_OF_SAMPLE: usize = 3;

pub(super) fn vary(args: &RunArgs) -> anyhow::Result<ExitCode> {
    check(args)?;
    interrupt::start_threads();
    let (runs, identity) = read(args)?;
    let columns = Columns::new(&runs);
    let Share { k, n } = args.vary.part.unwrap_or(Share { k: 1, n: 1 });
    let share = (k - 1..runs.len()).step_by(n);
    if args.stdout {
        return piped(&Arc::new((runs, columns)), share.collect(), args.case.quiet);
    }
    let column = if args.plot { Some(column(&args.vary, &runs, &columns)?) } else { None };
    let curves = if args.together { Some(together::of_rows(&runs)?) } else { None };
    let target = args.output.target(&args.case, out::VARY)?;
    out::keep_source(runs.first(), &target)?;
    let force = target.force;
    let tables: Vec<&'static str> = columns.tables.iter().map(|table| table.name).collect();
    let of_rows = curves.as_ref().map_or(&[][..], |curves| &curves.names);
    let files = OutputSet::open(
        target,
        &[&args.format.files(&tables)[..], &[SUMMARY, CASE], &pictures(args, &runs), of_rows].concat(),
    )?;
    let mut journal = Journal::open(files.folder(), &identity, &columns.tables, force)?;

    let (all, there) = (share.len(), journal.count());
    let todo: Vec<usize> = share.filter(|run| !journal.has(run + 1)).collect();
    if there > 0 && !args.case.quiet {
        report::note(&format!("{there} of {all} rows are there already"));
    }
    let table = Arc::new((runs, columns));
    let interrupted = compute(&table, todo, args.case.quiet, |row| journal.keep(&row))?;
    let runs = &table.0;
    if interrupted {
        let (there, path) = (journal.count(), journal.path().display());
        report::warn(&format!(
            "interrupted: {there} of {all} rows are kept in {path}; the same command goes on from there"
        ));
        return Ok(ExitCode::from(INTERRUPTED));
    }

    let mut summary = RunsSummary::new(runs.first().title.as_deref(), &identity, runs.len());
    let writers = tables.iter().map(|name| (*name, files.writer(name))).collect();
    let shown: Vec<String> = column.iter().flat_map(|column| shown(runs, &table.1, column)).collect();
    let cells = journal.write(writers, &mut summary, &shown)?;
    tables.iter().try_for_each(|table| args.format.write_array(&files, table))?;
    if let Some(column) = &column {
        let title = args.case.headed(runs.first().title.as_deref());
        draw(&files, runs, &title, (column, &cells), &mut journal)?;
        curves.map_or(Ok(()), |curves| together::draw_rows(curves, &files, runs, &title))?;
    }
    files.write_text(CASE, &identity.case)?;
    let text = summary_text(&args.case.headed(runs.first().title.as_deref()), &summary, &varied(runs));
    let json = summary.to_json();
    let placed = Placed::new(files, &json, None)?;
    journal.remove()?;
    args.output.tell(args.case.quiet, &json, || text + &placed.written)?;
    Ok(ExitCode::from(ending(&summary)))
}

/// The runs that are asked for, and the identity of their table.
fn read(args: &RunArgs) -> anyhow::Result<(ManyRuns, Identity)> {
    let VaryArgs { vary: axes, part, .. } = &args.vary;
    let (name, text, set) = (args.case.name(), args.case.read_text()?, &args.case.set);
    let runs = ManyRuns::new(&name, &text, set, axes.clone()).map_err(|error| args.case.of_another_kind(error))?;
    let case = overridden(&name, &text, set).map_err(|error| args.case.of_another_kind(error))?;
    let asked = axes.iter().map(|axis| axis.text.clone()).collect();
    let part = part.map(|Share { k, n }| format!("{k}/{n}"));
    let identity = Identity::new(case, asked, part, runs.contents()).with_samples(args.samples.asked());
    args.case.note(runs.first());
    runs.first().warnings().iter().for_each(|warning| report::warn(warning));
    // Refuses times where the scene has none.
    args.samples.stream::<f64>(runs.first())?;
    Ok((runs.with_samples(args.samples.wanted().cloned()), identity))
}

/// Warns of what the rows of a table say, and returns its exit code.
pub(super) fn ending(summary: &RunsSummary) -> u8 {
    if summary.doubtful > 0 {
        let [are, their] = if summary.doubtful == 1 { ["is", "its"] } else { ["are", "their"] };
        let doubtful = summary.doubtful;
        report::warn(&format!("{doubtful} of the solved rows {are} doubtful: {their} column message says why"));
    }
    match (summary.rows - summary.solved, summary.solved) {
        (0, _) => return 0,
        (_, 0) => {
            report::warn("no row has a solution: the column message says why");
            return NO_CRITICAL_POINT;
        }
        (1, _) => report::warn(&format!("one of {} rows has no solution: its column message says why", summary.rows)),
        (refused, _) => {
            let rows = summary.rows;
            report::warn(&format!("{refused} of {rows} rows have no solution: their column message says why"));
        }
    }
    0
}

/// The names of the pictures.
fn pictures(args: &RunArgs, runs: &ManyRuns) -> Vec<&'static str> {
    let of_column = if runs.axes.len() == 1 { LINE } else { MAP };
    let section = (!runs.first().events.is_empty()).then_some(SECTION);
    if args.plot { [of_column].into_iter().chain(section).collect() } else { Vec::new() }
}

/// Draws the cells of a column over the keys that vary, and the events.
fn draw(
    files: &OutputSet,
    runs: &ManyRuns,
    title: &str,
    (column, cells): (&str, &[Vec<String>]),
    journal: &mut Journal,
) -> anyhow::Result<()> {
    let varied = |axis| pictures::Varied::from(axis);
    match runs.axes.as_slice() {
        [axis] => {
            let svg = match cells {
                [low, high] => pictures::hulls(title, column, varied(axis), [low, high]).to_svg(),
                _ => pictures::line(title, column, varied(axis), &cells[0]),
            };
            files.write_text(LINE, &svg)?;
        }
        [x, y] => files.write_text(MAP, &pictures::scan(title, column, [x, y].map(varied), &cells[0]).to_svg())?,
        _ => {}
    }
    if runs.first().events.is_empty() {
        return Ok(());
    }
    let first = &runs.axes[0];
    let mut named: Vec<(String, Vec<(f64, f64)>)> = Vec::new();
    for (run, events) in journal.events()? {
        let Ok(case) = runs.case(run) else { continue };
        let value = runs.values(run)[0];
        for (event, place) in pictures::places_of_events(&case, &events) {
            // Where there are too many rows for colours, each of several events has one.
            let is_by_event = first.values.len() > pictures::MOST_COLOURS && runs.first().events.len() > 1;
            let name = if is_by_event { event } else { format!("{} = {value}", first.key) };
            match named.iter_mut().find(|(other, _)| *other == name) {
                Some((_, places)) => places.push(place),
                None => named.push((name, vec![place])),
            }
        }
    }
    files.write_text(SECTION, &pictures::section_of_runs(title, runs.first(), named).to_svg())
}

/// Prints the table without its events, row by row in their order. Returns the exit code.
fn piped(table: &Arc<(ManyRuns, Columns)>, todo: Vec<usize>, is_quiet: bool) -> anyhow::Result<ExitCode> {
    let mut out = out::for_data()?;
    out.write_all(&table.1.header_line())?;
    let (mut summary, mut waiting) = (RunsSummary::of_rows(), BTreeMap::new());
    let mut order = todo.clone().into_iter().map(|run| run + 1).peekable();
    let interrupted = compute(table, todo, is_quiet, |row| {
        waiting.insert(row.row, row);
        while let Some(RunRow { records, status, verdict, .. }) = order.peek().and_then(|next| waiting.remove(next)) {
            order.next();
            summary.count(&status, verdict.as_str());
            out.write_all(&records[0])?;
        }
        Ok(out.flush()?)
    })?;
    Ok(ExitCode::from(if interrupted { INTERRUPTED } else { ending(&summary) }))
}

/// The column that a picture shows.
fn column(args: &VaryArgs, runs: &ManyRuns, columns: &Columns) -> anyhow::Result<String> {
    if args.vary.len() > 2 || args.part.is_some() {
        let message = "--plot draws a whole table over one or two keys that vary";
        return Err(refused(message, "give --vary once or twice, without --part, or leave out --plot"));
    }
    let header = columns.header();
    let default = || runs.first().coordinates().into_iter().find(|name| name != "t");
    let column = args.column.clone().or_else(default).unwrap_or_else(|| "status".to_owned());
    if header.contains(&column) {
        return Ok(column);
    }
    let known = header.join(", ");
    Err(refused(format!("the table has no column '{column}'"), format!("its columns are {known}")))
}

/// The columns whose cells are drawn: of intervals side by side both ends of the hull.
fn shown(runs: &ManyRuns, columns: &Columns, column: &str) -> Vec<String> {
    match (runs.axes.as_slice(), columns.ends_of(column)) {
        ([axis], Some(ends)) if axis.values.iter().all(|value| pictures::ends_of(value).is_some()) => ends.to_vec(),
        _ => vec![column.to_owned()],
    }
}

/// Refuses combinations of options that make no sense, and keys that are given twice.
fn check(args: &RunArgs) -> anyhow::Result<()> {
    let VaryArgs { vary: axes, part, .. } = &args.vary;
    if part.is_some() && args.output.out.is_none() && !args.stdout {
        return Err(refused("--part writes one of several tables", "give each part a folder, with --out"));
    }
    if args.stdout && args.samples.wanted().is_some() {
        let message = "--stdout writes one table, the rows, and samples are in another";
        return Err(refused(message, "leave --stdout or the samples out"));
    }
    for (place, axis) in axes.iter().enumerate() {
        let key = &axis.key;
        if axes[..place].iter().any(|other| other.key == *key) {
            return Err(refused(format!("--vary {key} is given twice"), "give all its values at once"));
        }
        if args.case.set.iter().any(|setting| key_of(setting).is_some_and(|other| other == *key)) {
            let message = format!("{key} is both in --set and in --vary");
            return Err(refused(message, "leave one of them out"));
        }
    }
    Ok(())
}

/// Computes the rows `todo`, which count from 0, with a progress bar if standard error is a terminal, and lets each be
/// kept. Returns whether it was interrupted.
fn compute(
    table: &Arc<(ManyRuns, Columns)>,
    todo: Vec<usize>,
    is_quiet: bool,
    mut keep: impl FnMut(RunRow) -> anyhow::Result<()>,
) -> anyhow::Result<bool> {
    let bar = study::bar(is_quiet, todo.len(), "{bar:30} {pos}/{len} runs, {eta} left");
    let (next, end) = (Arc::new(AtomicUsize::new(0)), todo.len());
    let work = {
        let next = Arc::clone(&next);
        move |(runs, columns): &(ManyRuns, Columns), tell: &(dyn Fn(RunRow) + Sync)| {
            rayon::broadcast(|_| {
                while let Some(&run) = todo.get(next.fetch_add(1, Ordering::Relaxed)) {
                    tell(computed(runs, columns, run));
                }
            });
        }
    };
    let mut kept = Ok(());
    let interrupted = study::computed(&bar, table, work, |row| {
        bar.inc(1);
        if kept.is_ok() {
            kept = keep(row);
            if kept.is_err() {
                // What cannot be kept need not be computed.
                next.store(end, Ordering::Relaxed);
            }
        }
    });
    kept.map(|()| interrupted)
}

/// Computes a row.
fn computed(runs: &ManyRuns, columns: &Columns, run: usize) -> RunRow {
    let refused = |status: &str, exit_code, message: &str| columns.row(runs, run, Err((status, exit_code, message)));
    let case = match runs.case(run) {
        Ok(case) => case,
        Err(error) => return refused(INVALID, INVALID_CASE, &error.message),
    };
    if let Err(error) = check_memory(&case, runs.samples.as_ref().map_or(0, Sampling::count)) {
        return refused(TOO_LARGE, INVALID_CASE, &error.to_string());
    }
    match runs.outcome(&case) {
        Ok(end) => columns.row(runs, run, Ok(&end)),
        Err(failure) => refused(failure.status.as_str(), report::code_of(failure.status), &failure.to_string()),
    }
}

fn check_memory(case: &Case, samples: usize) -> anyhow::Result<()> {
    let Settings { n_gamma, windows, .. } = case.settings;
    let samples = TEXT_OF_SAMPLE * samples;
    match case.settings.is_extended() {
        _ if n_gamma * windows + samples <= FEW_NODES => Ok(()),
        true => memory::check(&case.setup::<Extended>(), false, samples),
        false => memory::check(&case.setup::<f64>(), false, samples),
    }
}

/// The line that says what is varied.
fn varied(runs: &ManyRuns) -> String {
    let one = |axis: &Axis| match axis.values.as_slice() {
        [one] => format!("{} = {one}", axis.key),
        [first, .., last] => format!("{} from {first} to {last} ({} values)", axis.key, axis.values.len()),
        [] => axis.key.clone(),
    };
    row("varied", &runs.axes.iter().map(one).collect::<Vec<_>>().join(", "))
}

/// The lines for people: first how many rows have which verdict, then how many have which status. The line `varied` is
/// between them.
pub(super) fn summary_text(title: &str, summary: &RunsSummary, varied: &str) -> String {
    let RunsSummary { rows, solved, doubtful, proved, hulls, .. } = summary;
    let (trusted, refused) = (solved - doubtful - proved, rows - solved);
    let proved = if *proved > 0 { format!("{proved} proved, ") } else { String::new() };
    let counts: Vec<String> = summary.statuses.iter().map(|(status, count)| format!("{count} {status}")).collect();
    let part = summary.part.as_ref().map_or(String::new(), |part| format!(", part {part} of {}", summary.runs));
    wrapped(&format!("{title}: {proved}{trusted} trusted, {doubtful} doubtful, {refused} refused"), 2)
        + varied
        + &row("rows", &format!("{rows}{part}: {}", counts.join(", ")))
        + &hulls.map_or_else(String::new, |hulls| row("hull", &of_hulls(hulls, *rows)))
}

/// Says how many rows have a hull that is proved.
fn of_hulls(hulls: usize, rows: usize) -> String {
    if hulls == rows {
        return "all rows have one that is proved".to_owned();
    }
    format!("{hulls} of {rows} rows have one that is proved: the column message says why others have none")
}
