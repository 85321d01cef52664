//! What a failure says about the places of a space-time.

use super::failure::{At, Domain};
use super::newton::Failure;
use super::space::Space;
use super::status::Status;
use crate::geometry::metric::{Metric, OutsideDomain};
use crate::geometry::{Geometry, OutsideGeometry};
use crate::number::Real;

/// Below this share of its first value, g00 is on its way to a horizon.
const HORIZON: f64 = 1e-2;

/// A space-time whose places a failure can name.
pub(super) trait Places<S: Real>: Space<S> {
    /// The place at this γ where all coordinates are `q`.
    fn place(&self, gamma: f64, q: &[S]) -> At;

    /// The place of a point outside the domain, where `gamma` is γ of the node with an index.
    fn place_outside(&self, point: &Self::Outside, gamma: &dyn Fn(usize) -> f64) -> At;

    /// The place at this γ where the scene of this space-time leaves its domain.
    fn place_beyond(&self, gamma: f64, q: &[S], outside: &OutsideGeometry) -> At;

    /// Where a number of a window whose last node is there is beyond the range of numbers.
    fn place_of_overflow(&self, gamma: f64, q: &[S]) -> At;

    /// What it means that no window, however short, is solved from `here` on, in a run from `start`.
    fn judge_short_window(&self, failure: &mut Failure<Self::Outside>, here: &[S], start: &[S]);
}

impl<S: Real> Places<S> for Metric<S> {
    fn place(&self, gamma: f64, q: &[S]) -> At {
        At::x(gamma, q[1].to_f64(), self.g00(q[1]).to_f64())
    }

    fn place_outside(&self, point: &OutsideDomain, gamma: &dyn Fn(usize) -> f64) -> At {
        At::x(gamma(point.index), point.x, point.g00)
    }

    fn place_beyond(&self, gamma: f64, q: &[S], _: &OutsideGeometry) -> At {
        self.place(gamma, q)
    }

    fn place_of_overflow(&self, gamma: f64, q: &[S]) -> At {
        At::overflow(gamma, q[1].to_f64(), self.g00(q[1]).to_f64())
    }

    /// Newton's method does not get across a horizon: there it meets points outside, or the particle has come so close
    /// that nothing smooth is left.
    fn judge_short_window(&self, failure: &mut Failure<OutsideDomain>, here: &[S], start: &[S]) {
        let (x, [here, first]) = (here[1], [here, start].map(|q| self.g00(q[1]).to_f64()));
        if failure.outside.is_some() || here < HORIZON * first {
            failure.status = Status::OutsideDomain;
            failure.outside.get_or_insert(OutsideDomain { index: 0, x: x.to_f64(), g00: here });
        } else {
            failure.status = Status::Stalled;
        }
    }
}

impl<S: Real> Places<S> for Geometry<S> {
    fn place(&self, gamma: f64, q: &[S]) -> At {
        let named = |&a: &usize| (self.names()[a].clone(), q[a].to_f64());
        At::scene(gamma, self.active().iter().map(named).collect())
    }

    fn place_outside(&self, point: &OutsideGeometry, gamma: &dyn Fn(usize) -> f64) -> At {
        At { domain: domain_of(self, point), ..At::scene(gamma(point.index), Vec::new()) }
    }

    fn place_beyond(&self, gamma: f64, q: &[S], outside: &OutsideGeometry) -> At {
        At { domain: domain_of(self, outside), ..self.place(gamma, q) }
    }

    fn place_of_overflow(&self, gamma: f64, _: &[S]) -> At {
        At::scene(gamma, Vec::new())
    }

    fn judge_short_window(&self, failure: &mut Failure<OutsideGeometry>, _: &[S], _: &[S]) {
        failure.status = if failure.outside.is_some() { Status::OutsideDomain } else { Status::Stalled };
    }
}

/// Why a point is outside.
fn domain_of<S: Real>(geometry: &Geometry<S>, outside: &OutsideGeometry) -> Domain {
    let Some(block) = outside.block else { return Domain::Scene };
    let coordinates = geometry.blocks()[block].iter().map(|&a| geometry.names()[a].clone()).collect();
    Domain::Determinant { coordinates, value: outside.determinant }
}
