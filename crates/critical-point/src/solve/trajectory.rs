//! What a solved run has on its nodes, whatever the number of its coordinates.

use super::scene::WorldLine;
use super::solution::Solution;
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

/// The coordinates are t and x.
impl<S: Real> Trajectory<S> for Solution<S> {
    fn coordinates(&self) -> Vec<String> {
        ["t", "x"].map(str::to_owned).to_vec()
    }

    fn window_sizes(&self) -> impl ExactSizeIterator<Item = usize> + '_ {
        self.views().map(|view| view.grid.points())
    }

    fn digits(&self) -> u32 {
        self.digits
    }

    fn gammas(&self) -> impl Iterator<Item = S> + '_ {
        self.gamma()
    }

    fn positions(&self, a: usize) -> Box<dyn Iterator<Item = S> + '_> {
        self.row(a, &self.elapsed, &self.x)
    }

    fn backward_positions(&self, a: usize) -> Option<Box<dyn Iterator<Item = S> + '_>> {
        self.backward.as_ref().map(|backward| self.row(a, &backward.elapsed, &backward.x))
    }
}

impl<S: Real> Solution<S> {
    /// t for a = 0, x for a = 1.
    fn row<'s>(&'s self, a: usize, elapsed: &'s [S], x: &'s [S]) -> Box<dyn Iterator<Item = S> + 's> {
        match a {
            0 => Box::new(self.time_from_start(elapsed).map(|t| self.t_i + t)),
            _ => Box::new(x.iter().copied()),
        }
    }
}

impl<S: Real> Trajectory<S> for WorldLine<S> {
    fn coordinates(&self) -> Vec<String> {
        self.geometry().names().to_vec()
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
