//! How well the nodes satisfy the second-order geodesic equations. In the strong form these are written with D, in the
//! weak form with D̄ and an initial value for every derivative.

use std::iter::repeat;

use super::rows::derivative;
use crate::metric::MetricSamples;
use crate::scalar::Real;
use crate::solve::Solution;

/// Residuals of the geodesic equations on the nodes.
#[derive(Debug, Clone)]
pub struct GeodesicResiduals<S = f64> {
    /// ΔGᵗ = D( g00(x)∘Dt ); in the weak form D̄( g00(x)∘D̄t ) − H⁻¹e_1 Q_t.
    pub delta_g_t: Vec<S>,
    /// ΔGˣ = DDx + ½ g00′(x)∘(Dt)²; in the weak form D̄D̄x − H⁻¹e_1 ẋ_i + ½ g00′(x)∘(D̄t)².
    pub delta_g_x: Vec<S>,
}

impl<S: Real> GeodesicResiduals<S> {
    /// The residuals of `solution`, from the metric, Dt and Dx on its nodes.
    pub(super) fn new(solution: &Solution<S>, metric: &MetricSamples<S>, t_dot: &[S], x_dot: &[S]) -> Self {
        let momentum: Vec<S> = metric.g00.iter().zip(t_dot).map(|(&g, &u)| g * u).collect();
        let q_t = solution.invariants().q_t;
        let delta_g_t = derivative(solution.grids(), &momentum, repeat(q_t));
        let starts = solution.windows.iter().map(|window| window.start.x_dot);
        let mut delta_g_x = derivative(solution.grids(), x_dot, starts);
        for ((residual, &slope), &u) in delta_g_x.iter_mut().zip(&metric.first).zip(t_dot) {
            *residual += slope.half() * u * u;
        }
        Self { delta_g_t, delta_g_x }
    }
}
