//! Coefficients of the diagonal-norm SBP first-derivative operators, as exact rationals.
//!
//! There is one table per operator, and each names its source. A table holds the norm H and the boundary closure of D
//! at the left end, for unit spacing, and the antisymmetric interior stencil. The right end is the left one mirrored,
//! with the opposite sign. Nothing here is rounded: `tests/mathematics/numerics/sbp_identities.rs` proves
//! Q + Qᵀ = E_N − E_0 and the exactness on polynomials for these numbers, in exact arithmetic.

mod mattsson_nordstrom;

pub use mattsson_nordstrom::{SBP63, SBP84};

use crate::number::Real;

/// A rational number `numerator / denominator`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Rational {
    /// Numerator, carrying the sign.
    pub numerator: i64,
    /// Denominator, positive.
    pub denominator: i64,
}

impl Rational {
    /// The quotient in `S`, rounded once.
    pub fn to_real<S: Real>(self) -> S {
        S::from(self.numerator as f64) / S::from(self.denominator as f64)
    }
}

const fn r(numerator: i64, denominator: i64) -> Rational {
    Rational { numerator, denominator }
}

/// One operator family for unit spacing: D = H⁻¹Q with Q + Qᵀ = E_N − E_0 and diagonal H.
#[derive(Debug)]
pub struct Coefficients {
    /// Name as written in case files, e.g. `SBP42`.
    pub name: &'static str,
    /// Order of the interior stencil. The boundary closure has half that order.
    pub interior_order: usize,
    /// Diagonal of H at the first nodes; it is 1 at all further ones.
    pub norm: &'static [Rational],
    /// First rows of D, one per boundary node and all of the same length. Columns are counted from the first node.
    pub closure: &'static [&'static [Rational]],
    /// d_1, d_2, … of the interior row (Du)_k = Σ_m d_m (u_{k+m} − u_{k−m}).
    pub interior: &'static [Rational],
    /// Smallest number of nodes on which the two closures do not overlap and at least one node lies between the ends.
    pub minimum_points: usize,
}

/// SBP(2,1): second order inside, first order at the boundary.
///
/// Source: K. Strand, "Summation by parts for finite difference approximations for d/dx", J. Comput. Phys. 110
/// (1994) 47–67; printed as D^(2,1) by Rothkopf & Nordström (2023).
pub static SBP21: Coefficients = Coefficients {
    name: "SBP21",
    interior_order: 2,
    norm: &[r(1, 2)],
    closure: &[&[r(-1, 1), r(1, 1)]],
    interior: &[r(1, 2)],
    minimum_points: 3,
};

/// SBP(4,2): fourth order inside, second order at the boundary.
///
/// Source: Strand (1994), the diagonal-norm operator; printed as D^(4,2) by Rothkopf & Nordström (2023) with a
/// misprint: their row 4 has −59/86 in its third entry, which breaks Q + Qᵀ = E_N − E_0 and the exactness on linear
/// functions. The value below, −59/98, satisfies both.
pub static SBP42: Coefficients = Coefficients {
    name: "SBP42",
    interior_order: 4,
    norm: &[r(17, 48), r(59, 48), r(43, 48), r(49, 48)],
    closure: &[
        &[r(-24, 17), r(59, 34), r(-4, 17), r(-3, 34), r(0, 1), r(0, 1)],
        &[r(-1, 2), r(0, 1), r(1, 2), r(0, 1), r(0, 1), r(0, 1)],
        &[r(4, 43), r(-59, 86), r(0, 1), r(59, 86), r(-4, 43), r(0, 1)],
        &[r(3, 98), r(0, 1), r(-59, 98), r(0, 1), r(32, 49), r(-4, 49)],
    ],
    interior: &[r(2, 3), r(-1, 12)],
    minimum_points: 8,
};
