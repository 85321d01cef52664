//! The CSV tables of `run`, column by column, for any number of coordinates. Numbers are the shortest decimals that
//! read back to the same `f64`; extended numbers have as many significant digits as the case asks for.

use std::borrow::Cow;
use std::io::Write;

use csv::{ByteRecord, Writer, WriterBuilder};

use crate::diagnostics::Diagnostics;
use crate::number::{DecimalRoom, Real};
use crate::solve::WorldLine;
use crate::trajectory::{Crossing, Sample};

/// The tables are written in blocks of this many bytes.
const BUFFER: usize = 1 << 18;

/// A writer of a long table.
pub(crate) fn csv_writer<W: Write>(out: W) -> Writer<W> {
    WriterBuilder::new().buffer_capacity(BUFFER).from_writer(out)
}

/// The columns of a table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Contents {
    /// Those of `trajectory.csv`.
    Trajectory,
    /// Those of `residuals.csv`.
    Residuals,
    /// Those of both.
    Both,
}

/// A column: its name, and its values node by node.
struct Column<'c, S> {
    name: String,
    values: Box<dyn Iterator<Item = S> + 'c>,
}

/// Writes `trajectory.csv`: gamma, the coordinates, their derivatives. With several windows, this table and those below
/// have also the column window. The derivatives are those of [`Diagnostics::tangent`].
///
/// # Errors
/// If `out` cannot be written.
pub fn write_trajectory<S: Real>(
    mut out: impl Write,
    run: &WorldLine<S>,
    measured: &Diagnostics<S>,
) -> csv::Result<()> {
    write(run, measured, Contents::Trajectory, &mut out)
}

/// Writes `residuals.csv`: gamma; for every ignorable coordinate `delta_q_A` and `delta_q_A_corrected`; `delta_g_A` for
/// every coordinate; delta_k or, in the lift of Newton's law, delta_energy; `delta_NAME` for every invariant of the
/// user.
///
/// # Errors
/// If `out` cannot be written.
pub fn write_residuals<S: Real>(mut out: impl Write, run: &WorldLine<S>, measured: &Diagnostics<S>) -> csv::Result<()> {
    write(run, measured, Contents::Residuals, &mut out)
}

/// Writes the table of `run --stdout`, which has the columns of both of these tables.
///
/// # Errors
/// If `out` cannot be written.
pub fn write_combined<S: Real>(mut out: impl Write, run: &WorldLine<S>, measured: &Diagnostics<S>) -> csv::Result<()> {
    write(run, measured, Contents::Both, &mut out)
}

/// The table of a run, whatever the number of its coordinates.
fn write<S: Real>(
    run: &WorldLine<S>,
    measured: &Diagnostics<S>,
    contents: Contents,
    out: &mut dyn Write,
) -> csv::Result<()> {
    let tangent = (contents != Contents::Residuals).then(|| measured.tangent(run));
    let mut columns = tangent.as_deref().map_or_else(Vec::new, |tangent| trajectory(run, tangent));
    if contents != Contents::Trajectory {
        columns.extend(residuals(run, measured));
    }
    write_table(out, run, columns)
}

/// Writes `branches.csv`: gamma, every coordinate with _1, every coordinate with _2. A run that is not doubled has no
/// second branch.
///
/// # Errors
/// If `out` cannot be written.
pub fn write_branches<S: Real>(mut out: impl Write, run: &WorldLine<S>) -> csv::Result<()> {
    let names = run.geometry().names();
    let forward = |(a, name): (usize, &String)| Column { name: format!("{name}_1"), values: Box::new(run.q(a)) };
    let backward =
        |(a, name): (usize, &String)| Some(Column { name: format!("{name}_2"), values: Box::new(run.backward(a)?) });
    let columns = names.iter().enumerate().map(forward).chain(names.iter().enumerate().filter_map(backward));
    write_table(&mut out, run, columns.collect())
}

/// The numbers of a sample: γ, the coordinates and their derivatives.
fn numbers<S: Real>(sample: &Sample<S>) -> impl Iterator<Item = S> {
    std::iter::once(sample.gamma).chain(sample.q.iter().copied()).chain(sample.q_dot.iter().copied())
}

/// Writes `samples.csv`: gamma, the coordinates `names`, their derivatives. Extended numbers have `digits` significant
/// digits.
///
/// # Errors
/// If `out` cannot be written.
pub fn write_samples<S: Real>(
    mut out: impl Write,
    names: &[String],
    samples: &[Sample<S>],
    digits: u32,
) -> csv::Result<()> {
    let mut table = Table::new(&mut out, state_header(names).iter().map(String::as_str), digits)?;
    for sample in samples {
        table.row(numbers(sample), None)?;
    }
    table.finish()
}

