//! The CSV tables of `run`. Numbers are the shortest decimals that read back to the same `f64`; extended ones have as many
//! significant digits as are asked for.

use std::io::Write;

use csv::{ByteRecord, WriterBuilder};

use crate::diagnostics::Diagnostics;
use crate::sampling::Sample;
use crate::scalar::{DecimalRoom, Real};
use crate::solve::{Backward, Solution};

/// Bytes handed to the operating system at a time.
const BUFFER: usize = 1 << 18;

/// `trajectory.csv`: gamma,t,x,t_dot,x_dot.
///
/// # Errors
/// Whatever `out` reports.
pub fn write_trajectory<S: Real>(
    out: impl Write,
    solution: &Solution<S>,
    diagnostics: &Diagnostics<S>,
) -> csv::Result<()> {
    write_table(out, solution, &["gamma", "t", "x", "t_dot", "x_dot"], |k, push| {
        trajectory_row(solution, diagnostics, k, push);
    })
}

/// `residuals.csv`: gamma,delta_q_t,delta_q_t_corrected,delta_g_t,delta_g_x,delta_k.
///
/// # Errors
/// Whatever `out` reports.
pub fn write_residuals<S: Real>(
    out: impl Write,
    solution: &Solution<S>,
    diagnostics: &Diagnostics<S>,
) -> csv::Result<()> {
    let header = ["gamma", "delta_q_t", "delta_q_t_corrected", "delta_g_t", "delta_g_x", "delta_k"];
    write_table(out, solution, &header, |k, push| residual_row(diagnostics, k, push))
}

/// `run --stdout`: the columns of both tables.
///
/// # Errors
/// Whatever `out` reports.
pub fn write_combined<S: Real>(
    out: impl Write,
    solution: &Solution<S>,
    diagnostics: &Diagnostics<S>,
) -> csv::Result<()> {
    let header =
        ["gamma", "t", "x", "t_dot", "x_dot", "delta_q_t", "delta_q_t_corrected", "delta_g_t", "delta_g_x", "delta_k"];
    write_table(out, solution, &header, |k, push| {
        trajectory_row(solution, diagnostics, k, push);
        residual_row(diagnostics, k, push);
    })
}

/// `branches.csv`: gamma,t_1,x_1,t_2,x_2.
///
/// # Errors
/// Whatever `out` reports.
pub fn write_branches<S: Real>(out: impl Write, solution: &Solution<S>, backward: &Backward<S>) -> csv::Result<()> {
    write_table(out, solution, &["gamma", "t_1", "x_1", "t_2", "x_2"], |k, push| {
        push(solution.t_i + solution.elapsed[k]);
        push(solution.x[k]);
        push(solution.t_i + backward.elapsed[k]);
        push(backward.x[k]);
    })
}

/// `samples.csv`: gamma,t,x,t_dot,x_dot, with so many significant digits.
///
/// # Errors
/// Whatever `out` reports.
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

fn trajectory_row<S: Real>(solution: &Solution<S>, diagnostics: &Diagnostics<S>, k: usize, push: &mut dyn FnMut(S)) {
    push(solution.t_i + solution.elapsed[k]);
    push(solution.x[k]);
    push(diagnostics.t_dot[k]);
    push(diagnostics.x_dot[k]);
}

fn residual_row<S: Real>(diagnostics: &Diagnostics<S>, k: usize, push: &mut dyn FnMut(S)) {
    push(diagnostics.charges.delta_q_t[k]);
    push(diagnostics.charges.delta_q_t_corrected[k]);
    push(diagnostics.residuals.delta_g_t[k]);
    push(diagnostics.residuals.delta_g_x[k]);
    push(diagnostics.charges.delta_k[k]);
}

/// A header, then a row a node: γ and whatever `row` pushes for the node.
fn write_table<S: Real>(
    out: impl Write,
    solution: &Solution<S>,
    header: &[&str],
    row: impl Fn(usize, &mut dyn FnMut(S)),
) -> csv::Result<()> {
    let mut writer = WriterBuilder::new().buffer_capacity(BUFFER).from_writer(out);
    writer.write_record(header)?;
    let mut record = ByteRecord::new();
    let mut room = DecimalRoom::default();
    for (k, gamma) in solution.gamma().enumerate() {
        record.clear();
        let mut push = |value: S| record.push_field(value.write_decimal(solution.digits, &mut room).as_bytes());
        push(gamma);
        row(k, &mut push);
        writer.write_byte_record(&record)?;
    }
    writer.flush()?;
    Ok(())
}
