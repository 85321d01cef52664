//! What is proved of a window, and goes from there to the set of errors.

use super::algebras::Row;
use super::ellipse::Bounds;
use super::matrices::Matrices;

/// What a window adds to what it begins with, before A: δ, and bounds ε on all of it.
pub(super) struct Added {
    pub(super) delta: Vec<f64>,
    pub(super) epsilon: Vec<f64>,
}

/// What is proved of a window.
pub(super) struct Proved {
    pub(super) h: f64,
    /// The coefficients of v.
    pub(super) modes: Vec<Row>,
    pub(super) gain: Vec<f64>,
    pub(super) added: Added,
    /// The same of the differences of motions of a set.
    pub(super) apart: Option<Added>,
    /// Bounds of |v − f(y)| on the window.
    pub(super) defect: Vec<f64>,
    pub(super) matrices: Matrices,
    pub(super) bounds: Bounds,
    /// What is not rounding, as a part of what may be.
    pub(super) quality: f64,
    /// The largest |y| on the nodes.
    pub(super) sizes: Vec<f64>,
}
