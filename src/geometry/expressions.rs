//! Hamilton's equations as expressions: as they follow from the metric, and with fewer operations.
//!
//! Where the Hamiltonian H(q, p) is known, they are q̇^a = ∂H/∂p_a and, without a force, ṗ_a = −∂H/∂q^a.

use super::inverse::Inverse;
use super::parts::{Parts, plus};
use crate::formula::{Level, NodeId};
use crate::number::Real;

/// Expressions in the variables q^a, then n that stand in none of them (where velocities were), then p_a.
#[derive(Debug, Clone)]
pub(super) struct Expressions {
    /// q̇^a of all coordinates.
    pub(super) velocities: Vec<NodeId>,
    /// ṗ_a of active coordinates.
    pub(super) forces: Vec<NodeId>,
    /// The determinants of the blocks.
    pub(super) determinants: Vec<NodeId>,
}

impl Expressions {
    pub(super) fn new<S: Real>(parts: &mut Parts<S>, inverse: &Inverse, active: &[usize]) -> Self {
        let mut velocities = velocities(parts, inverse);
        let zero = parts.graph.constant(S::ZERO);
        velocities[parts.unknown.clone()].fill(zero);
        let forces = active.iter().map(|a| match parts.unknown.contains(a) {
            true => zero,
            false => rate(parts, *a, &velocities),
        });
        let forces: Vec<NodeId> = forces.collect();
        watch(parts, active, &mut velocities, &forces);
        Self { forces, determinants: inverse.blocks.iter().map(|block| block.determinant).collect(), velocities }
    }

    /// The same with fewer operations. What a sweep needs is written apart: it shares its work with nothing that is
    /// wanted once.
    pub(super) fn reduced<S: Real>(&self, parts: &mut Parts<S>, active: &[usize], is_separable: bool) -> Self {
        let (mut reduced, n) = (self.clone(), parts.dimension());
        let (mut sweep, mut others): (Vec<&mut NodeId>, Vec<&mut NodeId>) = (Vec::new(), Vec::new());
        for (a, velocity) in reduced.velocities.iter_mut().enumerate() {
            let is_unknown = active.contains(&a) && !is_separable;
            if is_unknown { sweep.push(velocity) } else { others.push(velocity) }
        }
        sweep.extend(&mut reduced.forces);
        others.extend(&mut reduced.determinants);
        for nodes in [sweep, others] {
            let roots: Vec<NodeId> = nodes.iter().map(|node| **node).collect();
            let written = parts.graph.reduced(&roots, level(n, active));
            nodes.into_iter().zip(written).for_each(|(node, written)| *node = written);
        }
        reduced
    }

    /// q̈^a = g^ab ṗ_b of active coordinates with a constant `inverse`, given by rows.
    pub(super) fn accelerations<S: Real>(&self, parts: &mut Parts<S>, active: &[usize], inverse: &[S]) -> Vec<NodeId> {
        let (rows, n) = (inverse.chunks_exact(active.len().max(1)), parts.dimension());
        let zero = parts.graph.constant(S::ZERO);
        let sum = |row: &[S]| {
            row.iter().zip(&self.forces).fold(zero, |sum, (&entry, &force)| {
                let entry = parts.graph.constant(entry);
                plus(&mut parts.graph, sum, [entry, force])
            })
        };
        let sums: Vec<NodeId> = rows.map(sum).collect();
        parts.graph.reduced(&sums, level(n, active))
    }
}

/// When variables of Hamilton's equations become known: momenta of ignorable coordinates at the start of a run, then
/// positions, then momenta.
pub(super) fn level(n: usize, active: &[usize]) -> impl Fn(usize) -> Level {
    move |variable| match variable.checked_sub(2 * n) {
        None => 1,
        Some(a) if active.contains(&a) => 2,
        Some(_) => 0,
    }
}

/// q̇^a for every a.
fn velocities<S: Real>(parts: &mut Parts<S>, inverse: &Inverse) -> Vec<NodeId> {
    let n = parts.dimension();
    if let Some(hamiltonian) = parts.hamiltonian {
        return (2 * n..3 * n).map(|p| parts.graph.derivative(hamiltonian, p)).collect();
    }
    let kinetic: Vec<NodeId> = (0..n)
        .map(|b| {
            let p = parts.graph.variable(2 * n + b);
            parts.one_form.get(&b).map_or(p, |&one_form| parts.graph.subtract(p, one_form))
        })
        .collect();
    let zero = parts.graph.constant(S::ZERO);
    let velocity = |a: usize| {
        let products = (0..n).filter_map(|b| Some([inverse.get(a, b)?, kinetic[b]]));
        products.fold(zero, |sum, product| plus(&mut parts.graph, sum, product))
    };
    (0..n).map(velocity).collect()
}

/// ṗ_a.
fn rate<S: Real>(parts: &mut Parts<S>, a: usize, q_dot: &[NodeId]) -> NodeId {
    match parts.hamiltonian {
        Some(hamiltonian) if parts.force.is_empty() => {
            let slope = parts.graph.derivative(hamiltonian, a);
            parts.graph.negate(slope)
        }
        _ => force(parts, a, q_dot),
    }
}

/// f_a + F_a.
pub(super) fn force<S: Real>(parts: &mut Parts<S>, a: usize, q_dot: &[NodeId]) -> NodeId {
    let mut sum = parts.graph.constant(S::ZERO);
    let velocities = [q_dot, &[parts.graph.constant(S::ONE)]].concat();
    for ([b, c], node) in parts.components() {
        let slope = parts.graph.derivative(node, a);
        let text = if b == c { "f + 0.5*(s*u*v)" } else { "f + s*u*v" };
        let named = [("f", sum), ("s", slope), ("u", velocities[b]), ("v", velocities[c])];
        sum = parts.graph.written(text, &named);
    }
    if let Some(&force) = parts.force.get(&a) {
        let n = parts.dimension();
        let variables: Vec<NodeId> = (0..n).map(|b| parts.graph.variable(b)).collect();
        let replacement: Vec<NodeId> = variables.iter().chain(q_dot).copied().collect();
        let force = parts.graph.substitute(&[force], &replacement)[0];
        sum = parts.graph.add(sum, force);
    }
    sum
}

/// Puts the rates of what is watched into the velocities of their coordinates.
fn watch<S: Real>(parts: &mut Parts<S>, active: &[usize], velocities: &mut [NodeId], forces: &[NodeId]) {
    let n = parts.dimension();
    let state = |parts: &mut Parts<S>, kind: usize| -> Vec<NodeId> {
        (0..n).map(|a| parts.graph.variable(kind * n + a)).collect()
    };
    let replacement = [state(parts, 0), velocities.to_vec(), state(parts, 2)].concat();
    let watched = parts.watched.clone();
    let formulas = parts.graph.substitute(&watched, &replacement);
    let first = n - formulas.len();
    for (k, formula) in formulas.into_iter().enumerate() {
        let mut rate = parts.graph.constant(S::ZERO);
        let moving = (0..first).map(|a| (a, velocities[a]));
        let pushed = active.iter().zip(forces).map(|(&a, &force)| (2 * n + a, force));
        for (variable, along) in moving.chain(pushed).collect::<Vec<_>>() {
            let slope = parts.graph.derivative(formula, variable);
            rate = plus(&mut parts.graph, rate, [slope, along]);
        }
        velocities[first + k] = rate;
    }
}
