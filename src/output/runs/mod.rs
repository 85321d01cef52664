//! The table of many runs: its rows, the journal that keeps them while it is made, and the join of parts of it.

mod journal;
mod merge;
mod row;
mod rows;
mod summary;

pub use journal::{Identity, Journal};
pub use merge::{Part, join, joined};
pub use row::{Columns, RowTable, RunRow};
pub use summary::RunsSummary;

/// The table, a row for each run.
pub const RUNS: &str = "runs.csv";
/// The events of all runs.
pub const RUNS_EVENTS: &str = "runs-events.csv";
/// The samples of all runs.
pub const RUNS_SAMPLES: &str = "runs-samples.csv";
/// The rows that are finished, while the table is not.
pub const JOURNAL: &str = "runs.partial.csv";
/// Their events.
pub const JOURNAL_EVENTS: &str = "runs-events.partial.csv";
/// Their samples.
pub const JOURNAL_SAMPLES: &str = "runs-samples.partial.csv";
/// The tables of many runs, each with the name that it has while it is made. All but the first are only there if the
/// runs have such.
const TABLES: [(&str, &str); 3] = [(RUNS, JOURNAL), (RUNS_EVENTS, JOURNAL_EVENTS), (RUNS_SAMPLES, JOURNAL_SAMPLES)];
