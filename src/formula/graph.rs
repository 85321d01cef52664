//! Expression graphs, in which every distinct sub-expression occurs once.

use std::collections::HashMap;

use super::Function;
pub(crate) use super::operation::NodeId;
use super::operation::Operation;
use super::variables::{LAST, OtherVariables, bit};
use crate::number::Real;

/// A value of the graph; operands are earlier nodes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Node {
    /// The variable of that index.
    Variable(usize),
    /// By its index in the graph's table of constants, so that nodes can be hashed.
    Constant(usize),
    /// Integer power. Derivatives are formed of it as a whole; programs get products ([`Graph::expand_powers`]).
    PowerInteger(NodeId, i32),
    Apply(Operation),
}

impl Node {
    pub(super) fn operands(self) -> impl Iterator<Item = NodeId> {
        let (operands, count) = match self {
            Self::Variable(_) | Self::Constant(_) => ([0; 3], 0),
            Self::PowerInteger(base, _) => ([base; 3], 1),
            Self::Apply(operation) => operation.listed(),
        };
        operands.into_iter().take(count)
    }
}

/// A directed acyclic graph of nodes in topological order.
#[derive(Debug, Clone)]
pub(crate) struct Graph<S> {
    pub(super) nodes: Vec<Node>,
    /// The variables in every node, a bit each; all from the 64th on share the last one.
    pub(super) variables: Vec<u64>,
    others: OtherVariables,
    constants: Vec<S>,
    /// The constants that no operation folds.
    held: Vec<usize>,
    index: QuickMap<Node, NodeId>,
    /// Derivatives that were formed, by node and variable.
    pub(super) derivatives: QuickMap<(NodeId, usize), NodeId>,
}

impl<S: Real> Default for Graph<S> {
    fn default() -> Self {
        Self {
            nodes: Vec::new(),
            variables: Vec::new(),
            others: OtherVariables::default(),
            // The constants that are looked for most often are found first.
            constants: vec![S::ZERO, S::ONE, -S::ONE],
            held: Vec::new(),
            index: QuickMap::default(),
            derivatives: QuickMap::default(),
        }
    }
}

impl<S: Real> Graph<S> {
    fn insert(&mut self, node: Node) -> NodeId {
        let key = match node {
            Node::Apply(operation) => Node::Apply(operation.sorted()),
            _ => node,
        };
        *self.index.entry(key).or_insert_with(|| {
            match node {
                Node::Variable(index) => {
                    self.variables.push(bit(index));
                    self.others.push_variable(index);
                }
                _ => {
                    self.variables.push(node.operands().fold(0, |all, operand| all | self.variables[operand]));
                    self.others.push(node.operands());
                }
            }
            self.nodes.push(node);
            self.nodes.len() - 1
        })
    }

    /// Returns true if the node may depend on the variable; it does not, if it may not.
    pub(crate) fn may_contain(&self, id: NodeId, variable: usize) -> bool {
        self.variables[id] & bit(variable) != 0 && (bit(variable) != LAST || self.others.contains(id, variable))
    }

    /// Returns true if two nodes may depend on one variable; they do not, if they may not.
    pub(crate) fn may_share(&self, one: NodeId, other: NodeId) -> bool {
        let shared = self.variables[one] & self.variables[other];
        shared & !LAST != 0 || shared != 0 && self.others.share(one, other)
    }

    /// Returns true if there is a node for this product.
    pub(super) fn has_product(&self, a: NodeId, b: NodeId) -> bool {
        self.index.contains_key(&Node::Apply(Operation::Multiply(a, b).sorted()))
    }

    fn apply(&mut self, operation: Operation) -> NodeId {
        self.insert(Node::Apply(operation))
    }

    /// The value of a [`Node::Constant`].
    pub(super) fn number(&self, constant: usize) -> S {
        self.constants[constant]
    }

    pub(crate) fn as_constant(&self, id: NodeId) -> Option<S> {
        match self.nodes[id] {
            Node::Constant(constant) if !self.held.contains(&constant) => Some(self.number(constant)),
            _ => None,
        }
    }

    pub(crate) fn is(&self, id: NodeId, value: f64) -> bool {
        self.as_constant(id) == Some(S::from(value))
    }

    pub(crate) fn variable(&mut self, index: usize) -> NodeId {
        self.insert(Node::Variable(index))
    }

