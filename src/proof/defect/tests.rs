//! The rounding of sums of products.

use super::*;
use crate::number::{Extended, Real};

/// The sum of errors that are added in single doubles: coefficients of all sizes and signs. The bound is a worst case
/// of 96 roundings of the sum of all errors, a thousandth of which random numbers use.
#[test]
fn rounding_of_sums_of_products_is_bounded() {
    let (exact, mut largest) = (Extended::from, 0.0_f64);
    for draw in 0..200 {
        let factors: Row = std::array::from_fn(|k| ((7 * k + 13 * draw) as f64).sin());
        let found = combined(&TABLES.legendre, &factors);
        for i in 0..LANES {
            let terms = factors.iter().zip(&TABLES.legendre);
            let sum =
                terms.fold(Extended::ZERO, |sum, (c, row)| sum + exact(*c) * (exact(row.hi[i]) + exact(row.lo[i])));
            let off = (sum - exact(found.hi[i]) - exact(found.lo[i])).abs().to_f64();
            assert!(off <= found.rad[i], "{off:e} {:e}", found.rad[i]);
            largest = largest.max(off / found.rad[i]);
        }
    }
    assert!(largest > 1e-3, "{largest}");
}
