//! The accuracy that is asked of a run or of its windows.

/// The accuracy of a run: the largest error of a coordinate at any node, relative to its size.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Accuracy {
    /// The accuracy of the run. Windows may not add up to more.
    Promised(f64),
    /// The accuracy of every window by itself. An estimate tells what they add up to.
    Estimated(f64),
    /// The accuracy of every window by itself. Nothing is known of what they add up to.
    Local(f64),
}

impl Accuracy {
    /// The number itself.
    pub fn value(self) -> f64 {
        let (Self::Promised(value) | Self::Estimated(value) | Self::Local(value)) = self;
        value
    }

    /// True if windows may not add up to more.
    pub fn is_promised(self) -> bool {
        matches!(self, Self::Promised(_))
    }
}
