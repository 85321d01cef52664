//! From a case to what a solver is told.

use super::{Case, Decimal};
use crate::Numeric;
use crate::metric::Metric;
use crate::solve::{End, Limit, Place, Settings, Setup};

/// The place of t among the coordinates t and x.
const T: usize = 0;

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

    /// The space-time and the start.
    fn place<S: Numeric>(&self) -> Place<S, Metric<S>> {
        Setup::place(self.metric(), self.initial_data())
    }
}

impl<S: Numeric> From<&Case> for Setup<S, Metric<S>> {
    fn from(case: &Case) -> Self {
        let place = case.place::<S>();
        let t_i: S = case.initial.t.to();
        let limit = match case.end() {
            End::Length(length) => Limit::Length(length),
            End::Duration(duration) => {
                // t_i + (t_f − t_i), rounded twice, may be the neighbouring number.
                let value = case.grid.t_f.as_ref().map_or(t_i + duration, Decimal::to);
                Limit::Value { coordinate: T, value }
            }
        };
        Self {
            // Of a formula, compiling it once is enough where the two are of one kind.
            rough: S::rough_place(&place, || case.place()),
            place,
            origin: Some((T, t_i)),
            gamma_i: case.grid.gamma_i.to(),
            limit,
            until: Vec::new(),
            regularised: case.scheme.regularised,
            settings: case.settings().within::<S>(),
        }
    }
}
