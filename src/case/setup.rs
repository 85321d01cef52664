//! From a case to what a solver is told.

use super::{Case, Decimal};
use crate::Numeric;
use crate::solve::{Scene, Settings, Setup};

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
            accuracy: self.solver.accuracy.as_ref().map(Decimal::value),
        }
    }

    /// The world-line that it is about.
    pub fn scene<S: Numeric>(&self) -> Scene<S> {
        let initial = self.initial_data();
        Scene {
            place: Scene::place(self.metric(), initial),
            t_i: initial.t,
            gamma_i: self.grid.gamma_i.to(),
            end: self.end(),
            t_f: self.grid.t_f.as_ref().map(Decimal::to),
        }
    }
}

impl<S: Numeric> From<&Case> for Setup<S> {
    fn from(case: &Case) -> Self {
        let scene = case.scene::<S>();
        Self {
            // Of a formula, compiling it once is enough where the two are of one kind.
            rough: S::rough_scene(&scene, || case.scene()),
            scene,
            regularised: case.scheme.regularised,
            settings: case.settings().within::<S>(),
        }
    }
}
