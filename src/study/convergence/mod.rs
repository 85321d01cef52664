//! Sweeps over operators and numbers of nodes: errors against the reference trajectory, and their slopes.

pub mod fit;
pub mod paper;
mod slope;
mod sweep;

use serde::Serialize;

pub use slope::Slope;
pub use sweep::{Sweep, errors, sweep};

use crate::case::{Form, SbpName};
use crate::reference::ReferenceEnds;
use crate::solve::Status;

/// The measured errors on one grid, in the units of t and x.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Errors {
    /// |t_N − t(γ_f)|.
    pub eps_t_final: f64,
    /// |x_N − x(γ_f)|.
    pub eps_x_final: f64,
    /// ((t − t(γ))ᵀ H (t − t(γ)))^½.
    pub eps_t_l2: f64,
    /// ((x − x(γ))ᵀ H (x − x(γ)))^½.
    pub eps_x_l2: f64,
    /// ΔQ_t at the last node.
    pub delta_q_t_last: f64,
    /// max |ΔK| over all nodes but the last of each window (weak form: over all).
    pub delta_k_max: f64,
}

/// One grid of the sweep.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ConvergencePoint {
    /// Operator.
    pub sbp: SbpName,
    /// Form of the action.
    pub form: Form,
    /// Distinct nodes of all windows.
    pub n_gamma: usize,
    /// (Mean) spacing Δγ of the nodes.
    pub delta_gamma: f64,
    /// The errors, if the solve converged.
    pub errors: Option<Errors>,
    /// Newton iterations.
    pub iterations: usize,
    /// Seconds in the solver, while other grids are solved in parallel.
    pub seconds: f64,
    /// How the solve ended.
    pub status: Status,
}

/// The quantities whose slopes are fitted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
#[allow(missing_docs)] // Named as in `Errors`.
pub enum Quantity {
    EpsTFinal,
    EpsXFinal,
    EpsTL2,
    EpsXL2,
}

impl Quantity {
    /// All of them, in the order of the files.
    pub const ALL: [Self; 4] = [Self::EpsTFinal, Self::EpsXFinal, Self::EpsTL2, Self::EpsXL2];

    /// The name used in files.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::EpsTFinal => "eps_t_final",
            Self::EpsXFinal => "eps_x_final",
            Self::EpsTL2 => "eps_t_l2",
            Self::EpsXL2 => "eps_x_l2",
        }
    }

    /// The symbol used in pictures.
    pub fn symbol(self) -> &'static str {
        match self {
            Self::EpsTFinal => "ε_t(γ_f)",
            Self::EpsXFinal => "ε_x(γ_f)",
            Self::EpsTL2 => "ε_t(L2)",
            Self::EpsXL2 => "ε_x(L2)",
        }
    }

    /// Whether it is an error at γ_f.
    pub fn is_at_end(self) -> bool {
        matches!(self, Self::EpsTFinal | Self::EpsXFinal)
    }

    /// Its value.
    pub fn of(self, errors: &Errors) -> f64 {
        match self {
            Self::EpsTFinal => errors.eps_t_final,
            Self::EpsXFinal => errors.eps_x_final,
            Self::EpsTL2 => errors.eps_t_l2,
            Self::EpsXL2 => errors.eps_x_l2,
        }
    }
}

/// The reference against which the errors are measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReferenceInfo<S = f64> {
    /// Its estimate of its own relative error.
    pub error_estimate: f64,
    /// Number of Taylor steps.
    pub steps: usize,
    /// γ_f.
    pub gamma_final: S,
    /// t(γ_f).
    pub t_final: S,
    /// x(γ_f).
    pub x_final: S,
    /// Largest |t − t_i|: the size that errors of t are compared with.
    pub t_size: f64,
    /// Largest |x| at a node of the finest grid: the size that errors of x are compared with.
    pub x_size: f64,
}

/// The whole sweep.
#[derive(Debug, Clone)]
pub struct Convergence<S = f64> {
    /// The grids that were finished: operators in the requested order, then N ascending.
    pub points: Vec<ConvergencePoint>,
    /// The reference with which they are compared.
    pub reference: ReferenceInfo<S>,
    /// Digits of the arithmetic, from which the level of rounding follows.
    pub digits: u32,
    /// Whether the sweep was cancelled before all grids were done.
    pub interrupted: bool,
}

/// The reason why there is no sweep.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SweepError {
    /// There is no trajectory to compare with.
    #[error(transparent)]
    Reference(#[from] ReferenceEnds),
    /// A grid is not possible: too few nodes for the operator, too many, or too close.
    #[error("{0}")]
    Grid(String),
}
