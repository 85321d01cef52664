//! One step of the Taylor method as polynomials.

use super::ReferencePoint;
use crate::scalar::{Compensated, Real};

/// One step: x and t − t_i as polynomials in γ, counted from the start of the step.
#[derive(Debug, Clone)]
pub(super) struct Step<S> {
    pub(super) start: Compensated<S>,
    pub(super) x: Vec<S>,
    pub(super) x_low: S,
    pub(super) t: Vec<S>,
    pub(super) t_low: S,
}

/// Σ_{j≥1} c_j s^j, the polynomial without c_0. It is small, and is added to c_0 at the end to lose less to rounding.
pub(super) fn increment<S: Real>(c: &[S], s: S) -> S {
    c[1..].iter().rev().fold(S::ZERO, |sum, &c| (sum + c) * s)
}

/// The derivative dc/ds of the polynomial.
pub(super) fn slope<S: Real>(c: &[S], s: S) -> S {
    c.iter().enumerate().skip(1).rev().fold(S::ZERO, |sum, (j, &c)| sum * s + S::from(j as f64) * c)
}

impl<S: Real> Step<S> {
    pub(super) fn at(&self, gamma: S) -> ReferencePoint<S> {
        let s = (gamma - self.start.high) - self.start.low;
        ReferencePoint {
            elapsed: self.t[0] + (self.t_low + increment(&self.t, s)),
            x: self.x[0] + (self.x_low + increment(&self.x, s)),
            t_dot: slope(&self.t, s),
            x_dot: slope(&self.x, s),
        }
    }
}
