//! Momenta behind an event that acts, as functions of the state before it, with their first derivatives, in balls.

use super::jets::{Ends, Jets};
use super::{GeometryError, GeometryText};
use crate::number::Extended;

/// A velocity, or a momentum, that an event sets.
#[derive(Debug, Clone, Copy)]
pub(crate) struct NewRate<'t> {
    pub(crate) coordinate: usize,
    pub(crate) is_momentum: bool,
    /// Its formula in the state before.
    pub(crate) formula: &'t str,
}

/// The momenta that an event changes.
#[derive(Debug)]
pub(crate) struct Reset {
    /// Their coordinates.
    pub(crate) changed: Vec<usize>,
    /// p_a behind the event for each of these.
    pub(crate) jets: Jets,
}

impl Reset {
    /// The momenta behind an event in the scene `text` that sets velocities, or else momenta, where `norm` is K at the
    /// start. The other velocities, or momenta, stay.
    ///
    /// With p_a = g_ab q̇^b + A_a those behind it are p_a + Σ g_ab (v^b − q̇^b), where v^b are the velocities that it
    /// sets. The momentum of `left_out` stays as it was: that of t, which the rate of s changes where that keeps K at
    /// 0, and on which nothing but that rate depends.
    ///
    /// # Errors
    /// [`GeometryError`] with a mistake in a formula.
    pub(crate) fn new(
        text: &GeometryText,
        set: &[NewRate<'_>],
        (norm, left_out): (Extended, Option<usize>),
    ) -> Result<Self, GeometryError> {
        let mut ends = Ends::new(text, norm, false)?;
        let n = ends.dimension();
        let mut momenta = vec![None; n];
        for of in set {
            let (b, node) = (of.coordinate, ends.of_end(of.formula)?);
            let graph = &mut ends.scope.graph;
            if of.is_momentum {
                momenta[b] = Some(if text.mirrored().contains(&b) { graph.negate(node) } else { node });
                continue;
            }
            let change = graph.subtract(node, ends.velocities[b]);
            for (a, momentum) in momenta.iter_mut().enumerate().filter(|(a, _)| Some(*a) != left_out) {
                let Some(&component) = ends.metric.get(&[a.min(b), a.max(b)]) else { continue };
                let before = momentum.unwrap_or_else(|| graph.variable(2 * n + a));
                let by = graph.multiply(component, change);
                *momentum = Some(graph.add(before, by));
            }
        }
        let (changed, nodes): (Vec<usize>, Vec<_>) =
            momenta.iter().enumerate().filter_map(|(a, node)| node.map(|node| (a, node))).unzip();
        Ok(Self { changed, jets: Jets::of_nodes(ends.scope, [n, 0], &nodes) })
    }
}
