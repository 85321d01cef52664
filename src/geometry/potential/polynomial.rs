//! Polynomial potentials.

use super::PotentialJet;
use crate::number::Real;

/// V(x) = Σ_k c_k x^k.
#[derive(Debug, Clone, PartialEq)]
pub struct Polynomial<S = f64> {
    /// c_0, c_1, …; empty for V = 0.
    coefficients: Vec<S>,
}

impl<S: Real> Polynomial<S> {
    /// The polynomial with these coefficients, lowest power first.
    pub fn new(coefficients: Vec<S>) -> Self {
        Self { coefficients }
    }

    /// c_0, c_1, …
    pub fn coefficients(&self) -> &[S] {
        &self.coefficients
    }

    /// V, V′, V″ by Horner's rule, all three in one pass.
    #[inline]
    pub fn at(&self, x: S) -> PotentialJet<S> {
        let (mut value, mut first, mut half_second) = (S::ZERO, S::ZERO, S::ZERO);
        for &c in self.coefficients.iter().rev() {
            half_second = half_second * x + first;
            first = first * x + value;
            value = value * x + c;
        }
        PotentialJet { value, first, second: half_second + half_second }
    }
}
