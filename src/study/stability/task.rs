//! Runs of a cell, before anybody knows which method does them.

use super::status::CellStatus;
use super::track::Track;
use crate::case::{Form, SbpName};
use crate::methods::Failure;
use crate::number::Real;
use crate::reference::ReferenceTrajectory;
use crate::solve::NoSolution;
use crate::study::space::Point;

/// The trajectory to compare with, in any precision.
pub(super) trait Reference: Send + Sync {
    /// The point at γ − γ_i = `gamma`, which must be in its range.
    fn at(&self, gamma: f64) -> Point;

    /// The estimate of its own error, relative to the largest values of the coordinates.
    fn error_estimate(&self) -> f64;

    /// Number of Taylor steps.
    fn steps(&self) -> usize;
}

impl<S: Real> Reference for ReferenceTrajectory<S> {
    fn at(&self, gamma: f64) -> Point {
        let Point { q, q_dot, p } = self.at(gamma.into());
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

/// The length of a world-line, and its start.
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

/// The measurement of a result when the clock has stopped.
pub(super) type Measured<'w> = Box<dyn FnOnce() -> Track + 'w>;

/// A run to be timed.
pub(super) struct Task<'w> {
    /// The intervals of its grid; 0 where it chooses them.
    pub(super) intervals: usize,
    pub(super) run: Box<dyn FnOnce() -> Result<Measured<'w>, Failed> + 'w>,
}
