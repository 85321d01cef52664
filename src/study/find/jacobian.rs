//! The derivatives of all residuals by all unknowns.
//!
//! Where the linearised equations do not give a column, it is a central difference of two runs. A step of h makes an
//! error of h² there, and what a run is off by makes one of noise/h: with h the cube root of the noise, relative to the
//! size of the unknown, a column is good to the power 2/3 of it. Newton's method needs no more: it converges by that
//! factor in every step, to where the residuals of the runs themselves vanish. Where a run makes more of a small
//! change, as after many turns, the residuals bend over such a step: then it is shorter.

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
    /// What errors of residuals make of an entry, for a change of the unknown as large as its scale.
    pub(super) most_of_errors: f64,
}

/// A step that would be shorter by less stays.
const ALIKE: f64 = 0.5;
/// So many shorter steps are tried.
const SHORTER: usize = 4;

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
        let column = |j: usize| -> Result<Column, NoValue> {
            let known = phi.as_ref().and_then(|phi| chain::column(problem, here, phi, j));
            let known = known.map(|entries| Column { entries, difference: None });
            let column = known.map_or_else(|| difference(problem, here, j), Ok)?;
            let step = column.difference.as_ref().map_or(problem.scales[j], |difference| difference.step);
            let is_seen = |(entry, error): (&f64, &f64)| (entry * step).abs() > *error;
            if column.entries.iter().zip(&here.errors).any(is_seen) {
                Ok(column)
            } else {
                Err(NoValue::independent(&problem.find.unknowns[j].key))
            }
        };
        // Of several columns that there are not, the first is told, whichever is computed first.
        let columns: Vec<_> = (0..here.values.len()).into_par_iter().map(column).collect();
        let columns = columns.into_iter().collect::<Result<Vec<_>, _>>()?;
        let matrix = DMatrix::from_fn(here.residuals.len(), columns.len(), |i, j| columns[j].entries[i]);
        let (mut share, mut most_of_errors) = (share_of(here.noise), 1.0);
        for (j, difference) in columns.iter().enumerate().filter_map(|(j, of)| Some((j, of.difference.as_ref()?))) {
            share = larger(share, difference.share);
            most_of_errors = larger(most_of_errors, problem.scales[j] / difference.step);
        }
        let is_difference = columns.iter().map(|column| column.difference.is_some()).collect();
        Ok(Self { matrix, is_difference, share, most_of_errors })
    }
}

/// The derivatives by one unknown.
struct Column {
    entries: Vec<f64>,
    /// How they were found, if it is a difference of runs.
    difference: Option<Difference>,
}

/// A central difference.
struct Difference {
    /// The change of the unknown to either side.
    step: f64,
    /// The part of it over which errors of the runs and what bends are alike.
    shorter: f64,
    /// The relative error.
    share: f64,
}

/// A central difference of two runs over a step that is short enough.
fn difference(problem: &Problem, here: &Evaluation, j: usize) -> Result<Column, NoValue> {
    let mut step = here.noise.cbrt() * larger(problem.scales[j], here.values[j].abs());
    let mut column = difference_over(problem, here, j, step)?;
    for _ in 0..SHORTER {
        let shorter = column.difference.as_ref().map_or(1.0, |difference| difference.shorter);
        if shorter >= ALIKE || shorter.is_nan() {
            break;
        }
        step *= larger(shorter, 1e-3);
        column = difference_over(problem, here, j, step)?;
    }
    Ok(column)
}

/// A central difference over ± a step.
fn difference_over(problem: &Problem, here: &Evaluation, j: usize, step: f64) -> Result<Column, NoValue> {
    let beside = |change: f64| {
        let mut values = here.values.clone();
        values[j] += change;
        problem.evaluate(&values, false)
    };
    let (above, below) = (beside(step)?, beside(-step)?);
    // The unknowns are rounded: their distance is not quite twice the step.
    let distance = above.values[j] - below.values[j];
    let (mut change, mut bent) = (0.0_f64, 0.0_f64);
    for (here, (above, below)) in here.residuals.iter().zip(above.residuals.iter().zip(&below.residuals)) {
        change = change.hypot(above - below);
        bent = bent.hypot(above + below - 2.0 * here);
    }
    let noise = here.errors.iter().fold(0.0_f64, |sum, error| sum.hypot(*error));
    // Relative to the change, what bends makes an error of its square, and runs one of noise/change.
    let bend = if bent > 4.0 * noise { bent / change } else { 0.0 };
    let shorter = (noise / (change * bend * bend)).cbrt();
    let entries = above.residuals.iter().zip(&below.residuals).map(|(above, below)| (above - below) / distance);
    let share = if bend > 0.0 { larger(noise / change, bend * bend) } else { 0.0 };
    Ok(Column { entries: entries.collect(), difference: Some(Difference { step, shorter, share }) })
}
