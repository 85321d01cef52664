//! `find CASE --vary KEY=VALUES`: searches from several starts.

use std::process::ExitCode;
use std::sync::Arc;

use geodesic_ivp::case::Find;
use geodesic_ivp::output::{CASE, OutputSet, SUMMARY, starts_summary, write_starts};
use geodesic_ivp::study::find::{FromStart, find_each, solutions};
use geodesic_ivp::study::many::ManyRuns;

use super::find_args::{FindArgs, checked, with_error};
use super::interrupt;
use super::lines::{listed, row, wrapped};
use super::report::{self, Interrupted, NO_CRITICAL_POINT};
use super::study::{self, Placed};

const STARTS: &str = "starts.csv";
/// So many different solutions are told.
const MOST_TOLD: usize = 12;

pub(super) fn find_from_each(args: &FindArgs) -> anyhow::Result<ExitCode> {
    let (name, text) = (args.case.name(), args.case.read_text()?);
    interrupt::start_threads();
    let starts = ManyRuns::new(&name, &text, &args.case.set, args.vary.clone());
    let starts = starts.map_err(|error| args.case.of_another_kind(error))?;
    let wanted = checked(starts.first())?;
    args.case.note(starts.first());
    let target = args.output.target(&args.case, "find")?;
    let files = OutputSet::open(target, &[STARTS, SUMMARY, CASE])?;
    files.write_text(CASE, &starts.first().to_toml())?;
    let title = args.case.headed(starts.first().title.as_deref());
    let (starts, searches) = searched(starts, args.case.quiet)?;
    let numbers = solutions(&searches);
    files.write_table(STARTS, |out| write_starts(out, &wanted, &starts, &searches, &numbers))?;
    let json = starts_summary(&wanted, starts.first().title.as_deref(), &searches, &numbers);
    let placed = Placed::new(files, &json, None)?;
    args.output.tell(args.case.quiet, &json, || told(&title, &wanted, &searches, &numbers) + &placed.written)?;
    if numbers.iter().all(Option::is_none) {
        report::warn("no search has found anything: the column message says why");
        return Ok(ExitCode::from(NO_CRITICAL_POINT));
    }
    Ok(ExitCode::SUCCESS)
}

/// Searches beside this thread, with a bar if standard error is a terminal.
fn searched(starts: ManyRuns, is_quiet: bool) -> anyhow::Result<(Arc<ManyRuns>, Vec<FromStart>)> {
    let bar = study::bar(is_quiet, starts.len(), "{bar:30} {pos}/{len} searches ({elapsed})");
    let (starts, mut result) = (Arc::new(starts), None);
    let interrupted = study::computed(
        &bar,
        &starts,
        |starts, tell: &(dyn Fn(Option<Vec<FromStart>>) + Sync)| tell(Some(find_each(starts, &|| tell(None)))),
        |news| match news {
            None => bar.inc(1),
            searches => result = searches,
        },
    );
    let searches = result.filter(|_| !interrupted).ok_or(Interrupted)?;
    Ok((starts, searches))
}

/// The lines about several searches.
fn told(title: &str, wanted: &Find, searches: &[FromStart], numbers: &[Option<usize>]) -> String {
    let found = numbers.iter().flatten().count();
    let different = numbers.iter().flatten().max().copied().unwrap_or(0);
    let head = format!("{title}: {found} of {} searches have found something, {different} different", searches.len());
    let mut text = wrapped(&head, 2);
    for number in 1..=different.min(MOST_TOLD) {
        let first = searches.iter().zip(numbers).find(|(_, own)| **own == Some(number));
        let Some(found) = first.and_then(|(search, _)| search.found()) else { continue };
        let all = wanted.unknowns.iter().zip(found.values.iter().zip(&found.errors));
        let one = all.map(|(unknown, (value, error))| format!("{} = {}", unknown.key, with_error(*value, *error)));
        let times = numbers.iter().filter(|own| **own == Some(number)).count();
        let times = if times == 1 { "once".to_owned() } else { format!("{times} times") };
        text += &row(&format!("{number}"), &format!("{}, {times}", listed(one)));
    }
    if different > MOST_TOLD {
        text += &row("", &format!("and {} more", different - MOST_TOLD));
    }
    text
}