    pub(crate) fn constant(&mut self, value: S) -> NodeId {
        // A formula has only a few constants, so they are searched in order. 0 and −0 are different constants, because
        // of their signs; a NaN is equal to nothing and always becomes a new one.
        let same = |known: &S| *known == value && known.signum() == value.signum();
        let known =
            (0..self.constants.len()).find(|&known| same(&self.constants[known]) && !self.held.contains(&known));
        let constant = known.unwrap_or_else(|| {
            self.constants.push(value);
            self.constants.len() - 1
        });
        self.insert(Node::Constant(constant))
    }

    /// A constant that may become another one: operations with it are kept, so that the graph has the same form for
    /// every value.
    pub(crate) fn held(&mut self, value: S) -> NodeId {
        self.held.push(self.constants.len());
        self.constants.push(value);
        self.insert(Node::Constant(self.constants.len() - 1))
    }

    pub(crate) fn whole(&mut self, value: i32) -> NodeId {
        self.constant(S::from(f64::from(value)))
    }

    pub(crate) fn add(&mut self, a: NodeId, b: NodeId) -> NodeId {
        match (self.as_constant(a), self.as_constant(b)) {
            (Some(u), Some(v)) => self.constant(u + v),
            (Some(u), _) if u == S::ZERO => b,
            (_, Some(v)) if v == S::ZERO => a,
            _ => self.apply(Operation::Add(a, b)),
        }
    }

    pub(crate) fn subtract(&mut self, a: NodeId, b: NodeId) -> NodeId {
        match (self.as_constant(a), self.as_constant(b)) {
            (Some(u), Some(v)) => self.constant(u - v),
            (Some(u), _) if u == S::ZERO => self.negate(b),
            (_, Some(v)) if v == S::ZERO => a,
            _ => self.apply(Operation::Subtract(a, b)),
        }
    }

    pub(crate) fn multiply(&mut self, a: NodeId, b: NodeId) -> NodeId {
        match (self.as_constant(a), self.as_constant(b)) {
            (Some(u), Some(v)) => self.constant(u * v),
            // Also where the other factor is not finite: 0*ln(x) is taken to be 0 for every x.
            (Some(u), _) | (_, Some(u)) if u == S::ZERO => self.whole(0),
            (Some(u), _) if u == S::ONE => b,
            (_, Some(v)) if v == S::ONE => a,
            _ => self.apply(Operation::Multiply(a, b)),
        }
    }

    pub(crate) fn divide(&mut self, a: NodeId, b: NodeId) -> NodeId {
        match (self.as_constant(a), self.as_constant(b)) {
            (Some(u), Some(v)) => self.constant(u / v),
            (Some(u), _) if u == S::ZERO => a,
            (_, Some(v)) if v == S::ONE => a,
            // Multiplying by a power of two gives the same number to the bit, ten times faster.
            (_, Some(v)) if is_power_of_two(v) => {
                let reciprocal = self.constant(S::ONE / v);
                self.multiply(a, reciprocal)
            }
            _ => self.apply(Operation::Divide(a, b)),
        }
    }

    pub(crate) fn negate(&mut self, a: NodeId) -> NodeId {
        match (self.as_constant(a), self.nodes[a]) {
            (Some(value), _) => self.constant(-value),
            (None, Node::Apply(Operation::Negate(inner))) => inner,
            _ => self.apply(Operation::Negate(a)),
        }
    }

    pub(crate) fn power(&mut self, base: NodeId, exponent: NodeId) -> NodeId {
        match (self.as_constant(base), self.as_constant(exponent)) {
            (Some(u), Some(v)) => self.constant(u.powf(v)),
            (_, Some(v)) if is_small_integer(v) => self.power_integer(base, v.to_f64() as i32),
            _ => self.apply(Operation::Power(base, exponent)),
        }
    }

    pub(crate) fn power_integer(&mut self, base: NodeId, exponent: i32) -> NodeId {
        match exponent {
            0 => self.whole(1),
            1 => base,
            _ => self.insert(Node::PowerInteger(base, exponent)),
        }
    }

    pub(crate) fn call(&mut self, function: Function, argument: NodeId) -> NodeId {
        match self.as_constant(argument) {
            Some(u) => self.constant(function.apply(u)),
            None => self.apply(Operation::Call(function, argument)),
        }
    }

