//! Expressions written with fewer operations.
//!
//! Derivatives, inverses and contractions leave programs with many quotients of the same divisor, products in every
//! order, and factors that a whole sum shares. Here every expression becomes a number times powers of atoms, and a sum
//! of such products takes out what its terms share. Then
//!
//! - a divisor is inverted once, whatever is divided by it,
//! - what does not vary is multiplied first, so that it is computed once for many evaluations,
//!   and a sign is put there too where it can,
//! - factors are multiplied in one order, or as they were multiplied before, so that products share their parts.
//!
//! Products of sums are not multiplied out, and sums are added up in the order in which they were written but for terms
//! that share a factor: differences of nearly equal numbers stay as exact as they were.

mod product;
mod sum;
mod write;

use super::graph::{Graph, Node, NodeId};
use super::operation::Operation;
use super::variables::bit;
use crate::number::Real;
use product::Product;

/// When a variable becomes known: 0 if it is the same in many evaluations, higher the more often it changes.
pub(crate) type Level = u8;

impl<S: Real> Graph<S> {
    /// Expressions with the values of `roots` but for rounding, with fewer operations where that is possible. `level`
    /// tells how often a variable changes. In units far from 1 products of numbers may be beyond the range of numbers:
    /// then expressions stay as they are.
    pub(crate) fn reduced(&mut self, roots: &[NodeId], level: impl Fn(usize) -> Level) -> Vec<NodeId> {
        let uses = self.uses(roots);
        let mut later = Vec::new();
        for id in (0..uses.len()).filter(|&id| uses[id] > 0) {
            if let Node::Variable(variable) = self.nodes[id] {
                let level = usize::from(level(variable));
                later.resize(later.len().max(level), 0);
                later[..level].iter_mut().for_each(|later| *later |= bit(variable));
            }
        }
        let mut reducer = Reducer { graph: self, later, known: vec![Vec::new(); uses.len()], is_lost: false };
        for id in (0..uses.len()).filter(|&id| uses[id] > 0) {
            reducer.known[id] = reducer.form(id, &uses);
        }
        // All sums become nodes before the first root is written.
        roots.iter().for_each(|&root| reducer.settle(root));
        let nodes: Vec<NodeId> = roots.iter().map(|&root| reducer.rewritten(root)).collect();
        if reducer.is_lost {
            return roots.to_vec();
        }
        let nodes = reducer.with_quotients(&nodes);
        reducer.with_early_signs(&nodes)
    }
}

/// Writes expressions of a graph anew.
struct Reducer<'g, S> {
    graph: &'g mut Graph<S>,
    /// At k, the variables of a level beyond k, a bit each.
    later: Vec<u64>,
    /// The forms of the first nodes, where they are needed: a product, or the terms of a sum that may become a part of
    /// a longer one.
    known: Vec<Vec<Product<S>>>,
    /// True once a number was beyond the range of numbers.
    is_lost: bool,
}

impl<S: Real> Reducer<'_, S> {
    /// The form of a node after those of its operands.
    fn form(&mut self, id: NodeId, uses: &[usize]) -> Vec<Product<S>> {
        let operation = match self.graph.nodes[id] {
            Node::Variable(_) | Node::Constant(_) => return vec![self.atom(id)],
            Node::PowerInteger(base, exponent) => return vec![self.settled(base).power(exponent)],
            Node::Apply(operation) => operation,
        };
        vec![match operation {
            Operation::Add(a, b) => return self.longer(a, uses[a] == 1, b, S::ONE),
            Operation::Subtract(a, b) => return self.longer(a, uses[a] == 1, b, -S::ONE),
            Operation::Multiply(a, b) | Operation::Divide(a, b) => {
                self.settle(a);
                self.settle(b);
                let exponent = if matches!(operation, Operation::Divide(..)) { -1 } else { 1 };
                self.known[a][0].times(&self.known[b][0].power(exponent))
            }
            Operation::Negate(a) => self.settled(a).clone().scaled(-S::ONE),
            Operation::Power(a, b) => {
                let [base, exponent] = [a, b].map(|operand| self.rewritten(operand));
                let power = self.graph.power(base, exponent);
                self.atom(power)
            }
            Operation::Call(function, a) => {
                let argument = self.rewritten(a);
                let value = self.graph.call(function, argument);
                self.atom(value)
            }
            Operation::Fused(..) => unreachable!("graphs have no fused operations"),
        }]
    }

    /// A sum with one more term. It keeps its order of additions, if nothing else needs it.
    fn longer(&mut self, sum: NodeId, is_alone: bool, term: NodeId, sign: S) -> Vec<Product<S>> {
        let mut terms = if is_alone { std::mem::take(&mut self.known[sum]) } else { vec![self.settled(sum).clone()] };
        terms.push(self.settled(term).clone().scaled(sign));
        terms
    }

    /// Makes a product of what is known of a node.
    fn settle(&mut self, id: NodeId) {
        if self.known[id].len() > 1 {
            let terms = std::mem::take(&mut self.known[id]);
            self.known[id] = vec![self.sum(terms)];
        }
    }

    fn settled(&mut self, id: NodeId) -> &Product<S> {
        self.settle(id);
        &self.known[id][0]
    }

    /// The node that takes the place of this one.
    fn rewritten(&mut self, id: NodeId) -> NodeId {
        let product = self.settled(id).clone();
        self.write(&product)
    }

    /// A number, or a node that is no product.
    fn atom(&self, node: NodeId) -> Product<S> {
        match self.graph.as_constant(node) {
            Some(number) => Product { number, powers: Vec::new() },
            None => Product { number: S::ONE, powers: vec![(node, 1)] },
        }
    }
}
