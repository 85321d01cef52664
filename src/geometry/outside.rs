//! A point that lies outside the domain of a metric.

/// A block of the metric has a determinant of the wrong sign, or a number is not finite.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("the point lies outside the domain of the metric")]
pub struct OutsideGeometry {
    /// Index of the node.
    pub index: usize,
    /// The block of the metric, see [`Geometry::blocks`](super::Geometry::blocks); `None` where another number is not
    /// finite.
    pub block: Option<usize>,
    /// Its determinant there.
    pub determinant: f64,
    /// The first active coordinate there.
    pub position: f64,
}
