//! The Taylor series of [`crate::reference`] as a judge.

use super::points::Points;
use super::run_error::{Found, Judge, RunError};
use super::stepped_over::{Gaps, PROBES, fractions};
use crate::geometry::Start;
use crate::number::Real;
use crate::reference::ReferenceTrajectory;
use crate::solve::WorldLine;

/// The number of probes that are evaluated at a time.
const TOGETHER: usize = 256;

/// Compares the points of a world-line with a Taylor reference of as many digits. `None` if that does not reach the
/// end.
pub(super) fn compare<S: Real>(line: &WorldLine<S>, points: &Points<S>) -> Option<RunError> {
    let (geometry, start) = (line.geometry(), &line.place.start);
    let reference = ReferenceTrajectory::new(geometry, start, line.length, line.digits).ok()?;
    let mut found = Found::none(geometry.dimension());
    let last = points.len() - 1;
    for (k, &gamma) in points.gamma[..last].iter().enumerate() {
        let exact = reference.at(gamma);
        found.see(points.rows.iter().zip(&exact.q).map(|(row, &q)| (row[k] - q).to_f64()));
    }
    let end = reference.at(line.length);
    let off = points.rows.iter().zip(&end.q).map(|(row, &q)| (row[last] - q).to_f64()).collect();
    let q_dot: Vec<f64> = end.q_dot.iter().map(|q_dot| q_dot.to_f64()).collect();
    found.see(points.at_end(off, &q_dot));
    let error = reference.error_estimate();
    let own = points.own(points.sizes().into_iter().map(|size| error * size).collect());
    Some(found.finish(own, Judge::Taylor(error), stepped_over(line, &reference)))
}

/// The share of its way by which the motion may be off because of what the reference does not know.
fn stepped_over<S: Real>(line: &WorldLine<S>, reference: &ReferenceTrajectory<S>) -> f64 {
    let (geometry, start, length) = (line.geometry(), &line.place.start, line.length.to_f64());
    if S::IS_EXTENDED {
        return 0.0;
    }
    let mut gaps = Gaps::new(geometry, start);
    let places: Vec<f64> = fractions(PROBES).collect();
    for places in places.chunks(TOGETHER) {
        let points: Vec<_> = places.iter().map(|&place| reference.at(line.length * S::from(place))).collect();
        let row = |of: fn(&Start<S>) -> &[S], a: usize| points.iter().map(|point| of(point)[a]).collect();
        let rows = |of: fn(&Start<S>) -> &[S]| (0..start.q.len()).map(|a| row(of, a)).collect::<Vec<Vec<S>>>();
        gaps.see(length / PROBES as f64, &rows(|point| &point.q), &rows(|point| &point.q_dot));
    }
    gaps.share()
}
