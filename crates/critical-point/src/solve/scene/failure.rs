//! Failures in terms of a scene.

use super::window::Window;
use crate::geometry::{Geometry, OutsideGeometry};
use crate::scalar::Real;
use crate::solve::failure::{At, Domain, NoSolution};
use crate::solve::newton::Failure;
use crate::solve::status::InitialGuess;

/// A failed iteration. `gamma` is γ of a node, and `locate` maps an index of the residual to its node and, if they are
/// known, the active coordinates there.
pub(super) fn iterated(
    window: &Window<'_, f64, Geometry>,
    failure: Failure<OutsideGeometry>,
    initial_guess: InitialGuess,
    gamma: impl Fn(usize) -> f64,
    locate: impl Fn(usize, &[f64]) -> (usize, Vec<f64>),
) -> NoSolution {
    let geometry = window.geometry;
    NoSolution::iterated(failure, initial_guess, |outside, worst, unknowns| match outside {
        Some(point) => At { domain: domain_of(geometry, &point), ..At::scene(gamma(point.index), Vec::new()) },
        None => {
            let located = worst.filter(|_| !unknowns.is_empty()).map(|row| locate(row, unknowns));
            let (index, values) = located.unwrap_or_default();
            At::scene(gamma(index), named(geometry, values))
        }
    })
}

/// The active coordinates with their names.
pub(super) fn named<S: Real>(geometry: &Geometry<S>, values: impl IntoIterator<Item = f64>) -> Vec<(String, f64)> {
    geometry.active().iter().map(|&a| geometry.names()[a].clone()).zip(values).collect()
}

/// Why a point is outside.
pub(super) fn domain_of(geometry: &Geometry, outside: &OutsideGeometry) -> Domain {
    let Some(block) = outside.block else { return Domain::Scene };
    let coordinates = geometry.blocks()[block].iter().map(|&a| geometry.names()[a].clone()).collect();
    Domain::Determinant { coordinates, value: outside.determinant }
}
