//! The ranges of the coordinates of a run.

use crate::number::Real;
use crate::solve::{Place, WorldLine};

/// The number that the size of a coordinate counts from: 0 or, if it is ignorable, the start.
pub(crate) fn origin<S: Real>(place: &Place<S>, a: usize) -> S {
    if place.geometry.active().contains(&a) { S::ZERO } else { place.start.q[a] }
}

/// The least and the largest of some values; those of an ignorable coordinate count from the start.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extent {
    /// The least one.
    pub least: f64,
    /// The largest one.
    pub most: f64,
}

impl Extent {
    /// The range of coordinate `a` on the nodes of a world-line.
    pub fn new<S: Real>(line: &WorldLine<S>, a: usize) -> Self {
        let origin = origin(&line.place, a);
        Self::of(line.counted_from_origin(a, &line.q[a]).map(|q| (q - origin).to_f64()))
    }

    /// The range of these values.
    pub(crate) fn of(values: impl Iterator<Item = f64>) -> Self {
        let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
        // Iteration from inside goes window by window, which is faster.
        values.for_each(|q| (least, most) = (least.min(q), most.max(q)));
        Self { least, most }
    }

    /// The largest absolute value.
    pub fn size(self) -> f64 {
        self.least.abs().max(self.most.abs())
    }

    /// The largest value minus the least.
    pub fn range(self) -> f64 {
        self.most - self.least
    }
}
