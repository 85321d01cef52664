//! Reading a case named on the command line.

use std::io::{self, Read};
use std::path::{Path, PathBuf};

use anyhow::Context;
use geodesic_ivp::Case;

use super::CaseArgs;

impl CaseArgs {
    fn is_standard_input(&self) -> bool {
        self.case == Path::new("-")
    }

    /// The valid case.
    pub(super) fn read(&self) -> anyhow::Result<Case> {
        let (name, text) = if self.is_standard_input() {
            let mut text = String::new();
            io::stdin().read_to_string(&mut text).context("cannot read the case from standard input")?;
            ("<stdin>".to_owned(), text)
        } else {
            let name = self.case.display().to_string();
            let text =
                std::fs::read_to_string(&self.case).with_context(|| format!("cannot read the case file {name}"))?;
            (name, text)
        };
        Ok(Case::parse(&name, &text, &self.set)?)
    }

    /// `results/<case file stem>`.
    pub(super) fn default_output(&self) -> PathBuf {
        let stem = if self.is_standard_input() { None } else { self.case.file_stem() };
        Path::new("results").join(stem.unwrap_or("stdin".as_ref()))
    }
}
