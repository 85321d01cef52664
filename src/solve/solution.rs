//! A run in one coordinate: t and x.

use super::world_line::WorldLine;
use crate::action::MULTIPLIERS_PER_COORDINATE;
use crate::geometry::Start;
use crate::number::Real;

/// The world-line of a particle in a potential, in the coordinates t and x with the momenta p_t = Q_t and
/// p_x = −dx/dγ.
pub type Solution<S = f64> = WorldLine<S>;

/// The place of t among the coordinates.
const T: usize = 0;
/// The values of x.
const X: usize = 1;

/// The values from which to continue the trajectory. In the strong form these are not (Dt)_N and (Dx)_N: the last node
/// takes up the compatibility defect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EndState<S = f64> {
    /// t at the last node.
    pub t: S,
    /// x at the last node.
    pub x: S,
    /// w*_N = (Dx)_N − λ8/H_N; in the weak form w_N = (D̄x)_N.
    pub x_dot: S,
    /// Q_t, in the doubled system of the strong form as −λ5.
    pub q_t: S,
}

impl<S: Real> Solution<S> {
    /// t_i.
    pub fn t_i(&self) -> S {
        self.origin_of(T) + self.place.start.q[T]
    }

    /// t on the nodes (forward branch), counted from the start of their window.
    pub fn elapsed(&self) -> &[S] {
        &self.q[T]
    }

    /// x on the nodes (forward branch).
    pub fn x(&self) -> &[S] {
        &self.q[X]
    }

    /// t on the nodes, window by window, joints twice.
    pub fn t(&self) -> impl Iterator<Item = S> + '_ {
        self.q(T)
    }

    /// Returns the state to continue from.
    pub fn end_state(&self) -> EndState<S> {
        let [t, x] = [T, X].map(|a| self.last_position(a));
        let q_t = self.views().last().map_or(self.place.start.p[T], |view| view.end_momentum(T));
        EndState { t, x, x_dot: self.signed(-self.last_joint().p[X]), q_t: self.signed(q_t) }
    }

    /// t_N − t_i.
    pub fn duration(&self) -> S {
        self.last_joint().q[T]
    }

    /// λ1 … λ8 of the last window; the weak form has none.
    pub fn multipliers(&self) -> Option<&[S; 2 * MULTIPLIERS_PER_COORDINATE]> {
        self.windows.last()?.multipliers.first_chunk()
    }

    /// Q_t of the start.
    pub fn q_t(&self) -> S {
        self.signed(self.place.start.p[T])
    }

    /// K of the start.
    pub fn norm(&self) -> S {
        let Start { q, q_dot, .. } = &*self.place.start;
        self.geometry().norm(q, q_dot)
    }
}
