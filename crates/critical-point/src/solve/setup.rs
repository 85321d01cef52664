//! What is to be solved: a scene, and how.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::run::{Observer, Run};
use super::world_line::Place;
use crate::action::Form;
use crate::geodesic::InitialData;
use crate::geometry::Start;
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
    /// The space-time and the start, from which t counts.
    pub place: Place<S, Metric<S>>,
    /// t at the start.
    pub t_i: S,
    /// The first value of γ.
    pub gamma_i: S,
    /// Where the run ends.
    pub end: End<S>,
    /// The physical time at which it ends, if that is given.
    pub t_f: Option<S>,
}

impl<S: Real> Scene<S> {
    /// The space-time and the start that every world-line begins with.
    pub fn place(metric: Metric<S>, initial: InitialData<S>) -> Place<S, Metric<S>> {
        let start = InitialData { t: S::ZERO, ..initial }.start(&metric);
        Place { geometry: Arc::new(metric), start: Arc::new(start) }
    }

    /// The space-time.
    pub fn metric(&self) -> &Metric<S> {
        &self.place.geometry
    }

    /// The initial data, with time counted from the start (t = 0).
    pub fn initial(&self) -> InitialData<S> {
        initial_data(&self.place.start)
    }

    /// A run of it without windows. t counts from t_i, so that a shift of t_i shifts t and changes no other digit.
    pub(super) fn run<'o>(
        &self,
        settings: &Settings,
        observer: Option<Observer<'o, S, Metric<S>>>,
    ) -> Run<'o, S, Metric<S>> {
        Run::new(self.place.clone(), Some((0, self.t_i)), self.gamma_i, settings, observer)
    }
}

/// A start in the coordinates t and x as initial data.
pub(super) fn initial_data<S: Real>(start: &Start<S>) -> InitialData<S> {
    InitialData { t: start.q[0], x: start.q[1], t_dot: start.q_dot[0], x_dot: start.q_dot[1] }
}

/// How a world-line is computed, in one coordinate and in scenes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// The operator.
    pub sbp: SbpName,
    /// The form of the action.
    pub form: Form,
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
    /// The accuracy for which operator and windows are chosen, if they are to be: the operator, the form, the number of
    /// nodes and of windows say nothing then. Such a solve is one of the physical limit in `f64`. It is the error
    /// allowed, in a coordinate that is counted from its start relative to max(1, its largest change), in the others to
    /// max(1, their largest size).
    pub accuracy: Option<f64>,
}

impl Settings {
    /// Whether more digits are asked for than `f64` has.
    pub fn is_extended(&self) -> bool {
        self.digits > f64::MOST_DIGITS
    }

    /// The same with at most as many digits as `S` has.
    pub fn within<S: Real>(self) -> Self {
        Self { digits: self.digits.min(S::MOST_DIGITS), ..self }
    }
}

/// Everything that a solver is told. The numbers are valid: enough nodes for the operator, an end after the start.
#[derive(Debug, Clone)]
pub struct Setup<S = f64> {
    /// What is looked for.
    pub scene: Scene<S>,
    /// The same in `f64`, where first guesses and linear algebra work.
    pub rough: Scene,
    /// D̄ (true) or D (false) in the action.
    pub regularised: bool,
    /// How it is computed.
    pub settings: Settings,
}

impl<S: Real> Setup<S> {
    /// The same in `f64`.
    pub(super) fn in_f64(&self) -> Setup {
        Setup {
            scene: self.rough.clone(),
            rough: self.rough.clone(),
            regularised: self.regularised,
            settings: self.settings.within::<f64>(),
        }
    }
}
