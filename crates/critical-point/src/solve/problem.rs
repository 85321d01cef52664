//! A case made concrete: operator, metric and initial data on one grid.

use std::sync::Arc;

use super::setup::{Scene, Setup};
use super::window::Window;
use crate::action::Form;
use crate::geodesic::{InitialData, Invariants};
use crate::geometry::Start;
use crate::metric::Metric;
use crate::sbp::{SbpName, SbpOperator};
use crate::scalar::Real;

/// Everything a solve needs. Time is counted from the start: `initial.t` is 0 and t_i is added to results, so that a
/// shift of t_i shifts t and changes no other digit.
#[derive(Debug, Clone)]
pub(crate) struct Problem<S = f64> {
    pub(crate) form: Form,
    pub(crate) sbp: Arc<SbpOperator<S>>,
    pub(crate) sbp_name: SbpName,
    pub(crate) metric: Arc<Metric<S>>,
    pub(crate) initial: InitialData<S>,
    /// Q_t and K of the whole run: they are the same in every window.
    pub(crate) invariants: Invariants<S>,
    pub(crate) gamma_i: S,
    /// γ_f − γ_i.
    pub(crate) length: S,
    /// Significant decimal digits wanted; 16 for `f64`.
    pub(crate) digits: u32,
}

impl<S: Real> Problem<S> {
    /// The problem of the first window of `setup`, with windows of the given `length` in γ.
    pub(crate) fn new(setup: &Setup<S>, length: S) -> Self {
        Self::on_operator(setup, setup.settings.sbp, setup.settings.n_gamma, length)
    }

    /// The same with another operator.
    pub(crate) fn on_operator(setup: &Setup<S>, sbp_name: SbpName, points: usize, length: S) -> Self {
        let sbp = sbp_name.operator(points, length / S::from((points - 1) as f64));
        let Scene { metric, initial, gamma_i, .. } = &setup.scene;
        let initial = InitialData { t: S::ZERO, ..*initial };
        Self {
            form: setup.settings.form,
            invariants: initial.invariants(metric),
            sbp: Arc::new(sbp.expect("a valid setup has enough points")),
            sbp_name,
            metric: Arc::clone(metric),
            initial,
            gamma_i: *gamma_i,
            length,
            digits: setup.settings.digits,
        }
    }

    /// Moves on to the window that starts at `gamma` where the particle is at `x` with dx/dγ = `x_dot`.
    pub(crate) fn continue_from(&mut self, gamma: S, x: S, x_dot: S) {
        let t_dot = self.invariants.q_t / self.metric.g00(x);
        self.gamma_i = gamma;
        self.initial = InitialData { t: S::ZERO, x, t_dot, x_dot };
    }

    /// The same problem, rounded to `f64`.
    pub(super) fn rounded(&self, setup: &Setup<S>) -> Problem {
        let mut rounded: Problem = Problem::new(&setup.in_f64(), self.length.to_f64());
        let InitialData { t, x, t_dot, x_dot } = self.initial;
        let [t, x, t_dot, x_dot] = [t, x, t_dot, x_dot].map(S::to_f64);
        rounded.initial = InitialData { t, x, t_dot, x_dot };
        rounded.gamma_i = self.gamma_i.to_f64();
        rounded
    }

    /// The start in the coordinates t and x.
    pub(super) fn start(&self) -> Start<S> {
        let InitialData { t, x, t_dot, x_dot } = self.initial;
        Start { q: vec![t, x], q_dot: vec![t_dot, x_dot], p: vec![self.invariants.q_t, -x_dot] }
    }

    /// The window in the coordinates t and x, which starts there.
    pub(super) fn window<'w>(&'w self, start: &'w Start<S>, is_regularised: bool) -> Window<'w, S, Metric<S>> {
        let (geometry, digits) = (&*self.metric, self.digits);
        Window { form: self.form, sbp: &self.sbp, geometry, start, is_regularised, digits }
    }

    /// γ of node k.
    pub(crate) fn gamma(&self, k: usize) -> S {
        self.gamma_i + self.sbp.node(k)
    }
}
