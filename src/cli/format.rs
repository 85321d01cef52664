//! `--format npy`: tables also as arrays of NumPy.

use clap::{Args, ValueEnum};
use geodesic_ivp::output::OutputSet;
use geodesic_ivp::output::npy::{array_of, write_array};

use super::out::RESULTS;

/// The format of tables.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, ValueEnum)]
enum Format {
    /// CSV
    #[default]
    Csv,
    /// CSV, and beside it .npy, which NumPy loads as a record array
    Npy,
}

#[derive(Debug, Clone, Default, Args)]
pub(super) struct FormatArgs {
    /// The format of tables
    #[arg(
        long,
        value_name = "FORMAT",
        value_enum,
        default_value_t = Format::Csv,
        hide_default_value = true,
        help_heading = RESULTS
    )]
    format: Format,
}

impl FormatArgs {
    /// The files of these tables.
    pub(super) fn files(&self, tables: &[&'static str]) -> Vec<&'static str> {
        let arrays = tables.iter().filter(|_| self.format == Format::Npy).map(|table| array_of(table));
        tables.iter().copied().chain(arrays).collect()
    }

    /// Writes the array of a table that is written, if one is wanted.
    pub(super) fn write_array(&self, files: &OutputSet, table: &str) -> anyhow::Result<()> {
        match self.format {
            Format::Csv => Ok(()),
            Format::Npy => files.write_table(array_of(table), |out| write_array(table, files.writer(table), out)),
        }
    }
}
