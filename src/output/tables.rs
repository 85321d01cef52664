//! The CSV tables of `run`, column by column, for any number of coordinates. Numbers are the shortest decimals that
//! read back to the same `f64`; extended numbers have as many significant digits as the case asks for.

use std::io::Write;

use csv::{ByteRecord, Writer, WriterBuilder};

use crate::action::Form;
use crate::diagnostics::Diagnostics;
use crate::engine::{Growth, Sensitivity};
use crate::number::{DecimalRoom, Real};
use crate::solve::{Window, WorldLine};
use crate::trajectory::{Crossing, Sample};

/// The tables are written in blocks of this many bytes.
const BUFFER: usize = 1 << 18;

/// A column: its name, and its values node by node.
pub type Column<'c, S> = (String, Box<dyn Iterator<Item = S> + 'c>);

/// The columns of a table of a run, after γ.
pub type Columns<S> = for<'c> fn(&'c WorldLine<S>, &'c Diagnostics<S>) -> Vec<Column<'c, S>>;

/// A piece of a run, and what was measured on it.
pub type Part<'p, S> = (&'p WorldLine<S>, &'p Diagnostics<S>);

/// Writes a table with a row for each node of a run in pieces, where two rows have the same gamma if an event has acted
/// between them: gamma, the columns [`trajectory`], [`residuals`] or [`branches`] and, with several windows, the number
/// of the window; of every window every so many nodes and the last one.
///
/// # Errors
/// If `out` cannot be written.
pub fn write_nodes<S: Real>(
    mut out: impl Write,
    parts: &[Part<'_, S>],
    every: usize,
    columns: Columns<S>,
) -> csv::Result<()> {
    let has_windows = parts.last().is_some_and(|(run, _)| run.window_count > 1);
    for (index, (run, measured)) in parts.iter().enumerate() {
        write_table(&mut out, run, Rows { has_header: index == 0, has_windows, every }, columns(run, measured))?;
    }
    Ok(())
}

/// Writes `samples.csv`. Extended numbers have `digits` significant digits. If there are `radii`, by how much each
/// coordinate is proved to be off at most comes last, and is empty where nothing is proved.
///
/// # Errors
/// If `out` cannot be written.
pub fn write_samples<S: Real>(
    out: impl Write,
    names: &[String],
    (samples, radii): (&[Sample<S>], &[Option<Vec<f64>>]),
    digits: u32,
) -> csv::Result<()> {
    if !radii.iter().any(Option::is_some) {
        return write_rows(out, digits, state_header(names), samples.iter().map(numbers));
    }
    let mut writer = Writer::from_writer(out);
    writer.write_record(state_header(names).into_iter().chain(names.iter().map(radius_of)))?;
    for (k, sample) in samples.iter().enumerate() {
        let own = numbers(sample).map(|number| number.to_decimal(digits));
        writer.write_record(own.chain(radius_cells::<S>(radii.get(k), names.len(), digits)))?;
    }
    Ok(writer.flush()?)
}

/// The column of a proved bound.
pub(crate) fn radius_of(name: &String) -> String {
    format!("{name}_radius")
}

/// So many cells of proved bounds.
pub(crate) fn radius_cells<S: Real>(
    radii: Option<&Option<Vec<f64>>>,
    count: usize,
    digits: u32,
) -> impl Iterator<Item = String> {
    let cell = move |radius: f64| if radius.is_nan() { String::new() } else { S::from(radius).to_decimal(digits) };
    (0..count).map(move |place| radii.and_then(Option::as_ref).map_or_else(String::new, |of| cell(of[place])))
}

/// The columns of `events.csv` behind the name of the event: those of `samples.csv` and, of runs that are judged on
/// their way, by how much γ and every coordinate may be off.
pub(crate) fn event_header(names: &[String], is_judged: bool) -> Vec<String> {
    let errors = std::iter::once("gamma").chain(names.iter().map(String::as_str)).map(|name| format!("error_{name}"));
    state_header(names).into_iter().chain(errors.filter(|_| is_judged)).collect()
}

/// Writes `events.csv`: the name of the event, then the columns of `samples.csv` and, of runs that are judged on their
/// way, by how much γ and every coordinate may be off. `events` are the names of what was watched. If there are
/// `radii`, one for each crossing, what is proved of that comes last, and is empty where nothing is.
///
/// # Errors
/// If `out` cannot be written.
pub fn write_events<S: Real>(
    out: impl Write,
    names: &[String],
    events: &[&str],
    (crossings, radii): (&[Crossing<S>], &[Option<Vec<f64>>]),
    (digits, is_judged): (u32, bool),
) -> csv::Result<()> {
    let has_radii = radii.iter().any(Option::is_some);
    let proved = std::iter::once(&"gamma".to_owned()).chain(names).filter(|_| has_radii).map(radius_of).collect();
    let header = [vec!["event".to_owned()], event_header(names, is_judged), proved].concat();
    let mut writer = Writer::from_writer(out);
    writer.write_record(header)?;
    for (k, crossing) in crossings.iter().enumerate() {
        let name = events[crossing.watch].to_owned();
        let count = if has_radii { names.len() + 1 } else { 0 };
        let proved = radius_cells::<S>(radii.get(k), count, digits);
        writer.write_record(std::iter::once(name).chain(crossing.cells(digits, is_judged)).chain(proved))?;
    }
    Ok(writer.flush()?)
}

/// Writes `sensitivity.csv`: gamma, and for all active coordinates and momenta `A` and `B` in the columns `d_A_d_B` by
/// how much A changes there with B at the start. The rows are the joints of windows; two of them have the same gamma
/// where an event has acted. A run without a sensitivity has no rows.
///
/// # Errors
/// If `out` cannot be written.
pub fn write_sensitivity<S: Real>(out: impl Write, pieces: &[&WorldLine<S>]) -> csv::Result<()> {
    let Some(run) = pieces.first() else { return Ok(()) };
    let (names, active) = (run.geometry().names(), run.geometry().active());
    let positions = active.iter().map(|&a| names[a].clone());
    let unknowns: Vec<String> = positions.chain(active.iter().map(|&a| format!("p_{}", names[a]))).collect();
    let cells = unknowns.iter().flat_map(|a| unknowns.iter().map(move |b| format!("d_{a}_d_{b}")));
    let (m, n) = (active.len(), unknowns.len());
    // Momenta of the reversed motion have the other sign, and those that a user sees may have.
    let shown = |k: usize, value: S| match k.checked_sub(m) {
        Some(place) => run.geometry().seen(active[place], run.signed(value)),
        None => value,
    };
    // The sum with 0 takes the sign away from a zero.
    let entry = |(at, &value): (usize, &f64)| S::ZERO + shown(at / n, shown(at % n, S::from(value)));
    let header = std::iter::once("gamma".to_owned()).chain(cells);
    let rows = pieces.iter().flat_map(|run| {
        let matrices = run.sensitivity.iter().flat_map(Sensitivity::joints);
        joints(run).zip(matrices)
    });
    let rows = rows.map(|(gamma, row)| std::iter::once(gamma).chain(row.iter().enumerate().map(entry)));
    write_rows(out, run.digits, header, rows)
}

/// γ at the joints of windows, the start first.
fn joints<S: Real>(run: &WorldLine<S>) -> impl Iterator<Item = S> {
    let ends = run.windows.iter().map(|window| window.gamma[1]);
    std::iter::once(S::ZERO).chain(ends).map(|gamma| run.gamma_at(gamma))
}

/// Writes `growth.csv`: gamma, lyapunov and megno at all joints of windows. A run without a sensitivity has no rows.
///
/// # Errors
/// If `out` cannot be written.
pub fn write_growth<S: Real>(out: impl Write, pieces: &[&WorldLine<S>]) -> csv::Result<()> {
    let Some(run) = pieces.first() else { return Ok(()) };
    let rows = pieces.iter().flat_map(|run| {
        let growths = run.sensitivity.iter().flat_map(Sensitivity::growths);
        joints(run).zip(growths)
    });
    let rows =
        rows.map(|(gamma, Growth { lyapunov, megno, .. })| [gamma, S::from(*lyapunov), S::from(*megno)].into_iter());
    write_rows(out, run.digits, ["gamma", "lyapunov", "megno"].map(str::to_owned), rows)
}

/// The numbers of a sample: γ, the coordinates and their derivatives.
pub(super) fn numbers<S: Real>(sample: &Sample<S>) -> impl Iterator<Item = S> {
    std::iter::once(sample.gamma).chain(sample.q.iter().copied()).chain(sample.q_dot.iter().copied())
}

pub(super) fn write_rows<S: Real>(
    mut out: impl Write,
    digits: u32,
    header: impl IntoIterator<Item = String>,
    mut rows: impl Iterator<Item = impl Iterator<Item = S>>,
) -> csv::Result<()> {
    let mut table = Table::new(&mut out, digits, header)?;
    rows.try_for_each(|values| table.row(values, None))?;
    table.finish()
}

/// The columns of a point of a world-line.
pub(crate) fn state_header(names: &[String]) -> Vec<String> {
    let velocities = names.iter().map(|name| format!("{name}_dot"));
    std::iter::once("gamma".to_owned()).chain(names.iter().cloned()).chain(velocities).collect()
}

/// The columns of `trajectory.csv`: the coordinates, and their derivatives, those of [`Diagnostics::tangent`].
pub fn trajectory<'c, S: Real>(run: &'c WorldLine<S>, measured: &'c Diagnostics<S>) -> Vec<Column<'c, S>> {
    let names = run.geometry().names();
    let mut columns: Vec<Column<'_, S>> = Vec::with_capacity(2 * names.len());
    columns.extend(names.iter().enumerate().map(|(a, name)| -> Column<'_, S> { (name.clone(), Box::new(run.q(a))) }));
    let velocities = names.iter().zip(measured.tangent(run));
    columns.extend(velocities.map(|(name, row)| -> Column<'_, S> {
        (format!("{name}_dot"), Box::new((0..row.len()).map(move |node| row[node])))
    }));
    columns
}

/// The columns of `branches.csv`: every coordinate with _1, every coordinate with _2. A run that is not doubled has no
/// second branch.
pub fn branches<'c, S: Real>(run: &'c WorldLine<S>, _: &'c Diagnostics<S>) -> Vec<Column<'c, S>> {
    let names = || run.geometry().names().iter().enumerate();
    let forward = names().map(|(a, name)| -> Column<'_, S> { (format!("{name}_1"), Box::new(run.q(a))) });
    let backward =
        names().filter_map(|(a, name)| Some::<Column<'_, S>>((format!("{name}_2"), Box::new(run.backward(a)?))));
    forward.chain(backward).collect()
}

/// The columns of `residuals.csv`: for every ignorable coordinate `delta_q_A` and `delta_q_A_corrected`; `delta_g_A`
/// for every coordinate; delta_k or, in the lift of Newton's law, delta_energy; `delta_NAME` for every invariant of the
/// user; in the strong form `d_A`, which is Dq^A at every node, at the last one of a window, too, where `A_dot` is what
/// is handed on; and `error_A` for every result, if two marches judge each other: their largest distance so far.
pub fn residuals<'c, S: Real>(run: &'c WorldLine<S>, measured: &'c Diagnostics<S>) -> Vec<Column<'c, S>> {
    let coordinates = run.geometry().names();
    let mut rows: Vec<(String, &[S])> = Vec::new();
    for charge in &measured.charges {
        let name = &coordinates[charge.terms[0].0];
        rows.push((format!("delta_q_{name}"), &charge.delta));
        rows.push((format!("delta_q_{name}_corrected"), &charge.corrected));
    }
    rows.extend(coordinates.iter().zip(&measured.delta_g).map(|(name, row)| (format!("delta_g_{name}"), &**row)));
    rows.push(match &measured.energy {
        Some(energy) => ("delta_energy".to_owned(), &*energy.delta),
        None => ("delta_k".to_owned(), &*measured.norm.delta),
    });
    rows.extend(measured.invariants.iter().map(|(name, each)| (format!("delta_{name}"), &*each.delta)));
    let rows = rows.into_iter().map(|(name, row)| -> Column<'_, S> { (name, Box::new(row.iter().copied())) });
    rows.chain(derivatives(run, measured)).chain(errors(run)).collect()
}

/// Dq^A at every node, where the last one of a window has another tangent.
fn derivatives<'c, S: Real>(
    run: &'c WorldLine<S>,
    measured: &'c Diagnostics<S>,
) -> impl Iterator<Item = Column<'c, S>> {
    let rows = run.geometry().names().iter().zip(&measured.q_dot).filter(|_| run.form == Form::Strong);
    rows.map(|(name, row)| -> Column<'_, S> {
        (format!("d_{name}"), Box::new(row.iter().map(|&rate| run.signed(rate))))
    })
}

/// By how much each result may be off, if that is known of every window.
fn errors<S: Real>(run: &WorldLine<S>) -> impl Iterator<Item = Column<'_, S>> {
    let is_known = run.windows.iter().all(|window| !window.errors.is_empty());
    let results = if is_known { run.geometry().results() } else { 0 };
    run.geometry().names()[..results].iter().enumerate().map(|(a, name)| -> Column<'_, S> {
        let of_window = move |window: &'_ Window<S>| std::iter::repeat_n(S::from(window.errors[a]), window.points());
        (format!("error_{name}"), Box::new(run.windows.iter().flat_map(of_window)))
    })
}

