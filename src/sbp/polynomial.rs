//! Polynomials on a window as series of Legendre polynomials: through values on the nodes, their integrals, and where
//! what they follow may be zero.

use std::collections::HashMap;
use std::iter;

use super::gll::LobattoRule;
use super::legendre::legendre;
use crate::number::root::root;
use crate::number::{Real, sum};

/// Parts of the arc between two nodes between whose ends zeros of a derivative are looked for.
const PROBES: usize = 4;
/// The two highest modes of a polynomial that follows a function are less than this part of the largest: its slope is
/// off by less than n² times that, and has a sign.
const FOLLOWED: f64 = 1e-3;
/// Derivatives whose zeros tell apart those of the ones before.
const DERIVATIVES: usize = 3;
/// The place of an extremum on [−1, 1] need not be better known.
const EXTREMUM: f64 = 1e-12;

/// Conversion between nodal values on one rule and coefficients of Legendre polynomials. Both matrices are stored in
/// the order of access, so that products vectorise.
#[derive(Debug)]
pub(crate) struct Expansion<S> {
    /// Nodes on [0, 1].
    pub(crate) nodes: Vec<S>,
    /// For node j: its weights in coefficients 0 … n − 1.
    modes: Vec<S>,
    /// For degree k = 0 … n + 1: P_k at the nodes.
    basis: Vec<S>,
    /// The angles between neighbouring nodes as cosines.
    arcs: Vec<f64>,
    /// Places on [−1, 1], so many between two nodes and at these.
    probes: Vec<f64>,
}

impl<S: Real> Expansion<S> {
    /// Returns the one of the Gauss–Lobatto rule with so many points.
    pub(crate) fn new(points: usize) -> Self {
        let rule: LobattoRule<S> = LobattoRule::new(points);
        let at_nodes: Vec<Vec<S>> = rule.nodes.iter().map(|&z| legendre(points + 1, z)).collect();
        let last = points - 1;
        let angles: Vec<f64> = rule.nodes.iter().map(|z| (-z.to_f64()).clamp(-1.0, 1.0).acos()).collect();
        let arcs: Vec<f64> = angles.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let inside = |j: usize| (0..PROBES).map(move |k| (j, k as f64 / PROBES as f64));
        let probes = (0..last).flat_map(inside).map(|(j, share)| -(angles[j] + share * arcs[j]).cos());
        let probes = probes.chain(iter::once(1.0)).collect();
        let mode = |j: usize, k: usize| {
            // The rule does not integrate P_{n−1}² exactly, so the factor of the last coefficient is another one.
            let norm = if k < last { 2 * k + 1 } else { last };
            S::from(norm as f64).half() * rule.weights[j] * at_nodes[j][k]
        };
        Self {
            nodes: rule.nodes.iter().map(|&z| (S::ONE + z).half()).collect(),
            modes: (0..points * points).map(|place| mode(place / points, place % points)).collect(),
            basis: (0..points * (points + 2)).map(|place| at_nodes[place % points][place / points]).collect(),
            arcs,
            probes,
        }
    }

    /// Legendre coefficients of the polynomial through `values`.
    pub(crate) fn coefficients(&self, values: &[S]) -> Vec<S> {
        let mut coefficients = vec![S::ZERO; values.len()];
        for (modes, &value) in self.modes.chunks_exact(values.len()).zip(values) {
            coefficients.iter_mut().zip(modes).for_each(|(c, &mode)| *c += mode * value);
        }
        coefficients
    }

    /// Σ c_k P_k at the nodes, smallest terms first.
    pub(crate) fn values(&self, coefficients: &[S]) -> Vec<S> {
        let mut values = vec![S::ZERO; self.nodes.len()];
        for (basis, &c) in self.basis.chunks_exact(values.len()).zip(coefficients).rev() {
            values.iter_mut().zip(basis).for_each(|(value, &p)| *value += c * p);
        }
        values
    }
}

/// Expansions by number of nodes, each computed once.
pub(crate) type Tables<S> = HashMap<usize, Expansion<S>>;

/// The expansion on so many points.
pub(crate) fn expansion<S: Real>(tables: &mut Tables<S>, points: usize) -> &Expansion<S> {
    tables.entry(points).or_insert_with(|| Expansion::new(points))
}

