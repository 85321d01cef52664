//! A world-line of any space-time, for methods to compute.

use crate::methods::Problem;
use crate::number::{Extended, Real};
use crate::reference::{ReferenceEnds, ReferenceTrajectory};
use crate::solve::{Limit, Setup};
use crate::study::line::Line;
use crate::study::space::{self, Point};

/// A world-line of one length, with its reference.
pub(super) struct Course {
    pub(super) problem: Problem,
    /// The settings of a solver, without those of one scheme only.
    pub(super) setup: Setup,
    pub(super) reference: ReferenceTrajectory<Extended>,
}

/// Sixteen digits of the coordinates at the end, and four more to judge them. Errors of the phase grow with the square
/// of the length.
fn digits(length: f64) -> u32 {
    (20.0 + (2.0 * length.max(1.0).log10()).ceil()) as u32
}

impl Course {
    /// The world-line itself, or that of another length in γ.
    ///
    /// # Errors
    /// [`ReferenceEnds`] if it does not go so far.
    pub(super) fn new(line: Line, length: Option<f64>) -> Result<Self, ReferenceEnds> {
        let mut exact = line.exact.clone();
        // The length in γ to a time is not known, but it is about as long as the time.
        let extent = match (exact.limit, exact.origin) {
            (Limit::Value { value, .. }, Some((_, origin))) => (value - origin).to_f64(),
            _ => 1.0,
        };
        exact.settings.digits = digits(extent);
        let length = length.map_or_else(|| space::length_of(&exact).map(|length| length.to_f64()), Ok)?;
        let reference = space::reference(&exact.place, length.into(), digits(length))?;
        let problem = line.problem(&line.plain.place, length);
        Ok(Self { problem, setup: line.plain, reference })
    }
    /// The coordinates and K of the reference; t of a case is counted from the start.
    pub(super) fn exact(&self, gamma: f64) -> (Vec<Extended>, f64) {
        let Point { q, q_dot, .. } = self.reference.at(gamma.into());
        let in_f64 = |row: &[Extended]| row.iter().map(|value| value.to_f64()).collect::<Vec<f64>>();
        let k = self.problem.space.norm(&in_f64(&q), &in_f64(&q_dot));
        (q, k)
    }
}
