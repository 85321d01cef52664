//! How a solve can end. Termination is data: every way has its own variant, and no failure carries a trajectory.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::lobatto::MOST_EVALUATIONS;

/// The most nodes that a run to an accuracy keeps in memory: with everything that is measured on them, about 110 bytes
/// each.
pub(super) const MOST_NODES: f64 = 5e7;

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

/// Where Newton's iteration started.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum InitialGuess {
    /// No iteration: the equations are explicit and were marched.
    None,
    /// Short world-lines laid end to end, each the critical point of its own small doubled action, found from a
    /// straight line.
    WindowedAction,
    /// The fourth-order Nyström integrator on the geodesic equation, on the same nodes.
    Nystrom4,
    /// The classical Runge–Kutta method of order four on Hamilton's equations, on the same nodes.
    #[serde(rename = "runge-kutta4")]
    RungeKutta4,
    /// The polynomial of the previous window, continued into each window (in the first a parabola).
    Extrapolation,
}

impl InitialGuess {
    /// The name used in files.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::WindowedAction => "windowed-action",
            Self::Nystrom4 => "nystrom4",
            Self::RungeKutta4 => "runge-kutta4",
            Self::Extrapolation => "extrapolation",
        }
    }
}

/// The reason why there is no critical point, and where the solve stood.
#[derive(Debug, Clone, PartialEq)]
pub struct NoSolution {
    /// Any status but [`Status::Converged`].
    pub status: Status,
    /// γ of the node where it failed: of the point outside the domain, otherwise of the largest residual entry.
    pub gamma: f64,
    /// x there.
    pub x: f64,
    /// g00 there.
    pub g00: f64,
    /// Iterations done.
    pub iteration: usize,
    /// Largest residual entry at the last accepted iterate (infinite if none was accepted); the estimated error where
    /// an accuracy is not reached.
    pub residual: f64,
    /// What a run beyond a limit would need: nodes, or evaluations of the force. It is 0 for every other status.
    pub needed: f64,
    /// Whether an accuracy was asked for, so that windows and operator were not the user's to choose.
    pub adaptive: bool,
    /// The iterations.
    pub history: Vec<IterationRecord>,
    /// Where they started.
    pub initial_guess: InitialGuess,
}

impl fmt::Display for NoSolution {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { gamma, x, g00, iteration, residual, .. } = self;
        match self.status {
            Status::OutsideDomain => {
                let (gamma, x) = (Compact(*gamma), Compact(*x));
                write!(
                    f,
                    "the geodesic leaves the domain at gamma = {gamma}, x = {x}: g00 = {g00:.3e} (iteration {iteration}"
                )?;
                // Where the equations are explicit, or the first guess already leaves, there is no residual.
                if residual.is_finite() { write!(f, ", residual {residual:.2e})") } else { write!(f, ")") }
            }
            Status::EndTimeNotReached => {
                let (gamma, x) = (Compact(*gamma), Compact(*x));
                write!(f, "the physical time t_f is not reached: the search ended at gamma = {gamma}, x = {x}")
            }
            Status::AccuracyNotReached => {
                let gamma = Compact(*gamma);
                write!(f, "the accuracy is not reached: the estimated error is {residual:.1e} at gamma = {gamma}")
            }
            Status::EvaluationLimit => {
                let (gamma, x, needed) = (Compact(*gamma), Compact(*x), self.needed);
                write!(
                    f,
                    "stopped after {iteration} evaluations of the force at gamma = {gamma}, x = {x}: at this pace the run needs \
                     {needed:.1e} of them, above the limit of {MOST_EVALUATIONS:.0e}"
                )
            }
            Status::TooManyNodes => {
                let (gamma, needed) = (Compact(*gamma), self.needed);
                write!(
                    f,
                    "stopped at gamma = {gamma}: the run would have {needed:.1e} nodes, above the limit of {MOST_NODES:.0e} that \
                     are kept in memory"
                )
            }
            status if self.adaptive => {
                let (gamma, x) = (Compact(*gamma), Compact(*x));
                write!(
                    f,
                    "no critical point found ({status}): no window, however short, converges at gamma = {gamma}, x = {x}"
                )
            }
            status => write!(
                f,
                "no critical point found ({status}) after {iteration} iterations: largest residual {residual:.2e} at gamma = {}, x = {}",
                Compact(*gamma),
                Compact(*x)
            ),
        }
    }
}

