//! Expressions written with fewer operations.
//!
//! Derivatives, inverses and contractions leave programs with many quotients of the same divisor, products in every
//! order, and factors that a whole sum shares. Here every expression becomes a number times powers of atoms, and a sum
//! of such products takes out what its terms share. Then
//!
//! - a divisor is inverted once, whatever is divided by it,
//! - what does not vary is multiplied first, so that it is computed once for many evaluations,
//! - pairs of factors that occur in several products are multiplied once.
//!
//! Products of sums are not multiplied out, and sums are added up in the order in which they were written but for terms
//! that share a factor: differences of nearly equal numbers stay as exact as they were.

mod atoms;
mod sums;
mod words;
mod writer;

use super::graph::{Graph, Node, NodeId, Operation};
use crate::number::Real;
use atoms::Forms;
use writer::Writer;

/// When a variable becomes known: 0 if it is the same in many evaluations, higher the more often it changes.
pub(crate) type Level = u8;

/// What a division costs, in additions.
const DIVISION: usize = 8;

impl<S: Real> Graph<S> {
    /// Expressions with the values of `roots` but for rounding, with fewer operations where that is possible. `level`
    /// tells how often a variable changes.
    pub(crate) fn reduced(&mut self, roots: &[NodeId], level: impl Fn(usize) -> Level) -> Vec<NodeId> {
        let mut best = self.expand_powers(roots);
        let mut least = self.cost(&best, &level);
        for factors_out in [true, false] {
            let candidate = self.rewritten(roots, factors_out, &level);
            let cost = self.cost(&candidate, &level);
            if cost < least {
                (best, least) = (candidate, cost);
            }
        }
        best
    }

    fn rewritten(&mut self, roots: &[NodeId], factors_out: bool, level: &impl Fn(usize) -> Level) -> Vec<NodeId> {
        let (forms, products) = Forms::of(self, roots, factors_out);
        Writer::write(forms, &products, level)
    }

    /// The cost of one evaluation, without what does not vary.
    fn cost(&self, roots: &[NodeId], level: &impl Fn(usize) -> Level) -> usize {
        let is_needed = self.needed(roots);
        let last = is_needed.len();
        let mut varies = vec![false; last];
        let mut cost = 0;
        for id in (0..last).filter(|&id| is_needed[id]) {
            let node = self.nodes[id];
            varies[id] = match node {
                Node::Variable(index) => level(index) > 0,
                _ => node.operands().any(|operand| varies[operand]),
            };
            if varies[id] {
                cost += match node {
                    Node::Variable(_) | Node::Constant(_) => 0,
                    Node::Apply(Operation::Divide(..)) => DIVISION,
                    Node::PowerInteger(..) | Node::Apply(_) => 1,
                };
            }
        }
        cost
    }
}

#[cfg(test)]
mod tests;
