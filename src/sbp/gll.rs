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

use super::legendre::{Family, approximate_node};
use crate::number::{Constants, Extended, Real};

/// Smallest number of nodes of a rule: its two ends.
pub const LEAST_NODES: usize = 2;
/// Largest number of nodes that is offered.
pub const MOST_NODES: usize = 64;

/// Number of Newton steps in extended precision. Each doubles the number of correct digits, beginning with those of
/// `f64`.
const REFINEMENTS: usize = 4;

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

/// (P_{m−1}, P_m) at x, by P_{k+1} = xP_k + k/(k + 1) (xP_k − P_{k−1}) with these ratios.
fn legendre(ratios: &[Extended], x: Extended) -> (Extended, Extended) {
    ratios.iter().fold((Extended::ONE, x), |(before, now), &ratio| {
        let product = x * now;
        (now, product + ratio * (product - before))
    })
}

/// One Newton step towards a zero of P_m′, with (1 − x²)P_m′ = m(P_{m−1} − xP_m) and
/// (1 − x²)P_m″ = 2xP_m′ − m(m + 1)P_m.
fn newton_step(ratios: &[Extended], x: Extended) -> Extended {
    let (m, (before, now)) = (ratios.len() + 1, legendre(ratios, x));
    let [degree, eigenvalue] = [m, m * (m + 1)].map(|k| Extended::from(k as f64));
    let first = degree * (before - x * now) / (Extended::ONE - x * x);
    let second = ((x + x) * first - eigenvalue * now) / (Extended::ONE - x * x);
    x - first / second
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
    let m = n - 1;
    // The ratios of the recursion are k/(k + 1) for k = 1 … m − 1.
    let ratios: Vec<Extended> = (1..m).map(|k| Extended::from(k as f64) / Extended::from((k + 1) as f64)).collect();
    let mut nodes = vec![Extended::ZERO; n];
    for i in 0..n / 2 {
        let begin = || Extended::from(approximate_node(Family::Lobatto, n, i));
        let refined = || (0..REFINEMENTS).fold(begin(), |x, _| newton_step(&ratios, x));
        nodes[i] = if i == 0 { -Extended::ONE } else { refined() };
        nodes[m - i] = -nodes[i];
    }
    let values: Vec<Extended> = nodes.iter().map(|&x| legendre(&ratios, x).1).collect();
    let size = Extended::from((n * m) as f64);
    let weights = values.iter().map(|&p| Extended::from(2.0) / (size * p * p));
    let entry = |i: usize, j: usize| match (i, j) {
        (0, 0) => -size / Extended::from(4.0),
        _ if i == m && j == m => size / Extended::from(4.0),
        _ if i == j => Extended::ZERO,
        _ => values[i] / values[j] / (nodes[i] - nodes[j]),
    };
    let weights = weights.collect();
    let mut differentiation: Vec<Extended> = (0..(n * n).div_ceil(2)).map(|k| entry(k / n, k % n)).collect();
    // The rule is symmetric: the second half mirrors the first one, with the other sign.
    let mirrored: Vec<Extended> = differentiation[..n * n / 2].iter().rev().map(|&entry| -entry).collect();
    differentiation.extend(mirrored);
    [nodes, weights, differentiation].map(Constants::new)
}
