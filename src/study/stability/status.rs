//! The status of a cell, and the rules for it.
//!
//! A result is judged by its trajectory and never by Q_t. The sizes that errors are compared with come from the
//! reference over the same length: A is half the range of x, W is the largest |dx/dγ|, and T = A / max |dx/dt| is the
//! time in which the particle moves by A (at most t_f − t_i).
//!
//! | status | rule, the first that holds |
//! |---|---|
//! | no critical point | the solve ends without one; an implicit step of another method does not converge, or has too many steps |
//! | leaves the domain | the solve, or another method, meets g00 ≤ 0 |
//! | diverged | an error of x above [`DIVERGED`]·A, which is twice the distance of any two points of the motion; or a number is not finite |
//! | accurate | errors of x ≤ [`ACCURATE`]·A and of t ≤ [`ACCURATE`]·T at every node, so that the curves cannot be told apart by eye |
//! | sawtooth | the amplitude of the (−1)^k component of x is above [`SAWTOOTH`]·A and [`ROUGHER`] times that of the reference on the same nodes |
//! | drifting | the mean of K over the last quarter of the nodes differs from that over the first by more than [`DRIFTING`]·W² |
//! | inaccurate | anything else: the orbit is right, but the time is wrong |
//!
//! If the geodesic itself leaves the domain before the end, there is no trajectory to compare with. A result is then
//! called inaccurate, and its errors are empty.

/// Largest error of an accurate trajectory, relative to A and T.
pub const ACCURATE: f64 = 1e-2;
/// A wrong time alone causes errors of at most two amplitudes; twice that means another motion.
pub const DIVERGED: f64 = 4.0;
/// A sawtooth smaller than this share of A is not the cause of an inaccurate result.
pub const SAWTOOTH: f64 = 1e-2;
/// The sawtooth is measured by fourth differences, which a smooth motion has on a coarse grid too. It is attributed to
/// the computational mode if it is this many times larger than that of the reference.
pub const ROUGHER: f64 = 3.0;
/// K = g00 ṫ² − ẋ² belongs to another orbit when it has changed by this share of ẋ².
pub const DRIFTING: f64 = 1e-2;

/// How a cell of the map ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum CellStatus {
    /// The trajectory agrees with the reference at every node.
    Accurate,
    /// The orbit is kept, but the phase is lost.
    Inaccurate,
    /// Even and odd nodes have separated: the computational mode.
    Sawtooth,
    /// K has drifted away from its value.
    Drifting,
    /// The result is another motion, or not finite.
    Diverged,
    /// The solve has found no critical point, or another method has failed.
    NoCriticalPoint,
    /// The trajectory has met g00 ≤ 0.
    OutsideDomain,
}

impl CellStatus {
    /// All of them, from best to worst.
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

/// The sizes by which a trajectory is judged.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sizes {
    /// A.
    pub x: f64,
    /// T.
    pub t: f64,
    /// W².
    pub k: f64,
}

/// The measurements by which a result is judged.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Evidence {
    /// Largest errors of x and t over the nodes; `None` without a reference.
    pub errors: Option<[f64; 2]>,
    /// Amplitude of the (−1)^k component of x, and that of the reference on the same nodes; `None` if the nodes are not
    /// equidistant, or too few.
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
        // A small error is enough for an accurate trajectory, even with a sawtooth.
        let small = Evidence { sawtooth: Some([0.02, 0.0]), ..errors(5e-3, 0.0) };
        assert_eq!(judge(&small, &sizes), CellStatus::Accurate);
    }
}
