//! The scene that a space-time is for the engine.

use super::arithmetic::Arithmetic;
use super::places::Places;
use crate::geometry::Geometry;
use crate::geometry::metric::Metric;

/// A space-time for which [`solve`](crate::solve()) finds world-lines.
#[expect(private_bounds, reason = "only this module solves")]
pub trait Routes<S: Arithmetic>: Places<S> {
    /// The space-time as a scene.
    fn as_scene(&self) -> &Geometry<S>;
}

impl<S: Arithmetic> Routes<S> for Metric<S> {
    fn as_scene(&self) -> &Geometry<S> {
        self.scene()
    }
}

impl<S: Arithmetic> Routes<S> for Geometry<S> {
    fn as_scene(&self) -> &Self {
        self
    }
}
