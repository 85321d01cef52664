//! Polynomials on a window as series of Legendre polynomials: through values on the nodes, their integrals, and where
//! what they follow may be zero.

use std::collections::BTreeMap;
use std::iter;
use std::sync::Arc;

use super::gll::LobattoRule;
use super::legendre::legendre;
use crate::number::root::root;
use crate::number::{Real, sum};

/// Parts of the arc between two nodes between whose ends zeros of a derivative are looked for.
const PROBES: usize = 4;
/// Derivatives whose zeros tell apart those of the ones before: up to nine zeros are told apart that lie between two
/// probes.
const DERIVATIVES: usize = 8;
/// So many coefficients are summed up at once.
const SUMS: usize = 8;
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
        let mut coefficients = Vec::new();
        self.coefficients_into(values, &mut coefficients);
        coefficients
    }

    /// The same, into room that is there.
    fn coefficients_into(&self, values: &[S], coefficients: &mut Vec<S>) {
        let count = values.len();
        coefficients.clear();
        coefficients.resize(count, S::ZERO);
        // Some sums are formed at once, so that each stays in a register.
        let (blocks, rest) = coefficients.as_chunks_mut::<SUMS>();
        let first_of_rest = SUMS * blocks.len();
        for (block, sums) in blocks.iter_mut().enumerate() {
            let mut all = [S::ZERO; SUMS];
            for (modes, &value) in self.modes.chunks_exact(count).zip(values) {
                let modes: &[S; SUMS] = modes[SUMS * block..].first_chunk().expect("a block is full");
                (0..SUMS).for_each(|k| all[k] += modes[k] * value);
            }
            *sums = all;
        }
        if !rest.is_empty() {
            for (modes, &value) in self.modes.chunks_exact(count).zip(values) {
                rest.iter_mut().zip(&modes[first_of_rest..]).for_each(|(c, &mode)| *c += mode * value);
            }
        }
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
pub(crate) type Tables<S> = BTreeMap<usize, Arc<Expansion<S>>>;

/// The expansion on so many points.
pub(crate) fn expansion<S: Real>(tables: &mut Tables<S>, points: usize) -> Arc<Expansion<S>> {
    Arc::clone(tables.entry(points).or_insert_with(|| Arc::new(Expansion::new(points))))
}

/// Σ c_k P_k, smallest terms first.
pub(crate) fn series<S: Real>(c: &[S], basis: &[S]) -> S {
    sum(c.iter().zip(basis).rev().map(|(&c, &p)| c * p))
}

/// By how much a series of so many coefficients changes at most, and what it leaves open of a function: its last two
/// modes go on to as many more.
pub(crate) fn extent<S: Real>(coefficients: &[S]) -> [S; 2] {
    let sum = |c: &[S]| c.iter().fold(S::ZERO, |sum, c| sum + c.abs());
    let count = coefficients.len();
    [sum(coefficients), S::from(count as f64) * sum(&coefficients[count.saturating_sub(2)..])]
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

/// The polynomial through values at Lobatto points, relative to its scale, in `f64`, with room for its extrema.
#[derive(Debug, Clone, Default)]
pub(crate) struct Through<S> {
    scale: S,
    modes: Vec<S>,
    coefficients: Vec<f64>,
    /// The values.
    sizes: Vec<f64>,
    /// By how much what has these values may be off from the polynomial between them.
    off: f64,
    derivatives: Vec<Vec<f64>>,
    /// The zeros of a derivative between two points, and places with their slopes between which others are looked for.
    zeros: Vec<f64>,
    slopes: Vec<[f64; 2]>,
    /// The places s ∈ [0, 1] of extrema.
    extrema: Vec<f64>,
    /// False if it does not tell how often it is zero.
    is_clear: bool,
}

impl<S: Real> Through<S> {
    /// Goes through `values` at the points of `expansion`, and looks for extrema between points where what has these
    /// values may be zero twice.
    ///
    /// With z = cos θ every P_k changes by at most k for a change of θ (S. Bernstein), so that between two values of
    /// one sign the polynomial is nowhere zero if it would have to change by more, and nor is its slope.
    pub(crate) fn fit(&mut self, expansion: &Expansion<S>, values: &[S]) {
        expansion.coefficients_into(values, &mut self.modes);
        let scale = self.modes.iter().fold(S::ZERO, |most, c| most.max(c.abs()));
        self.scale = if scale > S::ZERO { scale } else { S::ONE };
        let of_scale = |value: &S| (*value / self.scale).to_f64();
        self.coefficients.clear();
        self.coefficients.extend(self.modes.iter().map(of_scale));
        self.sizes.clear();
        self.sizes.extend(values.iter().map(of_scale));
        self.extrema.clear();
        self.is_clear = true;
        let (c, n) = (&self.coefficients, self.coefficients.len());
        let all: f64 = c.iter().map(|c| c.abs()).sum();
        self.off = c[n - 1].abs() + c[n - 2].abs() + n as f64 * f64::EPSILON * all;
        let (most, mut most_of_slope, mut has_derivatives) = (rate(c), None, false);
        for (j, arc) in expansion.arcs.iter().enumerate() {
            let [a, b] = [self.sizes[j], self.sizes[j + 1]];
            if a * b > 0.0 && a.abs() + b.abs() > most * arc {
                continue;
            }
            let probes = &expansion.probes[PROBES * j..=PROBES * (j + 1)];
            let most = *most_of_slope.get_or_insert_with(|| {
                self.derivatives.resize_with(DERIVATIVES, Vec::new);
                derivative(&self.coefficients, &mut self.derivatives[0]);
                rate(&self.derivatives[0])
            });
            let [a, b] = [probes[0], probes[PROBES]].map(|z| clenshaw(&self.derivatives[0], z));
            if a * b > 0.0 && a.abs() + b.abs() > most * arc {
                continue;
            }
            if !has_derivatives {
                self.derive();
                has_derivatives = true;
            }
            self.look_between(probes);
        }
    }

    /// The places s ∈ [0, 1] of the extrema that were found.
    pub(crate) fn extrema(&self) -> &[f64] {
        &self.extrema
    }

    /// Returns true if the polynomial tells how often what it goes through is zero: nowhere is it zero together with
    /// its slope, but for what it leaves out.
    pub(crate) fn is_clear(&self) -> bool {
        self.is_clear
    }

    /// The derivatives behind the first one.
    fn derive(&mut self) {
        for order in 1..DERIVATIVES {
            let (before, rest) = self.derivatives.split_at_mut(order);
            derivative(&before[order - 1], &mut rest[0]);
        }
    }

    /// Its extrema between two neighbouring points. Two that are close together have a zero of the second derivative
    /// between them, and so on.
    fn look_between(&mut self, probes: &[f64]) {
        self.zeros.clear();
        // A slope is known to n² times what the values are (A. A. Markov).
        let known = (self.sizes.len() * self.sizes.len()) as f64 * self.off;
        let is_at_zero = |z: f64| clenshaw(&self.coefficients, z).abs() <= known;
        for (order, derivative) in self.derivatives.iter().enumerate().rev() {
            self.slopes.clear();
            self.slopes.extend(probes.iter().chain(&self.zeros).map(|&z| [z, clenshaw(derivative, z)]));
            self.slopes.sort_unstable_by(|one, other| one[0].total_cmp(&other[0]));
            if order == 0 {
                let is_flat = |&z: &f64| clenshaw(derivative, z).abs() <= known && is_at_zero(z);
                self.is_clear &= !self.zeros.iter().any(is_flat);
            }
            self.zeros.clear();
            let changes = self.slopes.windows(2).filter(|pair| pair[0][1] * pair[1][1] < 0.0);
            let zeros = changes.map(|pair| root(pair[0], pair[1], EXTREMUM, |z| clenshaw(derivative, z)));
            self.zeros.extend(zeros);
        }
        self.is_clear &= !self.zeros.iter().any(|&z| is_at_zero(z));
        self.extrema.extend(self.zeros.iter().map(|z| 0.5 * (z + 1.0)));
    }
}

/// By how much a series of Legendre polynomials changes with an angle at most.
fn rate(c: &[f64]) -> f64 {
    c.iter().enumerate().map(|(k, c)| k as f64 * c.abs()).sum()
}

/// The Legendre coefficients of the derivative: P_k′ = Σ (2j + 1) P_j over j = k − 1, k − 3, …
fn derivative(coefficients: &[f64], out: &mut Vec<f64>) {
    let count = coefficients.len();
    out.clear();
    out.resize(count, 0.0);
    for j in (0..count.saturating_sub(1)).rev() {
        // The sum over j + 1, j + 3, … is that over j + 3, j + 5, … and one more.
        out[j] = coefficients[j + 1] + out.get(j + 2).copied().unwrap_or(0.0);
    }
    out.iter_mut().enumerate().for_each(|(j, sum)| *sum *= (2 * j + 1) as f64);
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
            let mut through = Through::default();
            through.fit(&expansion, &values);
            through.extrema().iter().map(|s| 2.0 * s - 1.0).collect::<Vec<f64>>()
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

    /// Zeros that are closer together than the polynomial tells are not told, and others are.
    #[test]
    fn what_is_flat_at_zero_is_not_clear() {
        let expansion: Expansion<f64> = Expansion::new(24);
        let is_clear = |f: &dyn Fn(f64) -> f64| {
            let values: Vec<f64> = expansion.nodes.iter().map(|s| f(2.0 * s - 1.0)).collect();
            let mut through = Through::default();
            through.fit(&expansion, &values);
            through.is_clear()
        };
        assert!(is_clear(&|z| (5.0 * z).sin()) && is_clear(&|z| z + 1.0) && is_clear(&|z| (z - 0.31).powi(2) - 1e-6));
        assert!(!is_clear(&|z| (z - 0.31).powi(2)) && !is_clear(&|z| (z - 0.31).powi(3)));
        let five = |z: f64| (z - 0.31) * ((z - 0.31).powi(2) - 1e-8) * ((z - 0.31).powi(2) - 4e-8);
        assert!(!is_clear(&five));
        let c = [0.5, -1.0, 2.0, 0.25];
        let sum = |z: f64| series(&c, &legendre(3, z));
        assert!([-1.0, -0.3, 0.7].iter().all(|&z| (clenshaw(&c, z) - sum(z)).abs() < 1e-15));
    }
}
