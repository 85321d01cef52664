//! The Lagrangian and the force of a scene as programs: their components with derivatives, and what follows from them.

use super::expressions::force;
use super::inverse::Inverse;
use super::parts::{Parts, plus};
use super::structure::{ForceTerm, Samples, Source, Structure, Term};
use crate::formula::{Graph, NodeId, Program};
use crate::number::Real;

/// L = ½ g_ab q̇^a q̇^b + A_a q̇^a with a force F_a(q, q̇).
#[derive(Debug)]
pub(crate) struct Lagrangian<S = f64> {
    pub(super) structure: Structure<S>,
    /// Rows of the metric and the one-form in the order of the structure, then the determinants of the blocks.
    pub(super) fields: Program<S>,
    /// Rows of the force, in 2n variables.
    pub(super) force: Program<S>,
    /// In the variables q^a and q̇^a: p_a of all coordinates, then f_a + F_a of active ones.
    pub(crate) momenta: Program<S>,
}

impl<S: Real> Lagrangian<S> {
    pub(super) fn new(parts: &mut Parts<S>, inverse: &Inverse, active: &[usize]) -> Self {
        let (n, momenta) = (parts.dimension(), momenta(parts, active));
        let (mut structure, mut rows) = structure_of(parts);
        rows.extend(inverse.blocks.iter().map(|block| block.determinant));
        let fields = Program::new(&mut parts.graph, n, &rows);
        let rows = add_force(&mut structure, parts);
        structure.particles = parts.particles.clone();
        let force = Program::new(&mut parts.graph, 2 * n, &rows);
        Self { structure, fields, force, momenta }
    }

    /// Fills in the first rows of the metric, the one-form and the determinants, as many as there is room for, at
    /// positions, inside the domain or not.
    pub(super) fn fill(&self, q: &[&[S]], samples: &mut Samples<S>) {
        self.fields.sample(q, &mut samples.rows_mut().collect::<Vec<_>>());
    }

    /// The rows of the determinants of the blocks.
    pub(super) fn determinants<'s>(&self, samples: &'s Samples<S>) -> impl Iterator<Item = &'s [S]> {
        (self.structure.rows..self.fields.outputs.len()).map(|row| samples.row(row))
    }
}

/// Appends the expression to the rows, or takes it as the constant that it is; `None` if it is zero.
pub(super) fn source<S: Real>(graph: &Graph<S>, node: NodeId, rows: &mut Vec<NodeId>) -> Option<Source<S>> {
    match graph.as_constant(node) {
        Some(value) if value == S::ZERO => None,
        Some(value) => Some(Source::Constant(value)),
        None => {
            rows.push(node);
            Some(Source::Row(rows.len() - 1))
        }
    }
}

/// The structure of metric and one-form, with the expressions of its rows.
fn structure_of<S: Real>(parts: &mut Parts<S>) -> (Structure<S>, Vec<NodeId>) {
    let n = parts.dimension();
    let components = parts.components();
    let mut structure = Structure { dimension: n, has_one_form: !parts.one_form.is_empty(), ..Structure::default() };
    let mut rows = Vec::new();
    for &(ab, node) in &components {
        structure.values.extend(source(&parts.graph, node, &mut rows).map(|value| Term { ab, by: [], value }));
    }
    structure.rows_of_values = rows.len();
    for &(ab, node) in &components {
        for c in (0..n).filter(|&c| parts.graph.may_contain(node, c)).collect::<Vec<_>>() {
            let node = parts.graph.derivative(node, c);
            structure.first.extend(source(&parts.graph, node, &mut rows).map(|value| Term { ab, by: [c], value }));
        }
    }
    structure.rows_of_first = rows.len();
    for &(ab, node) in &components {
        for c in (0..n).filter(|&c| parts.graph.may_contain(node, c)).collect::<Vec<_>>() {
            let first = parts.graph.derivative(node, c);
            for d in (c..n).filter(|&d| parts.graph.may_contain(first, d)).collect::<Vec<_>>() {
                let node = parts.graph.derivative(first, d);
                let value = source(&parts.graph, node, &mut rows);
                structure.second.extend(value.map(|value| Term { ab, by: [c, d], value }));
            }
        }
    }
    structure.rows = rows.len();
    (structure, rows)
}

/// Adds the force to the structure. Returns the expressions of its rows.
fn add_force<S: Real>(structure: &mut Structure<S>, parts: &mut Parts<S>) -> Vec<NodeId> {
    let variables = 2 * parts.dimension();
    let components: Vec<(usize, NodeId)> = parts.force.iter().map(|(&a, &node)| (a, node)).collect();
    let mut rows = Vec::new();
    let mut value = |graph: &Graph<S>, node| source(graph, node, &mut rows);
    for &(a, node) in &components {
        structure.force.extend(value(&parts.graph, node).map(|value| ForceTerm { a, by: [], value }));
        for v in 0..variables {
            let first = parts.graph.derivative(node, v);
            structure.force_first.extend(value(&parts.graph, first).map(|value| ForceTerm { a, by: [v], value }));
        }
    }
    structure.force_rows = rows.len();
    rows
}

/// p_a of all coordinates and f_a + F_a of active ones, with few operations.
fn momenta<S: Real>(parts: &mut Parts<S>, active: &[usize]) -> Program<S> {
    let n = parts.dimension();
    let q_dot: Vec<NodeId> = (n..2 * n).map(|variable| parts.graph.variable(variable)).collect();
    let mut outputs: Vec<NodeId> = Vec::with_capacity(n + active.len());
    for a in 0..n {
        let one_form = parts.one_form.get(&a).copied().unwrap_or_else(|| parts.graph.constant(S::ZERO));
        let products: Vec<_> = (0..n).filter_map(|b| Some([parts.component(a, b)?, q_dot[b]])).collect();
        outputs.push(products.into_iter().fold(one_form, |sum, product| plus(&mut parts.graph, sum, product)));
    }
    for &a in active {
        outputs.push(force(parts, a, &q_dot));
    }
    let outputs = parts.graph.reduced(&outputs, |_| 1);
    Program::new(&mut parts.graph, 2 * n, &outputs).fused()
}
