//! Intervals on several boxes at a time.

use crate::number::vector::Nodes;

/// The number of boxes.
pub(super) const BOXES: usize = 8;

/// An interval for each box: the lower bounds, then the upper ones.
pub(super) type Lanes = Nodes<{ 2 * BOXES }>;

/// Relative to the result v, more than arithmetic rounds: |v| 2⁻⁵² is at least the distance from v to the next number
/// outwards, and what was rounded is half of that distance at most.
pub(super) const ROUNDS: f64 = f64::EPSILON;

/// More than numbers next to 0 are rounded.
pub(super) const TINY: f64 = f64::MIN_POSITIVE;
