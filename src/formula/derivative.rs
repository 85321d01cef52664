//! Symbolic derivatives on a graph.

use super::Function;
use super::graph::{Graph, Node, NodeId};
use super::operation::Operation;
use crate::number::Real;

impl<S: Real> Graph<S> {
    /// The derivative of the expression rooted at `root` with respect to a variable, as a new expression of the same
    /// graph.
    pub(crate) fn derivative(&mut self, root: NodeId, variable: usize) -> NodeId {
        let is_unknown = |graph: &Self, id: NodeId| {
            graph.may_contain(id, variable) && !graph.derivatives.contains_key(&(id, variable))
        };
        let mut waiting = Vec::new();
        waiting.extend(Some(root).filter(|&root| is_unknown(self, root)));
        while let Some(&id) = waiting.last() {
            // The last one waits for its operands, if they have no derivatives yet.
            let place = waiting.len();
            waiting.extend(self.nodes[id].operands().filter(|&operand| is_unknown(self, operand)));
            if waiting.len() == place {
                let derivative = self.derivative_of_node(id, variable);
                self.derivatives.insert((id, variable), derivative);
                waiting.pop();
            }
        }
        self.known_derivative(root, variable)
    }

    /// A derivative that was formed, or that of a node without the variable.
    fn known_derivative(&mut self, id: NodeId, variable: usize) -> NodeId {
        self.derivatives.get(&(id, variable)).copied().unwrap_or_else(|| self.whole(0))
    }

    fn derivative_of_node(&mut self, id: NodeId, variable: usize) -> NodeId {
        match self.nodes[id] {
            Node::Variable(index) => self.whole((index == variable).into()),
            Node::Constant(_) => self.whole(0),
            Node::PowerInteger(a, n) => {
                let coefficient = self.whole(n);
                let power = self.power_integer(a, n - 1);
                let outer = self.multiply(coefficient, power);
                let inner = self.known_derivative(a, variable);
                self.multiply(outer, inner)
            }
            Node::Apply(operation) => self.derivative_of(operation, id, variable),
        }
    }

    /// The derivative of the node `id`, which is this operation.
    fn derivative_of(&mut self, operation: Operation, id: NodeId, variable: usize) -> NodeId {
        let zero = self.whole(0);
        let inner = |graph: &Self, operand: NodeId| *graph.derivatives.get(&(operand, variable)).unwrap_or(&zero);
        match operation {
            Operation::Negate(a) => self.negate(inner(self, a)),
            Operation::Call(function, a) => {
                let outer = self.derivative_of_call(function, a, id);
                self.multiply(outer, inner(self, a))
            }
            Operation::Fused(..) => unreachable!("graphs have no fused operations"),
            Operation::Add(a, b) => self.add(inner(self, a), inner(self, b)),
            Operation::Subtract(a, b) => self.subtract(inner(self, a), inner(self, b)),
            Operation::Multiply(a, b) => {
                let left = self.multiply(inner(self, a), b);
                let right = self.multiply(a, inner(self, b));
                self.add(left, right)
            }
            Operation::Divide(a, b) => {
                // (a/b)′ = (a′ − (a/b) b′)/b
                let quotient = self.multiply(id, inner(self, b));
                let numerator = self.subtract(inner(self, a), quotient);
                self.divide(numerator, b)
            }
            Operation::Power(a, b) => {
                // (a^b)′ = b a^(b−1) a′ + a^b ln(a) b′; the logarithm enters only where the exponent is not constant.
                let one = self.whole(1);
                let less = self.subtract(b, one);
                let power = self.power(a, less);
                let outer = self.multiply(b, power);
                let from_base = self.multiply(outer, inner(self, a));
                if self.is(inner(self, b), 0.0) {
                    return from_base;
                }
                let ln = self.call(Function::Ln, a);
                let outer = self.multiply(id, ln);
                let from_exponent = self.multiply(outer, inner(self, b));
                self.add(from_base, from_exponent)
            }
        }
    }

    /// f′(u) for `value` = f(u).
    fn derivative_of_call(&mut self, function: Function, u: NodeId, value: NodeId) -> NodeId {
        let one = self.whole(1);
        match function {
            Function::Sin => self.call(Function::Cos, u),
            Function::Cos => {
                let sin = self.call(Function::Sin, u);
                self.negate(sin)
            }
            Function::Tan => {
                let square = self.power_integer(value, 2);
                self.add(one, square)
            }
            Function::Sinh => self.call(Function::Cosh, u),
            Function::Cosh => self.call(Function::Sinh, u),
            Function::Tanh => {
                let square = self.power_integer(value, 2);
                self.subtract(one, square)
            }
            Function::Asin | Function::Acos => {
                let square = self.power_integer(u, 2);
                let difference = self.subtract(one, square);
                let root = self.call(Function::Sqrt, difference);
                let reciprocal = self.divide(one, root);
                if function == Function::Asin { reciprocal } else { self.negate(reciprocal) }
            }
            Function::Atan => {
                let square = self.power_integer(u, 2);
                let sum = self.add(one, square);
                self.divide(one, sum)
            }
            Function::Exp => value,
            Function::Ln => self.divide(one, u),
            Function::Log10 => {
                let scale = self.constant(S::ONE / S::LN_10);
                self.divide(scale, u)
            }
            Function::Sqrt => {
                let half = self.constant(S::ONE.half());
                self.divide(half, value)
            }
            Function::Abs => self.call(Function::Sign, u),
            Function::Sign | Function::Step => self.whole(0),
            Function::Table(table) => match table.derivative() {
                Some(slope) => self.call(Function::Table(slope), u),
                None => self.whole(0),
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Graph;

    #[test]
    fn derivatives_by_the_last_of_many_variables() {
        let mut graph = Graph::<f64>::default();
        let variables: Vec<_> = (0..80).map(|variable| graph.variable(variable)).collect();
        let sum = variables.iter().copied().reduce(|sum, variable| graph.add(sum, variable)).unwrap();
        let square = graph.power_integer(variables[70], 2);
        let product = graph.multiply(square, variables[3]);
        let all = graph.add(sum, product);
        for (variable, others) in [(2, vec![]), (69, vec![]), (79, vec![]), (70, vec![70, 3]), (3, vec![70, 3])] {
            let derivative = graph.derivative(all, variable);
            let contains = graph.variables_of(derivative, 80);
            assert!((0..80).filter(|&v| contains[v]).all(|v| others.contains(&v)), "{variable}");
            assert_eq!(others.is_empty(), graph.is(derivative, 1.0), "{variable}");
        }
    }
}
