//! The charges that only a free particle has.

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
        let (geometry, start) = (solution.geometry(), &solution.place.start);
        if geometry.depends_on(1) || geometry.g00(&start.q) != geometry.c_squared() {
            return None;
        }
        let delta_q_x: Vec<S> = x_dot.iter().map(|&w| start.q_dot[1] - w).collect();
        let q_eta = start.q[1] * start.q_dot[0];
        let time = solution.counted_from_origin(0, solution.elapsed());
        let delta_q_eta: Vec<S> = (solution.x().iter().zip(t_dot))
            .zip(time.zip(x_dot))
            .map(|((&x, &u), (t, &w))| x * u - t * w - q_eta)
            .collect();
        Some(Self { max_abs_delta_q_x: max_abs(&delta_q_x), max_abs_delta_q_eta: max_abs(&delta_q_eta) })
    }
}
