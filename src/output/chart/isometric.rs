//! Axes along which a unit has the same length.

use super::axis::Axis;
use super::canvas::PLOT_HEIGHT;

/// Rounds of fitting: the labels of y depend on the range, which depends on the room that the labels leave.
const ROUNDS: usize = 3;

/// Both axes widened so that a unit has the same length along them, and where a plot that ends at `right` begins.
/// `left_of` says where it begins with given labels of y.
pub(super) fn isometric((x, y): (&Axis, &Axis), right: i32, left_of: impl Fn(&Axis) -> i32) -> (Axis, Axis, i32) {
    let span = |axis: &Axis| axis.range.end - axis.range.start;
    let widened = |left: i32| {
        let (width, height) = (f64::from(right - left), f64::from(PLOT_HEIGHT));
        let unit = (span(x) / width).max(span(y) / height);
        (x.widened(unit * width), y.widened(unit * height))
    };
    let left = (0..ROUNDS).fold(left_of(y), |left, _| left_of(&widened(left).1));
    let (x, y) = widened(left);
    (x, y, left)
}
