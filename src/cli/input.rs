//! Reading a case named on the command line.

use std::io::{self, Read};
use std::path::{Path, PathBuf};

use anyhow::Context;
use geodesic_ivp::{Case, CaseError};

use super::CaseArgs;

impl CaseArgs {
    fn is_standard_input(&self) -> bool {
        self.case == Path::new("-")
    }

    /// Whether `--set` changes the case.
    pub(super) fn has_overrides(&self) -> bool {
        !self.set.is_empty()
    }

    /// What errors call the source.
    pub(super) fn name(&self) -> String {
        if self.is_standard_input() { "<stdin>".to_owned() } else { self.case.display().to_string() }
    }

    /// The valid case.
    pub(super) fn read(&self) -> anyhow::Result<Case> {
        let name = self.name();
        let mut bytes = Vec::new();
        if self.is_standard_input() {
            io::stdin().read_to_end(&mut bytes).context("cannot read the case from standard input")?;
        } else {
            bytes = std::fs::read(&self.case).with_context(|| format!("cannot read the case file {name}"))?;
        }
        let text = String::from_utf8(bytes)
            .map_err(|error| CaseError::without_place(&name, format!("the case is not UTF-8 text: {error}")))?;
        Ok(Case::parse(&name, &text, &self.set)?)
    }

    /// `results/<case file stem>`.
    pub(super) fn default_output(&self) -> PathBuf {
        let stem = if self.is_standard_input() { None } else { self.case.file_stem() };
        Path::new("results").join(stem.unwrap_or("stdin".as_ref()))
    }
}
