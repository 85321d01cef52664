//! Slopes of errors on log–log axes, above the *rounding plateau*: on fine grids rounding keeps errors from falling.

/// Errors that no longer fall can be due to rounding if they have at most this many decimal digits fewer than the
/// arithmetic, relative to the size of the quantity. Above that level, only growing errors end a fit.
const PLATEAU_DIGITS: i32 = 9;
/// If the error of the coarsest grid has at most this many digits fewer than the arithmetic, all errors are rounding.
const ROUNDING_DIGITS: i32 = 3;
/// Rounding can add up to 10 to this power times √N, in units of the last digit. Below that, half of an error may be
/// rounding.
const NEAR_DIGITS: i32 = 1;
/// Errors that fall with less than this order have stopped falling, since every scheme has at least order one.
const STALLED: f64 = 0.5;
/// Close to rounding, an error is affected by it if it falls with less than this share of the preceding order.
const SHARE_OF_ORDER: f64 = 0.8;
/// A fit uses only errors that are at least this many times the level of the plateau.
const ABOVE_PLATEAU: f64 = 4.0;
/// Local slopes whose range is larger than this are not asymptotic.
const ASYMPTOTIC_SPREAD: f64 = 0.2;

/// A fitted power law error ∝ Δγ^slope.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// Least-squares slope of log error against log Δγ.
    pub slope: f64,
    /// The standard error of the slope; `None` for two points.
    pub standard_error: Option<f64>,
    /// The slope of the same errors against log 1/N, as the paper plots them.
    pub slope_vs_inverse_n: f64,
    /// The slopes between successive points of the fitted range, coarse to fine.
    pub local_slopes: Vec<f64>,
}

impl Fit {
    /// Fits `errors` over grids with spacings `delta_gamma` and `n_gamma` nodes, from coarse to fine; `None` with fewer
    /// than two grids.
    pub fn new(delta_gamma: &[f64], n_gamma: &[usize], errors: &[f64]) -> Option<Self> {
        if errors.len() < 2 {
            return None;
        }
        let inverse_n: Vec<f64> = n_gamma.iter().map(|&n| 1.0 / n as f64).collect();
        let (slope, standard_error) = log_log(delta_gamma, errors);
        let (slope_vs_inverse_n, _) = log_log(&inverse_n, errors);
        Some(Self { slope, standard_error, slope_vs_inverse_n, local_slopes: local_slopes(delta_gamma, errors) })
    }

    /// Returns true if the local slopes agree well enough for the fit to describe an order, and not a transition
    /// between orders.
    pub fn is_asymptotic(&self) -> bool {
        self.asymptotic_from() == Some(0)
    }

    /// The index of the coarsest grid from which on the local slopes agree, if there are three grids or more from it.
    pub fn asymptotic_from(&self) -> Option<usize> {
        let last = self.local_slopes.len().saturating_sub(1).max(1);
        (0..last).find(|&first| {
            let (low, high) = range(&self.local_slopes[first..]);
            high - low <= ASYMPTOTIC_SPREAD
        })
    }
}

/// The smallest and the largest of some slopes.
pub(super) fn range(slopes: &[f64]) -> (f64, f64) {
    slopes.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &s| (low.min(s), high.max(s)))
}

/// The slope of log y against log x, and its standard error.
fn log_log(x: &[f64], y: &[f64]) -> (f64, Option<f64>) {
    let n = x.len() as f64;
    let mean = |v: &[f64]| v.iter().map(|v| v.ln()).sum::<f64>() / n;
    let (x_mean, y_mean) = (mean(x), mean(y));
    let points = || x.iter().zip(y).map(|(x, y)| (x.ln() - x_mean, y.ln() - y_mean));
    let spread: f64 = points().map(|(x, _)| x * x).sum();
    let slope = points().map(|(x, y)| x * y).sum::<f64>() / spread;
    let residual: f64 = points().map(|(x, y)| (y - slope * x).powi(2)).sum();
    (slope, (n > 2.0).then(|| (residual / (n - 2.0) / spread).sqrt()))
}

