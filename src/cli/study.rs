//! The skeleton of all studies: they open their files, compute beside the main thread, write what there is, and say so.

use std::process::ExitCode;
use std::sync::Arc;

use geodesic_ivp::Case;
use geodesic_ivp::output::{OutputSet, SUMMARY, Target};
use geodesic_ivp::reference::ReferenceEnds;
use indicatif::{ProgressBar, ProgressStyle};

use super::CaseArgs;
use super::interrupt::{INTERRUPTED, beside_it};
use super::lines::{broken, row};
use super::out::OutArgs;
use super::report;

/// The value of an option that is a positive number.
pub(super) fn positive(text: &str) -> Result<f64, String> {
    let parsed = text.trim().parse().ok().filter(|&value: &f64| value > 0.0 && value.is_finite());
    parsed.ok_or_else(|| "expected a positive number".to_owned())
}

/// Help begins after its label.
const HELP_COLUMNS: usize = 90;

/// The methods whose names begin with one of `names`, and those that are left out although nobody said so.
pub(super) type Chosen<M> = (Vec<M>, Vec<M>);

/// Those of `all` whose names begin with one of `names`; without names all that suit the case.
///
/// # Errors
/// If a name is that of no method, or of one that does not suit the case.
pub(super) fn chosen<M>(
    case: &Case,
    names: &[String],
    all: Vec<M>,
    label: impl Fn(&M) -> String,
    unsuitable: impl Fn(&M, bool) -> Option<&'static str>,
) -> anyhow::Result<Chosen<M>> {
    // Only a scene may not be separable.
    let is_separable = (!case.is_of_x).then(|| case.geometry::<f64>().is_separable());
    let unsuitable = |method: &M| unsuitable(method, is_separable?);
    let (methods, left_out): Chosen<M> = all.into_iter().partition(|method| unsuitable(method).is_none());
    if names.is_empty() {
        return Ok((methods, left_out));
    }
    let begins = |method: &M, name: &str| label(method).to_lowercase().starts_with(&name.trim().to_lowercase());
    if let Some(name) = names.iter().find(|name| !methods.iter().any(|method| begins(method, name))) {
        let other = left_out.iter().find(|method| begins(method, name));
        let message = match other.and_then(|method| Some((label(method), unsuitable(method)?))) {
            Some((label, reason)) => format!("{label} {reason}"),
            None => format!("no method is called '{name}'"),
        };
        let list = methods.iter().map(|method| label(method).replace(' ', "\u{a0}")).collect::<Vec<_>>().join(", ");
        let help = format!("the methods for this case are\n{}", broken(&list, 0, HELP_COLUMNS).trim_end());
        return Err(report::refused(message, help));
    }
    let methods = methods.into_iter().filter(|method| names.iter().any(|name| begins(method, name))).collect();
    Ok((methods, Vec::new()))
}

/// The list of values of `--methods`, for the long help.
pub(super) fn methods_help(names: impl Iterator<Item = String>) -> String {
    format!(
        "Measure only these methods: names, or the beginnings of names [default: all that suit the case]\n\n\
         [possible values: {}]",
        names.collect::<Vec<_>>().join(", ")
    )
}

