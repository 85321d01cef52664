//! Where a command's results go: its files, and its summary on standard output.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use clap::{Args, ValueHint};
use geodesic_ivp::output::{Origin, Target, origin_of};

use super::{CaseArgs, report, stdout};

/// The commands that write files. Those of the first go into the folder of the case itself, those of the others into
/// folders in that one.
const COMMANDS: [&str; 5] = ["run", VARY, "converge", "work-precision", "stability"];

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
    out: Option<PathBuf>,

    /// Also replace files that this program did not write
    #[arg(long)]
    force: bool,

    /// Print the summary as JSON, which is the text of summary.json
    #[arg(long, conflicts_with = "quiet")]
    json: bool,
}

impl OutArgs {
    /// Returns true if a folder is named.
    pub(super) fn is_named(&self) -> bool {
        self.out.is_some()
    }

    /// Makes the folder that is named, if one is, the one called `name` in it.
    pub(super) fn go_below(&mut self, name: &OsStr) {
        self.out = self.out.take().map(|folder| folder.join(name));
    }

    /// Refuses a computation whose JSON summary would be lost.
    ///
    /// # Errors
    /// If JSON is asked for and standard output is closed.
    pub(super) fn check_standard_output(&self) -> anyhow::Result<()> {
        if self.json { stdout::for_data().map(drop) } else { Ok(()) }
    }

    /// Returns true if the summary is printed for people, who read there what is doubtful.
    pub(super) fn is_for_people(&self, quiet: bool) -> bool {
        !self.json && !quiet
    }

    /// Prints the summary of a command as the options ask for it: as `json`, as `readable`, or not at all if it is to
    /// be quiet.
    ///
    /// # Errors
    /// If standard output is closed or cannot be written.
    pub(super) fn tell(&self, quiet: bool, json: &str, readable: impl FnOnce() -> String) -> anyhow::Result<()> {
        match (self.json, quiet) {
            (true, _) => stdout::write_data(json.as_bytes()),
            (false, true) => Ok(()),
            (false, false) => stdout::write(&readable()),
        }
    }

    /// Where the files of `command` go.
    ///
    /// # Errors
    /// If the record of the files in a folder cannot be read.
    pub(super) fn target(&self, case: &CaseArgs, command: &str) -> anyhow::Result<Target> {
        let origin = Origin { command: command.to_owned(), case: case.identity() };
        let (folder, own) = match &self.out {
            Some(folder) => (folder.clone(), false),
            None => (default_folder(case, &origin)?, true),
        };
        Ok(Target { folder, origin, own, force: self.force })
    }

    /// The folder of `--out`, for files of `origin`.
    pub(super) fn named_target(&self, origin: Origin) -> Target {
        Target { folder: self.out.clone().unwrap_or_default(), origin, own: false, force: self.force }
    }

    /// Where the files of `command` go for one of several built-in cases that it takes when no case is given:
    /// `results/<command>/<case>`, or `<case>` in the folder of `--out`.
    pub(super) fn built_in_target(&self, case: &str, command: &str) -> Target {
        let folder = self.out.clone().unwrap_or_else(|| Path::new("results").join(command)).join(case);
        let origin = Origin { command: command.to_owned(), case: format!("<built-in {case}>") };
        Target { folder, origin, own: self.out.is_none(), force: self.force }
    }
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
