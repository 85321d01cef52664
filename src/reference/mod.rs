//! The trajectory to compare with: the geodesic equations integrated by a Taylor method of high order.
//!
//! ```text
//! dx/dγ = w,    dw/dγ = −½ g00′(x) (Q_t/g00(x))²,    dt/dγ = Q_t/g00(x)
//! ```
//!
//! Each step expands t and x in γ to order 24 from the potential's own program, so every potential of a case has a
//! reference, formulas included. The step is chosen so that the last terms are below the rounding of the first; the
//! state is summed with compensation. A step stops where an argument of `abs` changes its sign. The polynomials of the
//! steps are the dense output. The whole integration is done twice, with different order and steps, and the difference
//! is the reported error estimate.

mod series;
mod steps;
mod time_parametrised;

pub use time_parametrised::{TimeState, time_parametrised};

use std::fmt;

use crate::geodesic::InitialData;
use crate::metric::Metric;

use self::steps::{Goal, Steps};

/// Order of the trajectory that is used.
const ORDER: usize = 24;
/// Order and share of the step of the one that checks it.
const CHECK_ORDER: usize = 20;
const CHECK_STEP: f64 = 0.7;

/// A point of the reference trajectory.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReferencePoint {
    /// t − t_i.
    pub elapsed: f64,
    /// x.
    pub x: f64,
    /// dt/dγ.
    pub t_dot: f64,
    /// dx/dγ.
    pub x_dot: f64,
}

/// Why a reference trajectory ends early.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EndReason {
    /// It meets g00 ≤ 0 or a point where V is not finite.
    OutsideDomain,
    /// V is not smooth enough there to be expanded in a series.
    Singular,
    /// The physical time asked for is not reached: t hardly grows any more.
    TimeNotReached,
}

/// There is no trajectory to compare with over the whole range.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReferenceEnds {
    /// Why.
    pub reason: EndReason,
    /// γ − γ_i where it ends.
    pub gamma: f64,
    /// x there.
    pub x: f64,
    /// g00 there.
    pub g00: f64,
}

impl fmt::Display for ReferenceEnds {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let what = match self.reason {
            EndReason::OutsideDomain => "the geodesic leaves the domain",
            EndReason::Singular => "the potential has no Taylor series",
            EndReason::TimeNotReached => "the physical time t_f is not reached",
        };
        let Self { gamma, x, g00, .. } = self;
        write!(f, "the reference trajectory ends at gamma - gamma_i = {gamma:.6}, x = {x:.6e}, g00 = {g00:.3e}: {what}")
    }
}

impl std::error::Error for ReferenceEnds {}

/// A trajectory of the geodesic equations with its own error estimate.
#[derive(Debug, Clone)]
pub struct ReferenceTrajectory {
    steps: Steps,
    error_estimate: f64,
}

impl ReferenceTrajectory {
    /// The geodesic of `metric` from `initial` over γ − γ_i ∈ [0, `length`]. Time counts from the start.
    ///
    /// # Errors
    /// [`ReferenceEnds`] if it meets g00 ≤ 0 or a singularity of V.
    pub fn new(metric: &Metric, initial: InitialData, length: f64) -> Result<Self, ReferenceEnds> {
        let steps = Steps::integrate(metric, initial, Goal::Gamma(length), ORDER, 1.0)?;
        let check = Steps::integrate(metric, initial, Goal::Gamma(length), CHECK_ORDER, CHECK_STEP)?;
        let error_estimate = steps.distance(&check);
        Ok(Self { steps, error_estimate })
    }

    /// The value of γ − γ_i at which t − t_i = `duration`.
    ///
    /// # Errors
    /// [`ReferenceEnds`] if the geodesic leaves the domain before that time.
    pub fn length_of(metric: &Metric, initial: InitialData, duration: f64) -> Result<f64, ReferenceEnds> {
        Steps::integrate(metric, initial, Goal::Time(duration), ORDER, 1.0).map(|steps| steps.end())
    }

    /// The largest difference in t or x, relative to the largest |t − t_i| or |x|, between this trajectory and one of
    /// another order and step, over the ends of its steps.
    pub fn error_estimate(&self) -> f64 {
        self.error_estimate
    }

    /// Number of Taylor steps.
    pub fn steps(&self) -> usize {
        self.steps.len()
    }

    /// The point at γ − γ_i = `gamma`, inside the range it was made for.
    pub fn at(&self, gamma: f64) -> ReferencePoint {
        self.steps.at(gamma)
    }
}
