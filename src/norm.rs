//! The maximum norm.

use crate::scalar::Real;

/// max |u_k|; NaN if any entry is NaN, so that every comparison with it fails.
pub(crate) fn max_abs<S: Real>(u: &[S]) -> S {
    u.iter().fold(
        S::ZERO,
        |largest, v| if largest.is_nan() || v.is_nan() { S::from(f64::NAN) } else { largest.max(v.abs()) },
    )
}
