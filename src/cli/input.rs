//! Reading a case named on the command line.

use std::io::{self, Read};
use std::path::{Path, PathBuf};

use anyhow::Context;
use geodesic_ivp::case::builtin;
use geodesic_ivp::{Case, CaseError};

use super::{CaseArgs, report};

/// The built-in case of commands that are given none.
const DEFAULT: &str = "quartic";

/// Where a case comes from.
enum Source<'a> {
    StandardInput,
    File(&'a Path),
    /// The name of a built-in case.
    BuiltIn(&'a str),
}

impl CaseArgs {
    /// A file of that path wins over a built-in case of that name.
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

    /// Whether a case is named at all.
    pub(super) fn is_given(&self) -> bool {
        self.case.is_some()
    }

    /// Whether `--set` changes the case.
    pub(super) fn has_overrides(&self) -> bool {
        !self.set.is_empty()
    }

    /// What errors call the source.
    pub(super) fn name(&self) -> String {
        match self.source() {
            Source::StandardInput => "<stdin>".to_owned(),
            Source::File(path) => path.display().to_string(),
            Source::BuiltIn(name) => format!("<built-in {name}>"),
        }
    }

    /// The valid case. That a built-in one stands in for a file, or for no name at all, is said.
    pub(super) fn read(&self) -> anyhow::Result<Case> {
        let name = self.name();
        let mut bytes = Vec::new();
        match self.source() {
            Source::StandardInput => {
                io::stdin().read_to_end(&mut bytes).context("cannot read the case from standard input")?;
            }
            Source::File(path) => {
                bytes = std::fs::read(path).with_context(|| format!("cannot read the case file {name}"))?;
            }
            Source::BuiltIn(name) => {
                if !self.quiet {
                    report::note(&match self.is_given() {
                        true => format!("no file '{name}' here: the built-in case of that name is used"),
                        false => format!("no CASE is given: the built-in case '{name}' is used"),
                    });
                }
                return self.read_built_in(name);
            }
        }
        let text = String::from_utf8(bytes)
            .map_err(|error| CaseError::without_place(&name, format!("the case is not UTF-8 text: {error}")))?;
        Ok(Case::parse(&name, &text, &self.set)?)
    }

    /// A built-in case with the overrides of the command line.
    pub(super) fn read_built_in(&self, name: &str) -> anyhow::Result<Case> {
        let text = builtin::text(name).with_context(|| format!("there is no built-in case '{name}'"))?;
        Ok(Case::parse(&format!("<built-in {name}>"), text, &self.set)?)
    }

    /// `results/<case file stem>`.
    pub(super) fn default_output(&self) -> PathBuf {
        let stem = match self.source() {
            Source::StandardInput => None,
            Source::File(path) => path.file_stem(),
            Source::BuiltIn(name) => Some(name.as_ref()),
        };
        Path::new("results").join(stem.unwrap_or("stdin".as_ref()))
    }
}
