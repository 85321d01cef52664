//! The error of the run of a case, see [`crate::study::errors`].

use crate::case::Case;
use crate::number::Real;
use crate::solve::Solution;
use crate::study::errors;
use crate::trajectory::Sample;

pub use crate::study::errors::{Judge, RunError};

/// The error of `solution`, which must be the whole run of `case`; `None` if no second solve is possible.
pub fn run_error<S: Real>(case: &Case, solution: &Solution<S>) -> Option<RunError> {
    error_with_samples(case, solution, &[])
}

/// The error of a run of `case` of which only its last part, the `solution`, and `samples` of all of it are kept.
pub fn error_with_samples<S: Real>(case: &Case, solution: &Solution<S>, samples: &[Sample<S>]) -> Option<RunError> {
    errors::run_error(&case.into(), solution, samples)
}
