//! The error of the run of a case, see [`crate::errors`].

use crate::Numeric;
use crate::case::Case;
use crate::errors;
use crate::sampling::Sample;
use crate::solve::Solution;

pub use crate::errors::{Judge, RunError};

/// The error of `solution`, which must be the whole run of `case`; `None` if no second solve is possible.
pub fn run_error<S: Numeric>(case: &Case, solution: &Solution<S>) -> Option<RunError> {
    error_with_samples(case, solution, &[])
}

/// The error of a run of `case` of which only its last part, the `solution`, and `samples` of all of it are kept.
pub fn error_with_samples<S: Numeric>(case: &Case, solution: &Solution<S>, samples: &[Sample<S>]) -> Option<RunError> {
    errors::run_error(&case.into(), solution, samples)
}
