//! Polynomials on a window as series of Legendre polynomials: through values on the nodes, and their integrals.

use std::collections::HashMap;

use crate::number::{Real, sum};
use crate::sbp::gll::LobattoRule;
use crate::sbp::legendre::legendre;

/// Conversion between nodal values on one rule and coefficients of Legendre polynomials. Both matrices are stored in
/// the order of access, so that products vectorise.
#[derive(Debug)]
pub(super) struct Expansion<S> {
    /// Nodes on [0, 1].
    pub(super) nodes: Vec<S>,
    /// For node j: its weights in coefficients 0 … n − 1.
    modes: Vec<S>,
    /// For degree k = 0 … n + 1: P_k at the nodes.
    basis: Vec<S>,
}

impl<S: Real> Expansion<S> {
    /// Returns the one of the Gauss–Lobatto rule with so many points.
    pub(super) fn new(points: usize) -> Self {
        let rule: LobattoRule<S> = LobattoRule::new(points);
        let at_nodes: Vec<Vec<S>> = rule.nodes.iter().map(|&z| legendre(points + 1, z)).collect();
        let last = points - 1;
        let mode = |j: usize, k: usize| {
            // The rule does not integrate P_{n−1}² exactly, so the factor of the last coefficient is another one.
            let norm = if k < last { 2 * k + 1 } else { last };
            S::from(norm as f64).half() * rule.weights[j] * at_nodes[j][k]
        };
        Self {
            nodes: rule.nodes.iter().map(|&z| (S::ONE + z).half()).collect(),
            modes: (0..points * points).map(|place| mode(place / points, place % points)).collect(),
            basis: (0..points * (points + 2)).map(|place| at_nodes[place % points][place / points]).collect(),
        }
    }

    /// Legendre coefficients of the polynomial through `values`.
    pub(super) fn coefficients(&self, values: &[S]) -> Vec<S> {
        let mut coefficients = vec![S::ZERO; values.len()];
        for (modes, &value) in self.modes.chunks_exact(values.len()).zip(values) {
            coefficients.iter_mut().zip(modes).for_each(|(c, &mode)| *c += mode * value);
        }
        coefficients
    }

    /// Σ c_k P_k at the nodes, smallest terms first.
    pub(super) fn values(&self, coefficients: &[S]) -> Vec<S> {
        let mut values = vec![S::ZERO; self.nodes.len()];
        for (basis, &c) in self.basis.chunks_exact(values.len()).zip(coefficients).rev() {
            values.iter_mut().zip(basis).for_each(|(value, &p)| *value += c * p);
        }
        values
    }
}

/// Expansions by number of nodes, each computed once.
pub(super) type Tables<S> = HashMap<usize, Expansion<S>>;

/// The expansion on so many points.
pub(super) fn expansion<S: Real>(tables: &mut Tables<S>, points: usize) -> &Expansion<S> {
    tables.entry(points).or_insert_with(|| Expansion::new(points))
}

/// Σ c_k P_k, smallest terms first.
pub(super) fn series<S: Real>(c: &[S], basis: &[S]) -> S {
    sum(c.iter().zip(basis).rev().map(|(&c, &p)| c * p))
}

/// The Legendre coefficients of the integral from 0 to s ∈ [0, 1] of the series with coefficients `c`. They follow from
/// ∫_{−1}^z P_k = (P_{k+1} − P_{k−1})/(2k + 1), half of which is the integral on [0, 1].
pub(super) fn integral<S: Real>(c: &[S]) -> Vec<S> {
    let mut integral = vec![S::ZERO; c.len() + 1];
    for (k, &c) in c.iter().enumerate() {
        let share = c.half() / S::from((2 * k + 1) as f64);
        integral[k + 1] += share;
        if k == 0 { integral[0] += share } else { integral[k - 1] -= share }
    }
    integral
}
