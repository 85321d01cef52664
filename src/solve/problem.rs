//! A case made concrete: operator, metric and initial data on one grid.

use crate::action::{DoubledAction, Layout};
use crate::case::Case;
use crate::geodesic::{InitialData, Invariants};
use crate::metric::Metric;
use crate::sbp::{Coefficients, SbpOperator};

/// Everything a solve needs. Time is counted from the start: `initial.t` is 0 and t_i is added to results, so that a
/// shift of t_i shifts t and changes no other digit.
#[derive(Debug, Clone)]
pub(crate) struct Problem {
    pub(crate) coefficients: &'static Coefficients,
    pub(crate) sbp: SbpOperator,
    pub(crate) metric: Metric,
    pub(crate) initial: InitialData,
    pub(crate) gamma_i: f64,
    /// γ_f − γ_i.
    pub(crate) length: f64,
}

impl Problem {
    /// The problem of `case` on γ − γ_i ∈ [0, `length`].
    pub(crate) fn new(case: &Case, length: f64) -> Self {
        let coefficients = case.scheme.sbp.coefficients();
        let spacing = length / (case.grid.n_gamma - 1) as f64;
        let sbp = SbpOperator::new(coefficients, case.grid.n_gamma, spacing).expect("a valid case has enough points");
        Self {
            coefficients,
            sbp,
            metric: case.metric(),
            initial: InitialData { t: 0.0, ..case.initial_data() },
            gamma_i: case.grid.gamma_i,
            length,
        }
    }

    pub(crate) fn action(&self) -> DoubledAction<'_> {
        DoubledAction::new(&self.sbp, &self.metric, self.initial)
    }

    pub(crate) fn layout(&self) -> Layout {
        Layout::new(self.sbp.points())
    }

    pub(crate) fn invariants(&self) -> Invariants {
        self.initial.invariants(&self.metric)
    }

    /// γ of node k.
    pub(crate) fn gamma(&self, k: usize) -> f64 {
        self.gamma_i + k as f64 * self.sbp.spacing()
    }
}
