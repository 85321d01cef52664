//! Where the run of a case ends, counted from its start.

use crate::number::Real;
use crate::solve::Limit;

/// Where a run ends, counted from its start.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum End<S = f64> {
    /// At γ_f. The number is the length γ_f − γ_i of the range of γ.
    Length(S),
    /// At the physical time t_f. The number is the duration t_f − t_i.
    Duration(S),
}

impl<S: Real> End<S> {
    /// The end of a run with this limit, in which coordinates start at `start`.
    pub(super) fn new(limit: Limit<S>, start: impl FnOnce(usize) -> S) -> Self {
        match limit {
            Limit::Length(length) => Self::Length(length),
            Limit::Value { coordinate, value } => Self::Duration(value - start(coordinate)),
        }
    }
}
