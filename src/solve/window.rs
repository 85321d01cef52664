//! One window of a run, operator, geometry and start on one grid, and d/dγ on it as each form of the action means it.

use crate::action::{DoubledAction, Form, Layout};
use crate::geometry::{Geometry, Point, Start};
use crate::number::Real;
use crate::sbp::{RegularisedOperator, SbpOperator};

/// A window. Ignorable coordinates are counted from its start, so that no digit of their increments is lost.
#[derive(Debug, Clone, Copy)]
pub(super) struct Window<'w, S> {
    pub(super) form: Form,
    pub(super) sbp: &'w SbpOperator<S>,
    pub(super) geometry: &'w Geometry<S>,
    pub(super) start: &'w Start<S>,
    /// True if the strong action has D̄ in it, or for the ablation D.
    pub(super) is_regularised: bool,
    /// Significant digits wanted.
    pub(super) digits: u32,
    pub(super) max_iterations: usize,
}

impl<'w, S: Real> Window<'w, S> {
    pub(super) fn derivative(&self) -> FormDerivative<'w, S> {
        FormDerivative { sbp: self.sbp, form: self.form }
    }

    /// Returns true if nothing moves but ignorable coordinates: the constants are the solution then, to the last bit.
    pub(super) fn is_at_rest(&self) -> bool {
        let mut point = self.geometry.point();
        let is_zero = |point: &Point<S>| {
            let mut active = self.geometry.active().iter().enumerate();
            active.all(|(place, &a)| point.q_dot(a) == S::ZERO && point.p_dot(place) == S::ZERO)
        };
        point.evaluate(&self.start.q, &self.start.p).is_ok() && is_zero(&point)
    }

    /// The action that is asked for.
    pub(super) fn action(&self) -> DoubledAction<'w, S> {
        let action = self.regularised_action();
        if self.is_regularised { action } else { action.without_regularisation() }
    }

    /// The action with D̄, whichever is asked for.
    pub(super) fn regularised_action(&self) -> DoubledAction<'w, S> {
        DoubledAction::new(self.form, self.sbp, self.geometry, self.start.clone())
    }

    /// The order of the unknowns of the action.
    pub(super) fn layout(&self) -> Layout {
        Layout::new(self.start.q.len(), self.points(), self.form)
    }

    pub(super) fn points(&self) -> usize {
        self.sbp.points()
    }
}

/// d/dγ on a grid of a field with a given initial value:
///
/// ```text
/// strong    (Du)_k,            k = 1 … N−1;   u_1 is the initial value, u_2 … u_N are unknown
/// weak      (D̄u)_k,            k = 1 … N;     D̄u = Du + H⁻¹e_1 (u_1 − initial value), all of u is unknown
/// ```
///
/// Either way there are as many equations as unknowns, and u has an initial value that is not among the unknowns.
#[derive(Debug, Clone, Copy)]
pub(super) struct FormDerivative<'a, S> {
    pub(super) sbp: &'a SbpOperator<S>,
    pub(super) form: Form,
}

impl<'a, S: Real> FormDerivative<'a, S> {
    /// `out` = the derivative of `u` at all nodes (strong: at the last one it enters no equation).
    pub(super) fn apply(&self, u: &[S], initial: S, out: &mut [S]) {
        match self.form {
            Form::Strong => self.sbp.apply(u, out),
            Form::Weak => RegularisedOperator::new(self.sbp, initial).apply(u, out),
        }
    }

    /// Index of the first node whose value is unknown.
    pub(super) fn first_unknown(&self) -> usize {
        usize::from(self.form == Form::Strong)
    }

    /// Number of unknown nodes, which is that of equations.
    pub(super) fn unknowns(&self) -> usize {
        self.sbp.points() - self.first_unknown()
    }

    /// (unknown, entry) of equation k; entries of one unknown add.
    pub(super) fn row(&self, k: usize) -> impl Iterator<Item = (usize, S)> + 'a {
        let first = self.first_unknown();
        let penalty = (self.form == Form::Weak && k == 0).then(|| (0, S::ONE / self.sbp.weights()[0]));
        let known = move |&(column, _): &(usize, S)| column >= first;
        self.sbp.row(k).filter(known).map(move |(column, d)| (column - first, d)).chain(penalty)
    }

    /// Sub- and super-diagonals of the matrix of the equations.
    pub(super) fn reach(&self) -> (usize, usize) {
        let unknowns = self.unknowns();
        // The rows of the closures, and one row between them, show every offset that occurs.
        let closure = self.sbp.closure_rows();
        let rows = (0..=closure).chain(unknowns - closure..unknowns);
        rows.flat_map(|k| self.row(k).map(move |(column, _)| (k, column)))
            .fold((1, 0), |(l, u), (k, column)| (k.saturating_sub(column).max(l), column.saturating_sub(k).max(u)))
    }
}
