//! A trajectory to integrate: a geometry with a start.

use super::EndReason;
use super::ends::{ReferenceEnds, Words};
use super::equations::Equations;
use super::steps::{Goal, Steps};
use crate::geometry::{Geometry, Start};
use crate::number::Real;

/// A scene with a start.
pub(super) struct Begun<'g, S> {
    geometry: Geometry<S>,
    start: &'g Start<S>,
}

impl<'g, S: Real> Begun<'g, S> {
    /// With the domain that the start lies in.
    ///
    /// # Errors
    /// If it starts outside the domain.
    pub(super) fn new(geometry: &Geometry<S>, start: &'g Start<S>) -> Result<Self, ReferenceEnds> {
        let around = geometry.clone().around(&start.q);
        let geometry = around.map_err(|_| ends(geometry, EndReason::OutsideDomain, 0.0, &start.q))?;
        Ok(Self { geometry, start })
    }

    /// The active coordinates.
    pub(super) fn active(&self) -> &[usize] {
        self.geometry.active()
    }

    /// The state at the start. Positions and momenta have no unit of γ.
    pub(super) fn state(&self) -> Vec<S> {
        let mut state = self.start.q.clone();
        self.geometry.ignorable().for_each(|a| state[a] = S::ZERO);
        state.extend(self.geometry.active().iter().map(|&a| self.start.p[a]));
        state
    }

    /// The equations of motion over γ/`unit`, for series of this order.
    pub(super) fn equations(&self, unit: S, order: usize) -> Equations<'_, S> {
        Equations::new(&self.geometry, self.start, unit, order)
    }

    /// The goal that coordinate `a` has a value, over γ.
    pub(super) fn goal(&self, a: usize, value: S) -> Goal<S> {
        let distance = value - self.start.q[a];
        let length = (distance / self.start.q_dot[a]).abs();
        // From rest nothing tells how far it is.
        let length = if length.is_finite() { length } else { S::ONE };
        let value = if self.geometry.active().contains(&a) { value } else { distance };
        Goal::Value { component: a, value, sign: distance.signum(), length }
    }

    /// The largest relative difference between two integrations. Coordinates with the same g_aa at the start have the
    /// same unit, and share the largest size: of x and y one may be zero but for rounding.
    pub(super) fn difference(&self, steps: &Steps<S>, check: &Steps<S>) -> f64 {
        let n = self.geometry.dimension();
        let distances = steps.distances(check, n);
        let sizes: Vec<S> = distances.iter().map(|(_, size)| *size).collect();
        let sizes = self.geometry.shared(&self.start.q, &sizes);
        distances.iter().zip(sizes).fold(0.0, |largest, (&(distance, _), size)| {
            let relative = if distance.is_finite() { (distance / size).to_f64() } else { f64::INFINITY };
            largest.max(relative)
        })
    }

    /// The error that it ends in a state, at this γ − γ_i.
    pub(super) fn ends(&self, reason: EndReason, gamma: f64, state: &[S]) -> ReferenceEnds {
        let mut q = state[..self.geometry.dimension()].to_vec();
        self.geometry.ignorable().for_each(|a| q[a] += self.start.q[a]);
        ends(&self.geometry, reason, gamma, &q)
    }
}

/// The error that a trajectory ends where the coordinates are `q`.
fn ends<S: Real>(geometry: &Geometry<S>, reason: EndReason, gamma: f64, q: &[S]) -> ReferenceEnds {
    if let Some(g00) = geometry.g00(q) {
        let place = [("x", q[1]), ("g00", g00)].map(|(name, value)| (name.to_owned(), value.to_f64())).to_vec();
        let words = Words { formula: "the potential", value: "the physical time t_f" };
        return ReferenceEnds { reason, gamma, place, words };
    }
    let place = geometry.names().iter().cloned().zip(q.iter().map(|q| q.to_f64())).collect();
    let words = Words { formula: "a formula", value: "the value of the coordinate" };
    ReferenceEnds { reason, gamma, place, words }
}