/// Σ c_k P_k, smallest terms first.
pub(crate) fn series<S: Real>(c: &[S], basis: &[S]) -> S {
    sum(c.iter().zip(basis).rev().map(|(&c, &p)| c * p))
}

/// The Legendre coefficients of the integral from 0 to s ∈ [0, 1] of the series with coefficients `c`. They follow from
/// ∫_{−1}^z P_k = (P_{k+1} − P_{k−1})/(2k + 1), half of which is the integral on [0, 1].
pub(crate) fn integral<S: Real>(c: &[S]) -> Vec<S> {
    let mut integral = vec![S::ZERO; c.len() + 1];
    for (k, &c) in c.iter().enumerate() {
        let share = c.half() / S::from((2 * k + 1) as f64);
        integral[k + 1] += share;
        if k == 0 { integral[0] += share } else { integral[k - 1] -= share }
    }
    integral
}

/// The polynomial through values at Lobatto points, relative to its scale, in `f64`.
#[derive(Debug)]
pub(crate) struct Through<'e, S> {
    expansion: &'e Expansion<S>,
    scale: S,
    coefficients: Vec<f64>,
}

impl<'e, S: Real> Through<'e, S> {
    /// The polynomial through `values` at the points of `expansion`.
    pub(crate) fn new(expansion: &'e Expansion<S>, values: &[S]) -> Self {
        let coefficients = expansion.coefficients(values);
        let scale = coefficients.iter().fold(S::ZERO, |most, c| most.max(c.abs()));
        let scale = if scale > S::ZERO { scale } else { S::ONE };
        let coefficients: Vec<f64> = coefficients.iter().map(|&c| (c / scale).to_f64()).collect();
        Self { expansion, scale, coefficients }
    }

    /// The derivative by z ∈ [−1, 1] at both ends, where P_k′ is k(k + 1)/2 but for the sign. Where the polynomial does
    /// not follow what has these `values` it is the slope to the next point.
    pub(crate) fn end_slopes(&self, values: &[S]) -> [S; 2] {
        let (n, c, nodes) = (values.len(), &self.coefficients, &self.expansion.nodes);
        if c[n - 1].abs() + c[n - 2].abs() > FOLLOWED {
            let chord = |j: usize| (values[j + 1] - values[j]) / (nodes[j + 1] - nodes[j]);
            return [chord(0), chord(n - 2)].map(S::half);
        }
        let terms = || c.iter().enumerate().map(|(k, c)| (k, 0.5 * (k * (k + 1)) as f64 * c));
        let first: f64 = terms().map(|(k, term)| if k % 2 == 0 { -term } else { term }).sum();
        let last: f64 = terms().map(|(_, term)| term).sum();
        [first, last].map(|slope| self.scale * S::from(slope))
    }

    /// The places s ∈ [0, 1] of extrema between points where what has these `values` may be zero twice.
    ///
    /// With z = cos θ every P_k changes by at most k for a change of θ (S. Bernstein), so that between two values of
    /// one sign the polynomial is nowhere zero if it would have to change by more.
    pub(crate) fn extrema(&self, values: &[S]) -> Vec<f64> {
        let most: f64 = self.coefficients.iter().enumerate().map(|(k, c)| k as f64 * c.abs()).sum();
        let sizes = |j: usize| [values[j], values[j + 1]].map(|value| (value / self.scale).to_f64());
        let is_clear = |j: usize| {
            let [a, b] = sizes(j);
            a * b > 0.0 && a.abs() + b.abs() > most * self.expansion.arcs[j]
        };
        let open: Vec<usize> = (0..self.expansion.arcs.len()).filter(|&j| !is_clear(j)).collect();
        if open.is_empty() {
            return Vec::new();
        }
        let mut derivatives = vec![derivative(&self.coefficients)];
        for _ in 1..DERIVATIVES {
            derivatives.push(derivative(&derivatives[derivatives.len() - 1]));
        }
        let all = open.into_iter().flat_map(|j| self.extrema_in(j, &derivatives));
        all.map(|z| 0.5 * (z + 1.0)).collect()
    }

