//! The maximum norm, the larger of two numbers, and products of bounds.

use crate::number::Real;

/// max |u_k|; NaN if any entry is NaN, so that every comparison with it fails.
pub fn max_abs<S: Real>(u: &[S]) -> S {
    u.iter().map(|v| v.abs()).fold(S::ZERO, |largest, v| if v > largest || v.is_nan() { v } else { largest })
}

/// The larger of `a` and `b`; NaN if either is, which `f64::max` would drop.
pub fn larger<S: Real>(a: S, b: S) -> S {
    if a.is_nan() || b <= a { a } else { b }
}

/// The product of a size and a bound: nothing times whatever is nothing, also if that is infinite.
pub(crate) fn times(size: f64, bound: f64) -> f64 {
    if bound == 0.0 || size == 0.0 { 0.0 } else { size * bound }
}

/// The number with one significant digit, and not below.
pub fn rounded_up(number: f64) -> f64 {
    let unit = 10.0_f64.powi(number.log10().floor() as i32);
    // A digit that rounding made larger is none.
    let digit = (number / unit - 1e-9).ceil();
    if unit > 0.0 && unit.is_finite() { digit * unit } else { number }
}

#[cfg(test)]
mod tests {
    use super::{larger, rounded_up, times};

    #[test]
    fn nothing_times_infinity_is_nothing() {
        let infinite = f64::INFINITY;
        assert_eq!(
            [times(0.0, infinite), times(infinite, 0.0), times(2.0, infinite), times(2.0, 3.0)],
            [0.0, 0.0, infinite, 6.0]
        );
        assert!(times(2.0, f64::NAN).is_nan());
    }

    #[test]
    fn a_nan_stays() {
        let largest = |all: &[f64]| all.iter().copied().fold(0.0, larger);
        assert_eq!(largest(&[1.0, 3.0, 2.0]), 3.0);
        for all in [[f64::NAN, 1.0, 2.0], [1.0, f64::NAN, 2.0], [1.0, 2.0, f64::NAN]] {
            assert!(largest(&all).is_nan(), "{all:?}");
        }
    }

    #[test]
    fn a_number_that_has_no_first_digit_is_itself() {
        assert_eq!([0.0, f64::INFINITY].map(rounded_up), [0.0, f64::INFINITY]);
        assert!((rounded_up(2.1e-5) - 3e-5).abs() < 1e-19 && rounded_up(4e7) == 4e7);
    }
}
