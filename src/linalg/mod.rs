//! Linear algebra of the solvers: banded elimination, and sparse systems.

pub mod banded;
pub mod sparse;
