//! How well the nodes satisfy the second-order geodesic equations when these are written with D.

use crate::metric::MetricSamples;
use crate::sbp::SbpOperator;
use crate::scalar::Real;

/// Residuals of the geodesic equations on the nodes.
#[derive(Debug, Clone)]
pub struct GeodesicResiduals<S = f64> {
    /// ΔGᵗ = D( g00(x)∘Dt ).
    pub delta_g_t: Vec<S>,
    /// ΔGˣ = DDx + ½ g00′(x)∘(Dt)².
    pub delta_g_x: Vec<S>,
}

impl<S: Real> GeodesicResiduals<S> {
    /// From the metric, Dt and Dx on the nodes.
    pub(super) fn new(sbp: &SbpOperator<S>, metric: &MetricSamples<S>, t_dot: &[S], x_dot: &[S]) -> Self {
        let momentum: Vec<S> = metric.g00.iter().zip(t_dot).map(|(&g, &u)| g * u).collect();
        let mut delta_g_x = sbp.derivative(x_dot);
        for ((residual, &slope), &u) in delta_g_x.iter_mut().zip(&metric.first).zip(t_dot) {
            *residual += slope.half() * u * u;
        }
        Self { delta_g_t: sbp.derivative(&momentum), delta_g_x }
    }
}
