//! Polynomials on a window as series of Legendre polynomials: through values on the nodes, their integrals, and where
//! they have extrema.

use std::collections::HashMap;
use std::sync::OnceLock;

use crate::number::{Real, sum};
use crate::sbp::gll::{LobattoRule, MOST_NODES};
use crate::sbp::legendre::legendre;

/// Places for each coefficient of a polynomial between which zeros of its derivative are looked for.
const PROBES: usize = 4;
/// Bisections of an extremum, whose place need not be exact.
const BISECTIONS: usize = 40;

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

/// A polynomial on [−1, 1] as a Legendre series, relative to its scale, in `f64`.
#[derive(Debug)]
pub(super) struct Extrema<S> {
    scale: S,
    coefficients: Vec<f64>,
    derivative: Vec<f64>,
}

impl<S: Real> Extrema<S> {
    /// The polynomial with these Legendre coefficients, divided by the largest of them.
    pub(super) fn new(coefficients: &[S]) -> Self {
        let scale = coefficients.iter().fold(S::ZERO, |most, c| most.max(c.abs()));
        let scale = if scale > S::ZERO { scale } else { S::ONE };
        let coefficients: Vec<f64> = coefficients.iter().map(|&c| (c / scale).to_f64()).collect();
        // P_k′ = Σ (2j + 1) P_j over j = k − 1, k − 3, …
        let slope = |j: usize| (2 * j + 1) as f64 * coefficients.iter().skip(j + 1).step_by(2).sum::<f64>();
        let derivative = (0..coefficients.len()).map(slope).collect();
        Self { scale, coefficients, derivative }
    }

    /// The derivative at z.
    pub(super) fn slope(&self, z: f64) -> S {
        self.scale * S::from(self.relative_slope(z))
    }

    fn relative_slope(&self, z: f64) -> f64 {
        series(&self.derivative, &legendre(self.derivative.len().max(2) - 1, z))
    }

    /// Where the polynomial has extrema between −1 and 1; nowhere if they cannot be beyond zero.
    pub(super) fn extrema(&self) -> Vec<f64> {
        if self.coefficients[1..].iter().map(|c| c.abs()).sum::<f64>() < self.coefficients[0].abs() {
            return Vec::new();
        }
        let probes = probes(self.coefficients.len());
        let slopes: Vec<f64> = probes.iter().map(|(_, basis)| series(&self.derivative, basis)).collect();
        let changes = (1..probes.len()).filter(|&k| slopes[k - 1] * slopes[k] < 0.0);
        changes.map(|k| self.bisected(slopes[k - 1], probes[k - 1].0, probes[k].0)).collect()
    }

    /// Where the derivative, which has the sign of `side` at `low`, changes it.
    fn bisected(&self, side: f64, mut low: f64, mut high: f64) -> f64 {
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (low + high);
            if self.relative_slope(middle) * side > 0.0 { low = middle } else { high = middle }
        }
        0.5 * (low + high)
    }
}

/// A place, and the Legendre polynomials there.
type Probe = (f64, Vec<f64>);

/// The places where a series of so many coefficients is looked at, with the Legendre polynomials there. They are the
/// same in every window, and computing them would take longer than everything else of a search.
fn probes(coefficients: usize) -> &'static [Probe] {
    static PLACES: [OnceLock<Vec<Probe>>; MOST_NODES + 1] = [const { OnceLock::new() }; MOST_NODES + 1];
    PLACES[coefficients].get_or_init(|| {
        let last = PROBES * coefficients;
        let place = |k: usize| -(std::f64::consts::PI * k as f64 / last as f64).cos();
        (0..=last).map(|k| (place(k), legendre(coefficients.max(2) - 1, place(k)))).collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn extrema_are_where_the_slope_vanishes() {
        let expansion: Expansion<f64> = Expansion::new(24);
        let z: Vec<f64> = expansion.nodes.iter().map(|s| 2.0 * s - 1.0).collect();
        let of = |f: &dyn Fn(f64) -> f64| {
            Extrema::new(&expansion.coefficients(&z.iter().map(|&z| f(z)).collect::<Vec<_>>()))
        };
        let wave = of(&|z| (5.0 * z).sin());
        let expected: Vec<f64> = [-1.5, -0.5, 0.5, 1.5].map(|k| k * std::f64::consts::PI / 5.0).to_vec();
        let found = wave.extrema();
        assert_eq!(found.len(), expected.len());
        assert!(found.iter().zip(&expected).all(|(found, expected)| (found - expected).abs() < 1e-10), "{found:?}");
        // Two zeros at a distance of 0.002 have an extremum between them.
        let close = of(&|z| (z - 0.31).powi(2) - 1e-6);
        assert!(close.extrema().iter().any(|z| (z - 0.31).abs() < 1e-9));
        assert!(of(&|z| 6.0 + (5.0 * z).sin()).extrema().is_empty());
    }
}
