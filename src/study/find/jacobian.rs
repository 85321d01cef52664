//! The derivatives of all residuals by all unknowns.
//!
//! Where the linearised equations do not give a column, it is a central difference of two runs. A step of h makes an
//! error of h² there, and what a run is off by makes one of noise/h: with h the cube root of the noise, relative to the
//! size of the unknown, a column is good to the power 2/3 of it. Newton's method needs no more: it converges by that
//! factor in every step, to where the residuals of the runs themselves vanish.

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::chain;
use super::problem::{Evaluation, NoValue, Problem};
use crate::number::norm::larger;

/// The derivatives at an evaluation.
#[derive(Debug, Clone)]
pub(super) struct Jacobian {
    /// A row for each residual, a column for each unknown.
    pub(super) matrix: DMatrix<f64>,
    /// True for every column that is a difference of runs.
    pub(super) is_difference: Vec<bool>,
    /// The relative error of its entries.
    pub(super) share: f64,
}

/// The relative error of a central difference of numbers with this relative error.
pub(super) fn share_of(noise: f64) -> f64 {
    noise.powf(2.0 / 3.0)
}

impl Jacobian {
    /// The derivatives at an evaluation.
    ///
    /// # Errors
    /// [`NoValue`] where a run beside it is needed and has no solution, or does not depend on an unknown.
    pub(super) fn new(problem: &Problem, here: &Evaluation) -> Result<Self, NoValue> {
        let phi = chain::matrix(&here.run.line).filter(|_| problem.is_linearised);
        let column = |j: usize| -> Result<(Vec<f64>, bool), NoValue> {
            let known = phi.as_ref().and_then(|phi| chain::column(problem, here, phi, j));
            let is_difference = known.is_none();
            let column = known.map_or_else(|| difference(problem, here, j), Ok)?;
            let scale = if is_difference { step(problem, here, j) } else { problem.scales[j] };
            let is_seen = |(entry, error): (&f64, &f64)| (entry * scale).abs() > *error;
            if !column.iter().zip(&here.errors).any(is_seen) {
                return Err(NoValue::independent(&problem.find.unknowns[j].key));
            }
            Ok((column, is_difference))
        };
        // Of several columns that there are not, the first is told, whichever is computed first.
        let columns: Vec<_> = (0..here.values.len()).into_par_iter().map(column).collect();
        let columns = columns.into_iter().collect::<Result<Vec<_>, _>>()?;
        let matrix = DMatrix::from_fn(here.residuals.len(), columns.len(), |i, j| columns[j].0[i]);
        let is_difference: Vec<bool> = columns.iter().map(|(_, is_difference)| *is_difference).collect();
        Ok(Self { matrix, is_difference, share: share_of(here.noise) })
    }
}

fn step(problem: &Problem, here: &Evaluation, j: usize) -> f64 {
    here.noise.cbrt() * larger(problem.scales[j], here.values[j].abs())
}

/// A central difference of two runs.
fn difference(problem: &Problem, here: &Evaluation, j: usize) -> Result<Vec<f64>, NoValue> {
    let h = step(problem, here, j);
    let beside = |change: f64| {
        let mut values = here.values.clone();
        values[j] += change;
        problem.evaluate(&values, false)
    };
    let (above, below) = (beside(h)?, beside(-h)?);
    // The unknowns are rounded: their distance is not quite 2h.
    let distance = above.values[j] - below.values[j];
    Ok(above.residuals.iter().zip(&below.residuals).map(|(above, below)| (above - below) / distance).collect())
}
