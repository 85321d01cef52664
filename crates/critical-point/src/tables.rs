//! The CSV tables of `run`, column by column, for any number of coordinates. Numbers are the shortest decimals that
//! read back to the same `f64`; extended numbers have as many significant digits as the case asks for.

use std::borrow::Cow;
use std::io::Write;

use csv::{ByteRecord, Writer, WriterBuilder};

use crate::diagnostics::scene::SceneDiagnostics;
use crate::diagnostics::{Diagnosed, Diagnostics};
use crate::geometry::Geometry;
use crate::metric::Metric;
use crate::sampling::{Crossing, Sample, SceneSample};
use crate::scalar::{DecimalRoom, Real};
use crate::solve::{Solution, Space, WorldLine};

/// The tables are written in blocks of this many bytes.
const BUFFER: usize = 1 << 18;

/// A writer of a long table.
#[doc(hidden)]
pub fn csv_writer<W: Write>(out: W) -> Writer<W> {
    WriterBuilder::new().buffer_capacity(BUFFER).from_writer(out)
}

/// What is measured on a run, as rows of values on its nodes.
pub trait Measured<S: Real> {
    /// The space-time of the run.
    type Space: Space<S>;

    /// dq/dγ of every coordinate.
    fn tangent(&self, run: &WorldLine<S, Self::Space>) -> Vec<Cow<'_, [S]>>;

    /// The columns of `residuals.csv` after the first, with their names.
    fn residuals(&self, run: &WorldLine<S, Self::Space>) -> Vec<(String, &[S])>;

    /// Writes one of the tables.
    #[doc(hidden)]
    fn write(&self, run: &WorldLine<S, Self::Space>, contents: Contents, out: &mut dyn Write) -> csv::Result<()>;
}

/// The columns of a table.
#[doc(hidden)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Contents {
    /// Those of `trajectory.csv`.
    Trajectory,
    /// Those of `residuals.csv`.
    Residuals,
    /// Those of both.
    Both,
}

impl<S: Diagnosed + Tabled> Measured<S> for Diagnostics<S> {
    type Space = Metric<S>;

    fn tangent(&self, run: &Solution<S>) -> Vec<Cow<'_, [S]>> {
        Diagnostics::tangent(self, run).map(Cow::Owned).to_vec()
    }

    fn residuals(&self, _: &Solution<S>) -> Vec<(String, &[S])> {
        let (charges, residuals) = (&self.charges, &self.residuals);
        let columns = [
            ("delta_q_t", &charges.delta_q_t),
            ("delta_q_t_corrected", &charges.delta_q_t_corrected),
            ("delta_g_t", &residuals.delta_g_t),
            ("delta_g_x", &residuals.delta_g_x),
            ("delta_k", &charges.delta_k),
        ];
        columns.map(|(name, values)| (name.to_owned(), values.as_slice())).to_vec()
    }

    fn write(&self, run: &Solution<S>, contents: Contents, out: &mut dyn Write) -> csv::Result<()> {
        S::table(run, self, contents, out)
    }
}

impl<S: Diagnosed + Tabled> Measured<S> for SceneDiagnostics<S> {
    type Space = Geometry<S>;

    fn tangent(&self, _: &WorldLine<S>) -> Vec<Cow<'_, [S]>> {
        self.tangent.iter().map(|row| Cow::Borrowed(row.as_slice())).collect()
    }

    /// For every ignorable coordinate `delta_q_A` and `delta_q_A_corrected`; `delta_g_A` for every coordinate; delta_k
    /// or, in the lift of Newton's law, delta_energy; `delta_NAME` for every invariant of the user.
    fn residuals(&self, run: &WorldLine<S>) -> Vec<(String, &[S])> {
        let coordinates = run.geometry().names();
        let mut columns: Vec<(String, &[S])> = Vec::new();
        for charge in &self.charges {
            let name = &coordinates[charge.terms[0].0];
            columns.push((format!("delta_q_{name}"), &charge.delta));
            columns.push((format!("delta_q_{name}_corrected"), &charge.corrected));
        }
        for (name, row) in coordinates.iter().zip(&self.delta_g) {
            columns.push((format!("delta_g_{name}"), row));
        }
        match &self.delta_energy {
            Some(energy) => columns.push(("delta_energy".to_owned(), energy)),
            None => columns.push(("delta_k".to_owned(), &self.norm.delta)),
        }
        columns.extend(self.invariants.iter().map(|each| (format!("delta_{}", each.name), each.delta.as_slice())));
        columns
    }

    fn write(&self, run: &WorldLine<S>, contents: Contents, out: &mut dyn Write) -> csv::Result<()> {
        S::table_of_scene(run, self, contents, out)
    }
}

/// A column: its name, and its values node by node.
struct Column<'c, S> {
    name: String,
    values: Box<dyn Iterator<Item = S> + 'c>,
}

/// Writes `trajectory.csv`: gamma, the coordinates, their derivatives. With several windows, this table and those below
/// have also the column window. The derivatives are those of [`Measured::tangent`].
///
/// # Errors
/// If `out` cannot be written.
pub fn write_trajectory<S: Real, M: Measured<S>>(
    mut out: impl Write,
    run: &WorldLine<S, M::Space>,
    measured: &M,
) -> csv::Result<()> {
    measured.write(run, Contents::Trajectory, &mut out)
}

/// Writes `residuals.csv`: gamma, and the columns of [`Measured::residuals`].
///
/// # Errors
/// If `out` cannot be written.
pub fn write_residuals<S: Real, M: Measured<S>>(
    mut out: impl Write,
    run: &WorldLine<S, M::Space>,
    measured: &M,
) -> csv::Result<()> {
    measured.write(run, Contents::Residuals, &mut out)
}

