//! The equations of a solved run: the values that each of its windows starts from and hands on.

use super::world_line::{Joint, WindowNodes, WorldLine};
use crate::action::{Form, Layout};
use crate::number::Real;

impl<S: Real> WorldLine<S> {
    /// q^a on the nodes, where ignorable coordinates are counted from the start of their window.
    pub(crate) fn rows(&self) -> Vec<&[S]> {
        self.q.iter().map(Vec::as_slice).collect()
    }

    /// The values that row `a` starts from in each window.
    pub(crate) fn starts(&self, a: usize) -> impl Iterator<Item = S> {
        let is_active = self.geometry().active().contains(&a);
        self.views().map(move |view| if is_active { view.start.q[a] } else { S::ZERO })
    }

    /// p_a at the start of each window.
    pub(crate) fn start_momenta(&self, a: usize) -> impl Iterator<Item = S> {
        self.views().map(move |view| view.start.p[a])
    }

    /// p_a with which each window ends.
    pub(crate) fn end_momenta(&self, a: usize) -> impl Iterator<Item = S> {
        self.views().map(move |view| self.end_momentum(a, &view))
    }

    /// dq^a/dγ with which each window is continued.
    pub(crate) fn end_velocities(&self, a: usize) -> impl Iterator<Item = S> {
        self.views().map(move |view| self.continued_velocities(&view)[a])
    }

    /// K of what each window is continued with.
    pub(crate) fn end_norms(&self) -> impl Iterator<Item = S> {
        self.views().map(move |view| self.geometry().norm(view.end.q, &self.continued_velocities(&view)))
    }

    /// κ_a of each window; there is none without multipliers.
    pub(crate) fn kappas(&self, a: usize) -> impl Iterator<Item = Option<S>> {
        let place = Layout::new(self.q.len(), 0, Form::Strong).kappa(a);
        self.windows.iter().map(move |window| window.multipliers.get(place).copied())
    }

    /// The velocities with which a window is continued.
    fn continued_velocities(&self, view: &WindowNodes<'_, S>) -> Vec<S> {
        let p: Vec<S> = (0..self.q.len()).map(|a| self.end_momentum(a, view)).collect();
        self.velocities(Joint { p: &p, ..view.end })
    }

    /// p_a with which a window ends: −ν_a for an ignorable coordinate in the doubled system of the strong form. The
    /// next window starts with the constant that it stands for.
    pub(super) fn end_momentum(&self, a: usize, view: &WindowNodes<'_, S>) -> S {
        let nu = Layout::new(self.q.len(), 0, Form::Strong).nu(a);
        match view.window.multipliers.get(nu) {
            Some(&nu) if self.is_doubled() && !self.geometry().active().contains(&a) => -nu,
            _ => view.end.p[a],
        }
    }
}
