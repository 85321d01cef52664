//! The status of a cell, and the reasons for it.
//!
//! A result is judged by its trajectory and never by Q_t. Sizes come from the reference over the same length: A is half
//! the range of x, W the largest |dx/dγ|, and T = A / max |dx/dt| the time in which the motion is felt (at most
//! t_f − t_i).
//!
//! | status | rule, the first that holds |
//! |---|---|
//! | no critical point | the solve ends without one; an implicit step of another method does not converge, or has too many steps |
//! | leaves the domain | the solve, or another method, meets g00 ≤ 0 |
//! | diverged | an error of x above [`DIVERGED`]·A: no two points of the motion are half as far apart; or a number is not finite |
//! | accurate | errors of x ≤ [`ACCURATE`]·A and of t ≤ [`ACCURATE`]·T at every node: curves that cannot be told apart by eye |
//! | sawtooth | the amplitude of the (−1)^k component of x is above [`SAWTOOTH`]·A and [`ROUGHER`] times that of the reference on the same nodes |
//! | drifting | the mean of K over the last quarter of the nodes differs from that over the first by more than [`DRIFTING`]·W² |
//! | inaccurate | anything else: on the right orbit, at the wrong time |
//!
//! Where the geodesic itself has left the domain there is nothing to be accurate against: a result there is inaccurate,
//! and its errors stay empty.

/// Largest share of the amplitude that an accurate trajectory is off by.
pub const ACCURATE: f64 = 1e-2;
/// Errors of two amplitudes are the most that a wrong time can cause; twice that means another motion.
pub const DIVERGED: f64 = 4.0;
/// A sawtooth smaller than this does not cause an inaccurate result.
pub const SAWTOOTH: f64 = 1e-2;
/// A smooth motion on a coarse grid has fourth differences too; the computational mode is what exceeds them by this.
pub const ROUGHER: f64 = 3.0;
/// K = g00 ṫ² − ẋ² belongs to another orbit when it has changed by this share of ẋ².
pub const DRIFTING: f64 = 1e-2;

/// How a cell of the map ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum CellStatus {
    /// Checked against the reference at every node.
    Accurate,
    /// The orbit is kept, the phase is lost.
    Inaccurate,
    /// Even and odd nodes have separated: the computational mode.
    Sawtooth,
    /// K leaves its value for good.
    Drifting,
    /// Another motion, or none.
    Diverged,
    /// Nothing found.
    NoCriticalPoint,
    /// g00 ≤ 0.
    OutsideDomain,
}

impl CellStatus {
    /// From best to worst.
    pub const ALL: [Self; 7] = [
        Self::Accurate,
        Self::Inaccurate,
        Self::Sawtooth,
        Self::Drifting,
        Self::Diverged,
        Self::NoCriticalPoint,
        Self::OutsideDomain,
    ];

    /// The name used in files.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Accurate => "accurate",
            Self::Inaccurate => "inaccurate",
            Self::Sawtooth => "sawtooth",
            Self::Drifting => "drifting",
            Self::Diverged => "diverged",
            Self::NoCriticalPoint => "no-critical-point",
            Self::OutsideDomain => "outside-domain",
        }
    }

    /// The name for display.
    pub fn label(self) -> &'static str {
        match self {
            Self::NoCriticalPoint => "no critical point",
            Self::OutsideDomain => "leaves the domain",
            _ => self.as_str(),
        }
    }
}

/// What a trajectory is measured by.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sizes {
    /// A.
    pub x: f64,
    /// T.
    pub t: f64,
    /// W².
    pub k: f64,
}

/// What was measured on a result.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Evidence {
    /// Largest errors of x and t over the nodes; none without a reference.
    pub errors: Option<[f64; 2]>,
    /// Amplitude of the (−1)^k component, and that of the reference on the same nodes; none where nodes are not
    /// equidistant or too few.
    pub sawtooth: Option<[f64; 2]>,
    /// Mean ΔK over the last quarter of the nodes minus that over the first.
    pub k_drift: f64,
}

/// The status of a result.
pub fn judge(evidence: &Evidence, sizes: &Sizes) -> CellStatus {
    let Some([x, t]) = evidence.errors else { return CellStatus::Inaccurate };
    // Written so that a NaN is never accurate.
    if x.is_nan() || t.is_nan() || x > DIVERGED * sizes.x {
        return CellStatus::Diverged;
    }
    if x <= ACCURATE * sizes.x && t <= ACCURATE * sizes.t {
        return CellStatus::Accurate;
    }
    let is_rough = |[amplitude, smooth]: [f64; 2]| amplitude > SAWTOOTH * sizes.x && amplitude > ROUGHER * smooth;
    if evidence.sawtooth.is_some_and(is_rough) {
        return CellStatus::Sawtooth;
    }
    if evidence.k_drift.abs() > DRIFTING * sizes.k { CellStatus::Drifting } else { CellStatus::Inaccurate }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_status_has_its_rule() {
        let sizes = Sizes { x: 1.0, t: 2.0, k: 4.0 };
        let errors = |x, t| Evidence { errors: Some([x, t]), ..Evidence::default() };
        assert_eq!(judge(&errors(1e-2, 2e-2), &sizes), CellStatus::Accurate);
        assert_eq!(judge(&errors(1e-2, 3e-2), &sizes), CellStatus::Inaccurate, "t counts as much as x");
        assert_eq!(judge(&errors(2e-2, 0.0), &sizes), CellStatus::Inaccurate);
        assert_eq!(judge(&errors(4.1, 0.0), &sizes), CellStatus::Diverged);
        assert_eq!(judge(&errors(f64::NAN, 0.0), &sizes), CellStatus::Diverged);
        assert_eq!(judge(&errors(0.0, f64::NAN), &sizes), CellStatus::Diverged);
        assert_eq!(judge(&Evidence::default(), &sizes), CellStatus::Inaccurate, "nothing to be accurate against");
        let rough = |amplitude, smooth| Evidence { sawtooth: Some([amplitude, smooth]), ..errors(0.5, 0.0) };
        assert_eq!(judge(&rough(0.02, 0.001), &sizes), CellStatus::Sawtooth);
        assert_eq!(judge(&rough(0.02, 0.01), &sizes), CellStatus::Inaccurate, "the motion itself is as rough");
        assert_eq!(judge(&Evidence { k_drift: -0.05, ..errors(0.5, 0.0) }, &sizes), CellStatus::Drifting);
        assert_eq!(judge(&Evidence { k_drift: -0.05, ..rough(0.02, 0.0) }, &sizes), CellStatus::Sawtooth);
        // An accurate trajectory is accurate, whatever else it shows.
        let small = Evidence { sawtooth: Some([0.02, 0.0]), ..errors(5e-3, 0.0) };
        assert_eq!(judge(&small, &sizes), CellStatus::Accurate);
    }
}
