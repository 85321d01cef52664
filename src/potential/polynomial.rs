//! Polynomial potentials.

use super::PotentialJet;

/// V(x) = Σ_k c_k x^k.
#[derive(Debug, Clone, PartialEq)]
pub struct Polynomial {
    /// c_0, c_1, …; empty for V = 0.
    coefficients: Vec<f64>,
}

impl Polynomial {
    /// From the coefficients, lowest power first.
    pub fn new(coefficients: Vec<f64>) -> Self {
        Self { coefficients }
    }

    /// c_0, c_1, …
    pub fn coefficients(&self) -> &[f64] {
        &self.coefficients
    }

    /// V, V′, V″ by Horner's rule on the three at once.
    #[inline]
    pub fn at(&self, x: f64) -> PotentialJet {
        let (mut value, mut first, mut half_second) = (0.0, 0.0, 0.0);
        for &c in self.coefficients.iter().rev() {
            half_second = half_second * x + first;
            first = first * x + value;
            value = value * x + c;
        }
        PotentialJet { value, first, second: 2.0 * half_second }
    }
}
