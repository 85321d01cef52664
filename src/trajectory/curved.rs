//! What sampling needs to know of a space-time.

use std::fmt::Debug;

use super::cursor::Reached;
use super::legendre::Tables;
use crate::number::Real;
use crate::solve::{Space, WorldLine};

/// A space-time whose world-lines are interpolated.
#[expect(private_interfaces, reason = "only this module interpolates")]
pub trait Curved<S: Real>: Space<S> {
    /// The world-line at one value of γ.
    type Sample;

    /// The world-line in one window.
    type Curve: Debug;

    /// Room to compute in.
    type Rates: Debug;

    /// Room to compute in.
    fn rates_room(&self) -> Self::Rates;

    /// The curve of a window.
    fn curve(line: &WorldLine<S, Self>, window: usize, tables: &mut Tables<S>, room: &mut Self::Rates) -> Self::Curve;

    /// The world-line at `place`, which is γ from the start of that window.
    fn sample(
        line: &WorldLine<S, Self>,
        window: usize,
        curve: &Self::Curve,
        place: S,
        room: &mut Self::Rates,
    ) -> Self::Sample;

    /// The world-line where coordinate `a` has a value in the window of that curve.
    fn sample_at_value(
        line: &WorldLine<S, Self>,
        value: (usize, &Reached<S>),
        curve: &Self::Curve,
        room: &mut Self::Rates,
    ) -> Self::Sample;

    /// The numbers that were asked for, in place of those that were found: γ, or the value of a coordinate.
    fn as_asked(sample: Self::Sample, gamma: Option<S>, value: Option<(usize, S)>) -> Self::Sample;
}
