//! The world-line that a solve returns.

use std::sync::Arc;

use super::grid::Window;
use super::signs::Watched;
use super::status::Iterations;
use crate::action::{Form, Layout, MULTIPLIERS_PER_COORDINATE};
use crate::engine::{Accuracy, GOOD_DIGITS, Handed, Sensitivity};
use crate::geometry::{Geometry, Start};
use crate::number::Real;
use crate::number::norm::larger;
use crate::sbp::{SbpName, SbpOperator};

/// The places of t and of x in one coordinate.
const T: usize = 0;
const X: usize = 1;

/// A space-time with the start of a world-line in it, in numbers of one kind.
#[derive(Debug, Clone)]
pub struct Place<S = f64> {
    /// The space-time; a geometry is one around the start.
    pub geometry: Arc<Geometry<S>>,
    /// The start.
    pub start: Arc<Start<S>>,
}

/// The origin that coordinate `a` counts from, which is 0 for most.
pub(super) fn origin_of<S: Real>(origin: Option<(usize, S)>, a: usize) -> S {
    origin.filter(|(coordinate, _)| *coordinate == a).map_or(S::ZERO, |(_, origin)| origin)
}

/// The start or the end of a window. In the strong form momenta are p*: the last node has the compatibility defect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Joint<'l, S> {
    /// q^a.
    pub q: &'l [S],
    /// p_a.
    pub p: &'l [S],
}

/// A converged critical point with the problem it solves; for a run in several windows, one for each, end to end.
///
/// The nodes are stored window by window: the joint of two windows appears in both. Where a run is handed out in parts
/// ([`solve_in_parts`](super::solve_in_parts)) it is one of them, at its place in the run.
#[derive(Debug, Clone)]
pub struct WorldLine<S = f64> {
    /// The space-time and the start.
    pub place: Place<S>,
    /// A coordinate that all counts from this value of it, so that a shift changes no other digit: t in one coordinate.
    pub(crate) origin: Option<(usize, S)>,
    /// γ of the first node.
    pub gamma_i: S,
    /// True if γ falls from there. Inside, all counts from the start: γ, and velocities and momenta by that.
    pub is_backward: bool,
    /// |γ_f − γ_i|.
    pub length: S,
    /// q^a on the nodes, a row for each coordinate; ignorable ones are counted from the start of their window.
    pub(crate) q: Vec<Vec<S>>,
    /// p*_a on the nodes, a row for each active coordinate: in scenes and in the physical limit only.
    pub(crate) p: Vec<Vec<S>>,
    /// The backward branch in the same rows, if the doubled system was solved.
    pub(crate) backward: Vec<Vec<S>>,
    /// The windows, in order.
    pub windows: Vec<Window<S>>,
    /// q^a and p_a where the windows start, and where the last one ends.
    pub(crate) joints: Vec<S>,
    /// Number of windows of the run so far; more than [`Self::windows`] holds where they are handed out one by one.
    pub window_count: usize,
    /// Largest entry of the gradient of the doubled action at this solution, in any window: its certificate.
    pub gradient_norm: S,
    /// The iterations. In one coordinate their corrections are those of t and x (physical limit: of x and w*).
    pub iterations: Iterations,
    /// Significant decimal digits that were asked for; 16 for `f64`.
    pub digits: u32,
    /// The estimated error of every coordinate at the nodes, relative to its size, of a run to an accuracy.
    pub error_estimate: Option<f64>,
    /// These sizes, as [`Windows::sizes`](crate::engine::Windows::sizes); none if there is no estimate.
    pub sizes: Vec<f64>,
    /// The errors of coordinates by [`Windows::errors`](crate::engine::Windows::errors); none if there is no estimate.
    pub errors: Vec<f64>,
    /// With an accuracy: the number of windows of which it is not proved that nothing steep hides between their nodes.
    pub windows_unproved: Option<usize>,
    /// With an accuracy: γ at the first touch of a place where a force jumps, which the error may make a passage.
    pub touched: Option<f64>,
    /// The growth of small changes of the start, if it was asked for.
    pub sensitivity: Option<Sensitivity>,
    /// The accuracy that the windows were chosen for, if they were.
    pub accuracy: Option<Accuracy>,
    /// γ − γ_i until which that estimate is below each of [`GOOD_DIGITS`].
    pub good_until: [f64; GOOD_DIGITS.len()],
    /// The place in [`Setup::until`](super::Setup::until) of the formula that ended the run, if one did.
    pub ended_by: Option<usize>,
    /// What is known of the formulas that may end the run.
    pub(crate) watched: Watched,
    /// The coordinate whose value ended the run, if one did, with that: what a run to an accuracy was asked for.
    pub ended_at: Option<(usize, S)>,
    /// The form of the action.
    pub form: Form,
    /// The name of the operator.
    pub sbp_name: SbpName,
    /// The rounding errors of q^a at the end, where Newton's method solved the run, and what the engine hands on.
    pub(crate) sums: Vec<S>,
    pub(crate) handed: Handed,
}

