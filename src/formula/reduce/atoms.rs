//! Normal forms: numbers times powers of atoms.

use std::collections::HashMap;

use super::super::Function;
use super::super::graph::{Graph, Node, NodeId, Operation};
use crate::number::Real;

/// Index of an atom in its [`Forms`].
pub(super) type AtomId = usize;

/// A number times powers of atoms, which are sorted. Zero has none.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) struct Product {
    /// The node of the number.
    pub(super) coefficient: NodeId,
    pub(super) powers: Vec<(AtomId, i32)>,
}

/// What is not a product. It is made of atoms before it.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) enum Atom {
    /// By its node.
    Variable(NodeId),
    Call(Function, Product),
    /// A power whose exponent is not an integer.
    Power([Product; 2]),
    /// In the order in which it is added up.
    Sum(Vec<Product>),
}

impl Atom {
    /// The products in it.
    pub(super) fn parts(&self) -> &[Product] {
        match self {
            Self::Variable(_) => &[],
            Self::Call(_, argument) => std::slice::from_ref(argument),
            Self::Power(parts) => parts,
            Self::Sum(terms) => terms,
        }
    }
}

/// A node that has a form.
enum Known {
    Product(Product),
    /// A sum that may become a part of a longer one.
    Terms(Vec<Product>),
}

/// The atoms of some expressions of a graph.
pub(super) struct Forms<'g, S> {
    pub(super) graph: &'g mut Graph<S>,
    pub(super) atoms: Vec<Atom>,
    index: HashMap<Atom, AtomId>,
    /// Whether a factor of some terms of a sum is put before the sum of these terms.
    pub(super) factors_out: bool,
}

impl<'g, S: Real> Forms<'g, S> {
    /// The forms of `roots`.
    pub(super) fn of(graph: &'g mut Graph<S>, roots: &[NodeId], factors_out: bool) -> (Self, Vec<Product>) {
        let uses = uses(graph, roots);
        let mut forms = Self { graph, atoms: Vec::new(), index: HashMap::new(), factors_out };
        let mut known: Vec<Option<Known>> = (0..uses.len()).map(|_| None).collect();
        for id in (0..uses.len()).filter(|&id| uses[id] > 0) {
            let form = match forms.graph.nodes[id] {
                Node::Apply(operation @ (Operation::Add(a, b) | Operation::Subtract(a, b))) => {
                    // The first operand keeps its order of additions, if nothing else needs it.
                    let mut terms = match known[a].take() {
                        Some(Known::Terms(terms)) if uses[a] == 1 => terms,
                        other => {
                            known[a] = other;
                            vec![forms.product(&mut known, a)]
                        }
                    };
                    let term = forms.product(&mut known, b);
                    let is_added = matches!(operation, Operation::Add(..));
                    terms.push(if is_added { term } else { forms.negated(term) });
                    Known::Terms(terms)
                }
                node => Known::Product(forms.of_node(id, node, &mut known)),
            };
            known[id] = Some(form);
        }
        let products = roots.iter().map(|&root| forms.product(&mut known, root)).collect();
        (forms, products)
    }

    /// What is known of a node, as a product.
    fn product(&mut self, known: &mut [Option<Known>], id: NodeId) -> Product {
        let product = match known[id].take().expect("operands come first") {
            Known::Product(product) => product,
            Known::Terms(terms) => self.sum(terms),
        };
        known[id] = Some(Known::Product(product.clone()));
        product
    }

    fn of_node(&mut self, id: NodeId, node: Node, known: &mut [Option<Known>]) -> Product {
        let operation = match node {
            Node::Variable(_) => return self.atom(Atom::Variable(id)),
            Node::Constant(_) => return Product { coefficient: id, powers: Vec::new() },
            Node::PowerInteger(base, exponent) => {
                let base = self.product(known, base);
                return self.power(&base, exponent);
            }
            Node::Apply(operation) => operation,
        };
        match operation {
            Operation::Add(..) | Operation::Subtract(..) => unreachable!("sums are collected by the caller"),
            Operation::Fused(..) => unreachable!("graphs have no fused operations"),
            Operation::Multiply(a, b) => {
                let [a, b] = [a, b].map(|operand| self.product(known, operand));
                self.times(&a, &b)
            }
            Operation::Divide(a, b) => {
                let [a, b] = [a, b].map(|operand| self.product(known, operand));
                let reciprocal = self.power(&b, -1);
                self.times(&a, &reciprocal)
            }
            Operation::Negate(a) => {
                let a = self.product(known, a);
                self.negated(a)
            }
            Operation::Power(a, b) => {
                let parts = [a, b].map(|operand| self.product(known, operand));
                self.atom(Atom::Power(parts))
            }
            Operation::Call(function, a) => {
                let argument = self.product(known, a);
                self.atom(Atom::Call(function, argument))
            }
        }
    }

    pub(super) fn atom(&mut self, atom: Atom) -> Product {
        let next = self.atoms.len();
        let id = *self.index.entry(atom).or_insert_with_key(|atom| {
            self.atoms.push(atom.clone());
            next
        });
        Product { coefficient: self.graph.whole(1), powers: vec![(id, 1)] }
    }

    pub(super) fn number(&self, product: &Product) -> S {
        self.graph.as_constant(product.coefficient).expect("a coefficient is a number")
    }

    /// The product with another number.
    pub(super) fn with_number(&mut self, number: S, powers: Vec<(AtomId, i32)>) -> Product {
        let powers = if number == S::ZERO { Vec::new() } else { powers };
        Product { coefficient: self.graph.constant(number), powers }
    }

    pub(super) fn negated(&mut self, product: Product) -> Product {
        let number = -self.number(&product);
        self.with_number(number, product.powers)
    }

    pub(super) fn times(&mut self, a: &Product, b: &Product) -> Product {
        let mut powers = a.powers.clone();
        for &(atom, exponent) in &b.powers {
            match powers.binary_search_by_key(&atom, |&(atom, _)| atom) {
                Ok(place) => powers[place].1 += exponent,
                Err(place) => powers.insert(place, (atom, exponent)),
            }
        }
        powers.retain(|&(_, exponent)| exponent != 0);
        let number = self.number(a) * self.number(b);
        self.with_number(number, powers)
    }

    fn power(&mut self, base: &Product, exponent: i32) -> Product {
        let number = self.number(base);
        let mut power = S::ONE;
        (0..exponent.unsigned_abs()).for_each(|_| power *= number);
        let power = if exponent < 0 { S::ONE / power } else { power };
        self.with_number(power, base.powers.iter().map(|&(atom, inner)| (atom, inner * exponent)).collect())
    }
}

/// How often every node is an operand of what `roots` need; the roots themselves are used by others too.
fn uses<S: Real>(graph: &Graph<S>, roots: &[NodeId]) -> Vec<usize> {
    let last = roots.iter().copied().max().map_or(0, |root| root + 1);
    let mut uses = vec![0; last];
    roots.iter().for_each(|&root| uses[root] += 2);
    for id in (0..last).rev() {
        if uses[id] > 0 {
            graph.nodes[id].operands().for_each(|operand| uses[operand] += 1);
        }
    }
    uses
}
