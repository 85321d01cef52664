//! What the atlas asks of a world-line, whatever the number of its coordinates.

use super::status::{CellStatus, Sizes};
use super::track::Track;
use crate::case::{Form, SbpName};
use crate::methods::{Failure, Output, Peer, Setting};
use crate::reference::{ReferenceEnds, ReferenceTrajectory};
use crate::solve::Arithmetic;
use crate::solve::NoSolution;
use crate::study::space::{Point, Studied};

/// The trajectory to compare with, in any precision.
pub(super) trait Reference: Send + Sync {
    /// The point at γ − γ_i = `gamma`, which must be in its range.
    fn at(&self, gamma: f64) -> Point;

    /// The estimate of its own error, relative to the largest values of the coordinates.
    fn error_estimate(&self) -> f64;

    /// Number of Taylor steps.
    fn steps(&self) -> usize;
}

impl<S: Arithmetic, G: Studied<S>> Reference for ReferenceTrajectory<S, G>
where
    Self: Send + Sync,
{
    fn at(&self, gamma: f64) -> Point {
        let Point { q, q_dot, p } = G::at(self, gamma.into()).into();
        let [q, q_dot, p] = [q, q_dot, p].map(|row| row.iter().map(|value| value.to_f64()).collect());
        Point { q, q_dot, p }
    }

    fn error_estimate(&self) -> f64 {
        self.error_estimate()
    }

    fn steps(&self) -> usize {
        self.steps()
    }
}

/// A grid for a scheme of this program.
#[derive(Debug, Clone, Copy)]
pub(super) enum Grid {
    /// So many nodes in each of so many windows; with spectral elements, so many nodes in all.
    Nodes { scheme: (SbpName, Form), nodes: usize, windows: usize },
    /// The doubled system of the strong form without the regularisation, on so many nodes.
    Unregularised(SbpName, usize),
    /// Whatever meets an accuracy.
    Accuracy(f64),
}

/// How far a world-line goes, and how it starts.
#[derive(Debug, Clone, Copy)]
pub(super) struct Range {
    /// γ_f − γ_i.
    pub(super) length: f64,
    /// The tangent at the start in units of the case's own; 1 in scenes.
    pub(super) tangent: f64,
}

/// Why there is no trajectory.
pub(super) struct Failed {
    pub(super) status: CellStatus,
    pub(super) iterations: Option<usize>,
}

impl From<NoSolution> for Failed {
    fn from(failure: NoSolution) -> Self {
        Self { status: CellStatus::of(failure.status), iterations: Some(failure.iterations.history.len()) }
    }
}

impl From<Failure> for Failed {
    fn from(failure: Failure) -> Self {
        let status = match failure {
            Failure::OutsideDomain => CellStatus::OutsideDomain,
            Failure::Diverged => CellStatus::Diverged,
            Failure::TooManySteps | Failure::NotConverged | Failure::AccuracyNotReached | Failure::NotSeparable => {
                CellStatus::NoCriticalPoint
            }
        };
        Self { status, iterations: None }
    }
}

/// What is measured on a result when the clock has stopped.
pub(super) type Measured<'w> = Box<dyn FnOnce() -> Track + 'w>;

/// A run to be timed.
pub(super) struct Task<'w> {
    /// The intervals of its grid; 0 where it chooses them.
    pub(super) intervals: usize,
    pub(super) run: Box<dyn FnOnce() -> Result<Measured<'w>, Failed> + 'w>,
}

/// A world-line to be charted.
pub(super) trait World: Send + Sync {
    /// Whether it is that of a scene.
    fn is_scene(&self) -> bool;

    /// Whether it is the lift of Newton's law, which has an energy.
    fn has_energy(&self) -> bool;

    /// The names of the coordinates.
    fn coordinates(&self) -> &[String];

    /// The coordinates that the equations depend on.
    fn active(&self) -> &[usize];

    /// What the coordinates of a [`Point`] are counted from when the reference estimates its error.
    fn origin(&self) -> Vec<f64>;

    /// γ_f − γ_i of the case.
    ///
    /// # Errors
    /// [`ReferenceEnds`] if the world-line does not get to its end.
    fn own_length(&self) -> Result<f64, ReferenceEnds>;

    /// The trajectory to compare with, in `f64` or in extended precision.
    ///
    /// # Errors
    /// [`ReferenceEnds`] if the world-line ends before.
    fn reference(&self, length: f64, is_extended: bool) -> Result<Box<dyn Reference>, ReferenceEnds>;

    /// The largest frequency of the linearised equations at these points, and their largest rate of growth.
    fn rates(&self, points: &[Point]) -> [f64; 2];

    /// The sizes by which trajectories with these points are judged. `points` are at least two, ends included.
    fn sizes(&self, points: &[Point], length: f64) -> Sizes;

    /// ṫ_i, if there is a coordinate t.
    fn t_dot(&self) -> Option<f64>;

    /// The run of a scheme of this program; `None` if there is no such grid.
    fn scheme(&self, grid: &Grid, range: Range) -> Option<Task<'_>>;

    /// The run of another method.
    fn other(&self, peer: &'static dyn Peer, range: Range, output: Output, setting: Setting) -> Task<'_>;
}