    /// For a sine or a cosine both of them, if the graph has them.
    pub(super) fn sine_and_cosine(&self, id: NodeId) -> Option<[NodeId; 2]> {
        let Node::Apply(Operation::Call(Function::Sin | Function::Cos, angle)) = self.nodes[id] else { return None };
        let find = |function| self.index.get(&Node::Apply(Operation::Call(function, angle))).copied();
        Some([find(Function::Sin)?, find(Function::Cos)?])
    }

    /// Counts how often every node is an operand of what `roots` need; the roots themselves are used by others too.
    pub(super) fn uses(&self, roots: &[NodeId]) -> Vec<usize> {
        let mut uses = vec![0; roots.iter().copied().max().map_or(0, |root| root + 1)];
        roots.iter().for_each(|&root| uses[root] += 2);
        for id in (0..uses.len()).rev() {
            if uses[id] > 0 {
                self.nodes[id].operands().for_each(|operand| uses[operand] += 1);
            }
        }
        uses
    }

    /// The expressions `roots` with other expressions, of the same graph, in place of variables: variable k becomes
    /// `replacement[k]`. Variables beyond that stay.
    pub(crate) fn substitute(&mut self, roots: &[NodeId], replacement: &[NodeId]) -> Vec<NodeId> {
        rebuilt(&self.uses(roots), roots, |id, replaced| match self.nodes[id] {
            Node::Variable(index) => replacement.get(index).copied().unwrap_or(id),
            _ => self.with_operands(id, replaced),
        })
    }

    /// The divisors in `roots`, and the bases of powers that may be divisors.
    pub(crate) fn divisors(&self, roots: &[NodeId]) -> Vec<NodeId> {
        let is_used = self.uses(roots).into_iter().enumerate().filter(|(_, uses)| *uses > 0);
        let divisor = |(id, _)| match self.nodes[id] {
            Node::Apply(Operation::Divide(_, divisor)) => Some(divisor),
            Node::Apply(Operation::Power(base, _)) => Some(base),
            Node::PowerInteger(base, exponent) if exponent < 0 => Some(base),
            _ => None,
        };
        is_used.filter_map(divisor).collect()
    }

    /// a and b of a node a − b.
    pub(crate) fn terms_of_difference(&self, id: NodeId) -> Option<(NodeId, NodeId)> {
        if let Node::Apply(Operation::Subtract(a, b)) = self.nodes[id] { Some((a, b)) } else { None }
    }

    /// The functions that `roots` need, each with its node and that of its argument.
    pub(crate) fn calls(&self, roots: &[NodeId]) -> Vec<(NodeId, Function, NodeId)> {
        let is_used = self.uses(roots).into_iter().enumerate().filter(|(_, uses)| *uses > 0);
        let call = |(id, _)| match self.nodes[id] {
            Node::Apply(Operation::Call(function, argument)) => Some((id, function, argument)),
            _ => None,
        };
        is_used.filter_map(call).collect()
    }

    /// The expressions `roots` with another one in place of a node.
    pub(crate) fn replaced(&mut self, roots: &[NodeId], id: NodeId, by: NodeId) -> Vec<NodeId> {
        rebuilt(&self.uses(roots), roots, |node, new| if node == id { by } else { self.with_operands(node, new) })
    }

    /// The node with `replaced[k]` in place of every operand k.
    pub(super) fn with_operands(&mut self, id: NodeId, replaced: &[NodeId]) -> NodeId {
        match self.nodes[id] {
            Node::Variable(_) | Node::Constant(_) => id,
            Node::PowerInteger(base, exponent) => self.power_integer(replaced[base], exponent),
            Node::Apply(operation) => self.simplified(operation.map(|operand| replaced[operand])),
        }
    }

    /// An operation on nodes, simplified where it can be.
    pub(super) fn simplified(&mut self, operation: Operation) -> NodeId {
        match operation {
            Operation::Add(a, b) => self.add(a, b),
            Operation::Subtract(a, b) => self.subtract(a, b),
            Operation::Multiply(a, b) => self.multiply(a, b),
            Operation::Divide(a, b) => self.divide(a, b),
            Operation::Negate(a) => self.negate(a),
            Operation::Power(a, b) => self.power(a, b),
            Operation::Call(function, a) => self.call(function, a),
            Operation::Fused(..) => unreachable!("graphs have no fused operations"),
        }
    }

