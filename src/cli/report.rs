//! Errors and warnings on standard error, and the exit code of each error.

use std::io::{self, IsTerminal, Write};

use annotate_snippets::{AnnotationKind, Group, Level, Renderer, Snippet};
use geodesic_ivp::output::Refused;
pub(super) use geodesic_ivp::output::{refused, refused_by_system};
use geodesic_ivp::reference::{EndReason, ReferenceEnds};
use geodesic_ivp::study::find::NotFound;
use geodesic_ivp::{CaseError, NoSolution, Status};

use super::lines::shown;

/// The exit code of an interrupted command.
pub(super) const INTERRUPTED: u8 = 130;

/// The error of a study that was interrupted before it had anything to write. The files of an earlier one stay.
#[derive(Debug, thiserror::Error)]
#[error("interrupted before anything was finished: no file was written")]
pub(super) struct Interrupted;

/// The error of a solved case that differs from its `[expect]` table: one phrase for each difference.
#[derive(Debug, thiserror::Error)]
#[error("the case does not meet its [expect] table: {}", .0.join("; "))]
pub(super) struct ExpectationNotMet(pub(super) Vec<String>);

/// The remedy for a reference that ends early, and the exit code.
fn of_reference(reason: EndReason) -> (&'static str, u8) {
    match reason {
        EndReason::OutsideDomain => ("end the run before the geodesic leaves the domain", OUTSIDE_DOMAIN),
        EndReason::Singular => ("end the run before that point", NO_CRITICAL_POINT),
        EndReason::TimeNotReached => ("give gamma_f instead of t_f, or an earlier t_f", NO_CRITICAL_POINT),
        EndReason::TooLong { .. } => ("choose a shorter run, or fewer digits", NO_CRITICAL_POINT),
    }
}

/// The page about results, whose tables the manual page has, too.
pub(super) const RESULTS: &str = include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/docs/results.md"));

/// The rows of the table of a page that has this heading, without the marks of code.
pub(super) fn rows<const N: usize>(page: &'static str, heading: &str) -> impl Iterator<Item = [String; N]> {
    let rows = page.lines().skip_while(move |line| *line != heading).skip(2).take_while(|line| line.starts_with('|'));
    rows.map(|line| {
        let mut cells = line.trim_matches('|').split('|').map(|cell| cell.trim().replace('`', ""));
        std::array::from_fn(|_| cells.next().unwrap_or_default())
    })
}

/// Every exit code and its meaning.
pub(super) fn exit_codes() -> impl Iterator<Item = [String; 2]> {
    rows(RESULTS, "| code | meaning |")
}

/// So many mistakes in a case are shown.
const MOST_MISTAKES: usize = 8;

const IO_FAILURE: u8 = 1;
pub(super) const INVALID_CASE: u8 = 2;
pub(super) const NO_CRITICAL_POINT: u8 = 3;
pub(super) const OUTSIDE_DOMAIN: u8 = 4;
const EXPECTATION: u8 = 5;

/// The exit code of a solve that ends without a solution.
pub(super) fn code_of(status: Status) -> u8 {
    if status == Status::OutsideDomain { OUTSIDE_DOMAIN } else { NO_CRITICAL_POINT }
}

/// Prints `error` for people and returns its exit code. A pipe whose reader has closed it is not an error.
pub(super) fn explain(error: &anyhow::Error) -> u8 {
    if is_broken_pipe(error) {
        return 0;
    }
    if let Some(case) = error.downcast_ref::<CaseError>() {
        print_case_error(case);
        return INVALID_CASE;
    }
    if error.is::<Interrupted>() {
        warn(&error.to_string());
        return INTERRUPTED;
    }
    let (help, code) = if let Some(failure) = error.downcast_ref::<NoSolution>() {
        (failure.advice(), code_of(failure.status))
    } else if let Some(none) = error.downcast_ref::<NotFound>() {
        (none.advice.as_str(), if none.is_outside { OUTSIDE_DOMAIN } else { NO_CRITICAL_POINT })
    } else if let Some(end) = error.downcast_ref::<ReferenceEnds>() {
        of_reference(end.reason)
    } else if let Some(refused) = error.downcast_ref::<Refused>() {
        (refused.help.as_str(), if refused.is_usage { INVALID_CASE } else { IO_FAILURE })
    } else if is_beyond_limit(error) {
        ("a limit of the size of files was reached: raise it (ulimit -f)", IO_FAILURE)
    } else {
        ("", if error.is::<ExpectationNotMet>() { EXPECTATION } else { IO_FAILURE })
    };
    print(&rendered(Group::with_title(Level::ERROR.primary_title(format!("{error:#}"))), help));
    code
}

/// Prints a warning.
pub(super) fn warn(message: &str) {
    print(&rendered(Group::with_title(Level::WARNING.primary_title(message)), ""));
}

/// Prints a note: something that a user should know although nothing is wrong.
pub(super) fn note(message: &str) {
    print(&rendered(Group::with_title(Level::NOTE.primary_title(message)), ""));
}

/// Prints a mistake in a case, and those that were found with it.
fn print_case_error(error: &CaseError) {
    let all: Vec<&CaseError> = std::iter::once(error).chain(&error.further).collect();
    let shown: Vec<String> = all.iter().take(MOST_MISTAKES).map(|error| render_case_error(error)).collect();
    print(&shown.join("\n"));
    if let Some(more) = all.len().checked_sub(MOST_MISTAKES + 1) {
        note(&format!("{} more mistakes follow", more + 1));
    }
}

fn render_case_error(error: &CaseError) -> String {
    // With a place, the snippet names the file. Without one, the message has to.
    let title = match error.span {
        Some(_) => error.message.clone(),
        None => format!("{}: {}", error.source_name, error.message),
    };
    let mut group = Group::with_title(Level::ERROR.primary_title(title));
    if let Some(span) = &error.span {
        let snippet = Snippet::source(&*error.text)
            .path(&*error.source_name)
            .annotation(AnnotationKind::Primary.span(span.clone()));
        group = group.element(snippet);
    }
    rendered(group, error.help.as_deref().unwrap_or_default())
}

/// A message and, if there is any, what to do about it.
fn rendered<'m>(message: Group<'m>, help: &'m str) -> String {
    let help = shown(help);
    let message = if help.is_empty() { message } else { message.element(Level::HELP.message(help.as_str())) };
    let colours = io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none();
    let renderer = if colours { Renderer::styled() } else { Renderer::plain() };
    renderer.render(&[message])
}

fn print(text: &str) {
    // If standard error is closed, there is no other way to report that.
    let _ = writeln!(io::stderr(), "{text}");
}

fn is_broken_pipe(error: &anyhow::Error) -> bool {
    is_of_system(error, io::ErrorKind::BrokenPipe)
}

/// Returns true if the system did not let a file grow.
fn is_beyond_limit(error: &anyhow::Error) -> bool {
    is_of_system(error, io::ErrorKind::FileTooLarge)
}

/// Returns true if the system, and not this program, gave this reason.
fn is_of_system(error: &anyhow::Error, kind: io::ErrorKind) -> bool {
    error.chain().any(|cause| {
        let csv = cause.downcast_ref::<csv::Error>().and_then(|error| match error.kind() {
            csv::ErrorKind::Io(error) => Some(error),
            _ => None,
        });
        let io = cause.downcast_ref::<io::Error>().or(csv);
        io.is_some_and(|error| error.kind() == kind && error.raw_os_error().is_some())
    })
}
