//! One of the functions of γ that sweeps iterate.

use crate::number::Compensated;
use crate::number::vector::Nodes;

/// One of the functions of γ that sweeps iterate.
#[derive(Debug, Clone, Copy)]
pub(super) struct Row<const N: usize> {
    /// Its value at the start of the window.
    pub(super) start: Compensated<f64>,
    /// Its slope at the start of the window, where the slope is an unknown too.
    pub(super) velocity: Compensated<f64>,
    /// 1/size, by which errors become relative; 0 if nothing is known of the size.
    pub(super) inverse_size: f64,
    /// 1/size of that slope.
    pub(super) inverse_speed: f64,
    /// Its value at the end of the window, and that of the slope.
    pub(super) end: Compensated<f64>,
    pub(super) velocity_end: Compensated<f64>,
    /// A bound of the error that a window makes in `end`; of the slope where that is an unknown too.
    pub(super) end_error: f64,
    /// The increment at the last node, as sweeps left it.
    pub(super) increment: f64,
    /// The part of the increments on the nodes that is known before the window is solved.
    pub(super) offset: Nodes<N>,
    /// The product of the slopes with the part of the matrix that rounding took from its entries.
    pub(super) low: Nodes<N>,
    /// The slopes in the window that was finished last.
    pub(super) slopes_before: Nodes<N>,
}

impl<const N: usize> Row<N> {
    /// An unknown that never moves has size 0, and counts nowhere.
    pub(super) fn new(start: f64, velocity: f64, [size, speed]: [f64; 2]) -> Self {
        Self {
            start: Compensated::from(start),
            velocity: Compensated::from(velocity),
            inverse_size: inverse(size),
            inverse_speed: inverse(speed),
            end: Compensated::from(start),
            velocity_end: Compensated::from(velocity),
            end_error: 0.0,
            increment: 0.0,
            offset: Nodes::ZERO,
            low: Nodes::ZERO,
            slopes_before: Nodes::ZERO,
        }
    }

    /// Goes on to the next window. Sizes grow with what they are sizes of.
    pub(super) fn advance(&mut self) {
        (self.start, self.velocity) = (self.end, self.velocity_end);
        grow(&mut self.inverse_size, self.start.high);
        grow(&mut self.inverse_speed, self.velocity.high);
    }
}

/// 1/size, or 0.
pub(super) fn inverse(size: f64) -> f64 {
    if size > 0.0 { 1.0 / size } else { 0.0 }
}

/// Takes the value for the size if it is larger.
#[inline(always)]
pub(super) fn grow(inverse_size: &mut f64, value: f64) {
    if value.abs() * *inverse_size > 1.0 {
        *inverse_size = 1.0 / value.abs();
    }
}
