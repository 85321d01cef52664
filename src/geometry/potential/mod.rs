//! Potentials V(x) with exact first and second derivatives.
//!
//! Two representations cover every case: a polynomial (free, linear, quartic and general ones) evaluated by Horner's
//! rule, and a compiled [`Formula`]. V is an energy; x is in the case's unit of length.
//!
//! ```
//! use std::collections::BTreeMap;
//!
//! use geodesic_ivp::geometry::potential::{Formula, Potential};
//!
//! let formula = Potential::Formula(Formula::new("k*x^4", &BTreeMap::from([("k".to_owned(), 0.5)]))?);
//! let (named, formula) = (Potential::quartic(0.5).at(2.0), formula.at(2.0));
//! assert_eq!((named.first, named.second), (16.0, 24.0));
//! assert_eq!((formula.first, formula.second), (16.0, 24.0));
//! # Ok::<(), geodesic_ivp::geometry::potential::FormulaError>(())
//! ```

mod formula;
mod polynomial;

pub use formula::{Formula, is_reserved};
pub use polynomial::Polynomial;

pub use crate::formula::FormulaError;
use crate::formula::Program;
use crate::number::Real;

/// V, V′ and V″ at one point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PotentialJet<S = f64> {
    /// V(x).
    pub value: S,
    /// V′(x).
    pub first: S,
    /// V″(x).
    pub second: S,
}

/// A potential V(x).
#[derive(Debug, Clone)]
pub enum Potential<S = f64> {
    /// V = Σ_k c_k x^k.
    Polynomial(Polynomial<S>),
    /// V from an expression in x.
    Formula(Formula<S>),
}

impl<S: Real> Potential<S> {
    /// V = 0.
    pub fn free() -> Self {
        Self::polynomial(vec![])
    }

    /// V = α x.
    pub fn linear(alpha: S) -> Self {
        Self::polynomial(vec![S::ZERO, alpha])
    }

    /// V = κ x⁴.
    pub fn quartic(kappa: S) -> Self {
        Self::polynomial(vec![S::ZERO, S::ZERO, S::ZERO, S::ZERO, kappa])
    }

    /// V = Σ_k c_k x^k, lowest power first.
    pub fn polynomial(coefficients: Vec<S>) -> Self {
        Self::Polynomial(Polynomial::new(coefficients))
    }

    /// V, V′, V″ as a straight-line program, for arithmetic on series.
    pub(crate) fn program(&self) -> Program<S> {
        match self {
            Self::Polynomial(p) => formula::polynomial(p.coefficients()),
            Self::Formula(f) => f.program().clone(),
        }
    }

    /// V, V′, V″ at `x`. They are not finite where the formula is not defined.
    pub fn at(&self, x: S) -> PotentialJet<S> {
        match self {
            Self::Polynomial(p) => p.at(x),
            Self::Formula(f) => f.at(x),
        }
    }

    /// V at `x`.
    #[inline]
    pub fn value(&self, x: S) -> S {
        match self {
            Self::Polynomial(p) => p.at(x).value,
            Self::Formula(f) => f.value(x),
        }
    }

    /// V and V′ at `x`.
    #[inline]
    pub fn value_and_slope(&self, x: S) -> [S; 2] {
        match self {
            Self::Polynomial(p) => {
                let PotentialJet { value, first, .. } = p.at(x);
                [value, first]
            }
            Self::Formula(f) => f.value_and_slope(x),
        }
    }

    /// Writes V, V′ and V″ at every entry of `x` into `out`, three arrays as long as `x`.
    pub fn sample(&self, x: &[S], out: [&mut [S]; 3]) {
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
