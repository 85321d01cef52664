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
mod g00;
pub mod gaps;
mod measures;
mod newtonian;
mod rows;
mod sawtooth;
mod scales;
pub mod scene;
pub mod verdict;
mod warnings;

pub use bound::Bound;
pub use charges::FreeParticleCharges;
pub use deviations::{ChargeDeviation, NormDeviation};
pub use measures::Measures;
pub use newtonian::{NEGLIGIBLE, Newtonian};
pub use sawtooth::{Sawtooth, sawtooth};
pub use scales::Scales;

use std::borrow::Cow;

use self::deviations::{Fields, tangent};
use self::scene::InvariantDeviation;
use crate::number::Real;
use crate::number::norm::max_abs;
use crate::solve::WorldLine;

/// Everything that is measured on a run. `M` is what one kind of space-time has alone: [`Measures`] for t and x,
/// [`SceneMeasures`](scene::SceneMeasures) elsewhere.
#[derive(Debug, Clone)]
pub struct Diagnostics<S: Real = f64, M = Measures<S>> {
    /// Dq^a on the nodes, for every coordinate; D̄q^a in the weak form. In the strong form the value at the last node
    /// of a window is not a velocity, see [`Self::tangent`].
    pub q_dot: Vec<Vec<S>>,
    /// The charges of the ignorable coordinates, in order. That of t in one coordinate is ΔQ_t = g00(x)∘(Dt) − Q_t, the
    /// paper's ΔE.
    pub charges: Vec<ChargeDeviation<S>>,
    /// Conserved sums of the momenta of active coordinates.
    pub sums: Vec<ChargeDeviation<S>>,
    /// ΔG_a = (Dp_a) − f_a − F_a of every coordinate; in the weak form with D̄ and the initial momenta. For a
    /// coordinate of a potential, whose g_aa is constant, it is divided by that: a deviation of d²q^a/dγ². In one
    /// coordinate these are ΔGᵗ = D( g00(x)∘Dt ) and ΔGˣ = DDx + ½ g00′(x)∘(Dt)².
    pub delta_g: Vec<Vec<S>>,
    /// Largest |ΔG_a| over the nodes whose row of D does not reach the last node of the window (weak: all nodes).
    pub max_delta_g: S,
    /// K and its deviation.
    pub norm: NormDeviation<S>,
    /// In the lift of Newton's law: the energy ½mv² + V of the computed positions and velocities minus the charge
    /// p_t/p_s, which is −K/(2 ṫ p_s).
    pub delta_energy: Option<Vec<S>>,
    /// The invariants of the user, in their order.
    pub invariants: Vec<InvariantDeviation<S>>,
    /// What is measured in this kind of space-time alone.
    pub measures: M,
}

impl<S: Real, M> Diagnostics<S, M> {
    /// With the deviations of these `sums`; `measures` is what finds the rest.
    fn of(
        fields: Fields<'_, S>,
        sums: &[Vec<(usize, S)>],
        measures: impl FnOnce(&Fields<'_, S>, &Common<'_, S>) -> M,
    ) -> Self {
        let (active, n) = (fields.run.geometry().active(), fields.velocities.len());
        let charge = |terms: Vec<(usize, S)>| fields.charge(terms);
        let charges: Vec<_> = (0..n).filter(|a| !active.contains(a)).map(|a| charge(vec![(a, S::ONE)])).collect();
        let sums = sums.iter().map(|terms| charge(terms.clone())).collect();
        let norm = fields.norm();
        let delta_g: Vec<Vec<S>> = (0..n).map(|a| fields.residual(a)).collect();
        let max_delta_g = max_abs(&delta_g.iter().map(|row| fields.max_residual(row)).collect::<Vec<_>>());
        let measures = measures(&fields, &Common { charges: &charges, norm: &norm, max_delta_g });
        let (delta_energy, invariants) = (None, Vec::new());
        let q_dot = fields.velocities;
        Self { q_dot, charges, sums, delta_g, max_delta_g, norm, delta_energy, invariants, measures }
    }

    /// dq^a/dγ of every coordinate on the nodes: Dq^a, except at the last node of a window in the strong form. There
    /// the row of D takes up the defect of D and does not give a velocity. Its place is taken by what the next window
    /// continues with.
    pub fn tangent(&self, run: &WorldLine<S>) -> Vec<Cow<'_, [S]>> {
        self.q_dot.iter().enumerate().map(|(a, row)| tangent(run, a, row)).collect()
    }
}

/// What is measured in every space-time.
struct Common<'c, S> {
    charges: &'c [ChargeDeviation<S>],
    norm: &'c NormDeviation<S>,
    max_delta_g: S,
}
