//! The CSV tables of `run`. Numbers are the shortest decimals that read back to the same `f64`; extended numbers have
//! as many significant digits as the case asks for.

use std::io::Write;

use csv::{ByteRecord, WriterBuilder};

use crate::diagnostics::Diagnostics;
use crate::sampling::Sample;
use crate::scalar::{DecimalRoom, Real};
use crate::solve::{Backward, Solution};

/// The tables are written in blocks of this many bytes.
pub(super) const BUFFER: usize = 1 << 18;

/// Writes `trajectory.csv` with the columns gamma,t,x,t_dot,x_dot. With several windows, this table and those below
/// have also the column window. t_dot and x_dot are those of [`Diagnostics::tangent`].
///
/// # Errors
/// If `out` cannot be written.
pub fn write_trajectory<S: Real>(
    out: impl Write,
    solution: &Solution<S>,
    diagnostics: &Diagnostics<S>,
) -> csv::Result<()> {
    let [t_dot, x_dot] = diagnostics.tangent(solution);
    write_table(out, solution, ["gamma", "t", "x", "t_dot", "x_dot"], |gamma, start, k| {
        let t = solution.t_i + (start + solution.elapsed[k]);
        [gamma, t, solution.x[k], t_dot[k], x_dot[k]]
    })
}

/// Writes `residuals.csv` with the columns gamma,delta_q_t,delta_q_t_corrected,delta_g_t,delta_g_x,delta_k.
///
/// # Errors
/// If `out` cannot be written.
pub fn write_residuals<S: Real>(
    out: impl Write,
    solution: &Solution<S>,
    diagnostics: &Diagnostics<S>,
) -> csv::Result<()> {
    let header = ["gamma", "delta_q_t", "delta_q_t_corrected", "delta_g_t", "delta_g_x", "delta_k"];
    write_table(out, solution, header, |gamma, _, k| {
        let [a, b, c, d, e] = residuals(diagnostics, k);
        [gamma, a, b, c, d, e]
    })
}

/// Writes the table of `run --stdout`, which has the columns of both of these tables.
///
/// # Errors
/// If `out` cannot be written.
pub fn write_combined<S: Real>(
    out: impl Write,
    solution: &Solution<S>,
    diagnostics: &Diagnostics<S>,
) -> csv::Result<()> {
    let header =
        ["gamma", "t", "x", "t_dot", "x_dot", "delta_q_t", "delta_q_t_corrected", "delta_g_t", "delta_g_x", "delta_k"];
    let [t_dot, x_dot] = diagnostics.tangent(solution);
    write_table(out, solution, header, |gamma, start, k| {
        let t = solution.t_i + (start + solution.elapsed[k]);
        let [a, b, c, d, e] = residuals(diagnostics, k);
        [gamma, t, solution.x[k], t_dot[k], x_dot[k], a, b, c, d, e]
    })
}

/// Writes `branches.csv` with the columns gamma,t_1,x_1,t_2,x_2.
///
/// # Errors
/// If `out` cannot be written.
pub fn write_branches<S: Real>(out: impl Write, solution: &Solution<S>, backward: &Backward<S>) -> csv::Result<()> {
    write_table(out, solution, ["gamma", "t_1", "x_1", "t_2", "x_2"], |gamma, start, k| {
        let [t_1, t_2] = [&solution.elapsed, &backward.elapsed].map(|t| solution.t_i + (start + t[k]));
        [gamma, t_1, solution.x[k], t_2, backward.x[k]]
    })
}

/// Writes `samples.csv` with the columns gamma,t,x,t_dot,x_dot. γ and t are those of the case, not counted from the
/// start. Extended numbers have `digits` significant digits.
///
/// # Errors
/// If `out` cannot be written.
pub fn write_samples<S: Real>(
    out: impl Write,
    samples: impl Iterator<Item = Sample<S>>,
    digits: u32,
) -> csv::Result<()> {
    let mut writer = WriterBuilder::new().buffer_capacity(BUFFER).from_writer(out);
    writer.write_record(["gamma", "t", "x", "t_dot", "x_dot"])?;
    let mut room = DecimalRoom::default();
    for Sample { gamma, t, x, t_dot, x_dot } in samples {
        for value in [gamma, t, x, t_dot, x_dot] {
            writer.write_field(value.write_decimal(digits, &mut room))?;
        }
        writer.write_record(None::<&[u8]>)?;
    }
    writer.flush()?;
    Ok(())
}

/// The columns of `residuals.csv` after the first, at node k.
fn residuals<S: Real>(diagnostics: &Diagnostics<S>, k: usize) -> [S; 5] {
    let (charges, residuals) = (&diagnostics.charges, &diagnostics.residuals);
    [
        charges.delta_q_t[k],
        charges.delta_q_t_corrected[k],
        residuals.delta_g_t[k],
        residuals.delta_g_x[k],
        charges.delta_k[k],
    ]
}

/// Writes a header and one row per node. The arguments of `row` are γ, t − t_i at the start of the window, and the
/// index of the node in the arrays. With several windows, a last column counts them from 1.
fn write_table<S: Real, const COLUMNS: usize>(
    out: impl Write,
    solution: &Solution<S>,
    header: [&str; COLUMNS],
    row: impl Fn(S, S, usize) -> [S; COLUMNS],
) -> csv::Result<()> {
    let mut writer = WriterBuilder::new().buffer_capacity(BUFFER).from_writer(out);
    let windows = solution.windows.len() > 1;
    writer.write_record(header.iter().chain(windows.then_some(&"window")))?;
    let mut record = ByteRecord::new();
    let mut room = DecimalRoom::default();
    for (index, view) in solution.views().enumerate() {
        for (k, node) in view.grid.nodes().enumerate() {
            record.clear();
            let gamma = solution.gamma_i + view.grid.gamma_at(k);
            for value in row(gamma, view.window.start.t, node) {
                record.push_field(value.write_decimal(solution.digits, &mut room).as_bytes());
            }
            if windows {
                record.push_field((index + 1).to_string().as_bytes());
            }
            writer.write_byte_record(&record)?;
        }
    }
    writer.flush()?;
    Ok(())
}
