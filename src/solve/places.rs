//! The words of a failure about the places of a space-time.

use super::failure::{At, Domain};
use crate::geometry::{Geometry, OutsideGeometry};
use crate::number::Real;

/// The place at this γ where all coordinates are `q`.
pub(super) fn place<S: Real>(geometry: &Geometry<S>, gamma: f64, q: &[S]) -> At {
    if let Some(g00) = geometry.g00(q) {
        return At::x(gamma, q[1].to_f64(), g00.to_f64());
    }
    let named = |&a: &usize| (geometry.names()[a].clone(), q[a].to_f64());
    At::scene(gamma, geometry.active().iter().map(named).collect())
}

/// The place of a node outside the domain, where `gamma` is γ of the node with an index.
pub(super) fn place_outside<S: Real>(
    geometry: &Geometry<S>,
    outside: &OutsideGeometry,
    gamma: &dyn Fn(usize) -> f64,
) -> At {
    let q = [S::ZERO, S::from(outside.position)];
    if geometry.g00(&q).is_some() {
        return place(geometry, gamma(outside.index), &q);
    }
    At { domain: domain_of(geometry, outside), ..At::scene(gamma(outside.index), Vec::new()) }
}

/// The place at this γ where all coordinates are `q`, which is outside the domain.
pub(super) fn place_beyond<S: Real>(geometry: &Geometry<S>, gamma: f64, q: &[S], outside: &OutsideGeometry) -> At {
    let at = place(geometry, gamma, q);
    if geometry.g00(q).is_some() { at } else { At { domain: domain_of(geometry, outside), ..at } }
}

/// Where a number of a window whose last node is there is beyond the range of numbers.
pub(super) fn place_of_overflow<S: Real>(geometry: &Geometry<S>, gamma: f64, q: &[S]) -> At {
    match geometry.g00(q) {
        Some(g00) => At::overflow(gamma, q[1].to_f64(), g00.to_f64()),
        None => At::scene(gamma, Vec::new()),
    }
}

/// Why a point is outside.
fn domain_of<S: Real>(geometry: &Geometry<S>, outside: &OutsideGeometry) -> Domain {
    let Some(block) = outside.block else { return Domain::Scene };
    let coordinates = geometry.blocks()[block].iter().map(|&a| geometry.names()[a].clone()).collect();
    Domain::Determinant { coordinates, value: outside.determinant }
}
