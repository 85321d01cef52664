//! The skeleton of all studies: they open their files, compute beside the main thread, write what there is, and say so.

use std::process::ExitCode;
use std::sync::Arc;

use geodesic_ivp::output::{OutputSet, SUMMARY, Target};
use indicatif::{ProgressBar, ProgressStyle};

use super::interrupt::{INTERRUPTED, beside_it};
use super::out::OutArgs;
use super::report;

/// The value of an option that is a positive number.
pub(super) fn positive(text: &str) -> Result<f64, String> {
    let parsed = text.trim().parse().ok().filter(|&value: &f64| value > 0.0 && value.is_finite());
    parsed.ok_or_else(|| "expected a positive number".to_owned())
}

/// Opens the tables, the summary and, where they are wanted, the pictures of a study.
pub(super) fn open(
    target: Target,
    tables: &[&'static str],
    pictures: Option<&[&'static str]>,
) -> anyhow::Result<OutputSet> {
    OutputSet::open(target, &[tables, &[SUMMARY], pictures.unwrap_or_default()].concat())
}

/// The error of a study without anything to judge by. The files of an earlier one are removed: they must not be taken
/// for its results.
pub(super) fn without_results(files: OutputSet, error: impl Into<anyhow::Error>) -> anyhow::Error {
    files.commit(&|_| false).err().unwrap_or_else(|| error.into())
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

/// Prepares and computes on another thread, and passes what `compute` reports to `hear` on this thread. Returns what
/// was prepared, and whether an interrupt came before the end; `None` if it came before that was ready.
///
/// # Errors
/// The result of `prepare`.
pub(super) fn computed<P: Send + Sync + 'static, T: Send + 'static, E: Send + 'static>(
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
        let folder = files.folder().to_owned();
        files.write_text(SUMMARY, &summary)?;
        let written = report::written(&folder, &files.commit(&|_| true)?);
        let interrupted =
            interrupted.map(|what| format!("interrupted: {what} were finished and are in {}", folder.display()));
        Ok(Committed { summary, text, written, interrupted })
    }
}

/// A study whose files are in place.
pub(super) struct Committed {
    pub(super) summary: String,
    pub(super) text: String,
    pub(super) written: String,
    interrupted: Option<String>,
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

    /// Returns true if it was interrupted.
    pub(super) fn is_interrupted(&self) -> bool {
        self.interrupted.is_some()
    }
}
