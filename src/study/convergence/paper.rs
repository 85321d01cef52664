//! The slopes that the paper reports: arXiv:2307.04490, section 4.

use super::Quantity;
use crate::case::SbpName;

/// A slope that the paper reports.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PublishedSlope {
    /// The built-in case with its potential.
    pub case: &'static str,
    /// The operator. The form is the strong one.
    pub sbp: SbpName,
    /// The error whose slope it is.
    pub quantity: Quantity,
    /// The paper's number, which is fitted against 1/N and not against Δγ = 1/(N − 1).
    pub slope: f64,
    /// The smallest and the largest N of the grids on which the errors have this slope. The paper does not name its
    /// grids.
    pub n_range: (usize, usize),
}

/// The built-in cases with the potentials of the paper's convergence study.
pub const BASE_CASES: [&str; 2] = ["linear", "quartic"];

/// Coarse grids, and finer ones, on which ε_x of the quartic potential has the order of SBP42.
const COARSE: (usize, usize) = (16, 64);
const FINE: (usize, usize) = (64, 256);

/// All slopes that the paper reports.
pub const PUBLISHED_SLOPES: [PublishedSlope; 8] = [
    of_x("linear", SbpName::Sbp21, 2.08, COARSE),
    of_t("linear", SbpName::Sbp21, 2.07, COARSE),
    of_x("linear", SbpName::Sbp42, 3.07, COARSE),
    of_t("linear", SbpName::Sbp42, 3.48, COARSE),
    of_x("quartic", SbpName::Sbp21, 2.08, COARSE),
    of_t("quartic", SbpName::Sbp21, 2.06, COARSE),
    of_x("quartic", SbpName::Sbp42, 2.84, FINE),
    of_t("quartic", SbpName::Sbp42, 3.13, FINE),
];

const fn of_x(case: &'static str, sbp: SbpName, slope: f64, n_range: (usize, usize)) -> PublishedSlope {
    PublishedSlope { case, sbp, quantity: Quantity::EPS_X_FINAL, slope, n_range }
}

const fn of_t(case: &'static str, sbp: SbpName, slope: f64, n_range: (usize, usize)) -> PublishedSlope {
    PublishedSlope { quantity: Quantity::EPS_T_FINAL, ..of_x(case, sbp, slope, n_range) }
}

/// The published slope of one quantity, if it exists.
pub fn published(case: &str, sbp: SbpName, quantity: Quantity) -> Option<&'static PublishedSlope> {
    PUBLISHED_SLOPES.iter().find(|one| one.case == case && one.sbp == sbp && one.quantity == quantity)
}
