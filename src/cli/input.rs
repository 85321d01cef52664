//! Reading a case named on the command line.

use std::ffi::OsStr;
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use anyhow::Context;
use geodesic_ivp::case::{MOST_OF_CASE, builtin, read_at_most};
use geodesic_ivp::formula::similar::nearest;
use geodesic_ivp::{Case, CaseError};

use super::CaseArgs;
use super::lines::{listed, shown};
use super::report;

/// The built-in case that is used by commands to which no case is given.
const DEFAULT: &str = "quartic";

/// Where a case comes from.
enum Source<'a> {
    StandardInput,
    File(&'a Path),
    /// The name of a built-in case.
    BuiltIn(&'a str),
}

impl CaseArgs {
    /// The source that the argument names. A file takes precedence over a built-in case of the same name.
    fn source(&self) -> Source<'_> {
        let Some(path) = self.case.as_deref() else { return Source::BuiltIn(DEFAULT) };
        if path == Path::new("-") {
            return Source::StandardInput;
        }
        let is_file = path.metadata().is_ok_and(|metadata| !metadata.is_dir());
        match path.to_str().filter(|name| !is_file && builtin::NAMES.contains(name)) {
            Some(name) => Source::BuiltIn(name),
            None => Source::File(path),
        }
    }

    /// The name of a built-in case that nothing changes, if the case is one.
    pub(super) fn unchanged(&self) -> Option<&str> {
        match self.source() {
            Source::BuiltIn(name) if self.set.is_empty() => Some(name),
            _ => None,
        }
    }

    /// The name of the source in error messages.
    pub(super) fn name(&self) -> String {
        match self.source() {
            Source::StandardInput => "<stdin>".to_owned(),
            Source::File(path) => shown(&path.display().to_string()),
            Source::BuiltIn(name) => format!("<built-in {name}>"),
        }
    }

    /// Identifies the case in the record of a result folder. For a file it is its path, relative to the current folder
    /// if the file is inside that.
    pub(super) fn identity(&self) -> String {
        let Source::File(path) = self.source() else { return self.name() };
        let path = path.canonicalize().unwrap_or_else(|_| path.to_owned());
        let here = std::env::current_dir().and_then(|here| here.canonicalize()).unwrap_or_default();
        path.strip_prefix(here).unwrap_or(&path).display().to_string()
    }

    /// The title, or the name of the case if there is none.
    pub(super) fn headed(&self, title: Option<&str>) -> String {
        title.map_or_else(|| shown(&self.stem().to_string_lossy()), str::to_owned)
    }

    /// The name for the folder of results: the stem of the case's file, or the name of a built-in case.
    pub(super) fn stem(&self) -> &OsStr {
        let stem = match self.source() {
            Source::StandardInput => None,
            // The stem of `...toml` would be the folder above.
            Source::File(path) => path.file_stem().filter(|stem| *stem != "." && *stem != "..").or(path.file_name()),
            Source::BuiltIn(name) => Some(name.as_ref()),
        };
        stem.unwrap_or("stdin".as_ref())
    }

    /// Reads the case. Prints a note if a built-in case is used because none was named.
    pub(super) fn read(&self) -> anyhow::Result<Case> {
        let text = self.read_text()?;
        let case = Case::parse(&self.name(), &text, &self.set).map_err(|error| self.of_another_kind(error))?;
        self.note(&case);
        Ok(case)
    }

    /// Prints the notes on a case.
    pub(super) fn note(&self, case: &Case) {
        if !self.quiet {
            case.notes().iter().for_each(|note| report::note(note));
        }
    }

    /// Reads a case for a study of schemes, of which none knows events that act.
    pub(super) fn read_for_study(&self) -> anyhow::Result<Case> {
        let case = self.read()?;
        if case.has_acting_events() {
            let help = "take their `set` out, or use run, run --vary and check";
            return Err(report::refused("this study of schemes knows no events that act", help));
        }
        Ok(case)
    }

    /// Reads the text of a case, with the same note.
    pub(super) fn read_text(&self) -> anyhow::Result<String> {
        let name = self.name();
        let bytes = match self.source() {
            Source::StandardInput => at_most(io::stdin(), None, &name)?,
            Source::File(path) => {
                if path.is_dir() {
                    return Err(unreadable(path, "it is a folder"));
                }
                let file = File::open(path).map_err(|error| unreadable(path, &error.to_string()))?;
                let size = file.metadata().ok().map(|metadata| metadata.len());
                at_most(file, size, &name)?
            }
            Source::BuiltIn(built_in) => {
                if !self.quiet && self.case.is_none() {
                    report::note(&format!("no CASE is given: the built-in case '{built_in}' is used"));
                }
                return Ok(built_in_text(built_in).to_owned());
            }
        };
        let text = String::from_utf8(bytes)
            .map_err(|error| CaseError::without_place(&name, format!("the case is not UTF-8 text: {error}")));
        Ok(text.map_err(|error| self.of_another_kind(error))?)
    }

    /// A built-in case with the overrides of the command line.
    pub(super) fn read_built_in(&self, name: &str) -> anyhow::Result<Case> {
        Ok(Case::parse(&format!("<built-in {name}>"), built_in_text(name), &self.set)?)
    }

    /// Adds to an error, if the file's name says that it is not TOML, that a case has to be.
    pub(super) fn of_another_kind(&self, mut error: CaseError) -> CaseError {
        if let Source::File(path) = self.source() {
            let extension = path.extension().and_then(OsStr::to_str);
            if let (Some(extension), None) = (extension.filter(|extension| *extension != "toml"), &error.help) {
                error.help =
                    Some(format!("a case is a TOML file, not .{extension}: `init quartic` writes one to start from"));
            }
        }
        error
    }
}

fn built_in_text(name: &str) -> &'static str {
    builtin::text(name).expect("the name is that of a built-in case")
}

/// Reads all bytes, or fails if there are too many for a case.
fn at_most(reader: impl Read, size: Option<u64>, name: &str) -> anyhow::Result<Vec<u8>> {
    let too_long = |error: &io::Error| error.kind() == io::ErrorKind::FileTooLarge;
    let read = read_at_most(reader, MOST_OF_CASE);
    if !read.as_ref().err().is_some_and(too_long) {
        return read.with_context(|| format!("cannot read the case {name}"));
    }
    // A device says that it has no bytes.
    let size = size.filter(|size| *size > MOST_OF_CASE);
    let found = size.map_or_else(|| "more".to_owned(), |size| size.to_string());
    let message = format!("too long for a case: it has {found} bytes, {MOST_OF_CASE} at most");
    Err(CaseError::without_place(name, message).into())
}

/// The error for a case file that cannot be read. It suggests a built-in case of a similar name, or those that begin
/// so.
fn unreadable(path: &Path, reason: &str) -> anyhow::Error {
    let stem = path.file_stem().and_then(OsStr::to_str).unwrap_or_default();
    let begin_so = builtin::NAMES.iter().filter(|name| !stem.is_empty() && name.starts_with(stem));
    let mut begin_so = begin_so.map(|name| format!("`{name}`")).peekable();
    let help = match nearest(stem, builtin::NAMES.iter().copied()) {
        Some(name) => format!("there is a built-in case `{name}`"),
        None if begin_so.peek().is_some() => format!("there are built-in cases {}", listed(begin_so)),
        None => "name a TOML file or a built-in case: `init --list` names these".to_owned(),
    };
    report::refused_by_system(format!("cannot read the case file {}: {reason}", path.display()), help)
}
