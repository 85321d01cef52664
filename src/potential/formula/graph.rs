//! Expression graphs, in which every distinct sub-expression occurs once, and their symbolic derivatives.

use std::collections::HashMap;

use crate::scalar::Real;

/// Index of a node in its [`Graph`].
pub(super) type NodeId = usize;

/// The functions of the grammar.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[allow(missing_docs)] // The variants are their own names.
pub enum Function {
    Sin,
    Cos,
    Tan,
    Sinh,
    Cosh,
    Tanh,
    Asin,
    Acos,
    Atan,
    Exp,
    Ln,
    Log10,
    Sqrt,
    Abs,
    /// Sign of the argument; arises as the derivative of `abs` and has no name in the grammar.
    Sign,
}

impl Function {
    /// Every function of the grammar with its name.
    pub const NAMED: [(&'static str, Function); 14] = [
        ("sin", Function::Sin),
        ("cos", Function::Cos),
        ("tan", Function::Tan),
        ("sinh", Function::Sinh),
        ("cosh", Function::Cosh),
        ("tanh", Function::Tanh),
        ("asin", Function::Asin),
        ("acos", Function::Acos),
        ("atan", Function::Atan),
        ("exp", Function::Exp),
        ("ln", Function::Ln),
        ("log10", Function::Log10),
        ("sqrt", Function::Sqrt),
        ("abs", Function::Abs),
    ];

    /// The function of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::NAMED.iter().find(|(n, _)| *n == name).map(|&(_, function)| function)
    }

    #[inline]
    pub(crate) fn apply<S: Real>(self, u: S) -> S {
        match self {
            Self::Sin => u.sin(),
            Self::Cos => u.cos(),
            Self::Tan => u.tan(),
            Self::Sinh => u.sinh(),
            Self::Cosh => u.cosh(),
            Self::Tanh => u.tanh(),
            Self::Asin => u.asin(),
            Self::Acos => u.acos(),
            Self::Atan => u.atan(),
            Self::Exp => u.exp(),
            Self::Ln => u.ln(),
            Self::Log10 => u.log10(),
            Self::Sqrt => u.sqrt(),
            Self::Abs => u.abs(),
            Self::Sign if u == S::ZERO => S::ZERO,
            Self::Sign => u.signum(),
        }
    }
}

/// One operation, whose operands are earlier nodes. A constant is given by its index in the graph's table of constants,
/// so that nodes can be hashed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Node {
    X,
    Constant(usize),
    Add(NodeId, NodeId),
    Subtract(NodeId, NodeId),
    Multiply(NodeId, NodeId),
    Divide(NodeId, NodeId),
    Negate(NodeId),
    /// Integer power.
    PowerInteger(NodeId, i32),
    Power(NodeId, NodeId),
    Call(Function, NodeId),
}

/// A directed acyclic graph of [`Node`]s in topological order.
#[derive(Debug)]
pub(super) struct Graph<S> {
    nodes: Vec<Node>,
    constants: Vec<S>,
    index: HashMap<Node, NodeId>,
}

impl<S> Default for Graph<S> {
    fn default() -> Self {
        Self { nodes: Vec::new(), constants: Vec::new(), index: HashMap::new() }
    }
}

impl<S: Real> Graph<S> {
    pub(super) fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    fn insert(&mut self, node: Node) -> NodeId {
        *self.index.entry(node).or_insert_with(|| {
            self.nodes.push(node);
            self.nodes.len() - 1
        })
    }

    /// The value of a [`Node::Constant`].
    pub(super) fn number(&self, constant: usize) -> S {
        self.constants[constant]
    }

    fn as_constant(&self, id: NodeId) -> Option<S> {
        match self.nodes[id] {
            Node::Constant(constant) => Some(self.number(constant)),
            _ => None,
        }
    }

    fn is(&self, id: NodeId, value: f64) -> bool {
        self.as_constant(id) == Some(S::from(value))
    }

    pub(super) fn x(&mut self) -> NodeId {
        self.insert(Node::X)
    }

    pub(super) fn constant(&mut self, value: S) -> NodeId {
        // A formula has only a few constants, so they are searched in order. 0 and −0 are different constants, because
        // of their signs; a NaN is equal to nothing and always becomes a new one.
        let same = |known: &S| *known == value && known.signum() == value.signum();
        let constant = self.constants.iter().position(same).unwrap_or_else(|| {
            self.constants.push(value);
            self.constants.len() - 1
        });
        self.insert(Node::Constant(constant))
    }

    fn whole(&mut self, value: i32) -> NodeId {
        self.constant(S::from(f64::from(value)))
    }

    pub(super) fn add(&mut self, a: NodeId, b: NodeId) -> NodeId {
        match (self.as_constant(a), self.as_constant(b)) {
            (Some(u), Some(v)) => self.constant(u + v),
            (Some(u), _) if u == S::ZERO => b,
            (_, Some(v)) if v == S::ZERO => a,
            _ => self.insert(Node::Add(a, b)),
        }
    }

