//! d/dγ of a field with a given initial value, as each form of the action means it.
//!
//! ```text
//! strong    (Du)_k,            k = 1 … N−1;   u_1 is the initial value, u_2 … u_N are unknown
//! weak      (D̄u)_k,            k = 1 … N;     D̄u = Du + H⁻¹e_1 (u_1 − initial value), all of u is unknown
//! ```
//!
//! Either way there are as many equations as unknowns, and u has an initial value that is not among the unknowns.

use crate::action::Form;
use crate::number::Real;
use crate::sbp::{RegularisedOperator, SbpOperator};

/// D or D̄ on a grid.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FormDerivative<'a, S> {
    sbp: &'a SbpOperator<S>,
    form: Form,
}

impl<'a, S: Real> FormDerivative<'a, S> {
    pub(crate) fn new(sbp: &'a SbpOperator<S>, form: Form) -> Self {
        Self { sbp, form }
    }

    /// The operator.
    pub(super) fn sbp(&self) -> &'a SbpOperator<S> {
        self.sbp
    }

    /// `out` = the derivative of `u` at all nodes (strong: at the last one it enters no equation).
    pub(crate) fn apply(&self, u: &[S], initial: S, out: &mut [S]) {
        match self.form {
            Form::Strong => self.sbp.apply(u, out),
            Form::Weak => RegularisedOperator::new(self.sbp, initial).apply(u, out),
        }
    }

    /// Index of the first node whose value is unknown.
    pub(super) fn first_unknown(&self) -> usize {
        match self.form {
            Form::Strong => 1,
            Form::Weak => 0,
        }
    }

    /// Number of unknown nodes, which is that of equations.
    pub(super) fn unknowns(&self) -> usize {
        self.sbp.points() - self.first_unknown()
    }

    /// (unknown, entry) of equation k; entries of one unknown add.
    pub(super) fn row(&self, k: usize) -> impl Iterator<Item = (usize, S)> + '_ {
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
