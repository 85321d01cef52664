//! The numbers that the engine was calibrated with, on random motions of many kinds (`cargo bench --bench promise`).
//!
//! a is the tolerance, and errors are relative to sizes.

// The tolerance of windows.

/// Errors inside a window may use up this part of a.
pub(super) const INSIDE: f64 = 0.6;
/// Bounds of errors inside a window are multiplied by this.
pub(super) const INSIDE_MARGIN: f64 = 1.5;
/// A window may add this part of a at its end.
pub(super) const ALONE: f64 = 1e-2;
/// A looser accuracy is served as this: it would cost hardly less, and windows that resolve nothing do not show it.
pub(super) const LOOSEST: f64 = 1e-4;
/// No window has to add less than this. Rounding of large values adds more at every window; sweeps leave less where
/// values are near 0.
pub(super) const ROUNDED: f64 = 1e-20;
/// A window with a kink in it may add this part of a, but no less than that: its error falls only like its length.
pub(super) const KINK: f64 = 1e-3;
pub(super) const LEAST_KINK: f64 = 1e-14;
/// Sweeps leave this part of a share.
pub(super) const LEFT: f64 = 0.01;
/// The highest modes of slopes that resolve the motion are less than this, relative to the largest slope.
pub(super) const RESOLVED: f64 = 0.03;
/// A window is solved again at most so often to end at a knot of a table. The first place is found from nodes on both
/// sides, the second one is good to six digits.
pub(super) const MOST_LANDINGS: usize = 5;
/// The first window is so many times a^(1/24) T long, with the time scale T of the motion.
pub(super) const FIRST: f64 = 3.0;
/// Below this accuracy, rounding of the tables counts.
pub(super) const EXACT: f64 = 1e-10;
/// A window that is longer than the rest of the run by no more than this part ends the run.
pub(super) const STRETCH: f64 = 1e-7;
/// An edge of the domain within so many windows of the first length is the reason of a failure.
pub(super) const AHEAD: [f64; 3] = [1.0, 4.0, 16.0];
/// Windows shorter than this part of the first are not cut any more because something may hide in them.
pub(super) const LEAST: f64 = 1e-9;
/// A run makes no progress where so many windows in turn come no further than as many of these. One that passes a kink
/// has some fifty of them.
pub(super) const MOST_IDLE: usize = 400;

// The step controller.

/// Windows are made for this part of what is allowed, as a power of two of an error inside.
pub(super) const AIM: f64 = -1.0;
/// After a refusal so many windows are no longer than the next shorter rung.
pub(super) const PATIENCE: u32 = 4;
/// A window that is not solved or does not resolve the motion is followed by one shorter by so many rungs.
pub(super) const UNSOLVED: i32 = 2;
/// One in which something may hide is followed by one shorter by so many rungs.
pub(super) const HIDDEN: i32 = 4;
/// By how many rungs lengths grow and shrink at most.
pub(super) const LARGEST_GROWTH: f64 = 2.0;
pub(super) const LARGEST_CUT: f64 = -8.0;

// The errors of a window.

/// Slopes that change an unknown by less than this, relative to its size, are noise.
pub(super) const NOISE: f64 = 1e-9;
/// The error at the end, divided by the product of the two truncations: 99.5 % of windows are below it, for equations
/// of first and of second order.
pub(super) const END: [f64; 2] = [4.0, 2.0];

// Sweeps.

/// Two changes in turn below this are rounding errors, the first relative to sizes, the second one to the values in the
/// window: near a pole of coordinates a change by what rounding makes of large values is a change of the motion;
pub(super) const NOISE_OF_SWEEPS: f64 = 2.5e-16;
/// and so is a change below this, relative to sizes, that does not contract.
pub(super) const STALLED: f64 = 1e-12;
/// Sweeps that contracted by this part are done then,
pub(super) const FAST: f64 = 0.25;
/// and slower ones, if only by this part, go on
pub(super) const SLOWEST_UNSEEN: f64 = 0.7;
/// until what they would change without rounding is less than this part of it.
pub(super) const UNSEEN_CHANGE: f64 = 0.1;
