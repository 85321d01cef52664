//! The polynomial through the values of a formula, and where it has extrema.

use std::sync::OnceLock;

use super::legendre::series;
use crate::number::Real;
use crate::sbp::gll::MOST_NODES;
use crate::sbp::legendre::legendre;

/// Places for each coefficient of a polynomial between which zeros of its derivative are looked for.
const PROBES: usize = 4;
/// Bisections of an extremum, whose place need not be exact.
const BISECTIONS: usize = 40;

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

    /// Returns true if the polynomial is bounded away from zero.
    fn keeps_its_sign(&self) -> bool {
        self.coefficients[1..].iter().map(|c| c.abs()).sum::<f64>() < self.coefficients[0].abs()
    }

    /// Where the polynomial has extrema between −1 and 1; nowhere if they cannot be beyond zero.
    pub(super) fn extrema(&self) -> Vec<f64> {
        if self.keeps_its_sign() {
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
    use crate::trajectory::legendre::Expansion;

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
