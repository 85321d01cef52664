//! World-lines of a scene of n coordinates by windows of the weak scheme, of an accuracy that is asked for.
//!
//! On one window the critical point of the weak action is the Lobatto IIIC method on Hamilton's equations of the active
//! coordinates; ignorable coordinates are quadratures and their momenta numbers. Where the kinetic part is constant,
//! q̈ = a(q) is solved with A² in one product for each coordinate; otherwise sweeps take momenta first, then positions
//! with the new momenta.
//!
//! Lengths are chosen from the highest Legendre modes of the rates, which show what a window adds to the error. What
//! errors grow to is seen from a *probe*, small errors that travel along with the world-line by its linearised
//! equations.

mod attempt;
mod certificate;
mod course;
mod enclosed;
mod growth;
mod guess;
mod judge;
mod march;
mod nodes;
mod probe;
mod request;
mod rule;
mod state;
mod stop;
mod tables;
#[cfg(test)]
mod tests;
mod transport;
mod tuning;
mod unknowns;
mod view;
mod window;
mod work;

pub use march::Flow;
pub use state::FlowState;
pub use stop::{PhasePoint, Stop};
pub use view::FlowView;

use super::Statistics;
use crate::geometry::OutsideGeometry;

/// Where a march ended.
#[derive(Debug, Clone)]
pub struct Followed {
    /// The last state.
    pub end: FlowState,
    /// γ − γ_i there.
    pub gamma: f64,
    /// Which of the stops ended it, if one did.
    pub stopped_by: Option<usize>,
    /// The work done, including rejected windows. An evaluation is a sweep.
    pub statistics: Statistics,
    /// An upper estimate of the error of every coordinate at all nodes, relative to max(1, largest |q^a|) for active
    /// coordinates and max(1, largest |q^a − q_i^a|) for ignorable ones.
    pub error_estimate: f64,
    /// How often the march was begun; every attempt but the last turned out not to be accurate enough.
    pub attempts: usize,
}

/// Why the march along a world-line of a scene ends early.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FlowFailure {
    /// The world-line leaves the domain.
    #[error("the world-line leaves the domain at gamma - gamma_i = {gamma:.6}")]
    OutsideDomain {
        /// γ − γ_i there.
        gamma: f64,
        /// q^a of all coordinates there.
        q: Vec<f64>,
        /// What is wrong there.
        outside: OutsideGeometry,
    },
    /// No window converges, however short.
    #[error("no window converges at gamma - gamma_i = {gamma:.6}")]
    NotConverged {
        /// γ − γ_i at its start.
        gamma: f64,
        /// q^a of all coordinates there.
        q: Vec<f64>,
    },
    /// The accuracy is beyond what the arithmetic can keep on a run of this length.
    #[error("the accuracy is not reached: the error is about {estimate:.1e} at gamma - gamma_i = {gamma:.6}")]
    AccuracyNotReached {
        /// γ − γ_i where that was found.
        gamma: f64,
        /// q^a of all coordinates there.
        q: Vec<f64>,
        /// The estimated error there, relative to the sizes of the coordinates.
        estimate: f64,
    },
    /// The march makes so little progress that it would need more evaluations than anybody would wait for.
    #[error("no progress after {evaluations} evaluations, at gamma - gamma_i = {gamma:.6e}")]
    EvaluationLimit {
        /// γ − γ_i where it was stopped.
        gamma: f64,
        /// q^a of all coordinates there.
        q: Vec<f64>,
        /// Evaluations of all nodes of a window so far.
        evaluations: usize,
        /// How many it would need at its pace; infinite if it has not moved.
        needed: f64,
    },
}
