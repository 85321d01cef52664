//! Where a command's results go: its files, and its summary on standard output, of which a failure to write is always
//! reported.

use std::io::{self, StdoutLock, Write};
use std::path::{Path, PathBuf};

use clap::{Args, ValueHint};
use geodesic_ivp::Case;
use geodesic_ivp::output::{Origin, Target, origin_of};

use super::CaseArgs;
use super::lines::shown;
use super::report;

/// The commands that write files. Those of the first go into the folder of the case itself, those of the others into
/// folders in that one.
const COMMANDS: [&str; 6] = ["run", VARY, "find", "converge", "work-precision", "stability"];

/// The name of `run --vary` in records: it has a folder of its own.
pub(super) const VARY: &str = "vary";

/// The heading of options about what is written.
pub(super) const RESULTS: &str = "Results";

/// Arguments of every command that writes files.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = RESULTS)]
pub(super) struct OutArgs {
    /// Write results here [default: below results/<case>]
    ///
    /// Only files of an earlier command are replaced. Without --out, run writes to results/<case>, other commands to
    /// results/<case>/<command>, and converge without CASE to results/converge/<case>.
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(super) out: Option<PathBuf>,

    /// Also replace files that this program did not write
    #[arg(long)]
    force: bool,

    /// Print the summary as JSON, which is the text of summary.json
    #[arg(long, conflicts_with = "quiet")]
    pub(super) json: bool,
}

impl OutArgs {
    /// Prints the summary of a command as the options ask for it: as `json`, as `summary_text`, or not at all if it is
    /// to be quiet.
    pub(super) fn tell(&self, quiet: bool, json: &str, summary_text: impl FnOnce() -> String) -> anyhow::Result<()> {
        match (self.json, quiet) {
            (true, _) => write_data(json.as_bytes()),
            (false, true) => Ok(()),
            (false, false) => write(&summary_text()),
        }
    }

    /// Where the files of `command` go.
    ///
    /// # Errors
    /// If the record of the files in a folder cannot be read, or a JSON summary would be lost.
    pub(super) fn target(&self, case: &CaseArgs, command: &str) -> anyhow::Result<Target> {
        let origin = Origin { command: command.to_owned(), case: case.identity() };
        let folder = self.out.clone().map_or_else(|| default_folder(case, &origin), Ok)?;
        self.target_in(folder, origin)
    }

    /// That folder, for files of `origin`. It is the program's own where none is named.
    ///
    /// # Errors
    /// If JSON is asked for and standard output is closed: a computation whose summary would be lost is refused.
    pub(super) fn target_in(&self, folder: PathBuf, origin: Origin) -> anyhow::Result<Target> {
        if self.json {
            drop(for_data()?);
        }
        Ok(Target { folder, origin, own: self.out.is_none(), force: self.force })
    }

    /// Where the files of `command` go for one of several built-in cases that it takes when no case is given:
    /// `results/<command>/<case>`, or `<case>` in the folder of `--out`.
    pub(super) fn built_in_target(&self, case: &str, command: &str) -> anyhow::Result<Target> {
        let folder = self.out.clone().unwrap_or_else(|| Path::new("results").join(command)).join(case);
        let origin = Origin { command: command.to_owned(), case: format!("<built-in {case}>") };
        self.target_in(folder, origin)
    }
}

/// Refuses to write where the run is that `case` continues: its files would be replaced, and with them its end.
///
/// # Errors
/// If the folder of `target` is that of the summary.
pub(super) fn keep_source(case: &Case, target: &Target) -> anyhow::Result<()> {
    let source = case.continues.as_ref().and_then(|summary| summary.canonicalize().ok()?.parent().map(Path::to_owned));
    if source.is_none() || source != target.folder.canonicalize().ok() {
        return Ok(());
    }
    let folder = target.folder.display();
    let message = format!("{folder} holds the run that this one continues, and its files would be replaced");
    Err(report::refused(message, "write to another folder with --out"))
}

/// The folder for the results of a command without `--out`. For `run` it is `results/<case file stem>` or, if that has
/// the results of another case with the same file name, the first of `results/<case file stem>-2`, … that has not.
/// Other commands have a folder in it.
fn default_folder(case: &CaseArgs, origin: &Origin) -> anyhow::Result<PathBuf> {
    let results = Path::new("results");
    let first = results.join(case.stem());
    let mut home = first.clone();
    let mut owner = None;
    for number in 2.. {
        let Some(other) = other_case(&home, origin)? else { break };
        owner.get_or_insert(other);
        let mut name = case.stem().to_owned();
        name.push(format!("-{number}"));
        home = results.join(name);
    }
    if let Some(owner) = owner.filter(|_| !case.quiet) {
        let (first, home) = (first.display(), home.display());
        report::note(&format!("{first} holds results of {owner}: those of {} go to {home}", origin.case));
    }
    Ok(folder_of(&home, &origin.command))
}

/// The case whose results are in `home`, if it is not the case of `origin`.
fn other_case(home: &Path, origin: &Origin) -> anyhow::Result<Option<String>> {
    for command in COMMANDS {
        if let Some(other) = origin_of(&folder_of(home, command))?.filter(|other| other.case != origin.case) {
            return Ok(Some(other.case));
        }
    }
    Ok(None)
}

fn folder_of(home: &Path, command: &str) -> PathBuf {
    if command == COMMANDS[0] { home.to_owned() } else { home.join(command) }
}

/// Writes `text`, which is for people, and flushes it, so that a full disk is noticed before the program ends.
pub(super) fn write(text: &str) -> anyhow::Result<()> {
    let mut out = io::stdout().lock();
    out.write_all(shown(text).as_bytes())?;
    Ok(out.flush()?)
}

/// Writes `bytes`, which are the whole output of a command.
pub(super) fn write_data(bytes: &[u8]) -> anyhow::Result<()> {
    let mut out = for_data()?;
    out.write_all(bytes)?;
    Ok(out.flush()?)
}

/// Standard output for data that is not kept anywhere else.
pub(super) fn for_data() -> anyhow::Result<StdoutLock<'static>> {
    if is_closed() {
        return Err(report::refused_by_system(
            "standard output is closed: nothing takes the data",
            "redirect it to a file or a pipe (/dev/null opened for reading and writing looks the same as closed)",
        ));
    }
    Ok(io::stdout().lock())
}

/// Returns true if standard output is closed.
///
/// Before `main` begins, the standard library opens /dev/null for reading and writing in place of a closed standard
/// stream. A user who redirects to /dev/null usually opens it for writing only. If it is open for both, standard output
/// is taken to be closed, since what is written to it is lost in any case.
#[cfg(target_os = "linux")]
fn is_closed() -> bool {
    use rustix::fs::{FileType, OFlags, fcntl_getfl, fstat, stat};
    let (Ok(null), Ok(found)) = (stat("/dev/null"), fstat(io::stdout())) else { return false };
    FileType::from_raw_mode(null.st_mode) == FileType::CharacterDevice
        && (found.st_mode, found.st_rdev) == (null.st_mode, null.st_rdev)
        && fcntl_getfl(io::stdout()).is_ok_and(|flags| flags.contains(OFlags::RDWR))
}

/// On other systems the standard library gives no way to tell.
#[cfg(not(target_os = "linux"))]
fn is_closed() -> bool {
    false
}
