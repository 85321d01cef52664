//! The linearised equations of a scene, which are formed when they are first asked for.

use super::expressions::{Expressions, level};
use super::lagrangian::source;
use super::parts::Parts;
use super::structure::Source;
use crate::formula::{NodeId, Program, Step};
use crate::number::Real;

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
    /// From Hamilton's equations as they were formed, and with few operations.
    pub(super) fn new(mut parts: Parts<S>, active: &[usize], expressions: &[Expressions; 2]) -> Self {
        let (n, level) = (parts.dimension(), level(parts.dimension(), active));
        // Derivatives of sums whose factors were taken out are short, but not of polynomials. A polynomial of one
        // coordinate has so few steps that forming both costs more than it saves.
        let tried = if active.len() == 1 { &expressions[1..] } else { &expressions[..] };
        let programs = tried.iter().map(|expressions| {
            let (entries, outputs) = entries(&mut parts, active, expressions);
            let outputs = parts.graph.reduced(&outputs, &level);
            let jacobian = Program::new(&mut parts.graph, 3 * n, &outputs).fused();
            let varies = jacobian.depends_on(|variable| level(variable) > 0);
            let varying = jacobian.schedule(0..jacobian.size(), |register| !varies[register]);
            (entries, jacobian, varying, varies)
        });
        let shortest = programs.min_by_key(|(_, _, varying, _)| varying.len());
        let (entries, jacobian, varying, varies) = shortest.expect("at least one is tried");
        let fixed = jacobian.schedule(0..jacobian.size(), |register| varies[register]);
        let of_active = entries.partition_point(|entry| entry.row < 2 * active.len());
        Self { entries, of_active, jacobian, fixed, varying }
    }

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

/// The entries that are not zero, with the expressions of those that vary.
fn entries<S: Real>(parts: &mut Parts<S>, active: &[usize], of: &Expressions) -> (Vec<Entry<S>>, Vec<NodeId>) {
    let (n, m) = (parts.dimension(), active.len());
    let unknown = active.iter().map(|&a| of.velocities[a]).chain(of.forces.iter().copied());
    let rows: Vec<NodeId> = unknown.chain((0..n).filter(|a| !active.contains(a)).map(|a| of.velocities[a])).collect();
    let columns: Vec<usize> = active.iter().copied().chain(active.iter().map(|&a| 2 * n + a)).collect();
    let (mut entries, mut outputs) = (Vec::new(), Vec::new());
    for row in 0..rows.len() {
        for column in 0..columns.len() {
            // Without a force q̇ and −ṗ are slopes of one function of q and p, whose second derivatives do not
            // depend on the order. So about half of the entries are found from other ones. An unknown parameter is no
            // such coordinate.
            let (of, by, is_opposite) = match (row / m, column / m) {
                _ if !parts.force.is_empty() || !parts.unknown.is_empty() => (row, column, false),
                (0, 1) => (row.min(column - m), row.max(column - m) + m, false),
                (1, 0) => (column.max(row - m) + m, column.min(row - m), false),
                (1, 1) => (column - m, row - m, true),
                _ => (row, column, false),
            };
            let derivative = parts.graph.derivative(rows[of], columns[by]);
            let node = if is_opposite { parts.graph.negate(derivative) } else { derivative };
            entries.extend(source(&parts.graph, node, &mut outputs).map(|value| Entry { row, column, value }));
        }
    }
    (entries, outputs)
}