/// A read-only view of one window of a [`WorldLine`].
#[derive(Debug, Clone, Copy)]
pub struct WindowNodes<'l, S> {
    /// The window.
    pub window: &'l Window<S>,
    /// The joint that it continues.
    pub start: Joint<'l, S>,
    /// The joint that the next window continues from.
    pub end: Joint<'l, S>,
    line: &'l WorldLine<S>,
}

impl<'l, S: Real> WindowNodes<'l, S> {
    /// q^a on its nodes, where ignorable ones are counted from its start.
    pub fn row(&self, a: usize) -> &'l [S] {
        &self.line.q[a][self.window.nodes()]
    }

    /// The rows of all coordinates.
    pub(crate) fn rows(&self) -> Vec<&'l [S]> {
        (0..self.line.q.len()).map(|a| self.row(a)).collect()
    }

    fn is_active(&self, a: usize) -> bool {
        self.line.geometry().active().contains(&a)
    }

    /// The value that row `a` starts from.
    pub(crate) fn first(&self, a: usize) -> S {
        if self.is_active(a) { self.start.q[a] } else { S::ZERO }
    }

    /// p_a with which it ends: −ν_a for an ignorable coordinate in the doubled system of the strong form. The next
    /// window starts with the constant that it stands for.
    pub(crate) fn end_momentum(&self, a: usize) -> S {
        let nu = Layout::new(self.line.q.len(), 0, Form::Strong).nu(a);
        match self.window.multipliers.get(nu) {
            Some(&nu) if self.line.is_doubled() && !self.is_active(a) => -nu,
            _ => self.end.p[a],
        }
    }

    /// dq^a/dγ with which it is continued.
    pub(crate) fn end_velocities(&self) -> Vec<S> {
        let p: Vec<S> = (0..self.line.q.len()).map(|a| self.end_momentum(a)).collect();
        self.line.velocities(Joint { p: &p, ..self.end })
    }

    /// Its part of a row of coordinate `a`, counted from its origin, as values of that coordinate.
    pub(crate) fn absolute(&self, a: usize, row: &'l [S]) -> impl Iterator<Item = S> + use<'l, S> {
        let (origin, row) = (self.line.origin_of(a), &row[self.window.nodes()]);
        let start = (!self.is_active(a)).then_some(self.start.q[a]);
        // What is counted from an origin is rounded once more in any case. Of anything else both rows of a joint are
        // what the next window starts from.
        let (is_joined, end) = (self.line.origin.is_none() && start.is_some(), self.end.q[a]);
        row.iter().enumerate().map(move |(k, &q)| match start {
            Some(_) if is_joined && k + 1 == row.len() => end,
            Some(start) => origin + (start + q),
            None => q,
        })
    }

    /// Rows of q^a of all coordinates and p_a of the active ones on the nodes, counted from the start. In the strong
    /// form the momenta are p*.
    pub(crate) fn increments(&self) -> Vec<Vec<S>> {
        let (line, rows, nodes) = (self.line, self.rows(), self.window.nodes());
        let (geometry, active) = (line.geometry(), line.geometry().active());
        let counted = |row: &[S], origin: S| row.iter().map(|&value| value - origin).collect::<Vec<S>>();
        let mut all: Vec<Vec<S>> = rows.iter().enumerate().map(|(a, row)| counted(row, self.first(a))).collect();
        if !line.is_doubled() {
            let momenta = line.p.iter().zip(active);
            all.extend(momenta.map(|(row, &a)| counted(&row[nodes.clone()], self.start.p[a])));
            return all;
        }
        // The doubled system has positions only.
        let mut velocities = vec![vec![S::ZERO; nodes.len()]; rows.len()];
        for (a, slopes) in velocities.iter_mut().enumerate() {
            self.window.derivative(rows[a], self.first(a), slopes);
        }
        let mut momenta = geometry.rows_of_momenta(&rows, &velocities.iter().map(Vec::as_slice).collect::<Vec<_>>());
        if line.form == Form::Strong {
            let ends = momenta.iter_mut().filter_map(|row| row.last_mut()).zip(self.end.p);
            ends.for_each(|(last, &end)| *last = end);
        }
        all.extend(active.iter().map(|&a| counted(&momenta[a], self.start.p[a])));
        all
    }
}

/// The world-line of a particle in a potential, in the coordinates t and x with the momenta p_t = Q_t and
/// p_x = −dx/dγ.
pub type Solution<S = f64> = WorldLine<S>;

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

impl<S: Real> WorldLine<S> {
    /// The space-time.
    pub fn geometry(&self) -> &Geometry<S> {
        &self.place.geometry
    }

    /// The operator of the first window.
    pub fn sbp(&self) -> &SbpOperator<S> {
        self.windows[0].sbp()
    }

