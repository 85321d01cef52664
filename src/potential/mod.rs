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

    /// `out` = (V, V′, V″) at every entry of `x`, one contiguous array each, all of the length of `x`.
    pub fn sample(&self, x: &[f64], out: [&mut [f64]; 3]) {
        match self {
            Self::Polynomial(p) => {
                let [value, first, second] = out;
                for (((&x, value), first), second) in x.iter().zip(value).zip(first).zip(second) {
                    let jet = p.at(x);
                    (*value, *first, *second) = (jet.value, jet.first, jet.second);
                }
            }
            Self::Formula(f) => f.sample(x, out),
        }
    }
}
