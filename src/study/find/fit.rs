//! The statistics of a fit: what the scatter of data makes of what was fitted to them.

use nalgebra::DMatrix;

use crate::case::Data;

/// A fit to data.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// The sum of the squares of residuals, each divided by its standard deviation if that is known.
    pub chi_squared: f64,
    /// The number of observations less that of the unknowns.
    pub degrees_of_freedom: usize,
    /// The covariance of the unknowns, by rows: (JᵀJ)⁻¹ with the residuals in standard deviations. Where these are not
    /// known, the scatter of the residuals stands for them; then it is NaN without a degree of freedom.
    pub covariance: Vec<Vec<f64>>,
    /// True if the standard deviations of the data are known.
    pub has_sigmas: bool,
    /// A row for each observation.
    pub rows: Vec<FitRow>,
}

/// An observation beside the run.
#[derive(Debug, Clone, PartialEq)]
pub struct FitRow {
    /// t or γ.
    pub place: f64,
    /// The coordinate.
    pub coordinate: String,
    /// The datum.
    pub observed: f64,
    /// The value of the run.
    pub computed: f64,
    /// The difference, run less datum, in standard deviations if these are known.
    pub residual: f64,
}

impl Fit {
    /// The statistics of residuals, where `inverse` is the pseudo-inverse of their derivatives.
    pub(super) fn new(data: &Data, residuals: &[f64], inverse: &DMatrix<f64>, names: &[String]) -> Self {
        let chi_squared: f64 = residuals.iter().map(|residual| residual * residual).sum();
        let degrees_of_freedom = residuals.len().saturating_sub(inverse.nrows());
        let has_sigmas = data.series.iter().all(|series| series.sigmas.is_some());
        let variance = if has_sigmas { 1.0 } else { chi_squared / degrees_of_freedom as f64 };
        // J⁺J⁺ᵀ = (JᵀJ)⁻¹.
        let covariance = inverse * inverse.transpose() * variance;
        let mut left = residuals.iter();
        let mut rows = Vec::new();
        for series in &data.series {
            for (k, (&place, &observed)) in data.places.iter().zip(&series.values).enumerate() {
                let residual = left.next().copied().unwrap_or(f64::NAN);
                let sigma = series.sigmas.as_ref().map_or(1.0, |sigmas| sigmas[k]);
                let (coordinate, computed) = (names[series.coordinate].clone(), observed + sigma * residual);
                rows.push(FitRow { place, coordinate, observed, computed, residual });
            }
        }
        let covariance = covariance.row_iter().map(|row| row.iter().copied().collect()).collect();
        Self { chi_squared, degrees_of_freedom, covariance, has_sigmas, rows }
    }

    /// The standard error of each unknown.
    pub fn standard_errors(&self) -> Vec<f64> {
        self.covariance.iter().enumerate().map(|(j, row)| row[j].sqrt()).collect()
    }
}
