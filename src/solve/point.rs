//! A place and a number in a message.

use std::fmt;

/// A number for a message: six decimals, or an exponent where those would be noise or a long row of zeros.
struct Compact(f64);

impl fmt::Display for Compact {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let size = self.0.abs();
        if size == 0.0 || (1e-3..1e9).contains(&size) {
            write!(f, "{:.6}", self.0)
        } else {
            write!(f, "{:.6e}", self.0)
        }
    }
}

/// A place for a message.
pub(super) struct Point<'p> {
    pub(super) gamma: f64,
    pub(super) point: &'p [(String, f64)],
}

impl fmt::Display for Point<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "gamma = {}", Compact(self.gamma))?;
        self.point.iter().try_for_each(|(name, value)| write!(f, ", {name} = {}", Compact(*value)))
    }
}
