//! How far a world-line in a scene is from the reference.

use super::run_error::{Found, Judge, RunError};
use super::stepped_over::{Between, PROBES, fractions};
use crate::geometry::Start;
use crate::number::Real;
use crate::reference::ReferenceTrajectory;
use crate::solve::WorldLine;

/// Of the probes so many are evaluated at a time.
const TOGETHER: usize = 256;

/// Compares a world-line with a Taylor reference of as many digits at every node. `None` if the reference does not
/// reach the end.
pub fn scene_error<S: Real>(line: &WorldLine<S>) -> Option<RunError> {
    let (geometry, start) = (line.geometry(), &line.place.start);
    let reference = ReferenceTrajectory::new(geometry, start, line.length, line.digits).ok()?;
    let n = geometry.dimension();
    let rows: Vec<Vec<S>> = (0..n).map(|a| line.q(a).collect()).collect();
    let mut found = Found::none(n);
    let last = line.nodes() - 1;
    for (k, gamma) in line.gamma().enumerate() {
        let exact = reference.at(if gamma < line.gamma_f() { gamma - line.gamma_i } else { line.length });
        let clock = line.ended_at.filter(|_| k == last).map(|(clock, _)| (clock, rows[clock][k] - exact.q[clock]));
        found.see((0..n).map(|a| {
            let off = rows[a][k] - exact.q[a];
            clock.map_or(off, |(clock, late)| off - late * pace(line, &exact, a, clock)).to_f64()
        }));
    }
    let sizes: Vec<f64> = (0..n).map(|a| Reach::new(line, a).size).collect();
    let error = reference.error_estimate();
    let own = geometry.shared(&start.q, &sizes).into_iter().map(|size| error * size).collect();
    Some(found.finish(own, Judge::Taylor(error), stepped_over(line, &reference)))
}

/// How far a coordinate goes.
#[derive(Debug, Clone, Copy)]
pub struct Reach {
    /// Its largest absolute value; that of the distance from the start for an ignorable coordinate.
    pub size: f64,
    /// Its largest value minus its least.
    pub range: f64,
}

impl Reach {
    /// How far coordinate `a` goes on the nodes of a world-line.
    pub fn new<S: Real>(line: &WorldLine<S>, a: usize) -> Self {
        let origin = if line.geometry().active().contains(&a) { S::ZERO } else { line.place.start.q[a] };
        let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
        for q in line.q(a) {
            let q = (q - origin).to_f64();
            (least, most) = (least.min(q), most.max(q));
        }
        Self { size: least.abs().max(most.abs()), range: most - least }
    }
}

/// dq^a by the change of the coordinate `clock`, from the last node of a world-line to the `exact` point: the mean of
/// both ends, so that an error of third order is left.
fn pace<S: Real>(line: &WorldLine<S>, exact: &Start<S>, a: usize, clock: usize) -> S {
    let found = &line.end().q_dot;
    S::from(0.5) * (found[a] / found[clock] + exact.q_dot[a] / exact.q_dot[clock])
}

/// The share of its way by which the motion may be off because of what the reference does not know.
fn stepped_over<S: Real>(line: &WorldLine<S>, reference: &ReferenceTrajectory<S>) -> f64 {
    let geometry = line.geometry();
    if S::IS_EXTENDED || !geometry.structure().force.is_empty() {
        return 0.0;
    }
    let start = &line.place.start;
    let (k, length) = (geometry.norm(&start.q, &start.q_dot), line.length.to_f64());
    let mut between = Between::default();
    let places: Vec<f64> = fractions(PROBES).collect();
    for places in places.chunks(TOGETHER) {
        let points: Vec<_> = places.iter().map(|&place| reference.at(line.length * S::from(place))).collect();
        let row = |of: fn(&Start<S>) -> &[S], a: usize| points.iter().map(|point| of(point)[a]).collect();
        let rows = |of: fn(&Start<S>) -> &[S]| (0..start.q.len()).map(|a| row(of, a)).collect::<Vec<Vec<S>>>();
        let (q, q_dot) = (rows(|point| &point.q), rows(|point| &point.q_dot));
        let [q, q_dot] = [&q, &q_dot].map(|rows| rows.iter().map(Vec::as_slice).collect::<Vec<_>>());
        let [norm, motion] = geometry.norm_and_motion(&q, &q_dot);
        for (here, motion) in norm.into_iter().zip(motion) {
            let motion = motion.to_f64();
            between.see(length / PROBES as f64, (here - k).to_f64(), motion + k.to_f64().abs(), motion);
        }
    }
    between.share()
}
