//! The CSV tables of `run` for scenes of n coordinates.

use std::io::Write;

use csv::{ByteRecord, WriterBuilder};

use super::tables::BUFFER;
use crate::diagnostics::scene::SceneDiagnostics;
use crate::scalar::{DecimalRoom, Real};
use crate::solve::scene::WorldLine;

/// A column: its name and its values on the nodes.
type Column<S> = (String, Vec<S>);

/// Writes `trajectory.csv`: gamma, the coordinates, their derivatives. With several windows, this table and those below
/// have also the column window.
///
/// # Errors
/// If `out` cannot be written.
pub fn write_trajectory<S: Real>(
    out: impl Write,
    line: &WorldLine<S>,
    diagnostics: &SceneDiagnostics<S>,
) -> csv::Result<()> {
    write_table(out, line, trajectory(line, diagnostics))
}

/// Writes `residuals.csv`: gamma; for every ignorable coordinate `delta_q_A` and `delta_q_A_corrected`; `delta_g_A` for
/// every coordinate; delta_k or, in the lift of Newton's law, delta_energy; `delta_NAME` for every invariant of the
/// user, whose `names` are given.
///
/// # Errors
/// If `out` cannot be written.
pub fn write_residuals<S: Real>(
    out: impl Write,
    line: &WorldLine<S>,
    diagnostics: &SceneDiagnostics<S>,
    names: &[&str],
) -> csv::Result<()> {
    write_table(out, line, residuals(line, diagnostics, names))
}

/// Writes the table of `run --stdout`, which has the columns of both of these tables.
///
/// # Errors
/// If `out` cannot be written.
pub fn write_combined<S: Real>(
    out: impl Write,
    line: &WorldLine<S>,
    diagnostics: &SceneDiagnostics<S>,
    names: &[&str],
) -> csv::Result<()> {
    let mut columns = trajectory(line, diagnostics);
    columns.extend(residuals(line, diagnostics, names));
    write_table(out, line, columns)
}

/// Writes `branches.csv`: gamma, every coordinate with _1, every coordinate with _2. A world-line that is not doubled
/// has no second branch.
///
/// # Errors
/// If `out` cannot be written.
pub fn write_branches<S: Real>(out: impl Write, line: &WorldLine<S>) -> csv::Result<()> {
    let names = line.geometry().names();
    let forward = names.iter().enumerate().map(|(a, name)| (format!("{name}_1"), line.q(a).collect()));
    let backward = names.iter().enumerate().filter_map(|(a, name)| {
        let row = line.backward(a)?.collect();
        Some((format!("{name}_2"), row))
    });
    write_table(out, line, forward.chain(backward).collect())
}

fn trajectory<S: Real>(line: &WorldLine<S>, diagnostics: &SceneDiagnostics<S>) -> Vec<Column<S>> {
    let names = line.geometry().names();
    let positions = names.iter().enumerate().map(|(a, name)| (name.clone(), line.q(a).collect()));
    let velocities = names.iter().zip(&diagnostics.tangent).map(|(name, row)| (format!("{name}_dot"), row.clone()));
    positions.chain(velocities).collect()
}

fn residuals<S: Real>(line: &WorldLine<S>, diagnostics: &SceneDiagnostics<S>, names: &[&str]) -> Vec<Column<S>> {
    let coordinates = line.geometry().names();
    let mut columns = Vec::new();
    for charge in &diagnostics.charges {
        let name = &coordinates[charge.terms[0].0];
        columns.push((format!("delta_q_{name}"), charge.delta.clone()));
        columns.push((format!("delta_q_{name}_corrected"), charge.corrected.clone()));
    }
    for (name, row) in coordinates.iter().zip(&diagnostics.delta_g) {
        columns.push((format!("delta_g_{name}"), row.clone()));
    }
    match &diagnostics.delta_energy {
        Some(energy) => columns.push(("delta_energy".to_owned(), energy.clone())),
        None => columns.push(("delta_k".to_owned(), diagnostics.delta_k.clone())),
    }
    for (name, invariant) in names.iter().zip(&diagnostics.invariants) {
        columns.push((format!("delta_{name}"), invariant.delta.clone()));
    }
    columns
}

/// Writes a header and one row per node: γ, the columns and, with several windows, the number of the window from 1.
fn write_table<S: Real>(out: impl Write, line: &WorldLine<S>, columns: Vec<Column<S>>) -> csv::Result<()> {
    let mut writer = WriterBuilder::new().buffer_capacity(BUFFER).from_writer(out);
    let has_windows = line.windows.len() > 1;
    let names = columns.iter().map(|(name, _)| name.as_str());
    writer.write_record(std::iter::once("gamma").chain(names).chain(has_windows.then_some("window")))?;
    let (mut record, mut room) = (ByteRecord::new(), DecimalRoom::default());
    let windows = line.grids().enumerate().flat_map(|(index, grid)| grid.nodes().map(move |_| index));
    for ((k, gamma), window) in line.gamma().enumerate().zip(windows) {
        record.clear();
        for value in std::iter::once(gamma).chain(columns.iter().map(|(_, values)| values[k])) {
            record.push_field(value.write_decimal(line.digits, &mut room).as_bytes());
        }
        if has_windows {
            record.push_field((window + 1).to_string().as_bytes());
        }
        writer.write_byte_record(&record)?;
    }
    writer.flush()?;
    Ok(())
}
