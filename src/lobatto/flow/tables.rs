//! The matrices of a window of a scene on one rule, for windows of any length.

use crate::lobatto::rule::WeakRule;
use crate::lobatto::tables::{Matrix, Nodes, evaluation_matrix};

/// The matrices of one system: A and A² as they are, or of what is left of the rates without their highest modes.
pub(super) struct Matrices<const P: usize> {
    /// A by columns.
    pub(super) a: Box<Matrix<P>>,
    /// A² by columns.
    pub(super) a_squared: Box<Matrix<P>>,
}

/// What windows of a rule need, with time in units of their length.
pub(super) struct FlowTables<const P: usize> {
    /// The window.
    pub(super) own: Matrices<P>,
    /// Its companion, which sees the rates without their two highest modes.
    pub(super) companion: Matrices<P>,
    /// c.
    pub(super) nodes: Nodes<P>,
}

/// Legendre modes of the rates that the companion does not see.
const UNSEEN: usize = 2;

impl<const P: usize> FlowTables<P> {
    pub(super) fn new(rule: &WeakRule) -> Self {
        let n = rule.points();
        let columns = |entry: &dyn Fn(usize, usize) -> f64| {
            let mut matrix = Box::new([[0.0; P]; P]);
            (0..n).for_each(|j| (0..n).for_each(|i| matrix[j][i] = entry(i, j)));
            matrix
        };
        let a = columns(&|i, j| rule.a()[i * n + j].hi);
        let a_squared = columns(&|i, j| rule.a_squared()[i * n + j].hi);
        // Nodal values without their highest modes, by columns.
        let seen = evaluation_matrix::<P>(rule, n - 1 - UNSEEN, |i| rule.nodes()[i].hi, n);
        let of_seen = |matrix: &Matrix<P>| columns(&|i, j| (0..n).map(|k| matrix[k][i] * seen[j][k]).sum());
        let companion = Matrices { a: of_seen(&a), a_squared: of_seen(&a_squared) };
        let mut nodes = Nodes::ZERO;
        nodes.0.iter_mut().zip(rule.nodes()).for_each(|(to, node)| *to = node.hi);
        Self { own: Matrices { a, a_squared }, companion, nodes }
    }
}
