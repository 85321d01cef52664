//! Slopes of errors on log–log axes, above the rounding plateau.

use nalgebra::{DMatrix, DVector};

/// Errors of this many decimal digits fewer than the arithmetic has, relative to the quantity's size, may belong to the
/// rounding plateau; larger ones never do.
const PLATEAU_DIGITS: i32 = 9;
/// If even the coarsest grid's error has only this many digits fewer, there is nothing but rounding.
const ROUNDING_DIGITS: i32 = 3;
/// On the plateau the error does not fall even with this share of the order seen before.
const SHARE_OF_ORDER: f64 = 0.9;
/// Local slopes that spread by more than this are not asymptotic.
const ASYMPTOTIC_SPREAD: f64 = 0.2;

/// A fitted power law error ∝ Δγ^slope.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// Least-squares slope of log error against log Δγ.
    pub slope: f64,
    /// Its standard error; not defined for two points.
    pub standard_error: Option<f64>,
    /// The slope of the same errors against log 1/N, as the paper plots them.
    pub slope_vs_inverse_n: f64,
    /// The slopes between successive points of the fitted range, coarse to fine.
    pub local_slopes: Vec<f64>,
}

impl Fit {
    /// Fits `errors` over grids with spacings `delta_gamma` and `n_gamma` nodes, coarse to fine; `None` with fewer than
    /// two.
    pub fn new(delta_gamma: &[f64], n_gamma: &[usize], errors: &[f64]) -> Option<Self> {
        if errors.len() < 2 {
            return None;
        }
        let inverse_n: Vec<f64> = n_gamma.iter().map(|&n| 1.0 / n as f64).collect();
        let (slope, standard_error) = log_log(delta_gamma, errors);
        let (slope_vs_inverse_n, _) = log_log(&inverse_n, errors);
        Some(Self { slope, standard_error, slope_vs_inverse_n, local_slopes: local_slopes(delta_gamma, errors) })
    }

    /// Smallest and largest local slope.
    pub fn local_range(&self) -> (f64, f64) {
        self.local_slopes.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &s| (low.min(s), high.max(s)))
    }

    /// Whether the local slopes agree so well that the fit describes an order and not a transition.
    pub fn is_asymptotic(&self) -> bool {
        let (low, high) = self.local_range();
        high - low <= ASYMPTOTIC_SPREAD
    }
}

/// Slope and its standard error of log y against log x.
fn log_log(x: &[f64], y: &[f64]) -> (f64, Option<f64>) {
    let n = x.len();
    let design = DMatrix::from_fn(n, 2, |row, column| if column == 0 { 1.0 } else { x[row].ln() });
    let target = DVector::from_iterator(n, y.iter().map(|y| y.ln()));
    let svd = design.clone().svd(true, true);
    let coefficients = svd.solve(&target, 0.0).expect("both factors were computed");
    let residual = (&target - &design * &coefficients).norm_squared();
    let standard_error = (n > 2)
        .then(|| {
            (design.transpose() * &design)
                .try_inverse()
                .map(|inverse| (residual / (n - 2) as f64 * inverse[(1, 1)]).sqrt())
        })
        .flatten();
    (coefficients[1], standard_error)
}

fn local_slopes(delta_gamma: &[f64], errors: &[f64]) -> Vec<f64> {
    let slope = |k: usize| (errors[k - 1] / errors[k]).ln() / (delta_gamma[k - 1] / delta_gamma[k]).ln();
    (1..errors.len()).map(slope).collect()
}

/// How many of the errors, coarse to fine, lie above the rounding plateau.
///
/// The plateau begins at the first point from which on no error falls as the order seen so far (the median of the local
/// slopes) would make it fall. That is found from the errors themselves; the only assumption is that an error above
/// 1e-7 of the quantity's `size` (with 16 `digits`; less with more) is not rounding, so that a pre-asymptotic hesitation
/// on coarse grids is not taken for it.
pub fn points_above_plateau(delta_gamma: &[f64], errors: &[f64], size: f64, digits: u32) -> usize {
    let short_of = |spare: i32| 10.0_f64.powi(spare - digits as i32);
    if errors.first().is_none_or(|first| *first <= short_of(ROUNDING_DIGITS) * size) {
        return 0;
    }
    let slopes = local_slopes(delta_gamma, errors);
    let begins_at = |&start: &usize| {
        let order = median(&slopes[..start - 1]).unwrap_or(1.0).max(1.0);
        let last = start - 1;
        let falls = |k: usize| errors[last] * (delta_gamma[k] / delta_gamma[last]).powf(SHARE_OF_ORDER * order);
        errors[start] <= short_of(PLATEAU_DIGITS) * size
            && (start..errors.len()).all(|k| errors[k] > falls(k) || errors[k] == 0.0)
    };
    (1..errors.len()).find(begins_at).unwrap_or(errors.len())
}

fn median(values: &[f64]) -> Option<f64> {
    let mut sorted: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grids(count: u32) -> (Vec<f64>, Vec<usize>) {
        let n: Vec<usize> = (0..count).map(|i| (16 << i) + 1).collect();
        (n.iter().map(|&n| 1.0 / (n - 1) as f64).collect(), n)
    }

    #[test]
    fn a_power_law_is_recovered() {
        let (h, n) = grids(5);
        let errors: Vec<f64> = h.iter().map(|h| 3.0 * h.powf(2.5)).collect();
        let fit = Fit::new(&h, &n, &errors).unwrap();
        assert!((fit.slope - 2.5).abs() < 1e-12 && fit.standard_error.unwrap() < 1e-12);
        assert!(fit.slope_vs_inverse_n > 2.5, "1/N shrinks more slowly than 1/(N-1)");
        assert!(fit.is_asymptotic() && fit.local_slopes.len() == 4);
        assert_eq!(Fit::new(&h[..1], &n[..1], &errors[..1]), None);
        assert_eq!(Fit::new(&h[..2], &n[..2], &errors[..2]).unwrap().standard_error, None);
    }

    #[test]
    fn the_standard_error_is_that_of_the_textbook() {
        // y = x with residuals (1, -2, 1)·c on logs 0, 1, 2: slope 1, RSS 6c², Var = 6c²/1/2.
        let (h, n) = ([1.0_f64.exp().powi(2), 1.0_f64.exp(), 1.0], [2, 3, 4]);
        let c: f64 = 0.01;
        let errors = [(2.0 + c).exp(), (1.0 - 2.0 * c).exp(), c.exp()];
        let fit = Fit::new(&h, &n, &errors).unwrap();
        assert!((fit.slope - 1.0).abs() < 1e-12);
        assert!((fit.standard_error.unwrap() - c * 3.0_f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn the_plateau_is_found_and_a_hesitation_is_not_one() {
        let (h, _) = grids(12);
        let plateau: Vec<f64> = h.iter().map(|h| h.powi(4) + 1e-14 / h).collect();
        let kept = points_above_plateau(&h, &plateau, 1.0, 16);
        assert!((5..=7).contains(&kept), "{kept}: rounding takes over where h^4 = 1e-14/h");
        let clean: Vec<f64> = h.iter().map(|h| h.powi(2)).collect();
        assert_eq!(points_above_plateau(&h, &clean, 1.0, 16), 12);
        let mut hesitating = clean.clone();
        hesitating[1] = hesitating[0];
        assert_eq!(points_above_plateau(&h, &hesitating, 1.0, 16), 12);
        assert_eq!(points_above_plateau(&h, &[1e-16; 12], 1.0, 16), 0);
        assert_eq!(points_above_plateau(&[], &[], 1.0, 16), 0);
    }
}
