//! The distance of a run from the world-line of the continuum.
//!
//! A run to an accuracy has an estimate of its own. Another is compared with a second solve by [`crate::engine`], which
//! shares neither grid nor operator with it and costs little. A run in extended precision that agrees with it to its
//! last digits is compared with the Taylor series of [`crate::reference`] in the same precision, and so is any run for
//! which that is wanted.

mod chain;
mod points;
mod run_error;
mod second_solve;
mod stepped_over;
mod taylor;

pub(crate) use chain::chain_error;
pub use run_error::{Judge, RunError};

use self::points::Points;
use self::stepped_over::own_windows;
use crate::number::Real;
use crate::solve::{Limit, Setup, WorldLine};
use crate::trajectory::Sample;

/// If the errors of an extended run are below this, relative to the sizes of the coordinates, they are measured in
/// extended precision.
const BEYOND_F64: f64 = 1e-11;

/// The error of the run of `setup`, of which only its last part, `line`, and `samples` of all of it may be kept; `None`
/// if no second solve reaches the end.
pub fn run_error<S: Real>(setup: &Setup<S>, line: &WorldLine<S>, samples: &[Sample<S>]) -> Option<RunError> {
    if let Some(estimate) = line.error_estimate {
        let largest: Vec<f64> = line.sizes.iter().map(|size| estimate * size).collect();
        let mut end = largest.clone();
        clock(setup, line).into_iter().for_each(|clock| end[clock] = 0.0);
        let own = vec![0.0; largest.len()];
        return Some(RunError { end, largest, own, judge: Judge::OwnEstimate, stepped_over: own_windows(setup, line) });
    }
    let points = Points::new(line, samples, clock(setup, line));
    let found = second_solve::compare(&setup.rough, &points);
    let is_beyond = |error: &RunError| {
        let sizes = points.sizes();
        error.at_most().iter().zip(&sizes).all(|(most, size)| *most <= BEYOND_F64 * size)
    };
    if S::IS_EXTENDED && found.as_ref().is_none_or(is_beyond) {
        taylor::compare(line, &points).or(found)
    } else {
        found
    }
}

/// The same against a Taylor reference of as many digits; `None` if that does not reach the end.
pub fn reference_error<S: Real>(setup: &Setup<S>, line: &WorldLine<S>, samples: &[Sample<S>]) -> Option<RunError> {
    taylor::compare(line, &Points::new(line, samples, clock(setup, line)))
}

/// The coordinate whose value ended the run, if one did.
fn clock<S: Real>(setup: &Setup<S>, line: &WorldLine<S>) -> Option<usize> {
    match setup.limit {
        Limit::Value { coordinate, .. } if line.ended_by.is_none() => Some(coordinate),
        _ => None,
    }
}
