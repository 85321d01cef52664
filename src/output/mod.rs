//! Files and tables. Nothing here prints to a terminal.
//!
//! ```
//! use geodesic_ivp::case::builtin;
//! use geodesic_ivp::diagnostics::Diagnostics;
//! use geodesic_ivp::output::Summary;
//! use geodesic_ivp::{Case, Solution, solve};
//!
//! let case = Case::parse("free", builtin::text("free").expect("it is built in"), &[])?;
//! let solution: Solution = solve(&case)?;
//! let diagnostics = Diagnostics::new(&solution);
//! let summary = Summary::new(&case, Ok((&solution, &diagnostics.measures)), 0.0).to_json();
//! assert!(summary.contains("\"status\": \"converged\""));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod chart;
mod convergence;
mod files;
mod lock;
mod manifest;
mod number;
pub mod pictures;
pub mod runs;
mod stability;
mod summary;
pub mod tables;
mod work_precision;

pub use chart::{Chart, Ink, Kind, Look, Map, Mark, Panel, Scale, Series, Shape, Sign};
pub use convergence::{ConvergenceSummary, write_convergence, write_slopes};
pub use files::{CASE, NotOurs, OutputSet, SUMMARY, Target};
pub use manifest::{Origin, origin_of};
pub use number::Number;
pub use stability::{Border, Onset, StabilitySummary, borders, onsets, write_stability};
pub use summary::{
    Coordinates, Error, Failed, Outcome, Point, SceneSummary, Seconds, Solved, SolvedScene, Summary, SummaryOf,
    json_object,
};
pub use tables::{write_branches, write_combined, write_events, write_residuals, write_samples, write_trajectory};
pub use work_precision::{WorkPrecisionSummary, read_rows, write_drift, write_work_precision};
