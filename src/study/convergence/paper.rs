//! The slopes that the paper reports: arXiv:2307.04490, section 4.

use super::Quantity;
use crate::case::SbpName;

/// A slope of the paper.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PublishedSlope {
    /// The shipped case with its potential.
    pub case: &'static str,
    /// Operator; the form is the strong one.
    pub sbp: SbpName,
    /// The error.
    pub quantity: Quantity,
    /// The paper's number, a fit against 1/N and not against Δγ = 1/(N − 1).
    pub slope: f64,
    /// The grids on which the errors have this slope, from the smallest N to the largest; the paper names none.
    pub n_range: (usize, usize),
}

/// The potentials of the paper's convergence study: the names of their shipped cases.
pub const BASE_CASES: [&str; 2] = ["linear", "quartic"];

/// Coarse grids, and the grids from which on ε_x of the quartic potential has SBP42's order.
const COARSE: (usize, usize) = (16, 64);
const FINE: (usize, usize) = (64, 256);

/// Everything that the paper reports.
pub const PUBLISHED_SLOPES: [PublishedSlope; 8] = [
    at_end("linear", SbpName::Sbp21, Quantity::EpsXFinal, 2.08, COARSE),
    at_end("linear", SbpName::Sbp21, Quantity::EpsTFinal, 2.07, COARSE),
    at_end("linear", SbpName::Sbp42, Quantity::EpsXFinal, 3.07, COARSE),
    at_end("linear", SbpName::Sbp42, Quantity::EpsTFinal, 3.48, COARSE),
    at_end("quartic", SbpName::Sbp21, Quantity::EpsXFinal, 2.08, COARSE),
    at_end("quartic", SbpName::Sbp21, Quantity::EpsTFinal, 2.06, COARSE),
    at_end("quartic", SbpName::Sbp42, Quantity::EpsXFinal, 2.84, FINE),
    at_end("quartic", SbpName::Sbp42, Quantity::EpsTFinal, 3.13, FINE),
];

const fn at_end(
    case: &'static str,
    sbp: SbpName,
    quantity: Quantity,
    slope: f64,
    n_range: (usize, usize),
) -> PublishedSlope {
    PublishedSlope { case, sbp, quantity, slope, n_range }
}

/// The published slope of one quantity, if it exists.
pub fn published(case: &str, sbp: SbpName, quantity: Quantity) -> Option<&'static PublishedSlope> {
    PUBLISHED_SLOPES.iter().find(|one| one.case == case && one.sbp == sbp && one.quantity == quantity)
}