    /// The windows in order.
    pub fn views(&self) -> impl ExactSizeIterator<Item = WindowNodes<'_, S>> + Clone {
        (0..self.windows.len()).map(|index| self.view(index))
    }

    /// A read-only view of one of the windows.
    pub fn view(&self, index: usize) -> WindowNodes<'_, S> {
        let [start, end] = [index, index + 1].map(|joint| self.joint(joint));
        WindowNodes { window: &self.windows[index], start, end, line: self }
    }

    /// Where a window starts or, for the number of windows, where the last one ends, as the start counts them.
    pub fn joint(&self, index: usize) -> Joint<'_, S> {
        let n = self.q.len();
        let (q, p) = self.joints[2 * n * index..][..2 * n].split_at(n);
        Joint { q, p }
    }

    /// The last joint: what to continue from.
    pub(crate) fn last_joint(&self) -> Joint<'_, S> {
        self.joint(self.windows.len())
    }

    /// Number of nodes, joints twice.
    pub fn nodes(&self) -> usize {
        self.q[0].len()
    }

    /// Returns true if both branches were solved for.
    pub fn is_doubled(&self) -> bool {
        !self.backward.is_empty()
    }

    /// Returns the state to continue from.
    pub fn end(&self) -> Start<S> {
        self.turned(self.end_inside())
    }

    /// The same, of the reversed motion if γ falls.
    pub(crate) fn end_inside(&self) -> Start<S> {
        let joint = self.last_joint();
        let q = (0..joint.q.len()).map(|a| self.last_position(a)).collect();
        Start { q, q_dot: self.velocities(joint), p: joint.p.to_vec() }
    }

    /// A state with the velocities and momenta of the motion, from those of the reversed one if γ falls, or back.
    pub(crate) fn turned(&self, state: Start<S>) -> Start<S> {
        if self.is_backward { state.reversed() } else { state }
    }

    /// A rate or a momentum of the motion, from that of the reversed one if γ falls.
    pub(crate) fn signed(&self, rate: S) -> S {
        if self.is_backward { -rate } else { rate }
    }

    /// γ at this distance from the start.
    pub(crate) fn gamma_at(&self, from_start: S) -> S {
        self.gamma_i + self.signed(from_start)
    }

    /// The origin that a coordinate counts from, which is 0 for most.
    pub(crate) fn origin_of(&self, a: usize) -> S {
        origin_of(self.origin, a)
    }

    /// q^a at the end of the run, to the last bit where that ended it.
    pub(crate) fn last_position(&self, a: usize) -> S {
        match self.ended_at {
            Some((coordinate, value)) if coordinate == a => value,
            _ => self.origin_of(a) + self.last_joint().q[a],
        }
    }

    /// dq^a/dγ = g^ab (p_b − A_b) at a joint.
    pub fn velocities(&self, joint: Joint<'_, S>) -> Vec<S> {
        let mut point = self.geometry().point();
        // A joint lies inside the domain.
        let _ = point.evaluate(joint.q, joint.p);
        (0..joint.q.len()).map(|a| point.q_dot(a)).collect()
    }

    /// γ of the last node.
    pub fn gamma_f(&self) -> S {
        self.gamma_at(self.length)
    }

    /// γ − γ_i on the nodes.
    pub fn gamma_from_start(&self) -> impl Iterator<Item = S> + '_ {
        self.windows.iter().flat_map(|window| (0..window.points()).map(move |k| window.gamma_at(k)))
    }

    /// γ on the nodes.
    pub fn gamma(&self) -> impl Iterator<Item = S> + '_ {
        self.gamma_from_start().map(|gamma| self.gamma_at(gamma))
    }

    /// q^a on the nodes.
    pub fn q(&self, a: usize) -> impl Iterator<Item = S> + '_ {
        let last = self.nodes().saturating_sub(1);
        let end = self.ended_at.filter(|(coordinate, _)| *coordinate == a);
        self.absolute(a, &self.q[a]).enumerate().map(move |(k, q)| match end {
            Some((_, value)) if k == last => value,
            _ => q,
        })
    }

    /// q^a of the backward branch on the nodes, if the doubled system was solved.
    pub fn backward(&self, a: usize) -> Option<impl Iterator<Item = S> + '_> {
        self.backward.get(a).map(|row| self.absolute(a, row))
    }

    fn absolute<'l>(&'l self, a: usize, row: &'l [S]) -> impl Iterator<Item = S> + 'l {
        self.views().flat_map(move |view| view.absolute(a, row))
    }

    /// A row of coordinate `a`, in which ignorable ones count from the start of their window, counted from its origin.
    pub(crate) fn counted_from_origin<'l>(&'l self, a: usize, row: &'l [S]) -> impl Iterator<Item = S> + 'l {
        self.views().flat_map(move |view| {
            let start = (!view.is_active(a)).then_some(view.start.q[a]);
            row[view.window.nodes()].iter().map(move |&q| start.map_or(q, |start| start + q))
        })
    }

    /// Largest distance between the branches in any coordinate; 0 in the physical limit.
    pub fn branch_distance(&self) -> S {
        let rows = self.q.iter().zip(&self.backward);
        rows.flat_map(|(one, two)| one.iter().zip(two)).fold(S::ZERO, |d, (&one, &two)| larger(d, (one - two).abs()))
    }

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
        self.geometry().norm(&self.place.start.q, &self.place.start.q_dot)
    }
}
