//! The table of many runs: its rows, the journal that keeps them while it is made, and the join of parts of it.

mod journal;
mod merge;
mod row;
mod rows;
mod summary;

pub use journal::{Identity, Journal};
pub use merge::{Part, join, joined};
pub use row::{Columns, RunRow};
pub use summary::RunsSummary;

/// The table, a row for each run.
pub const RUNS: &str = "runs.csv";
/// The events of all runs.
pub const RUNS_EVENTS: &str = "runs-events.csv";
/// The tables of many runs; the second is only there if they have events.
pub const TABLES: [&str; 2] = [RUNS, RUNS_EVENTS];
/// The rows that are finished, while the table is not.
pub const JOURNAL: &str = "runs.partial.csv";
/// Their events.
pub const JOURNAL_EVENTS: &str = "runs-events.partial.csv";
