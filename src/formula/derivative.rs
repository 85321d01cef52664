//! Symbolic derivatives on a graph.

use super::Function;
use super::graph::{Graph, Node, NodeId};
use super::operation::Operation;
use crate::number::Real;

impl<S: Real> Graph<S> {
    /// The derivative of the expression rooted at `root` with respect to a variable, as a new expression of the same
    /// graph.
    pub(crate) fn derivative(&mut self, root: NodeId, variable: usize) -> NodeId {
        let unknown = |graph: &Self, id: NodeId| {
            let id = graph.varying(id, variable);
            (graph.may_contain(id, variable) && !graph.derivatives.contains_key(&(id, variable))).then_some(id)
        };
        let mut waiting = Vec::new();
        waiting.extend(unknown(self, root));
        while let Some(&id) = waiting.last() {
            // The last one waits for its operands, if they have no derivatives yet.
            let place = waiting.len();
            waiting.extend(self.nodes[id].operands().filter_map(|operand| unknown(self, operand)));
            if waiting.len() == place {
                let derivative = self.derivative_of_node(id, variable);
                self.derivatives.insert((id, variable), derivative);
                waiting.pop();
            }
        }
        self.known_derivative(root, variable)
    }

    /// The node with the same derivative that is left of a sum without the last terms that do not contain the variable:
    /// of a sum over all pairs of many bodies each coordinate is in few.
    fn varying(&self, mut id: NodeId, variable: usize) -> NodeId {
        loop {
            id = match self.nodes[id] {
                Node::Apply(Operation::Add(a, b) | Operation::Subtract(a, b)) if !self.may_contain(b, variable) => a,
                Node::Apply(Operation::Add(a, b)) if !self.may_contain(a, variable) => b,
                _ => return id,
            };
        }
    }

    /// A derivative that was formed, or that of a node without the variable.
    fn known_derivative(&mut self, id: NodeId, variable: usize) -> NodeId {
        let id = self.varying(id, variable);
        self.derivatives.get(&(id, variable)).copied().unwrap_or_else(|| self.whole(0))
    }

    fn derivative_of_node(&mut self, id: NodeId, variable: usize) -> NodeId {
        let (text, [a, b]) = match self.nodes[id] {
            Node::Variable(index) => return self.whole((index == variable).into()),
            Node::Constant(_) => return self.whole(0),
            Node::PowerInteger(base, exponent) => {
                let (coefficient, power) = (self.whole(exponent), self.power_integer(base, exponent - 1));
                let slope = self.known_derivative(base, variable);
                return self.written("n*p*x", &[("n", coefficient), ("p", power), ("x", slope)]);
            }
            Node::Apply(Operation::Call(Function::Table(table), a)) => {
                let Some(slope) = table.derivative() else { return self.whole(0) };
                let (outer, inner) = (self.call(Function::Table(slope), a), self.known_derivative(a, variable));
                return self.multiply(outer, inner);
            }
            Node::Apply(operation) => match operation {
                Operation::Negate(a) => ("-x", [a; 2]),
                Operation::Call(function, a) => (derivative_of_call(function), [a; 2]),
                Operation::Add(a, b) => ("x + y", [a, b]),
                Operation::Subtract(a, b) => ("x - y", [a, b]),
                Operation::Multiply(a, b) => ("x*b + a*y", [a, b]),
                Operation::Divide(a, b) => ("(x - f*y)/b", [a, b]),
                // The logarithm enters only where the exponent is not constant.
                Operation::Power(a, b) if self.may_contain(b, variable) => ("b*a^(b - 1)*x + f*ln(a)*y", [a, b]),
                Operation::Power(a, b) => ("b*a^(b - 1)*x", [a, b]),
                Operation::Fused(..) => unreachable!("graphs have no fused operations"),
            },
        };
        let [x, y] = [a, b].map(|operand| self.known_derivative(operand, variable));
        self.written(text, &[("a", a), ("b", b), ("x", x), ("y", y), ("f", id)])
    }
}

/// The derivative of f = f(a), where a has the derivative x.
fn derivative_of_call(function: Function) -> &'static str {
    match function {
        Function::Sin => "cos(a)*x",
        Function::Cos => "-sin(a)*x",
        Function::Tan => "(1 + f^2)*x",
        Function::Sinh => "cosh(a)*x",
        Function::Cosh => "sinh(a)*x",
        Function::Tanh => "(1 - f^2)*x",
        Function::Asin => "1/sqrt(1 - a^2)*x",
        Function::Acos => "-(1/sqrt(1 - a^2))*x",
        Function::Atan => "1/(1 + a^2)*x",
        Function::Exp => "f*x",
        Function::Ln => "1/a*x",
        Function::Log10 => "1/ln(10)/a*x",
        Function::Sqrt => "0.5/f*x",
        Function::Abs => "sign(a)*x",
        Function::Sign | Function::Step | Function::Table(_) => "0",
    }
}