fn local_slopes(delta_gamma: &[f64], errors: &[f64]) -> Vec<f64> {
    let slope = |k: usize| (errors[k - 1] / errors[k]).ln() / (delta_gamma[k - 1] / delta_gamma[k]).ln();
    (1..errors.len()).map(slope).collect()
}

/// The number of errors that lie above the rounding plateau. `errors` are given from coarse to fine, on grids of
/// `n_gamma` nodes.
///
/// The plateau begins at a point from which, to the last grid, one of these holds:
///
/// * No error falls any more (with an order of at least a half), and the level can be one of rounding: with 16 `digits`
///   it is below 1e-7 of the quantity's `size`. Closer to rounding, below 1e-15 √N of the size, errors that fall with
///   less than 0.8 of the preceding order count as not falling, too.
/// * All errors are larger than the last one that fell, at any level.
///
/// Nothing else begins a plateau: not an order that drops from grid to grid, not coarse grids without a clear order,
/// and not an error that passes through zero. Points before a plateau are left out as well if they are less than four
/// times as large as its level, or less than twice if errors grow there.
pub fn points_above_plateau(delta_gamma: &[f64], n_gamma: &[usize], errors: &[f64], size: f64, digits: u32) -> usize {
    let short_of = |spare: i32| 10.0_f64.powi(spare - digits as i32) * size;
    // An error of zero is on the plateau, and has no logarithm.
    let some = errors.iter().position(|&error| error == 0.0).unwrap_or(errors.len());
    let errors = &errors[..some];
    if errors.first().is_none_or(|first| *first <= short_of(ROUNDING_DIGITS)) {
        return 0;
    }
    let slopes = local_slopes(delta_gamma, errors);
    let begins_at = |&start: &usize| {
        let (last, tail) = (start - 1, start..errors.len());
        let near = errors[start] <= short_of(NEAR_DIGITS) * (n_gamma[start] as f64).sqrt();
        let before = if last > 0 { slopes[last - 1] } else { 1.0 };
        let order = if near { STALLED.max(SHARE_OF_ORDER * before) } else { STALLED };
        let falls = |k: usize| errors[k] <= errors[last] * (delta_gamma[k] / delta_gamma[last]).powf(order);
        // If an error is small by accident, the later ones still fall as they did before it.
        let goes_on = tail.len() > 2 && !near && log_log(&delta_gamma[start..some], &errors[start..]).0 > STALLED;
        let grows = last > 0 && slopes[last - 1] > 0.0 && tail.clone().all(|k| errors[k] > errors[last]);
        let is_low = errors[start] <= short_of(PLATEAU_DIGITS);
        !goes_on && (grows || (is_low && !tail.clone().any(falls)))
    };
    let Some(start) = (1..some).find(begins_at) else { return some };
    let level = errors[start - 1..].iter().copied().fold(f64::INFINITY, f64::min);
    // Where errors begin to grow, only about half of the smallest one is rounding.
    let above = if errors[start] > errors[start - 1] { 0.5 * ABOVE_PLATEAU } else { ABOVE_PLATEAU };
    (0..start).rev().find(|&k| errors[k] >= above * level).map_or(0, |last| last + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grids(count: u32) -> (Vec<f64>, Vec<usize>) {
        let n: Vec<usize> = (0..count).map(|i| (16 << i) + 1).collect();
        (n.iter().map(|&n| 1.0 / (n - 1) as f64).collect(), n)
    }

    #[test]
    fn the_standard_error_is_that_of_a_straight_line() {
        // By hand: the deviations from y = 0.94 x are ±0.09 and ±0.27, and Σ (x − 1.5)² is 5.
        let [x, y] = [[0.0, 1.0, 2.0, 3.0], [0.0, 1.3, 1.7, 3.0]].map(|row| row.map(f64::exp));
        let fit = Fit::new(&x, &[2, 3, 4, 5], &y).unwrap();
        assert!((fit.slope - 0.94).abs() < 1e-14 && (fit.standard_error.unwrap() - 0.0162_f64.sqrt()).abs() < 1e-14);
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

    /// Counts the errors that are above the plateau.
    fn above(errors: &[f64]) -> usize {
        let (h, n) = grids(errors.len() as u32);
        points_above_plateau(&h, &n, errors, 1.0, 16)
    }

    /// The same of errors that follow a law on twelve grids.
    fn kept(error: impl Fn(f64) -> f64) -> usize {
        above(&grids(12).0.into_iter().map(error).collect::<Vec<_>>())
    }

    #[test]
    fn a_plateau_of_rounding_and_errors_that_grow_end_a_fit() {
        let ends = kept(|h| h.powi(4) + 1e-14 / h);
        assert!((5..=6).contains(&ends), "{ends}: rounding takes over where h^4 = 1e-14/h");
        let ends = kept(|h| h.powi(4) + 3e-16);
        assert!((8..=9).contains(&ends), "{ends}: h^4 = 3e-16 at the tenth");
        // A long run, in which rounding accumulates.
        let ends = kept(|h| h.powi(2) + 1e-8);
        assert!((8..=10).contains(&ends), "{ends}: h = 1e-4 at the tenth");
        let ends = kept(|h| 1e3 * h.powi(2) + 1e-7 / h.powi(2));
        assert!((4..=6).contains(&ends), "{ends}: the least error is 2e-2, and it grows from there");
        assert_eq!(kept(|_| 1e-16), 0);
        assert_eq!(kept(|h| if h < 1e-3 { 0.0 } else { h }), 6);
        assert_eq!(above(&[]), 0);
        // A sweep that ends just as the plateau begins.
        let (h, n) = grids(12);
        assert_eq!(points_above_plateau(&h[8..11], &n[8..11], &[8e-13, 1e-13, 4e-14], 1.0, 16), 1);
    }

    #[test]
    fn an_order_that_drops_is_no_plateau() {
        for (high, low) in [(8.0, 4.0), (6.0, 3.0), (4.0, 3.0), (3.7, 3.0), (4.0, 2.0), (2.0, 1.0)] {
            // The higher order leads on the first half of the grids.
            let crossing = 1.0_f64 / 512.0;
            let amplitude = 1e-7 / crossing.powf(low);
            let law = |h: f64| amplitude * (h.powf(low) + crossing.powf(low - high) * h.powf(high));
            let errors: Vec<f64> = grids(12).0.into_iter().map(law).filter(|&error| error > 1e-12).collect();
            assert_eq!(above(&errors), errors.len(), "{high} to {low}");
        }
        assert_eq!(kept(|h| h.powi(2)), 12);
        // In another unit as many errors are above rounding.
        let (h, n) = grids(12);
        let errors: Vec<f64> = h.iter().map(|h| h.powi(4) + 3e-16).collect();
        for unit in [1e-9, 1e9] {
            let scaled: Vec<f64> = errors.iter().map(|error| unit * error).collect();
            assert_eq!(points_above_plateau(&h, &n, &scaled, unit, 16), kept(|h| h.powi(4) + 3e-16), "{unit:e}");
        }
        // A coarse grid without a clear order, and an error that changes its sign between two grids.
        assert_eq!(kept(|h| if h > 0.04 { 1e-3 } else { h.powi(2) }), 12);
        assert_eq!(kept(|h| 1e-5 * h * (h - 0.9e-3).abs()), 12);
    }

    /// Close to rounding a fall that is far slower than before is none, and two errors are no trend.
    #[test]
    fn what_still_falls_may_be_a_plateau() {
        assert!(above(&[1.6e-10, 1e-11, 6e-13, 8e-15, 4e-15, 2e-15, 1e-15]) <= 4);
        let accident = [1e-5, 1e-6, 1e-7, 1e-8, 1e-12, 1e-9, 1e-10, 1e-11];
        assert!(above(&accident[..7]) < 7 && above(&accident) == 8);
    }
}
