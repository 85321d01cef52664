//! Files and tables. Nothing here prints to a terminal.

mod files;
mod summary;
mod tables;

pub use files::OutputSet;
pub use summary::{Outcome, Summary};
pub use tables::{write_branches, write_combined, write_residuals, write_trajectory};
