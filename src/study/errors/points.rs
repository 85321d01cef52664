//! The points at which a run is compared with another one.

use crate::diagnostics::Reach;
use crate::geometry::largest_of_kind;
use crate::number::Real;
use crate::solve::WorldLine;
use crate::trajectory::Sample;

/// The nodes of a run, counted from its start and its origin, or samples in place of some of them.
pub(super) struct Points<S> {
    /// γ − γ_i.
    pub(super) gamma: Vec<S>,
    /// q^a, a row for each coordinate.
    pub(super) rows: Vec<Vec<S>>,
    /// dq^a/dγ at the end.
    q_dot: Vec<S>,
    /// The coordinate whose value ended the run, if one did. The last point is compared at that value.
    pub(super) clock: Option<usize>,
    /// The origins of sizes: 0 of active coordinates, and the start of ignorable ones.
    origins: Vec<S>,
    /// For each coordinate the first with the same metric coefficient.
    alike: Vec<usize>,
}

impl<S: Real> Points<S> {
    /// The samples before `line`, and its nodes.
    pub(super) fn new(line: &WorldLine<S>, samples: &[Sample<S>], clock: Option<usize>) -> Self {
        let (geometry, start) = (line.geometry(), &line.place.start);
        let n = geometry.dimension();
        let mut gamma: Vec<S> = Vec::with_capacity(line.nodes());
        let mut rows: Vec<Vec<S>> = vec![Vec::with_capacity(line.nodes()); n];
        let first = line.gamma_from_start().next().unwrap_or(S::ZERO);
        let from_start = |sample: &Sample<S>| line.signed(sample.gamma - line.gamma_i);
        let mut before: Vec<&Sample<S>> = samples.iter().filter(|sample| from_start(sample) < first).collect();
        if before.first().zip(before.last()).is_some_and(|(first, last)| from_start(first) > from_start(last)) {
            before.reverse();
        }
        gamma.extend(before.iter().map(|sample| from_start(sample)));
        gamma.extend(line.gamma_from_start());
        for (a, row) in rows.iter_mut().enumerate() {
            row.extend(before.iter().map(|sample| sample.q[a] - line.origin_of(a)));
            row.extend(line.counted_from_origin(a, &line.q[a]));
        }
        let origin = |a: usize| if geometry.active().contains(&a) { S::ZERO } else { start.q[a] };
        let (q_dot, alike) = (line.end_inside().q_dot, geometry.alike(&start.q));
        Self { gamma, rows, q_dot, clock, origins: (0..n).map(origin).collect(), alike }
    }

    /// Number of points.
    pub(super) fn len(&self) -> usize {
        self.gamma.len()
    }

    /// The size of every coordinate, shared with others of its kind.
    pub(super) fn sizes(&self) -> Vec<f64> {
        let far = |(row, &origin): (&Vec<S>, &S)| Reach::of(row.iter().map(|&q| (q - origin).to_f64())).size();
        let sizes: Vec<f64> = self.rows.iter().zip(&self.origins).map(far).collect();
        largest_of_kind(&self.alike, &sizes)
    }

    /// By how much the last point is off at most in every coordinate, where it is off by `off` at equal γ from a
    /// world-line with `q_dot` there. Where the value of a coordinate ended the run, points with that value are
    /// compared: the pace of the world-line on the way there changes by about half of what it differs at both ends.
    pub(super) fn at_end(&self, off: Vec<f64>, q_dot: &[f64]) -> Vec<f64> {
        let Some(clock) = self.clock else { return off };
        let at = |a: usize| {
            let pace = q_dot[a] / q_dot[clock];
            (off[a] - off[clock] * pace).abs() + 0.5 * off[clock].abs() * (self.pace(a, clock) - pace).abs()
        };
        (0..off.len()).map(|a| if a == clock { 0.0 } else { at(a) }).collect()
    }

    /// dq^a by the change of the coordinate `clock`, at the end.
    fn pace(&self, a: usize, clock: usize) -> f64 {
        (self.q_dot[a] / self.q_dot[clock]).to_f64()
    }

    /// The errors of a judge that is off by so much in every coordinate. In a run that ends at a value of one, all of
    /// the error is in the others.
    pub(super) fn own(&self, mut errors: Vec<f64>) -> Vec<f64> {
        if let Some(clock) = self.clock {
            let late = std::mem::take(&mut errors[clock]);
            let others = errors.iter_mut().enumerate().filter(|(a, _)| *a != clock);
            others.for_each(|(a, own)| *own += late * self.pace(a, clock).abs());
        }
        errors
    }
}
