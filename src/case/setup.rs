//! From a case to what a solver is told.

use std::sync::Arc;

use super::{Case, Decimal};
use crate::scalar::Real;
use crate::solve::{Arithmetic, Scene, Setup};

impl Case {
    fn scene<S: Real>(&self) -> Scene<S> {
        Scene {
            metric: Arc::new(self.metric()),
            initial: self.initial_data(),
            gamma_i: self.grid.gamma_i.to(),
            end: self.end(),
            t_f: self.grid.t_f.as_ref().map(Decimal::to),
        }
    }
}

impl<S: Arithmetic> From<&Case> for Setup<S> {
    fn from(case: &Case) -> Self {
        let scene = case.scene::<S>();
        Self {
            // Of a formula, compiling it once is enough where the two are of one kind.
            rough: S::rough_scene(&scene, || case.scene()),
            scene,
            sbp: case.scheme.sbp,
            form: case.scheme.form,
            regularised: case.scheme.regularised,
            n_gamma: case.grid.n_gamma,
            windows: case.grid.windows,
            system: case.solver.system,
            digits: case.digits::<S>(),
            max_iterations: case.solver.max_iterations,
            accuracy: case.solver.accuracy.as_ref().map(Decimal::value),
        }
    }
}
