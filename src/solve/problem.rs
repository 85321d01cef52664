//! A case made concrete: operator, metric and initial data on one grid.

use std::any::Any;
use std::borrow::Cow;

use super::derivative::FormDerivative;
use crate::action::{DoubledAction, Layout};
use crate::case::{Case, Form};
use crate::geodesic::{InitialData, Invariants};
use crate::metric::Metric;
use crate::sbp::SbpOperator;
use crate::scalar::Real;

/// Everything a solve needs. Time is counted from the start: `initial.t` is 0 and t_i is added to results, so that a
/// shift of t_i shifts t and changes no other digit.
#[derive(Debug, Clone)]
pub(crate) struct Problem<S = f64> {
    pub(crate) form: Form,
    pub(crate) sbp: SbpOperator<S>,
    pub(crate) metric: Metric<S>,
    pub(crate) initial: InitialData<S>,
    pub(crate) gamma_i: S,
    /// γ_f − γ_i.
    pub(crate) length: S,
    /// Significant decimal digits wanted; 16 for `f64`.
    pub(crate) digits: u32,
}

impl<S: Real> Problem<S> {
    /// The problem of `case` on γ − γ_i ∈ [0, `length`].
    pub(crate) fn new(case: &Case, length: S) -> Self {
        let spacing = length / S::from((case.grid.n_gamma - 1) as f64);
        let sbp = case.scheme.sbp.operator(case.grid.n_gamma, spacing).expect("a valid case has enough points");
        Self {
            form: case.scheme.form,
            sbp,
            metric: case.metric(),
            initial: InitialData { t: S::ZERO, ..case.initial_data() },
            gamma_i: case.grid.gamma_i.to(),
            length,
            digits: case.digits::<S>(),
        }
    }

    /// The same problem in `f64`: itself, or one rounded from `case`.
    pub(crate) fn in_f64(&self, case: &Case) -> Cow<'_, Problem> {
        match (self as &dyn Any).downcast_ref() {
            Some(same) => Cow::Borrowed(same),
            None => Cow::Owned(Problem::new(case, self.length.to_f64())),
        }
    }

    pub(crate) fn action(&self) -> DoubledAction<'_, S> {
        match self.form {
            Form::Strong => DoubledAction::new(&self.sbp, &self.metric, self.initial),
            Form::Weak => DoubledAction::weak(&self.sbp, &self.metric, self.initial),
        }
    }

    /// The action that `case` asks for: with D̄, or for the ablation with D.
    pub(crate) fn action_of(&self, case: &Case) -> DoubledAction<'_, S> {
        if case.scheme.regularised {
            self.action()
        } else {
            DoubledAction::without_regularisation(&self.sbp, &self.metric, self.initial)
        }
    }

    pub(crate) fn layout(&self) -> Layout {
        Layout::new(self.sbp.points(), self.form)
    }

    pub(crate) fn derivative(&self) -> FormDerivative<'_, S> {
        FormDerivative::new(&self.sbp, self.form)
    }

    pub(crate) fn invariants(&self) -> Invariants<S> {
        self.initial.invariants(&self.metric)
    }

    /// γ of node k.
    pub(crate) fn gamma(&self, k: usize) -> S {
        self.gamma_i + self.sbp.node(k)
    }
}
