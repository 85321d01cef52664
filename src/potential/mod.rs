//! Potentials V(x) with exact first and second derivatives.
//!
//! Two representations cover every case: a polynomial (free, linear, quartic and general ones) evaluated by Horner's
//! rule, and a compiled [`Formula`]. V is an energy; x is in the case's unit of length.

pub mod formula;
mod polynomial;

pub use formula::{Formula, FormulaError};
pub(crate) use formula::{Function, Instruction, Program};
pub use polynomial::Polynomial;

/// V, V′ and V″ at one point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PotentialJet {
    /// V(x).
    pub value: f64,
    /// V′(x).
    pub first: f64,
    /// V″(x).
    pub second: f64,
}

/// V, V′ and V″ at many points, one contiguous array each.
#[derive(Debug, Clone, Default)]
pub struct PotentialSamples {
    /// V(x_k).
    pub value: Vec<f64>,
    /// V′(x_k).
    pub first: Vec<f64>,
    /// V″(x_k).
    pub second: Vec<f64>,
}

impl PotentialSamples {
    /// Room for `points` samples.
    pub fn zeros(points: usize) -> Self {
        Self { value: vec![0.0; points], first: vec![0.0; points], second: vec![0.0; points] }
    }
}

/// A potential V(x).
#[derive(Debug, Clone)]
pub enum Potential {
    /// V = Σ_k c_k x^k.
    Polynomial(Polynomial),
    /// V from an expression in x.
    Formula(Formula),
}

impl Potential {
    /// V = 0.
    pub fn free() -> Self {
        Self::polynomial(vec![])
    }

    /// V = α x.
    pub fn linear(alpha: f64) -> Self {
        Self::polynomial(vec![0.0, alpha])
    }

    /// V = κ x⁴.
    pub fn quartic(kappa: f64) -> Self {
        Self::polynomial(vec![0.0, 0.0, 0.0, 0.0, kappa])
    }

    /// V = Σ_k c_k x^k, lowest power first.
    pub fn polynomial(coefficients: Vec<f64>) -> Self {
        Self::Polynomial(Polynomial::new(coefficients))
    }

    /// V, V′, V″ as a straight-line program, for arithmetic other than on numbers.
    pub(crate) fn program(&self) -> Program {
        match self {
            Self::Polynomial(p) => Program::polynomial(p.coefficients()),
            Self::Formula(f) => f.program().clone(),
        }
    }

    /// V, V′, V″ at `x`. Not finite where the formula is not defined.
    pub fn at(&self, x: f64) -> PotentialJet {
        match self {
            Self::Polynomial(p) => p.at(x),
            Self::Formula(f) => f.at(x),
        }
    }

    /// V, V′, V″ at every entry of `x`.
    pub fn sample(&self, x: &[f64], out: &mut PotentialSamples) {
        match self {
            Self::Polynomial(p) => {
                for (k, &x) in x.iter().enumerate() {
                    let jet = p.at(x);
                    out.value[k] = jet.value;
                    out.first[k] = jet.first;
                    out.second[k] = jet.second;
                }
            }
            Self::Formula(f) => f.sample(x, out),
        }
    }
}
