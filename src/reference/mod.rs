//! The reference: a trajectory of Hamilton's equations to compare with, by a Taylor method of high order.
//!
//! Each step expands positions and momenta in γ: to order 24 for the 16 digits of `f64`, and to higher orders for more
//! digits. The series are computed from the program of the equations, so that every scene has a reference. The step is
//! chosen so that the last terms are below the rounding of the first ones, and the states are added up with compensated
//! sums. A step is halved if a formula has a feature that the series do not show. It ends early where an argument of
//! `abs` changes its sign. The polynomials of the steps are the dense output. The whole integration is done twice, with
//! different orders and steps, and the difference is the reported error estimate. The number of steps is limited, and
//! the limit is lower for more digits, because their steps cost more.

mod equations;
mod series;
mod steps;
mod time_parametrised;
mod trajectory;

pub use time_parametrised::time_parametrised;
pub use trajectory::ReferenceTrajectory;

use std::fmt;

use crate::geometry::Geometry;
use crate::number::Real;

/// Why a reference trajectory ends early.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EndReason {
    /// The trajectory meets g00 ≤ 0 or a point where V is not finite; in a scene, a point where a determinant of the
    /// metric changes its sign or a number is not finite.
    OutsideDomain,
    /// V, or another formula, is not smooth enough there to be expanded in a series.
    Singular,
    /// The requested physical time, or value of a coordinate, is not reached, because t hardly grows any more.
    TimeNotReached,
    /// The range would take more Taylor steps than are allowed.
    TooLong {
        /// The number of steps that are allowed.
        most_steps: usize,
    },
}

/// The error that a reference trajectory ends before the end of the requested range.
#[derive(Debug, Clone, PartialEq)]
pub struct ReferenceEnds {
    /// Why it ends.
    pub reason: EndReason,
    /// γ − γ_i where it ends.
    pub gamma: f64,
    /// The coordinates there, with their names; in one coordinate x and g00.
    pub place: Vec<(String, f64)>,
    /// True in one coordinate, where messages speak of the potential and of time.
    is_of_x: bool,
}

impl ReferenceEnds {
    /// A trajectory in `geometry` that ends where the coordinates are `q`.
    pub(super) fn new<S: Real>(geometry: &Geometry<S>, reason: EndReason, gamma: S, q: &[S]) -> Self {
        let g00 = geometry.g00(q);
        let place = match g00 {
            Some(g00) => [("x", q[1]), ("g00", g00)].map(|(name, value)| (name.to_owned(), value.to_f64())).to_vec(),
            None => geometry.names().iter().cloned().zip(q.iter().map(|q| q.to_f64())).collect(),
        };
        Self { reason, gamma: gamma.to_f64(), place, is_of_x: g00.is_some() }
    }
}

impl fmt::Display for ReferenceEnds {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the reference trajectory ends at gamma - gamma_i = {:.6}", self.gamma)?;
        for (name, value) in &self.place {
            write!(f, ", {name} = {value:.6e}")?;
        }
        match self.reason {
            EndReason::OutsideDomain => f.write_str(": the geodesic leaves the domain"),
            EndReason::Singular if self.is_of_x => f.write_str(": the potential has no Taylor series"),
            EndReason::Singular => f.write_str(": a formula has no Taylor series"),
            EndReason::TimeNotReached if self.is_of_x => f.write_str(": the physical time t_f is not reached"),
            EndReason::TimeNotReached => f.write_str(": the value of the coordinate is not reached"),
            EndReason::TooLong { most_steps: most } => {
                write!(f, ": the whole run would take more than {most} Taylor steps, the limit for so many digits")
            }
        }
    }
}

impl std::error::Error for ReferenceEnds {}
