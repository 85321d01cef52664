//! The maximum norm.

/// max |u_k|; NaN if any entry is NaN, so that a comparison with it fails.
pub(crate) fn max_abs(u: &[f64]) -> f64 {
    u.iter().fold(0.0, |largest: f64, v| if largest.is_nan() || v.is_nan() { f64::NAN } else { largest.max(v.abs()) })
}
