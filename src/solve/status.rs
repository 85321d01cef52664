//! The ways in which a solve can end. Each has its own variant, and no failure carries a trajectory.

use std::fmt;

use serde::{Deserialize, Serialize};

/// The most nodes that a run to an accuracy keeps in memory: with everything that is measured on them, about 110 bytes
/// each.
pub(super) const MOST_NODES: f64 = 5e7;

/// The most sweeps that a run may need: a day. At its pace a run that needs more is ended early.
pub(super) const MOST_SWEEPS: f64 = 1e12;

/// The most events that may act in a run.
pub(crate) const MOST_EVENTS: usize = 100_000;

/// The outcome of a solve.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Status {
    /// The residual is at the rounding level and the last step was small: a critical point.
    Converged,
    /// The residual is not at the rounding level after the allowed number of iterations.
    MaxIterations,
    /// No step length along the Newton direction reduces the residual.
    Stalled,
    /// The Hessian or Jacobian is singular to working precision.
    Singular,
    /// The geodesic, or every trial step, meets g00 ≤ 0 or a point where V is not finite.
    OutsideDomain,
    /// Refinement beyond `f64` does not reach the digits asked for.
    PrecisionNotReached,
    /// The requested accuracy is beyond what the arithmetic can keep on this run.
    AccuracyNotReached,
    /// The requested physical time t_f is not reached by any γ_f tried.
    EndTimeNotReached,
    /// The run makes too little progress for the number of force evaluations that it takes.
    EvaluationLimit,
    /// The run would have more nodes than memory holds.
    TooManyNodes,
    /// Events that act follow each other faster than rounding resolves, or there are too many of them.
    EventsPileUp,
    /// An event that acts leaves the motion at rest where its formula is zero, and forces hold it there.
    EventsRest,
}

impl Status {
    /// The name used in files.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Converged => "converged",
            Self::MaxIterations => "max-iterations",
            Self::Stalled => "stalled",
            Self::Singular => "singular",
            Self::OutsideDomain => "outside-domain",
            Self::PrecisionNotReached => "precision-not-reached",
            Self::AccuracyNotReached => "accuracy-not-reached",
            Self::EndTimeNotReached => "end-time-not-reached",
            Self::EvaluationLimit => "evaluation-limit",
            Self::TooManyNodes => "too-many-nodes",
            Self::EventsPileUp => "events-pile-up",
            Self::EventsRest => "events-rest",
        }
    }
}

impl fmt::Display for Status {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

/// One Newton iteration.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct IterationRecord {
    /// Number of the iteration, from 1.
    pub iteration: usize,
    /// Largest entry of the residual after the step (doubled: of ∇E_IVP; physical limit: of the collocation equations
    /// scaled by the size of x and w).
    pub residual: f64,
    /// Largest change of t or x (physical limit: of x or w).
    pub step: f64,
    /// Step length along the Newton direction; 1 is the full step.
    pub damping: f64,
    /// Change that the full step would make, relative to the size of its kind of coordinate: the larger of the two.
    pub relative_step: f64,
}

/// The iterations of a run, of all its windows.
#[derive(Debug, Clone, PartialEq)]
pub struct Iterations {
    /// Where the iteration started.
    pub initial_guess: InitialGuess,
    /// Their number: of Newton's method or, for the fixed-point iteration, evaluations of the force.
    pub count: usize,
    /// Those of the window that needed the most; none if the equations are explicit.
    pub history: Vec<IterationRecord>,
    /// Largest change that the last iteration of a window still made, relative to the sizes of what it changed. 0 if
    /// the equations are explicit.
    pub last_correction: f64,
}

impl Iterations {
    /// Those of one window.
    pub(super) fn of(initial_guess: InitialGuess, history: Vec<IterationRecord>) -> Self {
        let mut iterations = Self { initial_guess, count: 0, history: Vec::new(), last_correction: 0.0 };
        iterations.add(initial_guess, history);
        iterations
    }

    /// Adds those of the next window.
    pub(super) fn add(&mut self, initial_guess: InitialGuess, history: Vec<IterationRecord>) {
        self.initial_guess = initial_guess;
        self.count += history.len();
        self.last_correction = self.last_correction.max(history.last().map_or(0.0, |last| last.relative_step));
        if history.len() > self.history.len() {
            self.history = history;
        }
    }
}

/// Where Newton's iteration started.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum InitialGuess {
    /// No iteration: the equations are explicit and were marched.
    None,
    /// Steps of a Runge-Kutta method from node to node.
    Steps,
    /// Windows of the engine, as long as the motion allows, looked at on the nodes.
    Engine,
    /// The critical point with equal branches, where Newton's method for the doubled action failed from the guess.
    PhysicalLimit,
    /// The polynomial of the previous window, continued into each window (in the first a parabola).
    Extrapolation,
}
