//! What the reference needs to know of a space-time.

use std::fmt::Debug;

use super::EndReason;
use super::ends::ReferenceEnds;
use super::equations::Equations;
use super::polynomials::Polynomial;
use super::steps::{Goal, Steps};
use crate::number::Real;

/// A space-time whose equations of motion have Taylor series.
#[expect(private_bounds, private_interfaces, reason = "only this module integrates")]
pub trait Analytic<S: Real>: Sized {
    /// Where a trajectory starts.
    type Start;

    /// A point of a trajectory.
    type Point;

    /// What a point needs to know of the start.
    type Origin: Origin<S, Point = Self::Point>;

    /// A trajectory to integrate.
    ///
    /// # Errors
    /// If it starts outside the domain.
    fn begin(&self, start: &Self::Start) -> Result<impl Run<S, Origin = Self::Origin>, ReferenceEnds>;
}

/// What the points of a trajectory need to know of its start.
pub(super) trait Origin<S>: Debug + Clone {
    /// A point of the trajectory.
    type Point;

    /// The point where the parameter of a step over γ/`unit` is `s`.
    fn point(&self, components: &[Polynomial<S>], s: S, unit: S) -> Self::Point;
}

/// A space-time with a start.
pub(super) trait Run<S: Real> {
    /// See [`Analytic::Origin`].
    type Origin;

    /// What points need to know of the start.
    fn origin(&self) -> Self::Origin;

    /// The state at the start, over γ/`unit`.
    fn state(&self, unit: S) -> Vec<S>;

    /// The equations of motion over γ/`unit`, for series of this order.
    fn equations(&self, unit: S, order: usize) -> impl Equations<S>;

    /// The goal that coordinate `a` has a value, over γ.
    fn goal(&self, a: usize, value: S) -> Goal<S>;

    /// The largest relative difference between two integrations.
    fn difference(&self, steps: &Steps<S>, check: &Steps<S>) -> f64;

    /// The error that it ends in a state, at this γ − γ_i.
    fn ends(&self, reason: EndReason, gamma: f64, state: &[S]) -> ReferenceEnds;
}

/// The largest of the differences relative to the sizes.
pub(super) fn largest_relative<S: Real>(distances: impl IntoIterator<Item = (S, S)>) -> f64 {
    distances.into_iter().fold(0.0, |largest, (distance, size)| {
        let relative = if distance.is_finite() { (distance / size).to_f64() } else { f64::INFINITY };
        largest.max(relative)
    })
}
