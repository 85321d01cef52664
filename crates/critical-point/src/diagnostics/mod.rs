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
mod deviations;
pub mod gaps;
mod measures;
mod newtonian;
mod residuals;
mod rows;
mod sawtooth;
mod scales;
pub mod scene;
pub mod verdict;
mod warnings;

pub use bound::Bound;
pub use charges::{Charges, FreeParticleCharges};
pub use deviations::{ChargeDeviation, NormDeviation};
pub use measures::Measures;
pub use newtonian::{NEGLIGIBLE, Newtonian};
pub use residuals::GeodesicResiduals;
pub use sawtooth::{Sawtooth, sawtooth};
pub use scales::Scales;

use self::deviations::{Fields, tangent};
use self::scene::SceneDiagnostics;
use self::verdict::Reason;
use crate::geometry::Observable;
use crate::scalar::Real;
use crate::solve::{Solution, WorldLine};

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

impl<S: Diagnosed> Diagnostics<S> {
    /// Measures `solution`.
    pub fn new(solution: &Solution<S>) -> Self {
        S::diagnostics(solution)
    }

    /// dt/dγ and dx/dγ on the nodes: Dt and Dx, except at the last node of a window in the strong form. There the row
    /// of D takes up the defect of D and does not give a velocity. Its place is taken by the values that the next
    /// window continues with, Q_t/g00(x_N) and w*_N.
    pub fn tangent(&self, solution: &Solution<S>) -> [Vec<S>; 2] {
        S::tangent(self, solution)
    }
}

impl<S: Real> Diagnostics<S> {
    fn new_here(solution: &Solution<S>) -> Self {
        let fields = Fields::new(solution);
        let (charge, norm) = (fields.charge(vec![(0, S::ONE)]), fields.norm());
        let residuals = GeodesicResiduals { delta_g_t: fields.residual(0), delta_g_x: fields.residual(1) };
        let measures = Measures::new(&fields, &charge, &norm, &residuals);
        let [t_dot, x_dot] = <[Vec<S>; 2]>::try_from(fields.velocities).expect("there are t and x");
        let charges = Charges {
            delta_q_t: charge.delta,
            delta_q_t_corrected: charge.corrected,
            delta_k: norm.delta,
            delta_k_ends: norm.ends,
        };
        Self { t_dot, x_dot, charges, residuals, measures }
    }

    fn tangent_here(&self, solution: &Solution<S>) -> [Vec<S>; 2] {
        [tangent(solution, 0, &self.t_dot), tangent(solution, 1, &self.x_dot)]
    }
}

crate::compiled! {
    /// Numbers in which runs are measured.
    pub trait Diagnosed {
        fn diagnostics(solution: &Solution<Self>) -> Diagnostics<Self> = Diagnostics::new_here;
        fn tangent(this: &Diagnostics<Self>, solution: &Solution<Self>) -> [Vec<Self>; 2] = Diagnostics::tangent_here;
        fn scene_diagnostics(
            line: &WorldLine<Self>,
            sums: &[Vec<(usize, Self)>],
            invariants: &mut [(String, Observable<Self>)],
            is_lifted: bool,
        ) -> SceneDiagnostics<Self> = SceneDiagnostics::new_here;
        fn suspicions_of_scene(
            this: &SceneDiagnostics<Self>,
            line: &WorldLine<Self>,
        ) -> Vec<Reason> = SceneDiagnostics::suspicions_here;
        fn suspicions(this: &Measures<Self>, solution: &Solution<Self>) -> Vec<Reason> = Measures::suspicions_here;
        fn measures_followed_by(
            this: Measures<Self>,
            next: Measures<Self>,
        ) -> Measures<Self> = Measures::followed_by_here;
    }
}