    /// Which of the first `variables` variables the expression contains.
    pub(crate) fn variables_of(&self, root: NodeId, variables: usize) -> Vec<bool> {
        let uses = self.uses(&[root]);
        let is_used = |node: Node| (0..uses.len()).any(|id| uses[id] > 0 && self.nodes[id] == node);
        (0..variables).map(|variable| is_used(Node::Variable(variable))).collect()
    }

    /// The degree of an expression as a polynomial in all variables; `None` if it is none, or has a function of them.
    pub(crate) fn degree(&self, root: NodeId) -> Option<u32> {
        let uses = self.uses(&[root]);
        let mut degrees: Vec<Option<u32>> = Vec::with_capacity(root + 1);
        for (id, &uses) in uses.iter().enumerate() {
            let of = |operand: NodeId| degrees[operand];
            let both = |a: NodeId, b: NodeId| of(a).zip(of(b));
            let degree = match self.nodes[id] {
                _ if uses == 0 => None,
                Node::Variable(_) => Some(1),
                Node::Constant(_) => Some(0),
                Node::PowerInteger(base, exponent) => match (of(base), u32::try_from(exponent)) {
                    (Some(0), _) => Some(0),
                    (Some(degree), Ok(exponent)) => degree.checked_mul(exponent),
                    _ => None,
                },
                Node::Apply(Operation::Add(a, b) | Operation::Subtract(a, b)) => both(a, b).map(|(a, b)| a.max(b)),
                Node::Apply(Operation::Multiply(a, b)) => both(a, b).and_then(|(a, b)| a.checked_add(b)),
                Node::Apply(Operation::Negate(a)) => of(a),
                Node::Apply(Operation::Divide(a, b)) => of(a).filter(|_| of(b) == Some(0)),
                Node::Apply(operation) => operation.operands().all(|operand| of(operand) == Some(0)).then_some(0),
            };
            degrees.push(degree);
        }
        degrees[root]
    }

    /// Writes every integer power out as products, by repeated squaring. Powers of one base share their squares. The
    /// nodes that take the place of `roots`.
    pub(super) fn expand_powers(&mut self, roots: &[NodeId]) -> Vec<NodeId> {
        rebuilt(&self.uses(roots), roots, |id, expanded| match self.nodes[id] {
            Node::PowerInteger(base, exponent) => self.products(expanded[base], exponent),
            _ => self.with_operands(id, expanded),
        })
    }

    pub(super) fn products(&mut self, base: NodeId, exponent: i32) -> NodeId {
        let (mut square, mut remaining) = (base, exponent.unsigned_abs());
        let mut product = None;
        loop {
            if remaining & 1 == 1 {
                product = Some(product.map_or(square, |product| self.apply(Operation::Multiply(product, square))));
            }
            remaining >>= 1;
            if remaining == 0 {
                break;
            }
            square = self.apply(Operation::Multiply(square, square));
        }
        let product = product.unwrap_or_else(|| self.whole(1));
        if exponent < 0 {
            let one = self.whole(1);
            return self.apply(Operation::Divide(one, product));
        }
        product
    }
}

/// The nodes that take the place of `roots`, where every node that is used becomes the one that `new` makes from its
/// index and the nodes in the places of earlier ones.
pub(super) fn rebuilt(
    uses: &[usize],
    roots: &[NodeId],
    mut new: impl FnMut(NodeId, &[NodeId]) -> NodeId,
) -> Vec<NodeId> {
    let mut places: Vec<NodeId> = (0..uses.len()).collect();
    for id in (0..uses.len()).filter(|&id| uses[id] > 0) {
        places[id] = new(id, &places);
    }
    roots.iter().map(|&root| places[root]).collect()
}

fn is_small_integer<S: Real>(value: S) -> bool {
    let rounded = value.to_f64();
    S::from(rounded) == value && rounded.fract() == 0.0 && rounded.abs() <= 1e6
}

/// Returns true if the value is ±2^k, with a reciprocal that is as exact.
fn is_power_of_two<S: Real>(value: S) -> bool {
    let rounded = value.to_f64();
    S::from(rounded) == value && rounded.to_bits() << 12 == 0 && rounded.is_normal() && (1.0 / rounded).is_normal()
}

/// A table that finds a key in a few instructions. Nobody makes up formulas whose nodes collide.
type QuickMap<K, V> = HashMap<K, V, foldhash::fast::FixedState>;