    pub(super) fn subtract(&mut self, a: NodeId, b: NodeId) -> NodeId {
        match (self.as_constant(a), self.as_constant(b)) {
            (Some(u), Some(v)) => self.constant(u - v),
            (Some(u), _) if u == S::ZERO => self.negate(b),
            (_, Some(v)) if v == S::ZERO => a,
            _ => self.insert(Node::Subtract(a, b)),
        }
    }

    pub(super) fn multiply(&mut self, a: NodeId, b: NodeId) -> NodeId {
        match (self.as_constant(a), self.as_constant(b)) {
            (Some(u), Some(v)) => self.constant(u * v),
            // Also where the other factor is not finite: 0*ln(x) is taken to be 0 for every x.
            (Some(u), _) | (_, Some(u)) if u == S::ZERO => self.whole(0),
            (Some(u), _) if u == S::ONE => b,
            (_, Some(v)) if v == S::ONE => a,
            _ => self.insert(Node::Multiply(a, b)),
        }
    }

    pub(super) fn divide(&mut self, a: NodeId, b: NodeId) -> NodeId {
        match (self.as_constant(a), self.as_constant(b)) {
            (Some(u), Some(v)) => self.constant(u / v),
            (Some(u), _) if u == S::ZERO => a,
            (_, Some(v)) if v == S::ONE => a,
            _ => self.insert(Node::Divide(a, b)),
        }
    }

    pub(super) fn negate(&mut self, a: NodeId) -> NodeId {
        match self.nodes[a] {
            Node::Constant(constant) => self.constant(-self.number(constant)),
            Node::Negate(inner) => inner,
            _ => self.insert(Node::Negate(a)),
        }
    }

    pub(super) fn power(&mut self, base: NodeId, exponent: NodeId) -> NodeId {
        match (self.as_constant(base), self.as_constant(exponent)) {
            (Some(u), Some(v)) => self.constant(u.powf(v)),
            (_, Some(v)) if is_small_integer(v) => self.power_integer(base, v.to_f64() as i32),
            _ => self.insert(Node::Power(base, exponent)),
        }
    }

    fn power_integer(&mut self, base: NodeId, exponent: i32) -> NodeId {
        match exponent {
            0 => self.whole(1),
            1 => base,
            _ => self.insert(Node::PowerInteger(base, exponent)),
        }
    }

    pub(super) fn call(&mut self, function: Function, argument: NodeId) -> NodeId {
        match self.as_constant(argument) {
            Some(u) => self.constant(function.apply(u)),
            None => self.insert(Node::Call(function, argument)),
        }
    }

    /// d/dx of the expression rooted at `root`, as a new expression of the same graph.
    pub(super) fn derivative(&mut self, root: NodeId) -> NodeId {
        // Operands come before the nodes that use them, so one pass in order finds all inner derivatives ready.
        let mut derivatives: Vec<NodeId> = Vec::with_capacity(root + 1);
        for id in 0..=root {
            let derivative = self.derivative_of_node(id, &derivatives);
            derivatives.push(derivative);
        }
        derivatives[root]
    }

    fn derivative_of_node(&mut self, id: NodeId, inner: &[NodeId]) -> NodeId {
        match self.nodes[id] {
            Node::X => self.whole(1),
            Node::Constant(_) => self.whole(0),
            Node::Add(a, b) => self.add(inner[a], inner[b]),
            Node::Subtract(a, b) => self.subtract(inner[a], inner[b]),
            Node::Negate(a) => self.negate(inner[a]),
            Node::Multiply(a, b) => {
                let left = self.multiply(inner[a], b);
                let right = self.multiply(a, inner[b]);
                self.add(left, right)
            }
            Node::Divide(a, b) => {
                // (a/b)′ = (a′ − (a/b) b′)/b
                let quotient = self.multiply(id, inner[b]);
                let numerator = self.subtract(inner[a], quotient);
                self.divide(numerator, b)
            }
            Node::PowerInteger(a, n) => {
                let coefficient = self.whole(n);
                let power = self.power_integer(a, n - 1);
                let outer = self.multiply(coefficient, power);
                self.multiply(outer, inner[a])
            }
            Node::Power(a, b) => {
                // (a^b)′ = b a^(b−1) a′ + a^b ln(a) b′; the logarithm enters only where the exponent depends on x.
                let one = self.whole(1);
                let less = self.subtract(b, one);
                let power = self.power(a, less);
                let outer = self.multiply(b, power);
                let from_base = self.multiply(outer, inner[a]);
                if self.is(inner[b], 0.0) {
                    return from_base;
                }
                let ln = self.call(Function::Ln, a);
                let outer = self.multiply(id, ln);
                let from_exponent = self.multiply(outer, inner[b]);
                self.add(from_base, from_exponent)
            }
            Node::Call(function, a) => {
                let outer = self.derivative_of_call(function, a, id);
                self.multiply(outer, inner[a])
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
            Function::Sign => self.whole(0),
        }
    }
}

fn is_small_integer<S: Real>(value: S) -> bool {
    let rounded = value.to_f64();
    S::from(rounded) == value && rounded.fract() == 0.0 && rounded.abs() <= 1e6
}
