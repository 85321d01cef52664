//! What a solve of a scene returns.

use super::setup::Place;
use crate::action::Form;
use crate::geometry::{Geometry, Start};
use crate::sbp::{SbpName, SbpOperator};
use crate::scalar::Real;
use crate::solve::operator::{Operators, WindowGrid};
use crate::solve::status::Iterations;

/// A position with its velocities and momenta between two windows. In the strong form the momenta are p*, which differ
/// from g_ab (Dq^b)_N + A_a: the last node takes up the compatibility defect.
pub type SceneJoint<S = f64> = Start<S>;

/// One window of a world-line.
#[derive(Debug, Clone)]
pub struct SceneWindow<S = f64> {
    /// γ − γ_i at its first and its last node.
    pub gamma: [S; 2],
    /// What it continues.
    pub start: SceneJoint<S>,
    /// What the next window continues from.
    pub end: SceneJoint<S>,
    /// The multipliers of its action, in the order of [`Layout`](crate::action::Layout); the weak form has none.
    pub multipliers: Vec<S>,
    /// Index of its first node in the rows of the world-line, and of its operator there.
    pub(crate) first_node: usize,
    pub(crate) operator: usize,
}

/// A converged critical point in a scene; for a run in several windows, one for each, end to end.
///
/// The nodes are stored window by window: the joint of two windows appears in both.
#[derive(Debug, Clone)]
pub struct WorldLine<S = f64> {
    /// The geometry and the start.
    pub place: Place<S>,
    /// γ of the first node.
    pub gamma_i: S,
    /// γ_f − γ_i.
    pub length: S,
    /// q^a on the nodes, a row for each coordinate; ignorable ones are counted from the start of their window.
    pub(crate) q: Vec<Vec<S>>,
    /// p*_a on the nodes, a row for each active coordinate (physical limit only).
    #[doc(hidden)]
    pub p: Vec<Vec<S>>,
    /// The backward branch in the same rows, if the doubled system was solved.
    pub(crate) backward: Vec<Vec<S>>,
    /// The windows, in order.
    pub windows: Vec<SceneWindow<S>>,
    /// Largest entry of the gradient of the doubled action at this solution, in any window: its certificate.
    pub gradient_norm: S,
    /// The iterations.
    pub iterations: Iterations,
    /// Significant decimal digits that were asked for; 16 for `f64`.
    pub digits: u32,
    /// The estimated error of every coordinate at the nodes, relative to max(1, largest |q^a|) of active and
    /// max(1, largest |q^a − q_i^a|) of ignorable ones, if the windows were chosen for an accuracy.
    pub error_estimate: Option<f64>,
    /// With an accuracy: the number of windows of which it is not proved that nothing steep hides between their nodes.
    pub windows_unproved: Option<usize>,
    /// The accuracy that was asked for, if there was one.
    pub accuracy: Option<f64>,
    /// The place in [`SceneSetup::until`](super::SceneSetup::until) of the formula that ended the run, if one did.
    pub ended_by: Option<usize>,
    /// The coordinate whose value ended the run, if one did.
    pub ended_at: Option<usize>,
    /// The form of the action.
    pub form: Form,
    /// The name of the operator.
    pub sbp_name: SbpName,
    /// The operators of the windows: one if all have the same length and as many nodes.
    pub(crate) operators: Operators<S>,
}

impl<S: Real> WorldLine<S> {
    /// The geometry.
    pub fn geometry(&self) -> &Geometry<S> {
        &self.place.geometry
    }

    /// The operator of the first window.
    pub fn sbp(&self) -> &SbpOperator<S> {
        self.operators.first()
    }