/// Writes the table of `run --stdout`, which has the columns of both of these tables.
///
/// # Errors
/// If `out` cannot be written.
pub fn write_combined<S: Real, M: Measured<S>>(
    mut out: impl Write,
    run: &WorldLine<S, M::Space>,
    measured: &M,
) -> csv::Result<()> {
    measured.write(run, Contents::Both, &mut out)
}

/// The table of a run, whatever the number of its coordinates.
fn write_here<S: Real, M: Measured<S>>(
    run: &WorldLine<S, M::Space>,
    measured: &M,
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
pub fn write_branches<S: Real, G: Space<S>>(mut out: impl Write, run: &WorldLine<S, G>) -> csv::Result<()> {
    let names = run.geometry().coordinates();
    let forward = |(a, name): (usize, &String)| Column { name: format!("{name}_1"), values: Box::new(run.q(a)) };
    let backward =
        |(a, name): (usize, &String)| Some(Column { name: format!("{name}_2"), values: Box::new(run.backward(a)?) });
    let columns = names.iter().enumerate().map(forward).chain(names.iter().enumerate().filter_map(backward));
    write_table(&mut out, run, columns.collect())
}

/// The world-line at one value of γ, as a row of a table.
pub trait Row<S> {
    /// Its numbers, in the order of [`state_header`].
    fn numbers(&self) -> impl Iterator<Item = S>;
}

/// γ and t are those of the case, not counted from the start.
impl<S: Real> Row<S> for Sample<S> {
    fn numbers(&self) -> impl Iterator<Item = S> {
        [self.gamma, self.t, self.x, self.t_dot, self.x_dot].into_iter()
    }
}

impl<S: Real> Row<S> for SceneSample<S> {
    fn numbers(&self) -> impl Iterator<Item = S> {
        std::iter::once(self.gamma).chain(self.q.iter().copied()).chain(self.q_dot.iter().copied())
    }
}

/// Writes `samples.csv`: gamma, the coordinates `names`, their derivatives. Extended numbers have `digits` significant
/// digits.
///
/// # Errors
/// If `out` cannot be written.
pub fn write_samples<S: Tabled, R: Row<S>>(
    mut out: impl Write,
    names: &[String],
    samples: &[R],
    digits: u32,
) -> csv::Result<()> {
    let mut samples = samples.iter();
    let mut next = |numbers: &mut Vec<S>| samples.next().map(|sample| numbers.extend(sample.numbers()));
    S::table_of_samples(names, &mut next, digits, &mut out)
}

/// What appends the numbers of the next row, if there is one.
#[doc(hidden)]
pub type Rows<'r, S> = &'r mut dyn FnMut(&mut Vec<S>) -> Option<()>;

fn write_samples_here<S: Real>(
    names: &[String],
    next: Rows<'_, S>,
    digits: u32,
    out: &mut dyn Write,
) -> csv::Result<()> {
    let mut table = Table::new(out, state_header(names).iter().map(String::as_str), digits)?;
    let mut numbers = Vec::new();
    while next(&mut numbers).is_some() {
        table.row(numbers.drain(..), None)?;
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
        table.labelled_row(events[*watch], sample.numbers())?;
    }
    table.finish()
}

/// The columns of a point of a world-line.
#[doc(hidden)]
pub fn state_header(names: &[String]) -> Vec<String> {
    let velocities = names.iter().map(|name| format!("{name}_dot"));
    std::iter::once("gamma".to_owned()).chain(names.iter().cloned()).chain(velocities).collect()
}

fn trajectory<'c, S: Real, G: Space<S>>(run: &'c WorldLine<S, G>, tangent: &'c [Cow<'_, [S]>]) -> Vec<Column<'c, S>> {
    let names = run.geometry().coordinates();
    let velocities = names.iter().zip(tangent);
    let velocities = velocities
        .map(|(name, row)| Column { name: format!("{name}_dot"), values: Box::new(row.iter().copied()) as _ });
    let positions = names.iter().enumerate().map(|(a, name)| Column { name: name.clone(), values: Box::new(run.q(a)) });
    positions.chain(velocities).collect()
}

fn residuals<'c, S: Real, M: Measured<S>>(run: &WorldLine<S, M::Space>, measured: &'c M) -> Vec<Column<'c, S>> {
    let columns = measured.residuals(run).into_iter();
    columns.map(|(name, row)| Column { name, values: Box::new(row.iter().copied()) as _ }).collect()
}

/// Writes a header and one row per node: γ, the columns and, with several windows, the number of the window from 1.
fn write_table<S: Real, G: Space<S>>(
    out: &mut dyn Write,
    run: &WorldLine<S, G>,
    columns: Vec<Column<'_, S>>,
) -> csv::Result<()> {
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

crate::compiled! {
    /// Numbers in which tables are written.
    pub trait Tabled {
        fn table(
            run: &Solution<Self>,
            measured: &Diagnostics<Self>,
            contents: Contents,
            out: &mut dyn Write,
        ) -> csv::Result<()> = write_here;
        fn table_of_scene(
            run: &WorldLine<Self>,
            measured: &SceneDiagnostics<Self>,
            contents: Contents,
            out: &mut dyn Write,
        ) -> csv::Result<()> = write_here;
        fn table_of_samples(
            names: &[String],
            next: Rows<'_, Self>,
            digits: u32,
            out: &mut dyn Write,
        ) -> csv::Result<()> = write_samples_here;
    }
}
