//! What the Taylor method needs to know of a system of differential equations.

use crate::number::Real;

/// The solution around one point: a series for each component of the state.
pub(super) type Series<S> = Vec<Vec<S>>;

/// A system of differential equations of first order for a state of several components.
pub(super) trait Equations<S: Real> {
    /// So many of the first components are kept as polynomials.
    fn kept(&self) -> usize;

    /// The first coefficient of a component that has to do with its scale: 1 where the component itself has no meaning,
    /// because it is counted from the start, and 0 elsewhere.
    fn first_of_scale(&self, component: usize) -> usize;

    /// The series of every component around `state`, to the given order.
    fn expand(&mut self, state: &[S], order: usize) -> Series<S>;

    /// The series of the arguments of `abs` in the expansion that was computed last.
    fn kink_arguments(&self) -> impl Iterator<Item = &[S]>;

    /// The difference at s between the derivatives of the series and those that the equations want there, relative to
    /// the size of the terms of the series over a step `h`. What differs by more than `small` may be rounding: if it
    /// is known to be, the difference may be taken as zero.
    fn missed(&mut self, series: &Series<S>, h: S, s: S, small: S) -> S;

    /// Whether `state` lies inside the domain.
    fn is_inside(&mut self, state: &[S]) -> bool;

    /// Whether the edge of the domain is near, compared with the start.
    fn is_near_the_edge(&mut self, state: &[S]) -> bool;
}
