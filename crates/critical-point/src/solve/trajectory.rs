//! What a solved run has on its nodes, whatever the number of its coordinates.

use super::space::Space;
use super::world_line::WorldLine;
use crate::scalar::Real;

/// A solved run as rows of values on its nodes, window by window, joints twice.
pub trait Trajectory<S> {
    /// The names of the coordinates, in order.
    fn coordinates(&self) -> Vec<String>;

    /// Number of nodes of each window, in order.
    fn window_sizes(&self) -> impl ExactSizeIterator<Item = usize> + '_;

    /// Significant decimal digits that were asked for.
    fn digits(&self) -> u32;

    /// γ on the nodes.
    fn gammas(&self) -> impl Iterator<Item = S> + '_;

    /// Coordinate `a` on the nodes.
    fn positions(&self, a: usize) -> Box<dyn Iterator<Item = S> + '_>;

    /// Coordinate `a` of the backward branch on the nodes, if the doubled system was solved.
    fn backward_positions(&self, a: usize) -> Option<Box<dyn Iterator<Item = S> + '_>>;
}

impl<S: Real, G: Space<S>> Trajectory<S> for WorldLine<S, G> {
    fn coordinates(&self) -> Vec<String> {
        self.geometry().coordinates()
    }

    fn window_sizes(&self) -> impl ExactSizeIterator<Item = usize> + '_ {
        self.grids().map(|grid| grid.points())
    }

    fn digits(&self) -> u32 {
        self.digits
    }

    fn gammas(&self) -> impl Iterator<Item = S> + '_ {
        self.gamma()
    }

    fn positions(&self, a: usize) -> Box<dyn Iterator<Item = S> + '_> {
        Box::new(self.q(a))
    }

    fn backward_positions(&self, a: usize) -> Option<Box<dyn Iterator<Item = S> + '_>> {
        self.backward(a).map(|row| Box::new(row) as _)
    }
}
