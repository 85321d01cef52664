//! Which changes of the sign of a formula count.

/// Which sign changes are events.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Direction {
    /// From negative to positive.
    Up,
    /// From positive to negative.
    Down,
    /// Either of them.
    #[default]
    Both,
}

impl Direction {
    /// The name used in files.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Up => "up",
            Self::Down => "down",
            Self::Both => "both",
        }
    }

    /// Returns true if a change to positive values counts, or one to negative values.
    pub fn counts(self, to_positive: bool) -> bool {
        match self {
            Self::Up => to_positive,
            Self::Down => !to_positive,
            Self::Both => true,
        }
    }
}
