//! One window of a scene: operator, geometry and start on one grid.

use crate::action::{DoubledAction, Form};
use crate::geometry::{Motion, Start};
use crate::sbp::SbpOperator;
use crate::scalar::Real;
use crate::solve::derivative::FormDerivative;

/// A window. Ignorable coordinates are counted from its start, so that no digit of their increments is lost.
#[derive(Debug)]
pub(in crate::solve) struct Window<'w, S, G> {
    pub(in crate::solve) form: Form,
    pub(in crate::solve) sbp: &'w SbpOperator<S>,
    pub(in crate::solve) geometry: &'w G,
    pub(in crate::solve) start: &'w Start<S>,
    /// Significant digits wanted.
    pub(in crate::solve) digits: u32,
}

impl<S, G> Clone for Window<'_, S, G> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<S, G> Copy for Window<'_, S, G> {}

impl<'w, S: Real, G: Motion<S>> Window<'w, S, G> {
    pub(in crate::solve) fn derivative(&self) -> FormDerivative<'w, S> {
        FormDerivative::new(self.sbp, self.form)
    }

    pub(super) fn action(&self) -> DoubledAction<'w, S, G> {
        DoubledAction::of_form(self.form, self.sbp, self.geometry, self.start.clone())
    }

    pub(super) fn points(&self) -> usize {
        self.sbp.points()
    }
}
