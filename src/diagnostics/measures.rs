//! The most important numbers about a solution.

use super::bound::Bound;
use super::charges::FreeParticleCharges;
use super::deviations::Fields;
use super::g00::G00;
use super::newtonian::Newtonian;
use super::sawtooth::Sawtooth;
use super::scales::Scales;
use super::{Common, Diagnostics};
use crate::number::Real;
use crate::solve::Solution;

/// Extremes of the deviations over a run.
///
/// In the strong form, the *interior* nodes for Q_t and K are all but the last of each window. For ΔG they are those
/// whose row of D does not reach that last node. In the weak form all nodes are interior.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measures<S = f64> {
    /// max |ΔQ_t| over the interior nodes.
    pub max_abs_delta_q_t_interior: S,
    /// Largest |ΔQ_t| at the last node of a window.
    pub max_abs_delta_q_t_last: S,
    /// ΔQ_t at the last node of the run.
    pub delta_q_t_last: S,
    /// max |ΔQ_t + (λ7/H_N) e_N| over all nodes.
    pub max_abs_delta_q_t_corrected: S,
    /// max of |ΔGᵗ| and |ΔGˣ| over the interior nodes.
    pub max_abs_delta_g_interior: S,
    /// max |ΔK| over the interior nodes.
    pub max_abs_delta_k: S,
    /// max |ΔK| at the ends of the windows, for the values that the next window starts with.
    pub max_abs_delta_k_ends: S,
    /// Largest amplitude of the even–odd oscillation of x in a window; `None` if there are too few nodes, and for
    /// spectral elements. See [`Sawtooth`].
    pub sawtooth: Option<S>,
    /// H_BVP and its bound.
    pub bound: Bound<S>,
    /// Size, speed and frequency of the motion.
    pub scales: Scales,
    /// How far the motion is from Newton's.
    pub newtonian: Newtonian,
    /// Largest distance between the branches in t or x, if the doubled system was solved.
    pub branch_distance: Option<S>,
    /// The deviations of Q_x and Q_η, if the potential vanishes.
    pub free_particle: Option<FreeParticleCharges<S>>,
}

impl<S: Real> Measures<S> {
    /// The measures of a run, from those of its first part, `self`, and its second part, `next`.
    pub fn followed_by(self, next: Self) -> Self {
        let either = |a: Option<S>, b: Option<S>| a.into_iter().chain(b).reduce(S::max);
        Self {
            max_abs_delta_q_t_interior: self.max_abs_delta_q_t_interior.max(next.max_abs_delta_q_t_interior),
            max_abs_delta_q_t_last: self.max_abs_delta_q_t_last.max(next.max_abs_delta_q_t_last),
            delta_q_t_last: next.delta_q_t_last,
            max_abs_delta_q_t_corrected: self.max_abs_delta_q_t_corrected.max(next.max_abs_delta_q_t_corrected),
            max_abs_delta_g_interior: self.max_abs_delta_g_interior.max(next.max_abs_delta_g_interior),
            max_abs_delta_k: self.max_abs_delta_k.max(next.max_abs_delta_k),
            max_abs_delta_k_ends: self.max_abs_delta_k_ends.max(next.max_abs_delta_k_ends),
            sawtooth: either(self.sawtooth, next.sawtooth),
            bound: self.bound.followed_by(next.bound),
            scales: self.scales.followed_by(next.scales),
            newtonian: self.newtonian.followed_by(next.newtonian),
            branch_distance: either(self.branch_distance, next.branch_distance),
            free_particle: self.free_particle.zip(next.free_particle).map(|(a, b)| a.max(b)),
        }
    }
}

impl<S: Real> Diagnostics<S> {
    /// Measures `solution`.
    pub fn new(solution: &Solution<S>) -> Self {
        Self::of(Fields::new(solution), &[], Measures::new)
    }
}

impl<S: Real> Measures<S> {
    fn new(fields: &Fields<'_, S>, common: &Common<'_, S>) -> Self {
        let (solution, metric) = (fields.run, G00::new(fields.run.geometry(), &fields.samples));
        let [t_dot, x_dot] = [&fields.velocities[0], &fields.velocities[1]];
        let (charge, norm) = (&common.charges[0], common.norm);
        let sawtooth = Sawtooth::new(solution.x(), solution.grids());
        Self {
            max_abs_delta_q_t_interior: charge.max_interior,
            max_abs_delta_q_t_last: charge.max_last,
            delta_q_t_last: charge.delta.last().copied().unwrap_or(S::ZERO),
            max_abs_delta_q_t_corrected: charge.max_corrected,
            max_abs_delta_g_interior: common.max_delta_g,
            max_abs_delta_k: norm.max_interior,
            max_abs_delta_k_ends: norm.max_ends,
            sawtooth: sawtooth.amplitude,
            bound: Bound::new(solution, metric),
            scales: Scales::new(solution, metric, x_dot, sawtooth.sixth_difference),
            newtonian: Newtonian::new(solution, metric, x_dot),
            branch_distance: solution.is_doubled().then(|| solution.branch_distance()),
            free_particle: FreeParticleCharges::new(solution, t_dot, x_dot),
        }
    }
}
