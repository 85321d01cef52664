//! Files and tables. Nothing here prints to a terminal.
//!
//! ```
//! use geodesic_ivp::case::builtin;
//! use geodesic_ivp::Case;
//! use geodesic_ivp::output::run_summary;
//! use geodesic_ivp::study::run::{Run, Wanted, run};
//!
//! let case = Case::parse("free", builtin::text("free").expect("it is built in"), &[])?;
//! let setup = case.setup();
//! let (found, seconds) = run(&case, &setup, Wanted::default());
//! let found: Run = found.expect("it has a solution");
//! let summary = run_summary(&case, &found, &found.judged(&setup, false, false), [seconds, 0.0]);
//! assert!(summary.contains("\"status\": \"converged\""));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod chart;
mod convergence;
mod family;
mod files;
mod find;
mod hull;
mod json;
mod leftovers;
mod lock;
pub mod npy;
pub mod pictures;
pub mod runs;
mod stability;
pub mod streamed;
mod study_table;
mod summary;
pub mod tables;
mod work_precision;

pub use chart::{Chart, Kind, Map, Mark, Panel, Scale, Series, Shape, Sign, Style};
pub use convergence::{convergence_summary, convergence_table, slopes_table};
pub use family::{family_summary, starts_summary, write_members, write_starts};
pub use files::{CASE, Origin, OutputSet, Refused, SUMMARY, Target, origin_of, refused, refused_by_system};
pub use find::{find_summary, not_found_summary, write_fit, write_iterates};
pub use hull::write_hull;
pub use json::json_object;
pub use stability::{stability_summary, stability_table};
pub use study_table::StudyTable;
pub use summary::{failure_summary, run_summary};
pub use work_precision::{drift_table, read_rows, work_precision_summary, work_precision_table};
