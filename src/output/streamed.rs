//! Tables of a run that is handed out part by part, each in a file of its own: a run may have to begin again, and what
//! was written before is void then.

use std::fs::File;
use std::io::{Seek, Write};

use super::tables::{Rows, everything, numbers, state_header, write_rows, write_table};
use crate::diagnostics::Diagnostics;
use crate::number::Real;
use crate::solve::WorldLine;
use crate::trajectory::Sample;

/// A table with the columns of both tables of a run that is handed out part by part, in a file of its own.
#[derive(Debug)]
pub struct StreamedTable {
    file: File,
    every: usize,
    /// True if there are several windows, if that is known before the run.
    has_windows: Option<bool>,
    /// Otherwise the first window with their column, until there is a second one.
    first: Vec<u8>,
    /// The file that could not be written.
    error: Option<csv::Error>,
}

impl StreamedTable {
    /// A table in an empty file.
    pub fn new(file: File, every: usize, has_windows: Option<bool>) -> Self {
        Self { file, every, has_windows, first: Vec::new(), error: None }
    }

    /// Adds a part of the run, with what was measured on it alone. It must continue the previous one or, if it contains
    /// the first window, begins the run again.
    pub fn see<S: Real>(&mut self, part: &WorldLine<S>, measured: &Diagnostics<S>) {
        if self.error.is_none() {
            self.error = self.add(part, measured).err();
        }
    }

    fn add<S: Real>(&mut self, part: &WorldLine<S>, measured: &Diagnostics<S>) -> csv::Result<()> {
        let has_header = part.window_count == part.windows.len();
        let has_windows = self.has_windows.unwrap_or(!has_header || part.windows.len() > 1);
        let rows = |has_windows| Rows { has_header, has_windows, every: self.every };
        let first = std::mem::take(&mut self.first);
        if has_header || !first.is_empty() {
            self.file.set_len(0)?;
            self.file.rewind()?;
        }
        if !has_header {
            self.file.write_all(&first)?;
        } else if self.has_windows.is_none() && !has_windows {
            write_table(&mut self.first, part, rows(true), everything(part, measured))?;
        }
        write_table(&mut self.file, part, rows(has_windows), everything(part, measured))
    }

    /// The file with the whole table, at its beginning.
    ///
    /// # Errors
    /// If it could not be written.
    pub fn finish(mut self) -> csv::Result<File> {
        if let Some(error) = self.error {
            return Err(error);
        }
        self.file.rewind()?;
        Ok(self.file)
    }
}

/// The samples of a run that keeps none of them.
#[derive(Debug)]
pub struct StreamedSamples {
    file: File,
    /// The headings.
    header: Vec<String>,
    digits: u32,
    is_begun: bool,
    error: Option<csv::Error>,
}

impl StreamedSamples {
    /// Samples of these coordinates in an empty file. Extended numbers have `digits` significant digits.
    pub fn new(file: File, names: &[String], digits: u32) -> Self {
        Self { file, header: state_header(names), digits, is_begun: false, error: None }
    }

    /// Adds the next samples, or begins again with them.
    pub fn see<S: Real>(&mut self, samples: &[Sample<S>], begins: bool) {
        if self.error.is_none() {
            self.error = self.add(samples, begins).err();
        }
    }

    fn add<S: Real>(&mut self, samples: &[Sample<S>], begins: bool) -> csv::Result<()> {
        let has_header = !std::mem::replace(&mut self.is_begun, true) || begins;
        if has_header {
            self.file.set_len(0)?;
            self.file.rewind()?;
        }
        if samples.is_empty() && !has_header {
            return Ok(());
        }
        let header = self.header.iter().filter(|_| has_header).cloned();
        write_rows(&mut self.file, self.digits, header, samples.iter().map(numbers))
    }

    /// The file with all of them, at its beginning.
    ///
    /// # Errors
    /// If it could not be written.
    pub fn finish(mut self) -> csv::Result<File> {
        if let Some(error) = self.error {
            return Err(error);
        }
        self.file.rewind()?;
        Ok(self.file)
    }
}