pub(super) fn everything<'c, S: Real>(run: &'c WorldLine<S>, measured: &'c Diagnostics<S>) -> Vec<Column<'c, S>> {
    trajectory(run, measured).into_iter().chain(residuals(run, measured)).collect()
}

/// Which rows of a run are written, and how.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rows {
    pub(super) has_header: bool,
    /// True if there is a column with the number of the window.
    pub(super) has_windows: bool,
    /// Every so many nodes of a window are written, and its last one.
    pub(super) every: usize,
}

/// Writes a header and a row for each node that is wanted: γ, the columns and, with several windows, the number of the
/// window from 1.
pub(super) fn write_table<S: Real>(
    out: &mut dyn Write,
    run: &WorldLine<S>,
    rows: Rows,
    columns: Vec<Column<'_, S>>,
) -> csv::Result<()> {
    let (names, mut columns): (Vec<String>, Vec<_>) = columns.into_iter().unzip();
    let Rows { has_header, has_windows, every } = rows;
    let header = std::iter::once("gamma".to_owned()).chain(names).chain(has_windows.then(|| "window".to_owned()));
    let mut table = Table::new(out, run.digits, header.filter(|_| has_header))?;
    let mut gammas = run.gamma();
    for (window, grid) in (1 + run.window_count - run.windows.len()..).zip(&run.windows) {
        let last = grid.nodes().len() - 1;
        for (node, gamma) in gammas.by_ref().take(last + 1).enumerate() {
            let values = columns.iter_mut().filter_map(Iterator::next);
            if node % every == 0 || node == last {
                table.row(std::iter::once(gamma).chain(values), has_windows.then_some(window))?;
            } else {
                values.for_each(drop);
            }
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
    /// A table with these headings; one without any continues another.
    fn new(out: &'o mut dyn Write, digits: u32, headings: impl IntoIterator<Item = String>) -> csv::Result<Self> {
        let mut writer = WriterBuilder::new().buffer_capacity(BUFFER).from_writer(out);
        let header: ByteRecord = headings.into_iter().collect();
        if !header.is_empty() {
            writer.write_byte_record(&header)?;
        }
        Ok(Self { writer, digits, record: header, room: DecimalRoom::default() })
    }

    /// Writes a row: numbers and, where there is one, the number of a window.
    fn row<S: Real>(&mut self, values: impl Iterator<Item = S>, window: Option<usize>) -> csv::Result<()> {
        self.record.clear();
        for value in values {
            self.record.push_field(value.write_decimal(self.digits, &mut self.room).as_bytes());
        }
        window.iter().for_each(|window| self.record.push_field(window.to_string().as_bytes()));
        self.writer.write_byte_record(&self.record)
    }

    fn finish(mut self) -> csv::Result<()> {
        self.writer.flush()?;
        Ok(())
    }
}
