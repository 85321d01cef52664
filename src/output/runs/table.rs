//! Writing `runs.csv` and `runs-events.csv`.

use std::io::Write;

use anyhow::Context;
use csv::Writer;

use super::{Columns, RUNS, RUNS_EVENTS, RunRow};
use crate::output::tables::csv_writer;

/// A table of many runs that is being written.
pub(super) struct Tables<W: Write> {
    runs: Writer<W>,
    events: Option<Writer<W>>,
}

impl<W: Write> Tables<W> {
    /// Begins them with their headers.
    pub(super) fn new((runs, header): (W, &[String]), events: Option<(W, &[String])>) -> anyhow::Result<Self> {
        let begin = |out: W, header: &[String], name: &str| {
            let mut writer = csv_writer(out);
            writer.write_record(header).with_context(|| cannot(name))?;
            anyhow::Ok(writer)
        };
        Ok(Self {
            runs: begin(runs, header, RUNS)?,
            events: events.map(|(out, header)| begin(out, header, RUNS_EVENTS)).transpose()?,
        })
    }

    /// Adds a row to `runs.csv`, with all of its cells.
    pub(super) fn run(&mut self, cells: impl IntoIterator<Item = impl AsRef<[u8]>>) -> anyhow::Result<()> {
        self.runs.write_record(cells).with_context(|| cannot(RUNS))
    }

    /// Adds a row to `runs-events.csv`, with all of its cells.
    pub(super) fn event(&mut self, cells: impl IntoIterator<Item = impl AsRef<[u8]>>) -> anyhow::Result<()> {
        self.events.as_mut().map_or(Ok(()), |events| events.write_record(cells)).with_context(|| cannot(RUNS_EVENTS))
    }

    pub(super) fn finish(mut self) -> anyhow::Result<()> {
        self.runs.flush().with_context(|| cannot(RUNS))?;
        self.events.as_mut().map_or(Ok(()), Writer::flush).with_context(|| cannot(RUNS_EVENTS))
    }
}

fn cannot(name: &str) -> String {
    format!("cannot write {name}")
}

/// Writes the rows in their order to `runs`, and their events to `events` if the table has any.
///
/// # Errors
/// If a row cannot be had, or a table cannot be written.
pub fn write_runs<W: Write>(
    (runs, events): (W, Option<W>),
    columns: &Columns,
    rows: impl Iterator<Item = anyhow::Result<RunRow>>,
) -> anyhow::Result<()> {
    let (header, events_header) = (columns.header(), columns.events_header());
    let mut tables = Tables::new((runs, &header), events.map(|out| (out, events_header.as_slice())))?;
    for row in rows {
        let RunRow { row, cells, events, .. } = row?;
        let number = row.to_string();
        let with_number = |cells: &[String]| [std::slice::from_ref(&number), cells].concat();
        tables.run(with_number(&cells))?;
        events.iter().try_for_each(|cells| tables.event(with_number(cells)))?;
    }
    tables.finish()
}
