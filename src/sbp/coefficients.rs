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

/// A numerator, which carries the sign, and a positive denominator.
pub type Rational = (i64, i64);

/// The quotient in `S`, rounded once.
pub(crate) fn quotient<S: Real>(&(numerator, denominator): &Rational) -> S {
    S::from(numerator as f64) / S::from(denominator as f64)
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
    /// First rows of D, one per boundary node, without zeros at the end. Columns are counted from the first node.
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
    norm: &[(1, 2)],
    closure: &[&[(-1, 1), (1, 1)]],
    interior: &[(1, 2)],
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
    norm: &[(17, 48), (59, 48), (43, 48), (49, 48)],
    closure: &[
        &[(-24, 17), (59, 34), (-4, 17), (-3, 34)],
        &[(-1, 2), (0, 1), (1, 2)],
        &[(4, 43), (-59, 86), (0, 1), (59, 86), (-4, 43)],
        &[(3, 98), (0, 1), (-59, 98), (0, 1), (32, 49), (-4, 49)],
    ],
    interior: &[(2, 3), (-1, 12)],
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
        (13649, 43200), (12013, 8640), (2711, 4320), (5359, 4320), (7877, 8640), (43801, 43200),
    ],
    closure: &[
        &[(-21600, 13649), (3080648, 1515039), (-428795, 3030078), (-227457, 505013), (316607, 3030078),
          (55417, 1515039)],
        &[(-3080648, 6667215), (0, 1), (127681, 444481), (690233, 2666886), (-30719, 444481), (-66243, 4444810)],
        &[(85759, 1203684), (-127681, 200614), (0, 1), (182429, 300921), (-9189, 401228), (-3637, 200614)],
        &[(227457, 1982830), (-690233, 2379396), (-182429, 594849), (0, 1), (618955, 1189698), (-614387, 11896980),
          (72, 5359)],
        &[(-316607, 8743470), (30719, 291449), (9189, 582898), (-618955, 874347), (0, 1), (1120912, 1457245),
          (-1296, 7877), (144, 7877)],
        &[(-55417, 4861911), (66243, 3241274), (18185, 1620637), (614387, 9723822), (-1120912, 1620637), (0, 1),
          (32400, 43801), (-6480, 43801), (720, 43801)],
    ],
    interior: &[(3, 4), (-3, 20), (1, 60)],
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
        (1498139, 5080320), (1107307, 725760), (20761, 80640), (1304999, 725760), (299527, 725760),
        (103097, 80640), (670091, 725760), (5127739, 5080320),
    ],
    closure: &[
        &[(-2540160, 1498139), (1279435779, 569292820), (-19295151, 569292820), (-266780237, 341575692),
          (725511, 28464641), (39152001, 113858564), (-147365687, 1707878460), (-11394429, 569292820)],
        &[(-1279435779, 2945436620), (0, 1), (19324419, 210388330), (10393365, 21038833), (-6214495, 252465996),
          (-39291999, 210388330), (1109310, 21038833), (31664761, 4418154930)],
        &[(6431717, 165672780), (-6441473, 11833770), (0, 1), (921889, 2366754), (645809, 4733508), (407439, 3944590),
          (-354462, 1972295), (309191, 5522426)],
        &[(266780237, 2082778404), (-10393365, 24794981), (-2765667, 49589962), (0, 1), (12369141, 99179924),
          (13948923, 49589962), (-2934266, 74384943), (-6837807, 347129734)],
        &[(-725511, 39837091), (6214495, 68292156), (-1937427, 22764052), (-12369141, 22764052), (0, 1),
          (763665, 1198108), (-2343561, 22764052), (14291873, 478045092), (-2592, 299527)],
        &[(-1864381, 23506116), (13097333, 58765290), (-407439, 19588430), (-4649641, 11753058), (-254555, 1237164),
          (0, 1), (5346432, 9794215), (-923328, 9794215), (3072, 103097), (-288, 103097)],
        &[(21052241, 763903740), (-1109310, 12731729), (3190158, 63658645), (2934266, 38195187), (2343561, 50926916),
          (-48117888, 63658645), (0, 1), (52309152, 63658645), (-145152, 670091), (27648, 670091), (-2592, 670091)],
        &[(11394429, 1948540820), (-31664761, 2922811230), (-2782719, 194854082), (6837807, 194854082),
          (-14291873, 1169124492), (58169664, 487135205), (-366164064, 487135205), (0, 1), (4064256, 5127739),
          (-1016064, 5127739), (193536, 5127739), (-18144, 5127739)],
    ],
    interior: &[(4, 5), (-1, 5), (4, 105), (-1, 280)],
    minimum_points: 16,
};
