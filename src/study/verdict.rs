//! The verdict on a run.

use super::errors::RunError;
use crate::diagnostics::verdict::{CoordinateError, VerdictInput, largest};
use crate::diagnostics::{Diagnostics, Extent};
use crate::number::Real;
use crate::solve::WorldLine;

/// The facts that a [`Verdict`](crate::diagnostics::verdict::Verdict) on `line` is found from, with what was measured
/// on it and its error, if that is known.
/// The estimate of a run to an accuracy may be contradicted by a reference, if there is one.
pub fn facts_of_run<S: Real>(
    line: &WorldLine<S>,
    diagnostics: &Diagnostics<S>,
    error: Option<&RunError>,
    reference: Option<&RunError>,
) -> VerdictInput {
    let (geometry, reaches) = (line.geometry(), &diagnostics.reaches);
    // A run to an accuracy has found sizes itself.
    let size = |(a, reach): (usize, &Extent)| line.sizes.get(a).copied().unwrap_or(reach.size());
    let sizes: Vec<f64> = reaches.iter().enumerate().map(size).collect();
    // t and x of the paper have units of their own.
    let shared = if diagnostics.of_x.is_some() { sizes.clone() } else { geometry.shared(&line.place.start.q, &sizes) };
    // The coordinate s of Newton's law is no result: it was added to have a geodesic, and comes last.
    let count = reaches.len() - usize::from(diagnostics.energy.is_some());
    let errors = error.map(|error| {
        let (end, largest) = (error.at_most_at_end(), error.at_most());
        let of = |a: usize| CoordinateError {
            name: geometry.names()[a].clone(),
            end: end[a],
            largest: largest[a],
            size: sizes[a],
            range: reaches[a].range(),
            shared: shared[a],
        };
        (0..count).map(of).collect()
    });
    let relative = |error: &RunError| {
        let shares = error.largest.iter().zip(&line.sizes).filter(|(_, size)| **size > 0.0);
        [largest(shares.map(|(error, size)| error / size)), error.judge.relative_error()]
    };
    VerdictInput {
        errors,
        accuracy: line.accuracy,
        good_until: line.good_until.map(|until| line.gamma_at(S::from(until)).to_f64()),
        reference: reference.map(relative),
        stepped_over: error.map_or(0.0, |error| error.stepped_over),
        digits: line.digits,
        suspicions: diagnostics.suspicions(line),
    }
}
