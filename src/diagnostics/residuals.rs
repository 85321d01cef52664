//! How well the nodes satisfy the second-order geodesic equations when these are written with D.

use crate::metric::MetricSamples;
use crate::sbp::SbpOperator;

/// Residuals of the geodesic equations on the nodes.
#[derive(Debug, Clone)]
pub struct GeodesicResiduals {
    /// ΔGᵗ = D( g00(x)∘Dt ).
    pub delta_g_t: Vec<f64>,
    /// ΔGˣ = DDx + ½ g00′(x)∘(Dt)².
    pub delta_g_x: Vec<f64>,
}

impl GeodesicResiduals {
    /// From the metric, Dt and Dx on the nodes.
    pub(super) fn new(sbp: &SbpOperator, metric: &MetricSamples, t_dot: &[f64], x_dot: &[f64]) -> Self {
        let momentum: Vec<f64> = metric.g00.iter().zip(t_dot).map(|(g, u)| g * u).collect();
        let mut delta_g_x = sbp.derivative(x_dot);
        for ((residual, slope), u) in delta_g_x.iter_mut().zip(&metric.first).zip(t_dot) {
            *residual += 0.5 * slope * u * u;
        }
        Self { delta_g_t: sbp.derivative(&momentum), delta_g_x }
    }
}
