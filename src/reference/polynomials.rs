//! One step of the Taylor method as polynomials.

use crate::number::{Compensated, Real};

/// A component of the state over one step, as a polynomial in the parameter counted from the start of the step.
#[derive(Debug, Clone)]
pub(super) struct Polynomial<S> {
    pub(super) coefficients: Vec<S>,
    /// The rounding error of the first coefficient of the compensated sum.
    pub(super) low: S,
}

impl<S: Real> Polynomial<S> {
    pub(super) fn value(&self, s: S) -> S {
        self.coefficients[0] + (self.low + increment(&self.coefficients, s))
    }

    pub(super) fn slope(&self, s: S) -> S {
        slope(&self.coefficients, s)
    }
}

/// One step.
#[derive(Debug, Clone)]
pub(super) struct Step<S> {
    pub(super) start: Compensated<S>,
    /// The coefficients of the components that are kept.
    pub(super) components: Vec<Polynomial<S>>,
}

impl<S: Real> Step<S> {
    /// The parameter `gamma`, counted from the start of the step.
    pub(super) fn since_start(&self, gamma: S) -> S {
        (gamma - self.start.high) - self.start.low
    }
}

/// Σ_{j≥1} c_j s^j, the polynomial without c_0. It is small, and is added to c_0 at the end to lose less to rounding.
pub(super) fn increment<S: Real>(c: &[S], s: S) -> S {
    c[1..].iter().rev().fold(S::ZERO, |sum, &c| (sum + c) * s)
}

/// The derivative dc/ds of the polynomial.
pub(super) fn slope<S: Real>(c: &[S], s: S) -> S {
    c.iter().enumerate().skip(1).rev().fold(S::ZERO, |sum, (j, &c)| sum * s + S::from(j as f64) * c)
}
