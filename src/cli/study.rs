//! The skeleton of all studies: they open their files, compute beside the main thread, write what there is, and say so.

use std::process::ExitCode;
use std::sync::Arc;

use clap::Args;
use geodesic_ivp::Case;
use geodesic_ivp::output::{OutputSet, SUMMARY, Target};
use geodesic_ivp::reference::ReferenceEnds;
use geodesic_ivp::study::Method;
use indicatif::{ProgressBar, ProgressStyle};

use super::CaseArgs;
use super::interrupt::run_interruptible;
use super::lines::{broken, row};
use super::out::{OutArgs, RESULTS};
use super::report::{self, INTERRUPTED, Interrupted};

/// Arguments of every study of schemes.
#[derive(Debug, Args)]
pub(super) struct StudyArgs {
    #[command(flatten)]
    pub(super) case: CaseArgs,

    #[command(flatten)]
    pub(super) output: OutArgs,

    /// Also draw pictures
    #[arg(long, help_heading = RESULTS)]
    pub(super) plot: bool,
}

/// The value of an option that is a positive number.
pub(super) fn positive(text: &str) -> Result<f64, String> {
    let parsed = text.trim().parse().ok().filter(|&value: &f64| value > 0.0 && value.is_finite());
    parsed.ok_or_else(|| "expected a positive number".to_owned())
}

/// Help begins after its label.
const HELP_COLUMNS: usize = 90;

/// Those of `all` whose names begin with one of `names`; without names all that suit the case, and those that do not.
///
/// # Errors
/// If a name is that of no method, or of one that does not suit the case.
pub(super) fn chosen(case: &Case, names: &[String], all: Vec<Method>) -> anyhow::Result<(Vec<Method>, Vec<Method>)> {
    // Only a scene may not be separable.
    let is_separable = (!case.is_of_x).then(|| case.geometry::<f64>().is_separable());
    let unsuitable = |method: &Method| method.unsuitable(is_separable?);
    let (mut methods, left_out): (Vec<_>, Vec<_>) = all.into_iter().partition(|method| unsuitable(method).is_none());
    if names.is_empty() {
        return Ok((methods, left_out));
    }
    let begins = |method: &Method, name: &str| method.label().to_lowercase().starts_with(&name.trim().to_lowercase());
    if let Some(name) = names.iter().find(|name| !methods.iter().any(|method| begins(method, name))) {
        let other = left_out.iter().find(|method| begins(method, name));
        let message = match other.and_then(|method| Some((method.label(), unsuitable(method)?))) {
            Some((label, reason)) => format!("{label} {reason}"),
            None => format!("no method is called '{name}'"),
        };
        let list = methods.iter().map(|method| method.label().replace(' ', "\u{a0}")).collect::<Vec<_>>().join(", ");
        let help = format!("the methods for this case are\n{}", broken(&list, 0, HELP_COLUMNS).trim_end());
        return Err(report::refused(message, help));
    }
    methods.retain(|method| names.iter().any(|name| begins(method, name)));
    Ok((methods, Vec::new()))
}

/// The list of values of `--methods`, for the long help.
pub(super) fn methods_help(all: &[Method]) -> String {
    format!(
        "Measure only these methods: names, or the beginnings of names [default: all that suit the case]\n\n\
         [possible values: {}]",
        all.iter().map(Method::label).collect::<Vec<_>>().join(", ")
    )
}

impl StudyArgs {
    /// Opens the tables, the summary and, where they are wanted, the pictures of a study.
    pub(super) fn open(
        &self,
        target: Target,
        tables: &[&'static str],
        pictures: &[&'static str],
    ) -> anyhow::Result<OutputSet> {
        OutputSet::open(target, &[tables, &[SUMMARY], if self.plot { pictures } else { &[] }].concat())
    }

    /// Puts the files of a study in place, prints its summary, and returns the exit code: that of `code`, unless the
    /// study was interrupted when so much was `finished`.
    pub(super) fn finish(
        &self,
        files: OutputSet,
        (summary, text): (&str, &str),
        finished: Option<String>,
        code: impl FnOnce() -> u8,
    ) -> anyhow::Result<ExitCode> {
        let placed = Placed::new(files, summary, finished)?;
        self.output.tell(self.case.quiet, summary, || format!("{text}{}", placed.written))?;
        Ok(ExitCode::from(placed.code(code)))
    }
}

/// The files of a study in their places.
pub(super) struct Placed {
    /// The line that names them.
    pub(super) written: String,
    /// If the study was interrupted, the warning of that.
    pub(super) interrupted: Option<String>,
}

impl Placed {
    /// Puts the files in place, with this text of summary.json. If the study was interrupted, so much was `finished`.
    pub(super) fn new(files: OutputSet, summary: &str, finished: Option<String>) -> anyhow::Result<Self> {
        files.write_text(SUMMARY, summary)?;
        let folder = files.folder().display().to_string();
        let written = row("written", &format!("{folder}: {}", files.commit(&|_| true)?.join(", ")));
        let interrupted = finished.map(|what| format!("interrupted: {what} were finished and are in {folder}"));
        Ok(Self { written, interrupted })
    }

    /// The exit code: that of `code`, or, with a warning, that of an interrupt.
    pub(super) fn code(&self, code: impl FnOnce() -> u8) -> u8 {
        let Some(interrupted) = &self.interrupted else { return code() };
        report::warn(interrupted);
        INTERRUPTED
    }
}

/// Prepares a study on another thread. Where it has nothing to judge by, the files of an earlier one are removed: they
/// must not be taken for its results.
pub(super) fn prepared<P: Send + Sync + 'static>(
    files: OutputSet,
    prepare: impl FnOnce() -> anyhow::Result<P> + Send + 'static,
) -> anyhow::Result<(OutputSet, Arc<P>)> {
    let mut found = None;
    let interrupted = run_interruptible(move |tell| tell(prepare()), |ready| found = Some(ready));
    match found.filter(|_| !interrupted).ok_or(Interrupted)? {
        Ok(ready) => Ok((files, Arc::new(ready))),
        Err(error) if error.is::<ReferenceEnds>() => Err(files.commit(&|_| false).err().unwrap_or(error)),
        Err(error) => Err(error),
    }
}

/// Computes on another thread, and passes what that reports to `hear` on this thread, which also moves the bar. Returns
/// whether an interrupt came before the end.
pub(super) fn computed<P: Send + Sync + 'static, T: Send + 'static>(
    bar: &ProgressBar,
    prepared: &Arc<P>,
    compute: impl FnOnce(&P, &(dyn Fn(T) + Sync)) + Send + 'static,
    hear: impl FnMut(T),
) -> bool {
    let prepared = Arc::clone(prepared);
    let interrupted = run_interruptible(move |tell| compute(&prepared, tell), hear);
    bar.finish_and_clear();
    interrupted
}

/// A progress bar, which is hidden if the command is to be quiet or standard error is no terminal.
pub(super) fn bar(is_quiet: bool, length: usize, template: &str) -> ProgressBar {
    let bar = if is_quiet { ProgressBar::hidden() } else { ProgressBar::new(length as u64) };
    bar.set_style(ProgressStyle::with_template(template).expect("the template is valid"));
    bar
}
