//! Solver.
#![doc(test(attr(deny(warnings))))]

pub mod action;
pub mod banded;
pub mod case;
pub mod diagnostics;
pub mod geodesic;
pub mod metric;
pub mod output;
pub mod potential;
pub mod reference;
pub mod sbp;
pub mod solve;
pub mod study;

pub use case::{Case, CaseError};
pub use solve::{NoSolution, Solution, Status, solve};
