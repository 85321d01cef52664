//! Sweeps over operators and numbers of nodes: errors against the reference trajectory, and their slopes.
//!
//! ```
//! use geodesic_ivp::Case;
//! use geodesic_ivp::case::{Form, SbpName, builtin};
//! use geodesic_ivp::study::convergence::{Quantity, Sweep};
//!
//! let case = Case::parse("linear", builtin::text("linear").expect("it is built in"), &[])?;
//! let scheme = (SbpName::Sbp21, Form::Strong);
//! let convergence = Sweep::<f64>::new(&case, &[scheme], &[32, 64, 128])?.run(&|_, _| ());
//! let slopes = convergence.slopes((0, usize::MAX));
//! let of_x = slopes.iter().find(|slope| slope.quantity == Quantity::EPS_X_FINAL).expect("it is measured");
//! assert!((of_x.fit.as_ref().expect("three grids").slope - 2.0).abs() < 0.01);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod fit;
pub mod paper;
mod slope;
mod sweep;

pub use slope::Slope;
pub use sweep::Sweep;

use crate::case::{Form, SbpName};
use crate::number::norm::larger;
use crate::reference::ReferenceEnds;
use crate::solve::Status;

/// The measured errors on one grid, in the units of the coordinates.
#[derive(Debug, Clone, PartialEq)]
pub struct Errors {
    /// |q_N − q(γ_f)| of every coordinate.
    pub at_end: Vec<f64>,
    /// ((q − q(γ))ᵀ H (q − q(γ)))^½ of every coordinate.
    pub l2: Vec<f64>,
    /// ΔQ_t at the last node; in a scene, the largest |Δp_a| at the last node of a window, of every charge.
    pub charges_last: Vec<f64>,
    /// max |ΔK| over all nodes but the last of each window (weak form: over all).
    pub delta_k_max: f64,
}

/// One grid of the sweep.
#[derive(Debug, Clone, PartialEq)]
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
    /// The status with which the solve ended.
    pub status: Status,
}

/// A quantity whose slope is fitted: the error of a coordinate, or the largest of all, at γ_f or in the L2 norm.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Quantity {
    /// The coordinate, by its place; all of them if there is none.
    pub coordinate: Option<usize>,
    /// True if it is an error at γ_f.
    pub is_at_end: bool,
}

#[allow(missing_docs)] // Named as in the files, for one coordinate and for the largest error of several.
impl Quantity {
    pub const EPS_T_FINAL: Self = Self::new(Some(0), true);
    pub const EPS_X_FINAL: Self = Self::new(Some(1), true);
    pub const EPS_T_L2: Self = Self::new(Some(0), false);
    pub const EPS_X_L2: Self = Self::new(Some(1), false);
    pub const LARGEST_FINAL: Self = Self::new(None, true);
    pub const LARGEST_L2: Self = Self::new(None, false);

    const fn new(coordinate: Option<usize>, is_at_end: bool) -> Self {
        Self { coordinate, is_at_end }
    }

    /// Those of so many coordinates, in the order of the files. A case of one coordinate has two: t and x.
    pub fn all(coordinates: usize) -> Vec<Self> {
        [true, false].into_iter().flat_map(|at_end| (0..coordinates).map(move |a| Self::new(Some(a), at_end))).collect()
    }

    /// The name used in files, with these names of the coordinates.
    pub fn name(self, coordinates: &[String]) -> String {
        let of = self.coordinate.map_or("largest", |a| coordinates[a].as_str());
        format!("eps_{of}_{}", if self.is_at_end { "final" } else { "l2" })
    }

    /// The symbol used in pictures.
    pub fn symbol(self, coordinates: &[String]) -> String {
        let of = self.coordinate.map_or(String::new(), |a| format!("_{}", coordinates[a]));
        format!("ε{of}({})", if self.is_at_end { "γ_f" } else { "L2" })
    }

    /// Its value.
    pub fn of(self, errors: &Errors) -> f64 {
        self.pick(if self.is_at_end { &errors.at_end } else { &errors.l2 })
    }

    /// The value of its coordinate, or the largest.
    fn pick(self, values: &[f64]) -> f64 {
        self.coordinate.map_or_else(|| values.iter().copied().fold(0.0, larger), |a| values[a])
    }
}

/// The reference against which the errors are measured.
#[derive(Debug, Clone, PartialEq)]
pub struct ReferenceInfo<S = f64> {
    /// Its estimate of its own relative error.
    pub error_estimate: f64,
    /// Number of Taylor steps.
    pub steps: usize,
    /// γ_f.
    pub gamma_final: S,
    /// The coordinates at γ_f.
    pub end: Vec<S>,
    /// The size that errors of each coordinate are compared with: its largest absolute value at a node of the finest
    /// grid; of t and of the ignorable coordinates of a scene the largest distance from the start. In a scene
    /// coordinates with the same g_aa at the start share the largest.
    pub sizes: Vec<f64>,
}

/// The whole sweep.
#[derive(Debug, Clone)]
pub struct Convergence<S = f64> {
    /// The grids that were finished: operators in the requested order, then N ascending.
    pub points: Vec<ConvergencePoint>,
    /// The reference with which they are compared.
    pub reference: ReferenceInfo<S>,
    /// The names of the coordinates.
    pub coordinates: Vec<String>,
    /// The names of those whose momenta are charges.
    pub charges: Vec<String>,
    /// Digits of the arithmetic, from which the level of rounding follows.
    pub digits: u32,
    /// True if not all grids of the sweep are done.
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
