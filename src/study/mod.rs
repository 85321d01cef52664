//! Studies: many solves of variations of one case. They call [`crate::solve()`] and nothing below it, and [`crate::methods`] to compare with.

pub mod convergence;
pub mod run_error;
pub mod stability;
pub mod work_precision;
