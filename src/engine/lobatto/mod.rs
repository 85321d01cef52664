//! World-lines by windows of the weak scheme on Gauss–Lobatto nodes, at speed.
//!
//! With v = g00 D̄t and w = D̄x the weak (multiplier-free) form of the action has Q_t exactly constant at all nodes,
//! and its critical point on one window of length h with n Gauss–Lobatto nodes is
//!
//! ```text
//! X = x + h c w + h² A² a(X),      a = −½ g00′(X) u²,   u = Q_t/g00(X),      A = D̄⁻¹ = (D + H⁻¹E_0)⁻¹
//! x⁺ = x + h w + h² Σ b_j (1 − c_j) a_j,     w⁺ = w + h Σ b_j a_j,     t⁺ = t + h Σ b_j u_j
//! ```
//!
//! the Lobatto IIIC Runge–Kutta method (Chipman 1971; Hairer, Wanner, "Solving Ordinary Differential Equations II",
//! IV.5): L-stable and of order 2n − 2 at the ends of windows. *Inside* a window the scheme's own nodal values are less
//! accurate; [`WindowView::inside`] is of order n + 1 there for the price of a few sweeps of the iteration,
//! `sampling` continues the start of a window to points in it as accurately as to its end.
//!
//! X is found by iterating the first line. Where V calls functions (exp, cos, …) an evaluation of all nodes costs more
//! than the product with A²: there Newton's method takes three evaluations in place of eight, with the iteration for
//! its linear systems, unless the march goes to rounding.
//!
//! [`March`] walks windows of one length, [`Adaptive`] chooses rules and lengths for an accuracy asked for. With
//! s = γ/h a window has length 1, for h Q_t and h w in place of Q_t and w: one set of tables serves all lengths. To
//! rounding a march takes tables of its own length, as the rounding of h Q_t would be the same in every window. Both
//! follow Hairer, McLachlan, Razakarivony (2008), "Achieving Brouwer's law with implicit Runge–Kutta methods", where it
//! matters for long runs: the tables are computed to 30 digits and rounded so that their sums stay right, states are
//! unevaluated sums of two numbers, and what goes to rounding is summed as if in twice the precision. Over 4·10⁶
//! windows K then moves like a random walk of 1e-18 a window.
//!
//! What a window does not see between its nodes is looked at by interval arithmetic on the formulas (see `enclosure`).
//!
//! The iteration runs on contiguous arrays with the vector instructions that the machine has ([`Level`]).

mod adaptive;
mod attempt;
mod certificate;
mod control;
mod dense;
mod enclosed;
pub mod flow;
mod force;
mod formula;
mod guess;
mod hit;
mod judge;
mod kit;
mod march;
mod newton;
mod one;
mod pace;
mod probe;
mod product;
mod rule;
mod tables;
mod unit;
mod view;
mod walk;
mod window;

pub use crate::number::vector::{Level, Twofold};
pub use adaptive::{Adapted, Adaptive};
pub use march::{March, Marched};
pub use pace::MOST_EVALUATIONS;
pub use rule::WeakRule;
pub use view::{Certified, Inside, WindowView};

use crate::geometry::geodesic::InitialData;

/// What one window hands to the next; each quantity is an unevaluated sum.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct State {
    /// t.
    pub t: Twofold,
    /// x.
    pub x: Twofold,
    /// w = dx/dγ.
    pub w: Twofold,
}

impl From<InitialData> for State {
    fn from(initial: InitialData) -> Self {
        Self { t: initial.t.into(), x: initial.x.into(), w: initial.x_dot.into() }
    }
}

/// Where an adaptive march ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Goal {
    /// At γ − γ_i = this.
    Gamma(f64),
    /// At t − t_i = this, to the last bit.
    Time(f64),
}

/// The work done by a march.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Statistics {
    /// Windows that were accepted.
    pub windows: usize,
    /// Evaluations of the force on all nodes of a window.
    pub evaluations: usize,
    /// Windows that were accepted although something steep may hide between their nodes.
    pub unproved: usize,
}

/// Why a march ends early.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum MarchFailure {
    /// The world-line meets g00 ≤ 0 or a point where V is not finite.
    #[error("the geodesic leaves the domain at gamma - gamma_i = {gamma:.6}, x = {x:.6e}, g00 = {g00:.3e}")]
    OutsideDomain {
        /// Index of the window.
        window: usize,
        /// γ − γ_i, to about a hundredth of a window.
        gamma: f64,
        /// x there.
        x: f64,
        /// g00 there.
        g00: f64,
    },
    /// The iteration does not converge: the window is too long for the force.
    #[error("window {window} at gamma - gamma_i = {gamma:.6}, x = {x:.6e} does not converge: it is too long")]
    NotConverged {
        /// Index of the window.
        window: usize,
        /// γ − γ_i at its start.
        gamma: f64,
        /// x there.
        x: f64,
    },
    /// The requested accuracy is beyond what the arithmetic can keep on a run of this length.
    #[error("the accuracy is not reached: the error is about {estimate:.1e} at gamma - gamma_i = {gamma:.6}")]
    AccuracyNotReached {
        /// γ − γ_i where that was found.
        gamma: f64,
        /// The estimated error there, relative to max(1, |t|) and max(1, |x|).
        estimate: f64,
    },
    /// The march makes so little progress that it would need more evaluations of the force than [`MOST_EVALUATIONS`].
    #[error(
        "no progress after {evaluations} evaluations of the force, at gamma - gamma_i = {gamma:.6e}: {needed:.0e} \
         would be needed, above the limit of {MOST_EVALUATIONS:.0e}"
    )]
    EvaluationLimit {
        /// γ − γ_i where it was stopped.
        gamma: f64,
        /// x there.
        x: f64,
        /// Evaluations so far, each on all nodes of a window.
        evaluations: usize,
        /// How many it would need at its pace; infinite if it has not moved.
        needed: f64,
    },
    /// The requested physical time is not reached: t hardly grows any more.
    #[error("the time asked for is not reached: t - t_i = {elapsed:.6e} at gamma - gamma_i = {gamma:.6e}")]
    TimeNotReached {
        /// γ − γ_i where the search ended.
        gamma: f64,
        /// t − t_i there.
        elapsed: f64,
    },
}
