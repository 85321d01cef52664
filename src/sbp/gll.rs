//! The Gauss–Lobatto–Legendre rule: nodes, weights and the differentiation matrix of the polynomials through its nodes.
//!
//! P_m is the Legendre polynomial of degree m = n − 1. The nodes are ±1 and the zeros of P_m′, the weights are
//! 2/(n m P_m(x_i)²), and
//!
//! ```text
//! D_ij = P_m(x_i)/P_m(x_j)/(x_i − x_j)  (i ≠ j),     D_11 = −n m/4 = −D_nn,     D_ii = 0 otherwise.
//! ```
//!
//! The rule integrates polynomials of degree 2n − 3 exactly. Hence Q + Qᵀ = E_N − E_0 for Q = HD, and D is a
//! diagonal-norm SBP operator (Gassner, SIAM J. Sci. Comput. 35 (2013) A1233; the formulas are those of Canuto,
//! Hussaini, Quarteroni & Zang, Spectral Methods (2006), section 2.3). Everything is computed in extended precision and
//! rounded once.

use std::sync::OnceLock;

use super::legendre::{Family, Rule};
use crate::number::{Constants, Extended, Real};

/// Smallest number of nodes of a rule: its two ends.
pub const LEAST_NODES: usize = 2;
/// Largest number of nodes that is offered.
pub const MOST_NODES: usize = 64;

/// The rule on [−1, 1] in `S`.
#[derive(Debug, Clone)]
pub struct LobattoRule<S = f64> {
    /// Nodes in ascending order, exactly symmetric about 0.
    pub nodes: Vec<S>,
    /// Weights.
    pub weights: Vec<S>,
    /// Differentiation matrix, row-major.
    pub differentiation: Vec<S>,
}

impl<S: Real> LobattoRule<S> {
    /// The rule of `n` nodes. It is computed once in the life of the program.
    ///
    /// # Panics
    /// If n is not in [`LEAST_NODES`] … [`MOST_NODES`].
    pub fn new(n: usize) -> Self {
        static RULES: [OnceLock<[Constants; 3]>; MOST_NODES + 1] = [const { OnceLock::new() }; MOST_NODES + 1];
        assert!((LEAST_NODES..=MOST_NODES).contains(&n), "a Lobatto rule has {LEAST_NODES} to {MOST_NODES} nodes");
        let rule = RULES[n].get_or_init(|| computed(n));
        let [nodes, weights, differentiation] = rule.each_ref().map(|numbers| S::constants(numbers).to_vec());
        Self { nodes, weights, differentiation }
    }
}

/// Nodes, weights and differentiation matrix of the rule of `n` nodes.
fn computed(n: usize) -> [Constants; 3] {
    let (m, Rule { nodes, weights, legendre }) = (n - 1, Rule::new(Family::Lobatto, n));
    let corner = Extended::from((n * m) as f64) / Extended::from(4.0);
    let entry = |i: usize, j: usize| match (i, j) {
        (0, 0) => -corner,
        _ if i == m && j == m => corner,
        _ if i == j => Extended::ZERO,
        _ => legendre[i][m] / legendre[j][m] / (nodes[i] - nodes[j]),
    };
    let mut differentiation: Vec<Extended> = (0..(n * n).div_ceil(2)).map(|k| entry(k / n, k % n)).collect();
    // The rule is symmetric: the second half mirrors the first one, with the other sign.
    let mirrored: Vec<Extended> = differentiation[..n * n / 2].iter().rev().map(|&entry| -entry).collect();
    differentiation.extend(mirrored);
    [nodes, weights, differentiation].map(Constants::new)
}
