//! The operators of the windows of a run, and the grid that one of them gives a window.

use std::ops::Range;
use std::sync::{Arc, OnceLock};

use super::window::FormDerivative;
use crate::action::Form;
use crate::number::Real;
use crate::sbp::SbpOperator;

/// The latest operators that are searched for one to share.
const SEARCHED: usize = 64;

/// The operator of some windows. Those of elements are made when they are first asked for: a run that is only sampled
/// needs none.
#[derive(Debug, Clone)]
struct WindowOperator<S> {
    points: usize,
    /// The length of the window; it matters for elements only.
    length: S,
    is_element: bool,
    made: OnceLock<Arc<SbpOperator<S>>>,
}

impl<S: Real> WindowOperator<S> {
    fn get(&self) -> &SbpOperator<S> {
        self.made.get_or_init(|| Arc::new(SbpOperator::gauss_lobatto(self.points, self.length)))
    }
}

/// The operators of a run. Windows of one length and as many nodes share one.
#[derive(Debug, Clone, Default)]
pub(crate) struct Operators<S>(Vec<WindowOperator<S>>);

impl<S: Real> Operators<S> {
    /// The place of this operator.
    pub(super) fn place_of(&mut self, sbp: &Arc<SbpOperator<S>>) -> usize {
        let is_it = |operator: &WindowOperator<S>| operator.made.get().is_some_and(|made| Arc::ptr_eq(made, sbp));
        self.such_that(is_it, || WindowOperator {
            points: sbp.points(),
            length: S::ZERO,
            is_element: !sbp.is_equidistant(),
            made: OnceLock::from(Arc::clone(sbp)),
        })
    }

    /// The place of the Gauss–Lobatto element with so many nodes over this length of γ.
    pub(super) fn element(&mut self, points: usize, length: S) -> usize {
        let is_it = |operator: &WindowOperator<S>| {
            operator.is_element && operator.points == points && operator.length == length
        };
        self.such_that(is_it, || WindowOperator { points, length, is_element: true, made: OnceLock::new() })
    }

    /// Most runs have a dozen operators at most, and the last one is usually meant. Where every window has a length of
    /// its own, a search among all of them would take time quadratic in their number.
    fn such_that(
        &mut self,
        is_it: impl Fn(&WindowOperator<S>) -> bool,
        make: impl FnOnce() -> WindowOperator<S>,
    ) -> usize {
        let first = self.0.len().saturating_sub(SEARCHED);
        let found = self.0[first..].iter().rposition(is_it).map(|place| first + place);
        found.unwrap_or_else(|| {
            self.0.push(make());
            self.0.len() - 1
        })
    }

    /// The operator at a place.
    pub(super) fn get(&self, place: usize) -> &SbpOperator<S> {
        self.0[place].get()
    }

    /// The grid of a window with the operator at `place`, on γ − γ_i ∈ `gamma`, whose first node is that of
    /// `first_node` in the rows of the run.
    pub(super) fn grid(&self, place: usize, form: Form, gamma: [S; 2], first_node: usize) -> WindowGrid<'_, S> {
        WindowGrid { operator: &self.0[place], form, gamma, first_node }
    }
}

/// The nodes of one window: what its operator, its form and its place in the run say about them.
#[derive(Debug, Clone, Copy)]
pub(crate) struct WindowGrid<'a, S> {
    operator: &'a WindowOperator<S>,
    form: Form,
    gamma: [S; 2],
    first_node: usize,
}

impl<'a, S: Real> WindowGrid<'a, S> {
    /// Its operator.
    pub(crate) fn sbp(&self) -> &'a SbpOperator<S> {
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

    /// γ from each node to the next, in `f64`.
    pub(crate) fn distances(&self) -> Vec<f64> {
        let sbp = self.sbp();
        (1..self.points()).map(|k| (sbp.node(k) - sbp.node(k - 1)).to_f64()).collect()
    }

    /// Where charges are exact, in an array with one value per node: at all nodes but the last (strong), or at all
    /// (weak).
    pub(crate) fn exact(&self) -> Range<usize> {
        self.nodes_but(usize::from(self.form == Form::Strong))
    }

    /// The last node, in such an array.
    pub(crate) fn last(&self) -> Range<usize> {
        let end = self.nodes().end;
        end - 1..end
    }

    /// The nodes whose ΔG is not affected by the last node of the strong form, in such an array.
    pub(crate) fn uncoupled(&self) -> Range<usize> {
        self.nodes_but(match self.form {
            Form::Strong => self.sbp().rows_reaching_last_node(),
            Form::Weak => 0,
        })
    }

    fn nodes_but(&self, last: usize) -> Range<usize> {
        let Range { start, end } = self.nodes();
        start..end - last
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_of_one_length_share_an_operator() {
        let mut operators: Operators<f64> = Operators::default();
        let [long, short, again] = [4.0, 2.0, 4.0].map(|length| operators.element(16, length));
        assert!(long == again && long != short && operators.element(20, 4.0) != long);
    }
}
