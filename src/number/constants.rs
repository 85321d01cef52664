//! Numbers that are computed once for both types.

use std::sync::OnceLock;

use super::{Extended, Real};

/// Numbers in extended precision, and their roundings to `f64`, which are made when they are first asked for.
/// [`Real::constants`] takes those of one type.
#[derive(Debug)]
pub struct Constants {
    pub(super) exact: Vec<Extended>,
    rounded: OnceLock<Vec<f64>>,
}

impl Constants {
    /// These numbers.
    pub fn new(exact: Vec<Extended>) -> Self {
        Self { exact, rounded: OnceLock::new() }
    }

    pub(super) fn rounded(&self) -> &[f64] {
        self.rounded.get_or_init(|| self.exact.iter().map(|number| number.to_f64()).collect())
    }
}
