//! Compensated sums.

use super::Real;

/// A sum, as a rounded number and its rounding error.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Compensated<S> {
    /// The sum, rounded.
    pub high: S,
    /// Its rounding error.
    pub(crate) low: S,
}

impl<S: Real> Compensated<S> {
    /// A sum of one number.
    pub(crate) fn from(value: S) -> Self {
        Self { high: value, low: S::ZERO }
    }

    /// Adds `increment`, with Knuth's two-sum.
    pub(crate) fn plus(self, increment: S) -> Self {
        let increment = increment + self.low;
        let high = self.high + increment;
        let back = high - self.high;
        Self { high, low: (self.high - (high - back)) + (increment - back) }
    }
}