    /// The grids of the windows, in order.
    #[doc(hidden)]
    pub fn grids(&self) -> impl ExactSizeIterator<Item = WindowGrid<'_, S>> + Clone {
        self.windows.iter().map(|window| self.grid(window))
    }

    /// The grid of one of the windows.
    pub(crate) fn grid(&self, window: &SceneWindow<S>) -> WindowGrid<'_, S> {
        self.operators.grid(window.operator, self.form, window.gamma, window.first_node)
    }

    /// Number of nodes, joints twice.
    pub fn nodes(&self) -> usize {
        self.q[0].len()
    }

    /// Whether both branches were solved for.
    pub fn is_doubled(&self) -> bool {
        !self.backward.is_empty()
    }

    /// What to continue from.
    pub fn end(&self) -> &SceneJoint<S> {
        &self.windows[self.windows.len() - 1].end
    }

    /// γ of the last node.
    pub fn gamma_f(&self) -> S {
        self.gamma_i + self.length
    }

    /// γ on the nodes.
    pub fn gamma(&self) -> impl Iterator<Item = S> + '_ {
        self.grids().flat_map(move |grid| (0..grid.points()).map(move |k| self.gamma_i + grid.gamma_at(k)))
    }

    /// q^a on the nodes.
    pub fn q(&self, a: usize) -> impl Iterator<Item = S> + '_ {
        self.absolute(a, &self.q[a])
    }

    /// q^a of the backward branch on the nodes, if the doubled system was solved.
    pub fn backward(&self, a: usize) -> Option<impl Iterator<Item = S> + '_> {
        self.backward.get(a).map(|row| self.absolute(a, row))
    }

    /// A row of coordinate `a`, counted from its origin. An end of a window is what the next one starts from.
    fn absolute<'l>(&'l self, a: usize, row: &'l [S]) -> impl Iterator<Item = S> + 'l {
        let is_active = self.geometry().active().contains(&a);
        self.windows.iter().flat_map(move |window| {
            let row = &row[self.grid(window).nodes()];
            row.iter().enumerate().map(move |(k, &q)| match (is_active, k + 1 == row.len()) {
                (true, _) => q,
                (false, true) => window.end.q[a],
                (false, false) => window.start.q[a] + q,
            })
        })
    }

    /// The rows of a window: q^a on its nodes, where ignorable ones are counted from its start.
    #[doc(hidden)]
    pub fn rows(&self, window: &SceneWindow<S>) -> Vec<&[S]> {
        let nodes = self.grid(window).nodes();
        self.q.iter().map(|row| &row[nodes.clone()]).collect()
    }

    /// Rows of q^a of all coordinates and p_a of the active ones on the nodes of a window, counted from its start. In
    /// the strong form the momenta are p*.
    pub(crate) fn increments(&self, window: &SceneWindow<S>) -> Vec<Vec<S>> {
        let (geometry, grid) = (self.geometry(), self.grid(window));
        let from = self.start_of_rows(window);
        let rows = self.rows(window);
        let counted = |row: &[S], origin: S| row.iter().map(|&value| value - origin).collect::<Vec<S>>();
        let mut all: Vec<Vec<S>> = rows.iter().zip(&from.q).map(|(row, &origin)| counted(row, origin)).collect();
        if !self.is_doubled() {
            let momenta = self.p.iter().zip(geometry.active());
            all.extend(momenta.map(|(row, &a)| counted(&row[grid.nodes()], from.p[a])));
            return all;
        }
        // The doubled system has positions only.
        let velocities: Vec<Vec<S>> = (rows.iter().zip(&from.q))
            .map(|(row, &origin)| {
                let mut slopes = vec![S::ZERO; row.len()];
                grid.derivative(row, origin, &mut slopes);
                slopes
            })
            .collect();
        let at = |rows: &[&[S]], k: usize| rows.iter().map(|row| row[k]).collect::<Vec<S>>();
        let velocities: Vec<&[S]> = velocities.iter().map(Vec::as_slice).collect();
        let mut momenta: Vec<Vec<S>> =
            (0..grid.points()).map(|k| geometry.momenta_here(&at(&rows, k), &at(&velocities, k))).collect();
        if let (Form::Strong, Some(last)) = (self.form, momenta.last_mut()) {
            last.clone_from(&window.end.p);
        }
        all.extend(geometry.active().iter().map(|&a| momenta.iter().map(|p| p[a] - from.p[a]).collect()));
        all
    }

    /// The start of a window as its rows count it: ignorable coordinates are 0.
    pub(crate) fn start_of_rows(&self, window: &SceneWindow<S>) -> Start<S> {
        relative(self.geometry(), &window.start)
    }

    /// Largest distance between the branches in any coordinate; 0 in the physical limit.
    pub fn branch_distance(&self) -> S {
        let rows = self.q.iter().zip(&self.backward);
        rows.flat_map(|(one, two)| one.iter().zip(two)).fold(S::ZERO, |d, (&one, &two)| d.max((one - two).abs()))
    }
}

/// The same start with ignorable coordinates counted from it.
pub(super) fn relative<S: Real>(geometry: &Geometry<S>, start: &Start<S>) -> Start<S> {
    let mut start = start.clone();
    geometry.ignorable().for_each(|a| start.q[a] = S::ZERO);
    start
}
