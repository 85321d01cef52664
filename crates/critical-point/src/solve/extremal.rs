//! What the equations of a solved run are about, whatever the number of its coordinates.

use super::operator::WindowGrid;
use super::scene::WorldLine;
use super::solution::Solution;
use crate::action::{Form, Layout};
use crate::geometry::{Geometry, Lagrangian, Samples, Start};
use crate::metric::{G00, Metric};
use crate::scalar::Real;

/// What the equations say about a solved run: its Lagrangian, and what each of its windows starts from and hands on.
pub(crate) trait Extremal<S: Real> {
    /// What the action is made of.
    type Lagrangian: Lagrangian<S>;

    /// What the action is made of.
    fn lagrangian(&self) -> &Self::Lagrangian;

    /// The form of the action.
    fn form(&self) -> Form;

    /// Where the run starts.
    fn start(&self) -> Start<S>;

    /// The grids of the windows, in order.
    fn grids(&self) -> impl ExactSizeIterator<Item = WindowGrid<'_, S>> + Clone;

    /// q^a on the nodes, where some coordinates are counted from the start of their window.
    fn rows(&self) -> Vec<&[S]>;

    /// What row `a` starts from in each window.
    fn starts(&self, a: usize) -> impl Iterator<Item = S>;

    /// p_a at the start of each window.
    fn start_momenta(&self, a: usize) -> impl Iterator<Item = S>;

    /// p_a with which each window is continued.
    fn end_momenta(&self, a: usize) -> impl Iterator<Item = S>;

    /// dq^a/dγ with which each window is continued.
    fn end_velocities(&self, a: usize) -> impl Iterator<Item = S>;

    /// K of what each window is continued with. `samples` are those of [`Self::rows`].
    fn end_norms(&self, samples: &Samples<S>) -> impl Iterator<Item = S>;

    /// κ_a of each window; there is none without multipliers.
    fn kappas(&self, a: usize) -> impl Iterator<Item = Option<S>>;
}

impl<S: Real> Extremal<S> for Solution<S> {
    type Lagrangian = Metric<S>;

    fn lagrangian(&self) -> &Metric<S> {
        &self.metric
    }

    fn form(&self) -> Form {
        self.form
    }

    fn start(&self) -> Start<S> {
        self.initial.start(&self.metric)
    }

    fn grids(&self) -> impl ExactSizeIterator<Item = WindowGrid<'_, S>> + Clone {
        self.views().map(|view| view.grid)
    }

    fn rows(&self) -> Vec<&[S]> {
        vec![&self.elapsed, &self.x]
    }

    fn starts(&self, a: usize) -> impl Iterator<Item = S> {
        self.windows.iter().map(move |window| if a == 0 { S::ZERO } else { window.start.x })
    }

    fn start_momenta(&self, a: usize) -> impl Iterator<Item = S> {
        let q_t = self.invariants().q_t;
        self.windows.iter().map(move |window| if a == 0 { q_t } else { -window.start.x_dot })
    }

    fn end_momenta(&self, a: usize) -> impl Iterator<Item = S> {
        let q_t = self.end.q_t;
        self.windows.iter().map(move |window| if a == 0 { q_t } else { -window.end.x_dot })
    }

    fn end_velocities(&self, a: usize) -> impl Iterator<Item = S> {
        let t_dot = |x: S| self.end.q_t / self.metric.g00(x);
        self.windows.iter().map(move |window| if a == 0 { t_dot(window.end.x) } else { window.end.x_dot })
    }

    fn end_norms(&self, samples: &Samples<S>) -> impl Iterator<Item = S> {
        let (q_t, g00) = (self.end.q_t, samples.row(G00));
        self.views().map(move |view| {
            let (g00, w) = (g00[view.grid.nodes().end - 1], view.window.end.x_dot);
            q_t * q_t / g00 - w * w
        })
    }

    fn kappas(&self, a: usize) -> impl Iterator<Item = Option<S>> {
        let place = Layout::new(2, 0, Form::Strong).kappa(a);
        self.windows.iter().map(move |window| window.multipliers.as_ref().map(|lambda| lambda[place]))
    }
}

impl<S: Real> Extremal<S> for WorldLine<S> {
    type Lagrangian = Geometry<S>;

    fn lagrangian(&self) -> &Geometry<S> {
        self.geometry()
    }

    fn form(&self) -> Form {
        self.form
    }

    fn start(&self) -> Start<S> {
        self.place.start.clone()
    }

    fn grids(&self) -> impl ExactSizeIterator<Item = WindowGrid<'_, S>> + Clone {
        WorldLine::grids(self)
    }

    fn rows(&self) -> Vec<&[S]> {
        self.q.iter().map(Vec::as_slice).collect()
    }

    fn starts(&self, a: usize) -> impl Iterator<Item = S> {
        let is_active = self.geometry().active().contains(&a);
        self.windows.iter().map(move |window| if is_active { window.start.q[a] } else { S::ZERO })
    }

    fn start_momenta(&self, a: usize) -> impl Iterator<Item = S> {
        self.windows.iter().map(move |window| window.start.p[a])
    }

    fn end_momenta(&self, a: usize) -> impl Iterator<Item = S> {
        self.windows.iter().map(move |window| window.end.p[a])
    }

    fn end_velocities(&self, a: usize) -> impl Iterator<Item = S> {
        self.windows.iter().map(move |window| window.end.q_dot[a])
    }

    fn end_norms(&self, _: &Samples<S>) -> impl Iterator<Item = S> {
        self.windows.iter().map(|window| self.geometry().norm(&window.end.q, &window.end.q_dot))
    }

    fn kappas(&self, a: usize) -> impl Iterator<Item = Option<S>> {
        let place = Layout::new(self.q.len(), 0, Form::Strong).kappa(a);
        self.windows.iter().map(move |window| window.multipliers.get(place).copied())
    }
}
