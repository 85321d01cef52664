//! What is to be solved: a scene, and how.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::action::Form;
use crate::geodesic::InitialData;
use crate::metric::Metric;
use crate::sbp::SbpName;
use crate::scalar::Real;

/// The system of equations that is solved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum System {
    /// The collocation system that holds at the critical point. Its solution is certified on the doubled action.
    #[default]
    PhysicalLimit,
    /// ∇E_IVP = 0 in all 4N + 8 unknowns (4N in the weak form).
    Doubled,
}

/// Where a run ends, counted from its start.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum End<S = f64> {
    /// At γ_f. The number is the length γ_f − γ_i of the range of γ.
    Length(S),
    /// At the physical time t_f. The number is the duration t_f − t_i.
    Duration(S),
}

/// A world-line that is looked for, in numbers of one kind.
#[derive(Debug, Clone)]
pub struct Scene<S = f64> {
    /// The space-time.
    pub metric: Arc<Metric<S>>,
    /// The start and the tangent there.
    pub initial: InitialData<S>,
    /// The first value of γ.
    pub gamma_i: S,
    /// Where the run ends.
    pub end: End<S>,
    /// The physical time at which it ends, if that is given.
    pub t_f: Option<S>,
}

/// Everything that a solver is told. The numbers are valid: enough nodes for the operator, an end after the start.
#[derive(Debug, Clone)]
pub struct Setup<S = f64> {
    /// What is looked for.
    pub scene: Scene<S>,
    /// The same in `f64`, where first guesses and linear algebra work.
    pub rough: Scene,
    /// The operator.
    pub sbp: SbpName,
    /// The form of the action.
    pub form: Form,
    /// D̄ (true) or D (false) in the action.
    pub regularised: bool,
    /// The nodes of a window.
    pub n_gamma: usize,
    /// Windows of one length.
    pub windows: usize,
    /// Which system is solved.
    pub system: System,
    /// Significant decimal digits of the solution.
    pub digits: u32,
    /// Most Newton iterations of a window.
    pub max_iterations: usize,
    /// The error allowed, relative to max(1, largest |t − t_i|) and max(1, largest |x|), where operator and windows are
    /// left to the program.
    pub accuracy: Option<f64>,
}

impl<S: Real> Setup<S> {
    /// The same in `f64`.
    pub(super) fn in_f64(&self) -> Setup {
        let Self { sbp, form, regularised, n_gamma, windows, system, max_iterations, accuracy, .. } = *self;
        Setup {
            scene: self.rough.clone(),
            rough: self.rough.clone(),
            digits: self.digits.min(f64::MOST_DIGITS),
            sbp,
            form,
            regularised,
            n_gamma,
            windows,
            system,
            max_iterations,
            accuracy,
        }
    }
}
