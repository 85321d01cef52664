//! The matrices of a window of a scene on one rule, for windows of any length.

use crate::engine::lobatto::Twofold;
use crate::engine::lobatto::rule::WeakRule;
use crate::engine::lobatto::tables::{Matrix, round_row};
use crate::number::vector::Nodes;
use crate::sbp::collocation::legendre_values;

/// Nodes of a window on which small errors are followed.
pub(super) const LANES: usize = 16;

/// What windows of a rule need, with time in units of their length.
pub(super) struct FlowTables<const P: usize> {
    /// A by columns, rounded so that its rows sum right.
    pub(super) a: Box<Matrix<P>>,
    /// A² by columns, rounded like A.
    pub(super) a_squared: Box<Matrix<P>>,
    /// From nodal values to values on the nodes of [`Transport`](super::transport::Transport), by columns.
    pub(super) sampled: Box<[[f64; LANES]; P]>,
    /// Column k is the row of weights that nodal values have in Legendre coefficient k.
    pub(super) from_modes: Box<Matrix<P>>,
    /// c.
    pub(super) nodes: Nodes<P>,
}

impl<const P: usize> FlowTables<P> {
    pub(super) fn new(rule: &WeakRule) -> Self {
        let n = rule.points();
        let rounded = |matrix: &[Twofold]| {
            let mut columns = Box::new([[0.0; P]; P]);
            for (i, row) in matrix.chunks_exact(n).enumerate() {
                let mut order: Vec<u8> = (0..n as u8).collect();
                order.sort_by(|&i, &j| row[j as usize].hi.abs().total_cmp(&row[i as usize].hi.abs()));
                let mut out = vec![0.0; n];
                round_row(row, &order, &mut out);
                (0..n).for_each(|j| columns[j][i] = out[j]);
            }
            columns
        };
        let mut sampled = Box::new([[0.0; LANES]; P]);
        for (lane, node) in WeakRule::shared(LANES).nodes().iter().enumerate() {
            for (k, value) in legendre_values(n - 1, 2.0 * node.hi - 1.0).iter().enumerate() {
                sampled.iter_mut().zip(rule.mode(k)).for_each(|(column, mode)| column[lane] += value * mode);
            }
        }
        let mut from_modes = Box::new([[0.0; P]; P]);
        for (k, column) in from_modes[..n].iter_mut().enumerate() {
            column.iter_mut().zip(rule.mode(k)).for_each(|(to, mode)| *to = mode);
        }
        let mut nodes = Nodes::ZERO;
        nodes.0.iter_mut().zip(rule.nodes()).for_each(|(to, node)| *to = node.hi);
        Self { a: rounded(rule.a()), a_squared: rounded(rule.a_squared()), sampled, from_modes, nodes }
    }
}

#[cfg(test)]
mod tests {
    use super::{FlowTables, LANES};
    use crate::engine::lobatto::rule::WeakRule;

    /// Polynomials are what they are on other nodes.
    #[test]
    fn samples_of_polynomials_are_exact() {
        let tables = FlowTables::<24>::new(WeakRule::shared(20));
        for degree in 0..20 {
            let power = |c: f64| (c - 0.4).powi(degree);
            for (lane, node) in WeakRule::shared(LANES).nodes().iter().enumerate() {
                let nodes = tables.nodes.0[..20].iter().zip(&*tables.sampled);
                let sum: f64 = nodes.map(|(&c, column)| power(c) * column[lane]).sum();
                assert!((sum - power(node.hi)).abs() < 1e-13, "{degree}, {lane}: {sum}");
            }
        }
    }
}
