//! How a solve can end. Termination is data: every way has its own variant, and none of the bad ones carries a
//! trajectory.

use std::fmt;

use serde::{Deserialize, Serialize};

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
    /// The accuracy asked for is beyond what the arithmetic can keep on this run.
    AccuracyNotReached,
    /// The asked-for physical time t_f is not reached by any γ_f tried.
    EndTimeNotReached,
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
    /// In every window the polynomial of the window before, continued (in the first a parabola).
    Extrapolation,
}

impl InitialGuess {
    /// The name used in files.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::WindowedAction => "windowed-action",
            Self::Nystrom4 => "nystrom4",
            Self::Extrapolation => "extrapolation",
        }
    }
}

/// No critical point: why, and where the solve stood.
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
    /// Largest residual entry at the last accepted iterate (infinite if none was accepted).
    pub residual: f64,
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
struct Compact(f64);

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

impl NoSolution {
    /// What to try next.
    pub fn advice(&self) -> &'static str {
        match self.status {
            Status::Converged => "",
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
            Status::AccuracyNotReached => {
                "ask for less solver.accuracy or a shorter run; with scheme and grid given, solver.digits goes further"
            }
            Status::Stalled | Status::Singular => {
                "raise n_gamma or windows (or shorten gamma_f) so that every turn of the motion is resolved, or try another operator; \
                 far from 1, choose units nearer to it"
            }
        }
    }
}