    /// Its extrema between two neighbouring points. Two that are close together have a zero of the second derivative
    /// between them, and so on.
    fn extrema_in(&self, j: usize, derivatives: &[Vec<f64>]) -> Vec<f64> {
        let probes = self.expansion.probes[PROBES * j..=PROBES * (j + 1)].iter().copied();
        let mut zeros: Vec<f64> = Vec::new();
        for derivative in derivatives.iter().rev() {
            let mut places: Vec<f64> = probes.clone().chain(zeros).collect();
            places.sort_by(f64::total_cmp);
            let slopes: Vec<[f64; 2]> = places.into_iter().map(|z| [z, clenshaw(derivative, z)]).collect();
            let changes = slopes.windows(2).filter(|pair| pair[0][1] * pair[1][1] < 0.0);
            zeros = changes.map(|pair| root(pair[0], pair[1], EXTREMUM, |z| clenshaw(derivative, z))).collect();
        }
        zeros
    }
}

/// The Legendre coefficients of the derivative: P_k′ = Σ (2j + 1) P_j over j = k − 1, k − 3, …
fn derivative(coefficients: &[f64]) -> Vec<f64> {
    let sum = |j: usize| coefficients.iter().skip(j + 1).step_by(2).sum::<f64>();
    (0..coefficients.len()).map(|j| (2 * j + 1) as f64 * sum(j)).collect()
}

/// Σ c_k P_k(z) by C. W. Clenshaw's recurrence, which needs no room.
fn clenshaw(c: &[f64], z: f64) -> f64 {
    let [first, _] = c.iter().enumerate().rev().fold([0.0; 2], |[next, after], (k, c)| {
        let k = k as f64;
        [c + (2.0 * k + 1.0) / (k + 1.0) * z * next - (k + 1.0) / (k + 2.0) * after, next]
    });
    first
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn extrema_are_where_the_slope_vanishes() {
        let expansion: Expansion<f64> = Expansion::new(24);
        let z: Vec<f64> = expansion.nodes.iter().map(|s| 2.0 * s - 1.0).collect();
        let of = |f: &dyn Fn(f64) -> f64| {
            let values: Vec<f64> = z.iter().map(|&z| f(z)).collect();
            let found = Through::new(&expansion, &values).extrema(&values);
            found.into_iter().map(|s| 2.0 * s - 1.0).collect::<Vec<f64>>()
        };
        // A small part of a wave has its zeros far from its extrema.
        assert!(of(&|z| (5.0 * z).sin()).is_empty());
        let touching = of(&|z| 1.0 + 1e-9 + (5.0 * z).sin());
        assert_eq!(touching.len(), 2);
        let lowest = [-0.1, 0.3].map(|k| k * std::f64::consts::PI);
        assert!(touching.iter().zip(lowest).all(|(found, expected)| (found - expected).abs() < 1e-8), "{touching:?}");
        // Two zeros at a distance of 0.002 have an extremum between them.
        let close = of(&|z| (z - 0.31).powi(2) - 1e-6);
        assert!(close.iter().any(|z| (z - 0.31).abs() < 1e-9));
        // Three zeros between two neighbouring points have two.
        let middle = 0.5 * (z[11] + z[12]);
        let three = of(&|z| (z - middle) * ((z - middle).powi(2) - 1e-4));
        let expected = [-1.0, 1.0].map(|side| middle + side * 1e-2 / 3.0_f64.sqrt());
        assert!(expected.iter().all(|place| three.iter().any(|z| (z - place).abs() < 1e-9)), "{three:?}");
        assert!(of(&|z| 6.0 + (5.0 * z).sin()).is_empty());
    }

    #[test]
    fn slopes_at_the_ends_are_those_of_the_polynomial() {
        let expansion: Expansion<f64> = Expansion::new(9);
        let values: Vec<f64> = expansion.nodes.iter().map(|s| (2.0 * s - 1.0).powi(5) + 3.0 * s).collect();
        let [first, last] = Through::new(&expansion, &values).end_slopes(&values);
        assert!((first - 6.5).abs() < 1e-13 && (last - 6.5).abs() < 1e-13);
        // Through a narrow peak near the end the polynomial swings.
        let peak: Vec<f64> = expansion.nodes.iter().map(|s| -1.0 / (1.0 + (40.0 * (s - 0.9)).powi(2))).collect();
        let [_, last] = Through::new(&expansion, &peak).end_slopes(&peak);
        assert!(last > 0.0, "{last}");
        let c = [0.5, -1.0, 2.0, 0.25];
        let sum = |z: f64| series(&c, &legendre(3, z));
        assert!([-1.0, -0.3, 0.7].iter().all(|&z| (clenshaw(&c, z) - sum(z)).abs() < 1e-15));
    }
}
