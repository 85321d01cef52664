//! Linear algebra of the solvers: banded elimination, and sparse systems.

pub mod banded;
pub mod sparse;

/// A matrix is singular to working precision: elimination met a column without a usable pivot.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("the matrix is singular")]
pub struct Singular;
