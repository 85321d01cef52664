//! What became of a promise.

use std::fmt;

/// What came of a run.
pub(crate) enum Outcome {
    /// There is nothing to compare with: the reference is not accurate enough, or leaves the domain.
    NoReference,
    /// The run says that it cannot.
    Refused(String),
    /// The true error is above the accuracy.
    Broken { error: f64, estimate: f64 },
    /// It is below the accuracy and above the estimate.
    TooLow { error: f64, estimate: f64 },
    /// It is below both.
    Kept { error: f64, estimate: f64 },
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoReference => write!(f, "no reference"),
            Self::Refused(why) => write!(f, "refused, {why}"),
            Self::Broken { error, estimate } => write!(f, "BROKEN, error {error:.1e}, estimate {estimate:.1e}"),
            Self::TooLow { error, estimate } => write!(f, "TOO LOW, error {error:.1e}, estimate {estimate:.1e}"),
            Self::Kept { error, estimate } => write!(f, "kept, error {error:.1e}, estimate {estimate:.1e}"),
        }
    }
}