/// Opens the files of a study of one case, of which the JSON summary must not be lost.
pub(super) fn begin(
    (case, output): (&CaseArgs, &OutArgs),
    command: &str,
    tables: &[&'static str],
    pictures: Option<&[&'static str]>,
) -> anyhow::Result<OutputSet> {
    output.check_standard_output()?;
    open(output.target(case, command)?, tables, pictures)
}

/// Opens the tables, the summary and, where they are wanted, the pictures of a study.
pub(super) fn open(
    target: Target,
    tables: &[&'static str],
    pictures: Option<&[&'static str]>,
) -> anyhow::Result<OutputSet> {
    OutputSet::open(target, &[tables, &[SUMMARY], pictures.unwrap_or_default()].concat())
}

/// The error of a study that did not begin. Where it has nothing to judge by, the files of an earlier one are removed:
/// they must not be taken for its results.
pub(super) fn without_results(files: OutputSet, error: anyhow::Error) -> anyhow::Error {
    let committed = if error.is::<ReferenceEnds>() { files.commit(&|_| false) } else { Ok(Vec::new()) };
    committed.err().unwrap_or(error)
}

/// A progress bar, which is hidden if the command is to be quiet or standard error is no terminal.
pub(super) fn bar(is_quiet: bool, length: usize, template: &str) -> ProgressBar {
    let bar = if is_quiet { ProgressBar::hidden() } else { ProgressBar::new(length as u64) };
    bar.set_style(ProgressStyle::with_template(template).expect("the template is valid"));
    bar
}

/// A report of a thread.
enum News<P, T, E> {
    Ready(Arc<P>),
    Impossible(E),
    Done(T),
}

/// Prepares and computes on another thread, and passes what `compute` reports to `hear` on this thread, which also
/// moves the bar. Returns what was prepared, and whether an interrupt came before the end; `None` if it came before
/// that was ready.
///
/// # Errors
/// The result of `prepare`.
pub(super) fn computed<P: Send + Sync + 'static, T: Send + 'static, E: Send + 'static>(
    bar: &ProgressBar,
    prepare: impl FnOnce() -> Result<P, E> + Send + 'static,
    compute: impl FnOnce(&P, &(dyn Fn(T) + Sync)) + Send + 'static,
    mut hear: impl FnMut(&P, T),
) -> Result<Option<(Arc<P>, bool)>, E> {
    let work = move |tell: &(dyn Fn(News<P, T, E>) + Sync)| match prepare() {
        Ok(ready) => {
            let ready = Arc::new(ready);
            tell(News::Ready(Arc::clone(&ready)));
            compute(&ready, &|news| tell(News::Done(news)));
        }
        Err(error) => tell(News::Impossible(error)),
    };
    let mut found = Ok(None);
    let interrupted = beside_it(work, |news| match (news, &found) {
        (News::Ready(ready), _) => found = Ok(Some(ready)),
        (News::Impossible(error), _) => found = Err(error),
        (News::Done(news), Ok(Some(ready))) => hear(ready, news),
        (News::Done(_), _) => unreachable!("nothing is computed before it is prepared"),
    });
    bar.finish_and_clear();
    Ok(found?.map(|ready| (ready, interrupted)))
}

/// The outcome of a study.
pub(super) struct Finished {
    pub(super) files: OutputSet,
    /// The text of summary.json.
    pub(super) summary: String,
    /// The lines for people.
    pub(super) text: String,
    /// If the study was interrupted, what was finished.
    pub(super) interrupted: Option<String>,
}

impl Finished {
    /// Puts the files in place, and returns the line that names them. Warns if the study was interrupted.
    pub(super) fn commit(self) -> anyhow::Result<Committed> {
        let Self { files, summary, text, interrupted } = self;
        let folder = files.folder().display().to_string();
        files.write_text(SUMMARY, &summary)?;
        let written = row("written", &format!("{folder}: {}", files.commit(&|_| true)?.join(", ")));
        let interrupted = interrupted.map(|what| format!("interrupted: {what} were finished and are in {folder}"));
        Ok(Committed { summary, text, written, interrupted })
    }
}

/// A study whose files are in place.
pub(super) struct Committed {
    pub(super) summary: String,
    pub(super) text: String,
    pub(super) written: String,
    /// If the study was interrupted, the warning of that.
    pub(super) interrupted: Option<String>,
}

impl Committed {
    /// Prints the summary, and returns the exit code: `code`, unless the study was interrupted.
    pub(super) fn tell(&self, is_quiet: bool, output: &OutArgs, code: impl FnOnce() -> u8) -> anyhow::Result<ExitCode> {
        output.tell(is_quiet, &self.summary, || format!("{}{}", self.text, self.written))?;
        Ok(self.ending(code))
    }

    /// The exit code, with a warning if the study was interrupted.
    pub(super) fn ending(&self, code: impl FnOnce() -> u8) -> ExitCode {
        let Some(interrupted) = &self.interrupted else { return ExitCode::from(code()) };
        report::warn(interrupted);
        ExitCode::from(INTERRUPTED)
    }
}
