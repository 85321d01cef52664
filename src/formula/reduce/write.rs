//! From products back to nodes.

use super::super::graph::{Node, NodeId, rebuilt};
use super::super::operation::Operation;
use super::{Product, Reducer};
use crate::number::Real;

impl<S: Real> Reducer<'_, S> {
    /// When the value of a node is known: with the last of its variables.
    fn level_of(&self, id: NodeId) -> usize {
        self.later.iter().filter(|&later| later & self.graph.variables[id] != 0).count()
    }

    /// The node of a product. What is known first is multiplied first, and then the number. Variables come last: the
    /// components of a vector have factors in common, and each of them a variable of its own.
    pub(super) fn write(&mut self, product: &Product<S>) -> NodeId {
        self.is_lost |= !product.number.is_finite();
        let place = |&(atom, exponent): &(NodeId, i32)| {
            let is_variable = matches!(self.graph.nodes[atom], Node::Variable(_));
            (self.level_of(atom), is_variable, atom, exponent)
        };
        let mut factors: Vec<(usize, bool, NodeId, i32)> = product.powers.iter().map(place).collect();
        factors.sort_unstable();
        let (mut known, mut number) = (None, product.number);
        for group in factors.chunk_by(|one, other| one.0 == other.0) {
            // A sign is left for the end, so that products that differ by it are the same until then.
            let is_last = group.last() == factors.last();
            if let Some(known) = known.as_mut().filter(|_| is_last && number.abs() != S::ONE) {
                *known = self.scaled(*known, number);
                number = S::ONE;
            }
            let powers = group.iter().map(|&(_, _, atom, exponent)| self.power(atom, exponent));
            let nodes = known.into_iter().chain(powers).collect();
            known = Some(self.multiplied(nodes));
        }
        match known {
            Some(known) => self.scaled(known, number),
            None => self.graph.constant(number),
        }
    }

    fn scaled(&mut self, node: NodeId, number: S) -> NodeId {
        if number == -S::ONE {
            return self.graph.negate(node);
        }
        let number = self.graph.constant(number);
        self.graph.multiply(number, node)
    }

    fn power(&mut self, atom: NodeId, exponent: i32) -> NodeId {
        let one = self.graph.whole(1);
        let base = if exponent < 0 { self.graph.divide(one, atom) } else { atom };
        self.graph.products(base, exponent.abs())
    }

    /// The product of nodes, from products of two of them that were written before where there are any.
    fn multiplied(&mut self, mut nodes: Vec<NodeId>) -> NodeId {
        while nodes.len() > 1 {
            let mut pairs = (0..nodes.len()).flat_map(|i| (i + 1..nodes.len()).map(move |j| (i, j)));
            let is_known = |&(i, j): &(usize, usize)| self.graph.has_product(nodes[i], nodes[j]);
            let (i, j) = pairs.find(is_known).unwrap_or((0, 1));
            nodes[i] = self.graph.multiply(nodes[i], nodes[j]);
            nodes.remove(j);
        }
        nodes[0]
    }

    /// The terms one after the other; one that is subtracted does not come first, if another one can.
    pub(super) fn added(&mut self, terms: &[Product<S>]) -> NodeId {
        let first = terms.iter().position(|term| term.number > S::ZERO).unwrap_or(0);
        let mut sum = self.write(&terms[first]);
        for (_, term) in terms.iter().enumerate().filter(|&(place, _)| place != first) {
            if term.number < S::ZERO {
                let term = self.write(&term.clone().scaled(-S::ONE));
                sum = self.graph.subtract(sum, term);
            } else {
                let term = self.write(term);
                sum = self.graph.add(sum, term);
            }
        }
        sum
    }

    /// The same nodes with quotients in place of products with a reciprocal that varies and that nothing else needs.
    pub(super) fn with_quotients(&mut self, roots: &[NodeId]) -> Vec<NodeId> {
        let uses = self.graph.uses(roots);
        rebuilt(&uses, roots, |id, new| {
            let quotient = match self.graph.nodes[id] {
                Node::Apply(Operation::Multiply(a, b)) => {
                    [(a, b), (b, a)].into_iter().find_map(|(a, b)| Some((a, self.divisor(b).filter(|_| uses[b] == 1)?)))
                }
                _ => None,
            };
            match quotient {
                Some((a, b)) => self.graph.divide(new[a], new[b]),
                None => self.graph.with_operands(id, new),
            }
        })
    }

    /// The same nodes with the sign of a product at a factor that is known at the start, where nothing else needs the
    /// product.
    pub(super) fn with_early_signs(&mut self, roots: &[NodeId]) -> Vec<NodeId> {
        let uses = self.graph.uses(roots);
        rebuilt(&uses, roots, |id, new| {
            let opposite = match self.graph.nodes[id] {
                Node::Apply(Operation::Negate(a)) if uses[a] == 1 => self.opposite(new[a], &uses),
                _ => None,
            };
            opposite.unwrap_or_else(|| self.graph.with_operands(id, new))
        })
    }

    /// −a for nothing, if a product that only `a` needs has a factor that is known at the start.
    fn opposite(&mut self, a: NodeId, uses: &[usize]) -> Option<NodeId> {
        if self.level_of(a) == 0 {
            return Some(self.graph.negate(a));
        }
        if uses.get(a).is_none_or(|&uses| uses > 1) {
            return None;
        }
        match self.graph.nodes[a] {
            Node::Apply(Operation::Multiply(a, b)) => match self.opposite(a, uses) {
                Some(a) => Some(self.graph.multiply(a, b)),
                None => self.opposite(b, uses).map(|b| self.graph.multiply(a, b)),
            },
            Node::Apply(Operation::Divide(a, b)) => self.opposite(a, uses).map(|a| self.graph.divide(a, b)),
            _ => None,
        }
    }

    /// b, if the node is 1/b and varies.
    fn divisor(&self, id: NodeId) -> Option<NodeId> {
        match self.graph.nodes[id] {
            Node::Apply(Operation::Divide(a, b)) if self.graph.is(a, 1.0) => (self.level_of(b) > 0).then_some(b),
            _ => None,
        }
    }
}
