//! The state behind an event that acts, as functions of the state before it, with their first derivatives, in balls.

use super::jets::{Ends, Jets};
use super::{GeometryError, GeometryText};
use crate::formula::NodeId;
use crate::number::Extended;

/// The number of a coordinate that an event sets. An unknown parameter is one more coordinate, behind the others.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Setting {
    /// q^a.
    Position,
    /// dq^a/dγ.
    Velocity,
    /// p_a.
    Momentum,
}

/// A number that an event sets.
#[derive(Debug, Clone, Copy)]
pub(crate) struct NewValue<'t> {
    pub(crate) coordinate: usize,
    pub(crate) setting: Setting,
    /// Its formula in the state before.
    pub(crate) formula: &'t str,
}

/// The positions and momenta that an event changes.
#[derive(Debug)]
pub(crate) struct Reset {
    /// Their coordinates, and whether it is the momentum.
    pub(crate) changed: Vec<(usize, bool)>,
    /// q^a or p_a behind the event for each of these.
    pub(crate) jets: Jets,
}

impl Reset {
    /// The state behind an event in the scene `text` that sets positions, unknown parameters, and velocities or
    /// momenta, where `norm` is K at the start. The other velocities, or momenta, stay.
    ///
    /// With p_a = g_ab q̇^b + A_a the momenta behind it are those of the positions and velocities there. Where these
    /// move no g_ab and A_a, that is p_a + Σ g_ab (v^b − q̇^b), where v^b are the velocities that it sets. The momentum
    /// of `left_out` stays as it was: that of t, which the rate of s changes where that keeps K at 0, and on which
    /// nothing but that rate depends.
    ///
    /// # Errors
    /// [`GeometryError`] with a mistake in a formula.
    pub(crate) fn new(
        text: &GeometryText,
        set: &[NewValue<'_>],
        (norm, left_out): (Extended, Option<usize>),
    ) -> Result<Self, GeometryError> {
        let mut ends = Ends::new(text, norm, false)?;
        let n = ends.dimension();
        let mut values = [const { Vec::new() }; 3];
        values.fill(vec![None; n + text.unknown.len()]);
        for of in set {
            let node = ends.of_end(of.formula)?;
            let is_mirrored = of.setting == Setting::Momentum && text.mirrored().contains(&of.coordinate);
            let node = if is_mirrored { ends.scope.graph.negate(node) } else { node };
            values[of.setting as usize][of.coordinate] = Some(node);
        }
        let [positions, velocities, mut momenta] = values;
        if momenta.iter().all(Option::is_none) {
            for a in (0..n).filter(|&a| Some(a) != left_out) {
                momenta[a] = momentum(&mut ends, a, [&positions, &velocities]);
            }
        }
        let all = positions.into_iter().enumerate().map(|(a, node)| ((a, false), node));
        let all = all.chain(momenta.into_iter().enumerate().map(|(a, node)| ((a, true), node)));
        let (changed, nodes): (Vec<_>, Vec<_>) = all.filter_map(|(of, node)| Some((of, node?))).unzip();
        Ok(Self { changed, jets: Jets::of_nodes(ends.scope, [n, text.unknown.len()], &nodes) })
    }

    /// True for each formula whose value it leaves as it is: one of positions, and of unknown parameters, that it does
    /// not set.
    pub(crate) fn keeps(&self, formulas: &Jets) -> Vec<bool> {
        let is_set = |a: &usize| self.changed.contains(&(*a, false));
        formulas.places().map(|places| places.is_some_and(|places| !places.iter().any(is_set))).collect()
    }
}

/// p_a behind an event that sets these positions and velocities; `None` if that is what it was.
fn momentum(ends: &mut Ends, a: usize, [positions, velocities]: [&[Option<NodeId>]; 2]) -> Option<NodeId> {
    let n = ends.dimension();
    let row: Vec<(usize, NodeId)> =
        (0..n).filter_map(|b| Some((b, *ends.metric.get(&[a.min(b), a.max(b)])?))).collect();
    let one_form = ends.one_form.get(&a).copied();
    let graph = &mut ends.scope.graph;
    // There are two states with positions, velocities and momenta each, of which the first one is that before; unknown
    // parameters come last.
    let place = |k: usize| if k < n { Some(k) } else { k.checked_sub(5 * n).filter(|place| *place >= n) };
    let behind = |k: usize| place(k).and_then(|place| positions[place]);
    let moved: Vec<NodeId> =
        (0..5 * n + positions.len()).map(|k| behind(k).unwrap_or_else(|| graph.variable(k))).collect();
    let fields: Vec<NodeId> = row.iter().map(|(_, component)| *component).chain(one_form).collect();
    let there = graph.substitute(&fields, &moved);
    if there != fields {
        let zero = graph.constant(Extended::ZERO);
        let mut sum = there.get(row.len()).copied().unwrap_or(zero);
        for ((b, _), component) in row.iter().zip(&there) {
            let term = graph.multiply(*component, velocities[*b].unwrap_or(ends.velocities[*b]));
            sum = graph.add(sum, term);
        }
        return Some(sum);
    }
    let mut sum = None;
    for (b, component) in row {
        let Some(velocity) = velocities[b] else { continue };
        let before = sum.unwrap_or_else(|| graph.variable(2 * n + a));
        let change = graph.subtract(velocity, ends.velocities[b]);
        let by = graph.multiply(component, change);
        sum = Some(graph.add(before, by));
    }
    sum
}
