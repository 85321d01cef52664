//! The measures of a run in a potential of x alone.

use super::bound::Bound;
use super::charges::FreeParticleCharges;
use super::deviations::Fields;
use super::g00::G00;
use super::newtonian::Newtonian;
use super::scales::Scales;
use crate::number::Real;

/// Extremes over a run in t and x.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OfX<S = f64> {
    /// H_BVP and its bound.
    pub bound: Bound<S>,
    /// Size, speed and frequency of the motion.
    pub scales: Scales,
    /// The deviation of the motion from Newton's.
    pub newtonian: Newtonian,
    /// The deviations of Q_x and Q_η, if the potential vanishes.
    pub free_particle: Option<FreeParticleCharges<S>>,
}

impl<S: Real> OfX<S> {
    /// `None` in another space-time.
    pub(super) fn new(fields: &Fields<'_, S>) -> Option<Self> {
        let solution = fields.run;
        solution.geometry().c_squared()?;
        let metric = G00::new(solution.geometry(), &fields.samples);
        let [t_dot, x_dot] = [&fields.velocities[0], &fields.velocities[1]];
        Some(Self {
            bound: Bound::new(solution, metric),
            scales: Scales::new(solution, metric, x_dot),
            newtonian: Newtonian::new(solution, metric, x_dot),
            free_particle: FreeParticleCharges::new(solution, t_dot, x_dot),
        })
    }

    pub(super) fn followed_by(self, next: Self) -> Self {
        Self {
            bound: self.bound.followed_by(next.bound),
            scales: self.scales.followed_by(next.scales),
            newtonian: self.newtonian.followed_by(next.newtonian),
            free_particle: self.free_particle.zip(next.free_particle).map(|(a, b)| a.max(b)),
        }
    }
}
