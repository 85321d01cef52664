//! The parts of a scene that drive the motion, and those that do nothing.

use super::Enclosure;
use crate::geometry::Geometry;

impl Enclosure {
    /// For Hamilton's equations of a scene; `None` where nothing can hide. Variables of its path are q^a and, from 2n
    /// on, p_a of active coordinates.
    pub(crate) fn of_geometry(geometry: &Geometry) -> Option<Self> {
        let (n, active) = (geometry.dimension(), geometry.active());
        let varies = |variable: usize| active.contains(&variable) || active.iter().any(|a| 2 * n + a == variable);
        // Velocities of active coordinates are outputs of their own, unless momenta say the same.
        let outputs = if geometry.is_separable() { n } else { n + active.len() };
        Self::new(&geometry.hamiltonian().program, outputs, varies)
    }

    /// Sets the momenta of ignorable coordinates, which stay; those of active ones are not read.
    pub(crate) fn fix_momenta(&mut self, momenta: &[f64]) {
        let n = momenta.len();
        let fixed: Vec<(usize, f64)> = momenta.iter().enumerate().map(|(a, &p)| (2 * n + a, p)).collect();
        self.fix(&fixed);
    }
}

/// The weights of changes of rates.
pub(crate) struct Weights<'w> {
    /// One over the size of every coordinate.
    pub q: &'w [f64],
    /// For every active coordinate: by how much its momentum changes velocities, relative to the sizes of positions.
    pub p: &'w [f64],
}

/// By how much rates may change on all of the way, `length`, without moving a coordinate by more than a `share` of its
/// size, in the order of the program's outputs.
pub(crate) fn negligible_rates(geometry: &Geometry, weights: &Weights<'_>, length: f64, share: f64) -> Vec<f64> {
    let velocity = |a: usize| share / (length * weights.q[a]);
    let active = geometry.active().iter().filter(|_| !geometry.is_separable()).map(|&a| velocity(a));
    // An error of a momentum is one of velocities, for the rest of the way.
    let forces = weights.p.iter().map(|weight| share / (length * length * weight));
    active.chain(forces).chain(geometry.ignorable().map(velocity)).collect()
}
