//! The operators of the windows of a run.

use std::sync::{Arc, OnceLock};

use crate::sbp::SbpOperator;
use crate::scalar::Real;

/// The operator of some windows. Those of elements are made when they are first asked for: a run that is only sampled
/// needs none.
#[derive(Debug, Clone)]
pub(crate) struct WindowOperator<S> {
    points: usize,
    /// The length of the window; it matters for elements only.
    length: S,
    is_element: bool,
    made: OnceLock<Arc<SbpOperator<S>>>,
}

impl<S: Real> WindowOperator<S> {
    /// An operator that exists.
    pub(super) fn made(sbp: &Arc<SbpOperator<S>>) -> Self {
        let (points, is_element) = (sbp.points(), !sbp.is_equidistant());
        Self { points, length: S::ZERO, is_element, made: OnceLock::from(Arc::clone(sbp)) }
    }

    /// The Gauss–Lobatto element of so many nodes over this `length` of γ.
    pub(super) fn element(points: usize, length: S) -> Self {
        Self { points, length, is_element: true, made: OnceLock::new() }
    }

    /// Whether it is that of [`Self::element`].
    pub(super) fn is_element_of(&self, points: usize, length: S) -> bool {
        self.is_element && self.points == points && self.length == length
    }

    /// Whether it is this one.
    pub(super) fn is(&self, sbp: &Arc<SbpOperator<S>>) -> bool {
        self.made.get().is_some_and(|made| Arc::ptr_eq(made, sbp))
    }

    /// Number of nodes.
    pub(crate) fn points(&self) -> usize {
        self.points
    }

    /// Whether all intervals between nodes are equal.
    pub(crate) fn is_equidistant(&self) -> bool {
        !self.is_element
    }

    pub(crate) fn get(&self) -> &SbpOperator<S> {
        self.made.get_or_init(|| Arc::new(SbpOperator::gauss_lobatto(self.points, self.length)))
    }
}
