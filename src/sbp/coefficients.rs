//! Coefficients of the diagonal-norm SBP first-derivative operators, as exact rationals.
//!
//! There is one table per operator, and each names its source. A table holds the norm H and the boundary closure of D
//! at the left end, for unit spacing, and the antisymmetric interior stencil. The right end is the left one mirrored,
//! with the opposite sign. Nothing here is rounded: `tests/mathematics/numerics/sbp_identities.rs` proves
//! Q + Qᵀ = E_N − E_0 and the exactness on polynomials for these numbers, in exact arithmetic.
//!
//! The operators of orders 6 and 8 are those of K. Mattsson & J. Nordström, "Summation by parts operators for finite
//! difference approximations of second derivatives", J. Comput. Phys. 199 (2004) 503–540.
//! Their norms are unique. The closures have free parameters q_ij, which are entries of Q = HD, with rows and columns
//! counted from 1. The values below are those used with these operators at Uppsala, whose library gives them as
//! decimals. With them, the spectral radius of D is that of its interior stencil. Other values in circulation at order
//! 8, −231661/322560, 7120007/33868800 and 70710683/101606400, give a radius of 124 instead of 1.73. Their errors are a
//! few times smaller, but in `f64` the charge loses two more digits to rounding, and the doubled system with N = 1000
//! cannot be solved to rounding.

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

/// SBP(6,3): sixth order inside, third order at the boundary.
///
/// Source: Mattsson & Nordström (2004), with q_56 = 70057/99900 = 0.70127127….
#[rustfmt::skip]
pub static SBP63: Coefficients = Coefficients {
    name: "SBP63",
    interior_order: 6,
    norm: &[
        r(13649, 43200), r(12013, 8640), r(2711, 4320), r(5359, 4320), r(7877, 8640), r(43801, 43200),
    ],
    closure: &[
        &[r(-21600, 13649), r(3080648, 1515039), r(-428795, 3030078), r(-227457, 505013), r(316607, 3030078),
          r(55417, 1515039), r(0, 1), r(0, 1), r(0, 1)],
        &[r(-3080648, 6667215), r(0, 1), r(127681, 444481), r(690233, 2666886), r(-30719, 444481),
          r(-66243, 4444810), r(0, 1), r(0, 1), r(0, 1)],
        &[r(85759, 1203684), r(-127681, 200614), r(0, 1), r(182429, 300921), r(-9189, 401228), r(-3637, 200614),
          r(0, 1), r(0, 1), r(0, 1)],
        &[r(227457, 1982830), r(-690233, 2379396), r(-182429, 594849), r(0, 1), r(618955, 1189698),
          r(-614387, 11896980), r(72, 5359), r(0, 1), r(0, 1)],
        &[r(-316607, 8743470), r(30719, 291449), r(9189, 582898), r(-618955, 874347), r(0, 1), r(1120912, 1457245),
          r(-1296, 7877), r(144, 7877), r(0, 1)],
        &[r(-55417, 4861911), r(66243, 3241274), r(18185, 1620637), r(614387, 9723822), r(-1120912, 1620637),
          r(0, 1), r(32400, 43801), r(-6480, 43801), r(720, 43801)],
    ],
    interior: &[r(3, 4), r(-3, 20), r(1, 60)],
    minimum_points: 12,
};

/// SBP(8,4): eighth order inside, fourth order at the boundary.
///
/// Source: Mattsson & Nordström (2004), with q_67 = 663/950, q_68 = −229/1900 and q_78 = 2883/3800.
#[rustfmt::skip]
pub static SBP84: Coefficients = Coefficients {
    name: "SBP84",
    interior_order: 8,
    norm: &[
        r(1498139, 5080320), r(1107307, 725760), r(20761, 80640), r(1304999, 725760), r(299527, 725760),
        r(103097, 80640), r(670091, 725760), r(5127739, 5080320),
    ],
    closure: &[
        &[r(-2540160, 1498139), r(1279435779, 569292820), r(-19295151, 569292820), r(-266780237, 341575692),
          r(725511, 28464641), r(39152001, 113858564), r(-147365687, 1707878460), r(-11394429, 569292820), r(0, 1),
          r(0, 1), r(0, 1), r(0, 1)],
        &[r(-1279435779, 2945436620), r(0, 1), r(19324419, 210388330), r(10393365, 21038833), r(-6214495, 252465996),
          r(-39291999, 210388330), r(1109310, 21038833), r(31664761, 4418154930), r(0, 1), r(0, 1), r(0, 1), r(0, 1)],
        &[r(6431717, 165672780), r(-6441473, 11833770), r(0, 1), r(921889, 2366754), r(645809, 4733508),
          r(407439, 3944590), r(-354462, 1972295), r(309191, 5522426), r(0, 1), r(0, 1), r(0, 1), r(0, 1)],
        &[r(266780237, 2082778404), r(-10393365, 24794981), r(-2765667, 49589962), r(0, 1), r(12369141, 99179924),
          r(13948923, 49589962), r(-2934266, 74384943), r(-6837807, 347129734), r(0, 1), r(0, 1), r(0, 1), r(0, 1)],
        &[r(-725511, 39837091), r(6214495, 68292156), r(-1937427, 22764052), r(-12369141, 22764052), r(0, 1),
          r(763665, 1198108), r(-2343561, 22764052), r(14291873, 478045092), r(-2592, 299527), r(0, 1), r(0, 1),
          r(0, 1)],
        &[r(-1864381, 23506116), r(13097333, 58765290), r(-407439, 19588430), r(-4649641, 11753058),
          r(-254555, 1237164), r(0, 1), r(5346432, 9794215), r(-923328, 9794215), r(3072, 103097), r(-288, 103097),
          r(0, 1), r(0, 1)],
        &[r(21052241, 763903740), r(-1109310, 12731729), r(3190158, 63658645), r(2934266, 38195187),
          r(2343561, 50926916), r(-48117888, 63658645), r(0, 1), r(52309152, 63658645), r(-145152, 670091),
          r(27648, 670091), r(-2592, 670091), r(0, 1)],
        &[r(11394429, 1948540820), r(-31664761, 2922811230), r(-2782719, 194854082), r(6837807, 194854082),
          r(-14291873, 1169124492), r(58169664, 487135205), r(-366164064, 487135205), r(0, 1), r(4064256, 5127739),
          r(-1016064, 5127739), r(193536, 5127739), r(-18144, 5127739)],
    ],
    interior: &[r(4, 5), r(-1, 5), r(4, 105), r(-1, 280)],
    minimum_points: 16,
};
