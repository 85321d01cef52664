//! One window of a scene: operator, geometry and start on one grid.

use crate::action::{DoubledAction, Form};
use crate::geometry::{Geometry, Start};
use crate::sbp::SbpOperator;
use crate::scalar::Real;
use crate::solve::derivative::FormDerivative;

/// A window. Ignorable coordinates are counted from its start, so that no digit of their increments is lost.
#[derive(Debug, Clone, Copy)]
pub(super) struct Window<'w, S = f64> {
    pub(super) form: Form,
    pub(super) sbp: &'w SbpOperator<S>,
    pub(super) geometry: &'w Geometry<S>,
    pub(super) start: &'w Start<S>,
    /// Significant digits wanted.
    pub(super) digits: u32,
}

impl<'w, S: Real> Window<'w, S> {
    pub(super) fn derivative(&self) -> FormDerivative<'w, S> {
        FormDerivative::new(self.sbp, self.form)
    }

    pub(super) fn action(&self) -> DoubledAction<'w, S, Geometry<S>> {
        DoubledAction::of_form(self.form, self.sbp, self.geometry, self.start.clone())
    }

    pub(super) fn points(&self) -> usize {
        self.sbp.points()
    }
}

/// q^a and p_a of all coordinates at one node, to be filled in: ignorable coordinates are 0, their momenta the charges.
pub(super) struct Node<S> {
    pub(super) q: Vec<S>,
    pub(super) p: Vec<S>,
}

impl<S: Real> Node<S> {
    pub(super) fn new(start: &Start<S>) -> Self {
        Self { q: start.q.clone(), p: start.p.clone() }
    }
}