impl std::error::Error for NoSolution {}

/// A number for a message: six decimals, or an exponent where those would be noise or a long row of zeros.
pub(super) struct Compact(pub(super) f64);

impl fmt::Display for Compact {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let size = self.0.abs();
        if size == 0.0 || (1e-3..1e9).contains(&size) {
            write!(f, "{:.6}", self.0)
        } else {
            write!(f, "{:.6e}", self.0)
        }
    }
}

/// What to do where g00 is NaN.
const V_IS_NO_NUMBER: &str = "V is not a number there, as a root, a logarithm or a fractional power of a negative number \
                              is none: write the formula so that V exists everywhere (abs(x)), or end the run before";

/// A residual below this is rounding where units are of the order of 1.
const AT_ROUNDING: f64 = 1e-13;

impl NoSolution {
    /// What to try next.
    pub fn advice(&self) -> &'static str {
        if self.adaptive {
            return self.advice_to_an_accuracy();
        }
        match self.status {
            Status::Converged => "",
            Status::MaxIterations | Status::Stalled if self.residual < AT_ROUNDING => {
                "the residual is at the level of rounding, so more iterations would not help: the grid hardly determines the \
                 motion; raise n_gamma or windows, or give solver.accuracy in place of [scheme] and n_gamma"
            }
            Status::OutsideDomain if self.g00.is_nan() => V_IS_NO_NUMBER,
            Status::OutsideDomain => {
                "g00 = c^2 + 2V/m must stay positive: end the run before this gamma, choose initial data that stay away \
                 from the horizon, or raise c; if the potential is harmless there, the step is too coarse: raise \
                 n_gamma or windows"
            }
            Status::EndTimeNotReached => {
                "raise n_gamma or windows, so that every turn of the motion is resolved, or give gamma_f or an earlier t_f"
            }
            Status::MaxIterations => {
                "raise solver.max_iterations, or n_gamma or windows so that every turn of the motion is resolved"
            }
            Status::PrecisionNotReached => {
                "ask for fewer solver.digits; if f64 is in difficulties too (solver.digits = 16), raise n_gamma or windows so that \
                 every turn of the motion is resolved"
            }
            Status::AccuracyNotReached | Status::EvaluationLimit | Status::TooManyNodes => self.advice_to_an_accuracy(),
            Status::Stalled | Status::Singular => {
                "raise n_gamma or windows (or shorten gamma_f) so that every turn of the motion is resolved, or try another operator; \
                 far from 1, choose units nearer to it"
            }
        }
    }

    /// The same where the program chooses the windows: there is no n_gamma to raise.
    fn advice_to_an_accuracy(&self) -> &'static str {
        match self.status {
            Status::Converged => "",
            Status::OutsideDomain if self.g00.is_nan() => V_IS_NO_NUMBER,
            Status::OutsideDomain => {
                "g00 = c^2 + 2V/m must stay positive: end the run before this gamma, choose initial data that stay away \
                 from the horizon, or raise c"
            }
            Status::EndTimeNotReached => "give gamma_f or an earlier t_f: t hardly grows any more, or jumps over it",
            Status::EvaluationLimit => {
                "end the run before this gamma, or look at V there: it changes on a scale that windows cannot resolve"
            }
            Status::TooManyNodes => {
                "take samples in place of the tables (run --sample-t or --sample-gamma with --samples-only), or end the run earlier"
            }
            Status::AccuracyNotReached | Status::PrecisionNotReached => {
                "ask for a larger solver.accuracy, or a shorter run; with scheme and grid given, solver.digits goes further"
            }
            Status::MaxIterations | Status::Stalled | Status::Singular => {
                "end the run before this gamma, or look at V there: it is not smooth enough for an accuracy; far from 1, choose \
                 units nearer to it"
            }
        }
    }
}
