//! Independent checks of a solution. They use its nodes, the operator and the metric, and never call a solver.
//!
//! ```
//! use geodesic_ivp::case::builtin;
//! use geodesic_ivp::diagnostics::Diagnostics;
//! use geodesic_ivp::{Case, Solution, solve};
//!
//! let text = builtin::text("quartic").expect("it is built in");
//! let case = Case::parse("quartic", text, &["grid.gamma_f=100.0".to_owned(), "grid.n_gamma=2001".to_owned()])?;
//! let solution: Solution = solve(&case)?;
//! let measures = Diagnostics::new(&solution).measures;
//!
//! // Q_t is exact, and the trajectory is worth nothing: K tells.
//! assert!(measures.max_abs_delta_q_t_interior < 1e-12);
//! assert!(measures.max_abs_delta_k > 0.4);
//! assert!(measures.warnings(&solution).iter().any(|warning| warning.contains("K drifts")));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod bound;
mod charges;
mod measures;
mod newtonian;
mod residuals;
mod rows;
mod sawtooth;
mod scales;
pub mod scene;
mod warnings;

pub use bound::Bound;
pub use charges::{Charges, FreeParticleCharges};
pub use measures::Measures;
pub use newtonian::{NEGLIGIBLE, Newtonian};
pub use residuals::GeodesicResiduals;
pub use sawtooth::{Sawtooth, sawtooth};
pub use scales::Scales;

use std::iter::repeat;

use self::rows::{derivative, handed_on};
use crate::action::Form;
use crate::scalar::Real;
use crate::solve::Solution;

/// Everything that is measured on a solution.
#[derive(Debug, Clone)]
pub struct Diagnostics<S = f64> {
    /// Dt on the nodes; D̄t in the weak form. In the strong form the value at the last node of a window is not a
    /// velocity, see [`Self::tangent`].
    pub t_dot: Vec<S>,
    /// Dx on the nodes; D̄x in the weak form. The same holds for the last node of a window.
    pub x_dot: Vec<S>,
    /// ΔQ_t, its corrected form and ΔK.
    pub charges: Charges<S>,
    /// ΔGᵗ and ΔGˣ.
    pub residuals: GeodesicResiduals<S>,
    /// The extremes of all of these, H_BVP and its bound.
    pub measures: Measures<S>,
}

impl<S: Real> Diagnostics<S> {
    /// Measures `solution`.
    pub fn new(solution: &Solution<S>) -> Self {
        let t_dot = derivative(solution.grids(), &solution.elapsed, repeat(S::ZERO));
        let x_dot = derivative(solution.grids(), &solution.x, solution.windows.iter().map(|window| window.start.x));
        let metric = solution.metric.sample(&solution.x).expect("a solution lies inside the domain");
        let charges = Charges::new(solution, &metric.g00, &t_dot, &x_dot);
        let residuals = GeodesicResiduals::new(solution, &metric, &t_dot, &x_dot);
        let measures = Measures::new(solution, &metric, [&t_dot, &x_dot], &charges, &residuals);
        Self { t_dot, x_dot, charges, residuals, measures }
    }

    /// dt/dγ and dx/dγ on the nodes: Dt and Dx, except at the last node of a window in the strong form. There the row
    /// of D takes up the defect of D and does not give a velocity. Its place is taken by the values that the next
    /// window continues with, Q_t/g00(x_N) and w*_N.
    pub fn tangent(&self, solution: &Solution<S>) -> [Vec<S>; 2] {
        let rows = [self.t_dot.clone(), self.x_dot.clone()];
        if solution.form == Form::Weak {
            return rows;
        }
        let [t_dot, x_dot] = rows;
        let q_t = solution.end.q_t;
        let t_ends = solution.grids().map(|grid| q_t / solution.metric.at(solution.x[grid.last()][0]).g00);
        let x_ends = solution.windows.iter().map(|window| window.end.x_dot);
        [handed_on(solution.grids(), t_dot, t_ends), handed_on(solution.grids(), x_dot, x_ends)]
    }
}
