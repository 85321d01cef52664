//! Studies, which solve many variations of a case with [`crate::solve()`] and compare them with the integrators of
//! [`crate::methods`].

pub mod acting;
pub mod convergence;
mod doubts;
pub mod errors;
pub mod facts;
mod failed;
pub mod find;
pub mod many;
mod method;
pub mod proof;
pub mod run;
mod sampling;
mod solved;
mod some_nodes;
pub mod stability;
mod subject;
#[cfg(test)]
mod witnesses;
pub mod work_precision;

pub use method::Method;
pub use sampling::{Numbers, Sampling};
