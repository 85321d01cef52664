//! Why there is no next window.

use crate::geometry::OutsideGeometry;

/// Why there is no next window.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum Failure {
    /// A node is outside the domain.
    #[error("the motion leaves the domain")]
    OutsideDomain(OutsideGeometry),
    /// Sweeps do not converge.
    #[error("sweeps over a window do not converge")]
    NotConverged,
    /// No window is short enough for the accuracy.
    #[error("no window is short enough for the accuracy")]
    TooShort,
    /// Windows add up to more than the accuracy: after [`Engine::begin_again`](super::Engine::begin_again) they are
    /// shorter.
    #[error("windows add up to more than the accuracy: the run is to be begun again")]
    BeginAgain,
    /// A run to a value of a coordinate comes no nearer to it.
    #[error("the run comes no nearer to the value at which it is to end")]
    ValueNotReached,
    /// Rounding errors alone add up to more than the accuracy.
    #[error("rounding errors alone add up to more than the accuracy")]
    Rounding,
}

impl Failure {
    /// A word for files.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::OutsideDomain(_) => "outside-domain",
            Self::NotConverged | Self::TooShort => "not-converged",
            Self::ValueNotReached => "end-time-not-reached",
            Self::BeginAgain | Self::Rounding => "accuracy-not-reached",
        }
    }
}
