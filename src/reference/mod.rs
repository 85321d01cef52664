//! The reference: a trajectory of the geodesic equations to compare with, by a Taylor method of high order.
//!
//! ```text
//! dx/dγ = w,    dw/dγ = −½ g00′(x) (Q_t/g00(x))²,    dt/dγ = Q_t/g00(x)
//! ```
//!
//! Each step expands t and x in γ: to order 24 for the 16 digits of `f64`, and to higher orders for more digits. The
//! series are computed from the program of the potential, so that every potential of a case has a reference, formulas
//! included. The step is chosen so that the last terms are below the rounding of the first ones, and the states are
//! added up with compensated sums. A step is halved if V has a feature that the series do not show. It ends early where
//! an argument of `abs` changes its sign. The polynomials of the steps are the dense output. The whole integration is
//! done twice, with different orders and steps, and the difference is the reported error estimate. The number of steps
//! is limited, and the limit is lower for more digits, because their steps cost more.
//!
//! ```
//! use geodesic_ivp::geometry::geodesic::InitialData;
//! use geodesic_ivp::geometry::metric::Metric;
//! use geodesic_ivp::geometry::potential::Potential;
//! use geodesic_ivp::reference::ReferenceTrajectory;
//!
//! let metric: Metric = Metric::new(Potential::quartic(0.5), 1.0, 1.0);
//! let initial = InitialData { t: 0.0, x: 1.0, t_dot: 1.0, x_dot: 0.1 };
//! let reference = ReferenceTrajectory::new(&metric, &initial, 1.0, 16)?;
//! assert!((reference.at(1.0).x - 0.159_778_018_885_407).abs() < 1e-14);
//! # Ok::<(), geodesic_ivp::reference::ReferenceEnds>(())
//! ```
//!
//! A scene of n coordinates has the same reference, from its [`Geometry`](crate::geometry::Geometry) and its
//! [`Start`](crate::geometry::Start). The steps know only a system of equations of first order (`equations.rs`); that
//! of one coordinate (`one.rs`) and Hamilton's equations of a scene (`scene.rs`) are two of them, each behind a
//! space-time that is [`Analytic`].

mod analytic;
mod crossings;
mod ends;
mod equations;
mod one;
mod polynomials;
mod scene;
mod series;
mod size;
mod steps;
mod time_parametrised;
mod trajectory;

pub use analytic::Analytic;
pub use ends::{EndReason, ReferenceEnds};
pub use one::ReferencePoint;
pub use scene::ScenePoint;
pub use time_parametrised::{TimeState, time_parametrised};
pub use trajectory::ReferenceTrajectory;
