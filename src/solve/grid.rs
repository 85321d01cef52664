//! The windows of a run: their operators, and what these say about their nodes.

use std::ops::Range;
use std::sync::{Arc, OnceLock};

use crate::action::Form;
use crate::number::Real;
use crate::sbp::{RegularisedOperator, SbpOperator};

/// Windows are shown to an observer once they have so many nodes: what is done for a part alone is done more rarely.
pub(super) const SHOWN: usize = 512;

/// The operator of some windows. Those of elements are made when they are first asked for: a run that is only sampled
/// needs none.
#[derive(Debug)]
pub(crate) struct WindowOperator<S> {
    points: usize,
    /// The length of the window; it matters for elements only.
    pub(super) length: S,
    is_element: bool,
    made: OnceLock<SbpOperator<S>>,
}

impl<S: Real> WindowOperator<S> {
    /// One that is made.
    pub(super) fn made(sbp: SbpOperator<S>) -> Arc<Self> {
        let (points, is_element) = (sbp.points(), !sbp.is_equidistant());
        Arc::new(Self { points, length: S::ZERO, is_element, made: OnceLock::from(sbp) })
    }

    /// The Gauss–Lobatto element with so many nodes over this length of γ.
    pub(super) fn element(points: usize, length: S) -> Arc<Self> {
        Arc::new(Self { points, length, is_element: true, made: OnceLock::new() })
    }

    pub(super) fn get(&self) -> &SbpOperator<S> {
        self.made.get_or_init(|| SbpOperator::gauss_lobatto(self.points, self.length))
    }
}

/// One window of a world-line.
#[derive(Debug, Clone)]
pub struct Window<S = f64> {
    /// γ − γ_i at its first and its last node.
    pub gamma: [S; 2],
    /// The multipliers of its action, in the order of [`Layout`](crate::action::Layout); the weak form has none.
    pub multipliers: Vec<S>,
    /// By how much each result may be off in it: the largest distance so far of the two marches that judge each other.
    /// Empty where there are none.
    pub errors: Vec<f64>,
    /// Index of its first node in the rows of the world-line.
    pub(super) first_node: usize,
    pub(super) form: Form,
    /// Windows of one length and as many nodes share one.
    pub(super) operator: Arc<WindowOperator<S>>,
}

impl<S: Real> Window<S> {
    /// γ from its first to its last node.
    pub fn length(&self) -> S {
        self.gamma[1] - self.gamma[0]
    }

    /// Its operator.
    pub(crate) fn sbp(&self) -> &SbpOperator<S> {
        self.operator.get()
    }

    /// Number of nodes.
    pub(crate) fn points(&self) -> usize {
        self.operator.points
    }

    /// Returns true if all intervals between its nodes are equal.
    pub(crate) fn is_equidistant(&self) -> bool {
        !self.operator.is_element
    }

    /// Its part of an array that holds one value per node.
    pub(crate) fn nodes(&self) -> Range<usize> {
        self.first_node..self.first_node + self.points()
    }

    /// d/dγ as the form of the action means it: Du (strong), or D̄u of a field `u` that starts at `initial` (weak).
    pub(crate) fn derivative(&self, u: &[S], initial: S, out: &mut [S]) {
        FormDerivative { sbp: self.sbp(), form: self.form }.apply(u, initial, out);
    }

    /// γ − γ_i at node k.
    #[inline]
    pub(crate) fn gamma_at(&self, k: usize) -> S {
        let [first, last] = self.gamma;
        if k + 1 == self.points() {
            last
        } else if first == S::ZERO {
            self.sbp().node(k)
        } else {
            first + self.sbp().node(k)
        }
    }

    /// Where charges are exact, in an array with one value per node: at all nodes but the last (strong), or at all
    /// (weak).
    pub(crate) fn exact(&self) -> Range<usize> {
        self.nodes_but(usize::from(self.form == Form::Strong))
    }

    /// The nodes whose ΔG is not affected by the last node of the strong form, in such an array.
    pub(crate) fn uncoupled(&self) -> Range<usize> {
        self.nodes_but(if self.form == Form::Strong { self.sbp().rows_reaching_last_node() } else { 0 })
    }

    fn nodes_but(&self, last: usize) -> Range<usize> {
        let Range { start, end } = self.nodes();
        start..end - last
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
