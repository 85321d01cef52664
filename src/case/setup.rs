//! From a case to what a solver is told.

use std::sync::Arc;

use super::{Case, Decimal, T};
use crate::engine::Accuracy;
use crate::number::Real;
use crate::solve::Arithmetic;
use crate::solve::{Place, Settings, Setup};

/// What windows are chosen for: an accuracy or a tolerance.
pub(super) fn wanted([accuracy, tolerance]: [Option<f64>; 2]) -> Option<Accuracy> {
    accuracy.map(Accuracy::Promised).or(tolerance.map(Accuracy::Estimated))
}

impl Case {
    /// How its world-line is computed.
    pub fn settings(&self) -> Settings {
        Settings {
            sbp: self.scheme.sbp,
            form: self.scheme.form,
            n_gamma: self.grid.n_gamma,
            windows: self.grid.windows,
            system: self.solver.system,
            digits: self.solver.digits,
            max_iterations: self.solver.max_iterations,
            accuracy: wanted(
                [&self.solver.accuracy, &self.solver.tolerance].map(|number| number.as_ref().map(Decimal::value)),
            ),
        }
    }

    /// The space-time and the start.
    fn place<S: Real>(&self) -> Place<S> {
        let geometry = self.geometry();
        let start = self.start_in(&geometry);
        Place { geometry: Arc::new(geometry), start: Arc::new(start) }
    }
}

impl<S: Arithmetic> From<&Case> for Setup<S> {
    fn from(case: &Case) -> Self {
        let place = case.place::<S>();
        Self {
            // Of a formula, compiling it once is enough where the two are of one kind.
            rough: S::rough_place(&place, || case.place()),
            place,
            origin: Some((T, case.initial.t.to())),
            gamma_i: case.grid.gamma_i.to(),
            limit: case.limit(),
            until: Vec::new(),
            regularised: case.scheme.regularised,
            settings: case.settings().within::<S>(),
        }
    }
}
