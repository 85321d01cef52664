//! The reference: a trajectory of Hamilton's equations to compare with, by a Taylor method of high order.
//!
//! Each step expands positions and momenta in γ: to order 24 for the 16 digits of `f64`, and to higher orders for more
//! digits. The series are computed from the program of the equations, so that every scene has a reference. The step is
//! chosen so that the last terms are below the rounding of the first ones, and the states are added up with compensated
//! sums. A step is halved if a formula has a feature that the series do not show. It ends early where an argument of
//! `abs` changes its sign. The polynomials of the steps are the dense output. The whole integration is done twice, with
//! different orders and steps, and the difference is the reported error estimate. The number of steps is limited, and
//! the limit is lower for more digits, because their steps cost more.

mod ends;
mod equations;
mod series;
mod size;
mod steps;
mod time_parametrised;
mod trajectory;

pub use ends::{EndReason, ReferenceEnds};
pub use time_parametrised::time_parametrised;
pub use trajectory::ReferenceTrajectory;
