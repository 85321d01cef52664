//! One window of a run: operator, geometry and start on one grid.

use super::derivative::FormDerivative;
use crate::action::{DoubledAction, Form, Layout};
use crate::geometry::{Geometry, Point, Start};
use crate::number::Real;
use crate::sbp::SbpOperator;

/// A window. Ignorable coordinates are counted from its start, so that no digit of their increments is lost.
#[derive(Debug)]
pub(super) struct Window<'w, S> {
    pub(super) form: Form,
    pub(super) sbp: &'w SbpOperator<S>,
    pub(super) geometry: &'w Geometry<S>,
    pub(super) start: &'w Start<S>,
    /// True if the strong action has D̄ in it, or for the ablation D.
    pub(super) is_regularised: bool,
    /// Significant digits wanted.
    pub(super) digits: u32,
}

impl<S> Clone for Window<'_, S> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<S> Copy for Window<'_, S> {}

impl<'w, S: Real> Window<'w, S> {
    pub(super) fn derivative(&self) -> FormDerivative<'w, S> {
        FormDerivative::new(self.sbp, self.form)
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
        if self.is_regularised {
            self.regularised_action()
        } else {
            DoubledAction::without_regularisation(self.sbp, self.geometry, self.start.clone())
        }
    }

    /// The action with D̄, whichever is asked for.
    pub(super) fn regularised_action(&self) -> DoubledAction<'w, S> {
        DoubledAction::of_form(self.form, self.sbp, self.geometry, self.start.clone())
    }

    /// The order of the unknowns of the action.
    pub(super) fn layout(&self) -> Layout {
        Layout::new(self.start.q.len(), self.points(), self.form)
    }

    pub(super) fn points(&self) -> usize {
        self.sbp.points()
    }
}
