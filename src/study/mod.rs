//! Studies, which solve many variations of a case with [`crate::solve()`] and compare them with the integrators of
//! [`crate::methods`].
//!
//! ```
//! use geodesic_ivp::case::builtin;
//! use geodesic_ivp::solve::Setup;
//! use geodesic_ivp::study::errors::run_error;
//! use geodesic_ivp::{Case, Solution, solve};
//!
//! let case = Case::parse("morse", builtin::text("morse").expect("it is built in"), &[])?;
//! let solution: Solution = solve(&case)?;
//! let error = run_error(&Setup::from(&case), &solution, &[]).expect("there is a second solve");
//! assert!((1e-4..1e-3).contains(&error.at_most_at_end()[1]), "x is good to three digits");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod acting;
pub mod convergence;
pub mod errors;
mod line;
pub mod many;
pub mod run;
mod space;
pub mod stability;
pub mod verdict;
pub mod work_precision;

pub use space::{Deviations, Point};
