//! The charges that only a free particle has.

use crate::geometry::potential::Potential;
use crate::number::Real;
use crate::number::norm::max_abs;
use crate::solve::Solution;

/// The further charges of the free particle: its space-time is flat and has three Killing vectors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FreeParticleCharges<S = f64> {
    /// max |ΔQ_x|, Q_x = −ẋ (Killing vector (0, 1)).
    pub max_abs_delta_q_x: S,
    /// max |ΔQ_η|, Q_η = x ṫ − (t − t_i) ẋ (boost, Killing vector (x/c², t)).
    pub max_abs_delta_q_eta: S,
}

impl<S: Real> FreeParticleCharges<S> {
    /// The larger of the two values of each charge.
    pub(super) fn max(self, other: Self) -> Self {
        Self {
            max_abs_delta_q_x: self.max_abs_delta_q_x.max(other.max_abs_delta_q_x),
            max_abs_delta_q_eta: self.max_abs_delta_q_eta.max(other.max_abs_delta_q_eta),
        }
    }

    /// The charges if V = 0, over all nodes.
    pub(super) fn new(solution: &Solution<S>, t_dot: &[S], x_dot: &[S]) -> Option<Self> {
        let Potential::Polynomial(polynomial) = solution.geometry().potential() else { return None };
        if polynomial.coefficients().iter().any(|&c| c != S::ZERO) {
            return None;
        }
        let initial = solution.initial();
        let delta_q_x: Vec<S> = x_dot.iter().map(|&w| initial.x_dot - w).collect();
        let q_eta = initial.x * initial.t_dot;
        let time = solution.counted_from_origin(0, solution.elapsed());
        let delta_q_eta: Vec<S> = (solution.x().iter().zip(t_dot))
            .zip(time.zip(x_dot))
            .map(|((&x, &u), (t, &w))| x * u - t * w - q_eta)
            .collect();
        Some(Self { max_abs_delta_q_x: max_abs(&delta_q_x), max_abs_delta_q_eta: max_abs(&delta_q_eta) })
    }
}