/// Writes `events.csv`: the name of the event, then the columns of `samples.csv`. `events` are the names of what was
/// watched.
///
/// # Errors
/// If `out` cannot be written.
pub fn write_events<S: Real>(
    mut out: impl Write,
    names: &[String],
    events: &[&str],
    crossings: &[Crossing<S>],
    digits: u32,
) -> csv::Result<()> {
    let header = state_header(names);
    let mut table = Table::new(&mut out, std::iter::once("event").chain(header.iter().map(String::as_str)), digits)?;
    for Crossing { watch, sample } in crossings {
        table.labelled_row(events[*watch], numbers(sample))?;
    }
    table.finish()
}

/// The columns of a point of a world-line.
pub(crate) fn state_header(names: &[String]) -> Vec<String> {
    let velocities = names.iter().map(|name| format!("{name}_dot"));
    std::iter::once("gamma".to_owned()).chain(names.iter().cloned()).chain(velocities).collect()
}

fn trajectory<'c, S: Real>(run: &'c WorldLine<S>, tangent: &'c [Cow<'_, [S]>]) -> Vec<Column<'c, S>> {
    let names = run.geometry().names();
    let velocities = names.iter().zip(tangent);
    let velocities = velocities
        .map(|(name, row)| Column { name: format!("{name}_dot"), values: Box::new(row.iter().copied()) as _ });
    let positions = names.iter().enumerate().map(|(a, name)| Column { name: name.clone(), values: Box::new(run.q(a)) });
    positions.chain(velocities).collect()
}

fn residuals<'c, S: Real>(run: &'c WorldLine<S>, measured: &'c Diagnostics<S>) -> Vec<Column<'c, S>> {
    let coordinates = run.geometry().names();
    let mut columns: Vec<(String, &[S])> = Vec::new();
    for charge in &measured.charges {
        let name = &coordinates[charge.terms[0].0];
        columns.push((format!("delta_q_{name}"), &charge.delta));
        columns.push((format!("delta_q_{name}_corrected"), &charge.corrected));
    }
    for (name, row) in coordinates.iter().zip(&measured.delta_g) {
        columns.push((format!("delta_g_{name}"), row));
    }
    columns.push(match &measured.delta_energy {
        Some(energy) => ("delta_energy".to_owned(), energy),
        None => ("delta_k".to_owned(), &measured.norm.delta),
    });
    let invariants = measured.invariants.iter();
    columns.extend(invariants.map(|each| (format!("delta_{}", each.name), each.delta.as_slice())));
    let column = |(name, row): (String, &'c [S])| Column { name, values: Box::new(row.iter().copied()) as _ };
    columns.into_iter().map(column).collect()
}

/// Writes a header and one row per node: γ, the columns and, with several windows, the number of the window from 1.
fn write_table<S: Real>(out: &mut dyn Write, run: &WorldLine<S>, columns: Vec<Column<'_, S>>) -> csv::Result<()> {
    let (names, mut columns): (Vec<_>, Vec<_>) =
        columns.into_iter().map(|Column { name, values }| (name, values)).unzip();
    let has_windows = run.windows.len() > 1;
    let names = names.iter().map(String::as_str);
    let header = std::iter::once("gamma").chain(names).chain(has_windows.then_some("window"));
    let mut table = Table::new(out, header, run.digits)?;
    let mut gammas = run.gamma();
    for (window, grid) in (1..).zip(run.grids()) {
        for gamma in gammas.by_ref().take(grid.nodes().len()) {
            let values = columns.iter_mut().filter_map(Iterator::next);
            table.row(std::iter::once(gamma).chain(values), has_windows.then_some(window))?;
        }
    }
    table.finish()
}

/// A table that is being written.
struct Table<'o> {
    writer: Writer<&'o mut dyn Write>,
    digits: u32,
    record: ByteRecord,
    room: DecimalRoom,
}

impl<'o> Table<'o> {
    fn new<'h>(out: &'o mut dyn Write, header: impl IntoIterator<Item = &'h str>, digits: u32) -> csv::Result<Self> {
        let mut writer = csv_writer(out);
        writer.write_record(header)?;
        Ok(Self { writer, digits, record: ByteRecord::new(), room: DecimalRoom::default() })
    }

    fn row<S: Real>(&mut self, values: impl Iterator<Item = S>, window: Option<usize>) -> csv::Result<()> {
        self.record.clear();
        self.push(values);
        if let Some(window) = window {
            self.record.push_field(window.to_string().as_bytes());
        }
        self.writer.write_byte_record(&self.record)
    }

    fn labelled_row<S: Real>(&mut self, label: &str, values: impl Iterator<Item = S>) -> csv::Result<()> {
        self.record.clear();
        self.record.push_field(label.as_bytes());
        self.push(values);
        self.writer.write_byte_record(&self.record)
    }

    fn push<S: Real>(&mut self, values: impl Iterator<Item = S>) {
        for value in values {
            self.record.push_field(value.write_decimal(self.digits, &mut self.room).as_bytes());
        }
    }

    fn finish(mut self) -> csv::Result<()> {
        self.writer.flush()?;
        Ok(())
    }
}
