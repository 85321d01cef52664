//! The facts that a verdict on a run is found from.

use crate::diagnostics::verdict::{CoordinateError, Reason, VerdictInput};
use crate::diagnostics::{Diagnostics, Extent};
use crate::number::Real;
use crate::number::norm::larger;
use crate::solve::WorldLine;
use crate::study::errors::RunError;

/// The errors of coordinates of a run that is off by this, with what was measured on it.
pub(super) fn coordinate_errors<S: Real>(
    line: &WorldLine<S>,
    diagnostics: &Diagnostics<S>,
    error: &RunError,
) -> Vec<CoordinateError> {
    let (geometry, reaches) = (line.geometry(), &diagnostics.reaches);
    // A run to an accuracy has found sizes itself.
    let size = |(a, reach): (usize, &Extent)| line.sizes.get(a).copied().unwrap_or(reach.size());
    let sizes: Vec<f64> = reaches.iter().enumerate().map(size).collect();
    // t and x of the paper have units of their own.
    let is_of_x = diagnostics.of_x.is_some();
    let of_kind = |all: &[f64]| if is_of_x { all.to_vec() } else { geometry.shared(&line.place.start.q, all) };
    let ranges: Vec<f64> = reaches.iter().map(|reach| reach.range()).collect();
    let (shared, shared_ranges) = (of_kind(&sizes), of_kind(&ranges));
    let (end, largest) = (error.at_most_at_end(), error.at_most());
    let of = |a: usize| CoordinateError {
        name: geometry.names()[a].clone(),
        end: end[a],
        largest: largest[a],
        size: sizes[a],
        range: ranges[a],
        shared: shared[a],
        shared_range: shared_ranges[a],
    };
    (0..geometry.results()).map(of).collect()
}

/// The reasons to doubt a run that its witnesses give, beside this error if one is known, where rounding takes so much
/// from what it is certified with.
pub(super) fn suspicions<S: Real>(
    line: &WorldLine<S>,
    diagnostics: &Diagnostics<S>,
    error: Option<&RunError>,
    of_certificate: &[f64],
) -> Vec<Reason> {
    // A witness changes in proportion to a small error only, so a large one explains no deviation.
    let is_small =
        |error: &&RunError| coordinate_errors(line, diagnostics, error).iter().all(CoordinateError::is_small);
    let claimed = error.filter(is_small).map(|error| [error.at_most().as_slice(), of_certificate].concat());
    let mut suspicions = diagnostics.suspicions(line, of_certificate.last().copied().unwrap_or(0.0));
    suspicions.extend(diagnostics.unexplained(line, claimed.as_deref()));
    suspicions
}

/// The facts that a [`Verdict`](crate::diagnostics::verdict::Verdict) on `line` is found from, with what was measured
/// on it and its error, if that is known. The estimate of a run to an accuracy may be contradicted by a reference, if
/// there is one.
pub fn facts_of_run<S: Real>(
    line: &WorldLine<S>,
    diagnostics: &Diagnostics<S>,
    error: Option<&RunError>,
    reference: Option<&RunError>,
) -> VerdictInput {
    let suspicions = suspicions(line, diagnostics, error, &[]);
    VerdictInput { suspicions, ..facts_of_errors(line, diagnostics, error, reference) }
}

/// The same without the reasons to doubt the run that its witnesses give.
pub(super) fn facts_of_errors<S: Real>(
    line: &WorldLine<S>,
    diagnostics: &Diagnostics<S>,
    error: Option<&RunError>,
    reference: Option<&RunError>,
) -> VerdictInput {
    let errors = error.map(|error| coordinate_errors(line, diagnostics, error));
    let relative = |error: &RunError| {
        let shares = error.largest.iter().zip(&line.sizes).filter(|(_, size)| **size > 0.0);
        [shares.map(|(error, size)| error / size).fold(0.0, larger), error.judge.relative_error()]
    };
    VerdictInput {
        errors,
        accuracy: line.accuracy,
        good_until: line.good_until.map(|until| line.gamma_at(S::from(until)).to_f64()),
        reference: reference.map(relative),
        stepped_over: error.map_or(0.0, |error| error.stepped_over),
        digits: line.digits,
        suspicions: Vec::new(),
        is_unjudged: false,
    }
}
