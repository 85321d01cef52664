//! The linearised equations of a scene, which are formed when they are first asked for.

use std::sync::OnceLock;

use super::expressions::{Expressions, level};
use super::lagrangian::source;
use super::parts::Parts;
use super::structure::Source;
use crate::formula::{Graph, NodeId, Program, Step};
use crate::number::Real;

/// The expressions that the equations are derived from, and the equations once they are formed.
#[derive(Debug)]
pub(super) struct Linearised<S> {
    graph: Graph<S>,
    dimension: usize,
    active: Vec<usize>,
    /// Hamilton's equations as they were formed, and with few operations.
    expressions: [Expressions; 2],
    has_force: bool,
    equations: OnceLock<Equations<S>>,
}

/// The linearised equations as programs.
#[derive(Debug)]
pub(crate) struct Equations<S> {
    /// The entries that are not zero, those of ignorable coordinates last.
    pub(crate) entries: Vec<Entry<S>>,
    /// The number of those of active coordinates.
    of_active: usize,
    /// Its outputs are the entries that vary, in the variables of [`Hamiltonian`](super::Hamiltonian).
    pub(crate) jacobian: Program<S>,
    /// The steps that depend on momenta of ignorable coordinates alone, and the rest.
    pub(crate) fixed: Box<[Step]>,
    pub(crate) varying: Box<[Step]>,
}

/// An entry of the linearised equations that is not zero. Of m active coordinates rows 0 … m−1 are q̇^a, rows m … 2m−1
/// are ṗ_a, and then comes q̇^a of ignorable coordinates; columns are q^a and then p_a of active ones.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Entry<S> {
    pub(crate) row: usize,
    pub(crate) column: usize,
    pub(crate) value: Source<S>,
}

impl<S: Real> Equations<S> {
    /// The number of outputs of the program of the entries that belong to active coordinates. They come first.
    pub(super) fn varying_entries(&self) -> usize {
        self.entries[..self.of_active].iter().filter(|entry| matches!(entry.value, Source::Row(_))).count()
    }

    /// Calls `see(row, column, value)` for the entries of active coordinates, with `value_of` an output of the program.
    pub(crate) fn each_entry(&self, value_of: impl Fn(usize) -> S, mut see: impl FnMut(usize, usize, S)) {
        for &Entry { row, column, value } in &self.entries[..self.of_active] {
            match value {
                Source::Constant(value) => see(row, column, value),
                Source::Row(output) => see(row, column, value_of(output)),
            }
        }
    }
}

impl<S: Real> Linearised<S> {
    pub(super) fn new(parts: Parts<S>, active: &[usize], expressions: [Expressions; 2]) -> Self {
        Self {
            dimension: parts.dimension(),
            has_force: !parts.force.is_empty(),
            graph: parts.graph,
            active: active.to_vec(),
            expressions,
            equations: OnceLock::new(),
        }
    }

    pub(super) fn get(&self) -> &Equations<S> {
        self.equations.get_or_init(|| self.equations(&mut self.graph.clone()))
    }

    fn equations(&self, graph: &mut Graph<S>) -> Equations<S> {
        let level = level(self.dimension, &self.active);
        // Derivatives of sums whose factors were taken out are short, but not of polynomials. A polynomial of one
        // coordinate has so few steps that forming both costs more than it saves.
        let tried = if self.active.len() == 1 { &self.expressions[1..] } else { &self.expressions[..] };
        let programs = tried.iter().map(|expressions| {
            let (entries, outputs) = self.entries(graph, expressions);
            let outputs = graph.reduced(&outputs, &level);
            let jacobian = Program::new(graph, 3 * self.dimension, &outputs).fused();
            let varies = jacobian.depends_on(|variable| level(variable) > 0);
            let varying = jacobian.schedule(0..jacobian.size(), |register| !varies[register]);
            (entries, jacobian, varying, varies)
        });
        let shortest = programs.min_by_key(|(_, _, varying, _)| varying.len());
        let (entries, jacobian, varying, varies) = shortest.expect("at least one is tried");
        let fixed = jacobian.schedule(0..jacobian.size(), |register| varies[register]);
        let of_active = entries.partition_point(|entry| entry.row < 2 * self.active.len());
        Equations { entries, of_active, jacobian, fixed, varying }
    }

    /// The entries that are not zero, with the expressions of those that vary.
    fn entries(&self, graph: &mut Graph<S>, of: &Expressions) -> (Vec<Entry<S>>, Vec<NodeId>) {
        let (n, m) = (self.dimension, self.active.len());
        let is_active = |a: &usize| self.active.contains(a);
        let unknown = self.active.iter().map(|&a| of.velocities[a]).chain(of.forces.iter().copied());
        let rows: Vec<NodeId> = unknown.chain((0..n).filter(|a| !is_active(a)).map(|a| of.velocities[a])).collect();
        let columns: Vec<usize> = self.active.iter().copied().chain(self.active.iter().map(|&a| 2 * n + a)).collect();
        let (mut entries, mut outputs) = (Vec::new(), Vec::new());
        for row in 0..rows.len() {
            for column in 0..columns.len() {
                // Without a force q̇ and −ṗ are slopes of one function of q and p, whose second derivatives do not
                // depend on the order. So about half of the entries are found from other ones.
                let (of, by, is_opposite) = match (row / m, column / m) {
                    _ if self.has_force => (row, column, false),
                    (0, 1) => (row.min(column - m), row.max(column - m) + m, false),
                    (1, 0) => (column.max(row - m) + m, column.min(row - m), false),
                    (1, 1) => (column - m, row - m, true),
                    _ => (row, column, false),
                };
                let derivative = graph.derivative(rows[of], columns[by]);
                let node = if is_opposite { graph.negate(derivative) } else { derivative };
                entries.extend(source(graph, node, &mut outputs).map(|value| Entry { row, column, value }));
            }
        }
        (entries, outputs)
    }
}
