//! The status of a cell, and the rules for it.
//!
//! A result is judged by its trajectory and never by its charges. The sizes that errors are compared with come from the
//! reference over the same length: A is half the range of x, W is the largest |dx/dγ|, and T = A / max |dx/dt| is the
//! time in which the particle moves by A (at most t_f − t_i).
//!
//! In a scene every active coordinate has its A, and coordinates with the same g_aa at the start share the largest. Γ
//! is the shortest range of γ in which one of them moves by its A, at most the length of the run. An ignorable
//! coordinate is felt as t is: its T is max |q̇|·Γ. W² is what motion contributes to K: at most over the run, the sum
//! of the |g_ab q̇^a q̇^b| without the largest of them. In the rules x stands for every active coordinate, and t for
//! every ignorable one.
//!
//! The rules, of which the first that holds gives the status:
//!
//! 1. no critical point: the solve ends without one; an implicit step of another method does not converge, or has too
//!    many steps
//! 2. leaves the domain: the solve, or another method, meets g00 ≤ 0, or a determinant of the metric that changes its
//!    sign
//! 3. diverged: an error of x above [`DIVERGED`]·A, which is twice the distance of any two points of the motion; or a
//!    number is not finite
//! 4. accurate: errors of x ≤ [`ACCURATE`]·A and of t ≤ [`ACCURATE`]·T at every node, so that the curves cannot be told
//!    apart by eye
//! 5. sawtooth: the amplitude of the (−1)^k component of x is above [`SAWTOOTH`]·A and [`ROUGHER`] times that of the
//!    reference on the same nodes
//! 6. drifting: the mean of K over the last quarter of the nodes differs from that over the first by more than
//!    [`DRIFTING`]·W²
//! 7. inaccurate: anything else: the orbit is right, but the time is wrong
//!
//! If the geodesic itself leaves the domain before the end, there is no trajectory to compare with. A result is then
//! called inaccurate, and its errors are empty.

use crate::solve::Status;

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

/// The outcome of a cell of the map.
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
    /// The status of a solve that ended without a solution.
    pub(super) fn of(status: Status) -> Self {
        if status == Status::OutsideDomain { Self::OutsideDomain } else { Self::NoCriticalPoint }
    }

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
#[derive(Debug, Clone, PartialEq)]
pub struct Sizes {
    /// A of active coordinates and T of ignorable ones, in the order of the coordinates.
    pub q: Vec<f64>,
    /// W².
    pub k: f64,
}

/// The measurements by which a result is judged.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Evidence {
    /// Largest error of every coordinate over the nodes; `None` without a reference.
    pub errors: Option<Vec<f64>>,
    /// Amplitude of the (−1)^k component of active coordinates, and that of the reference on the same nodes; none if
    /// the nodes are not equidistant, or too few.
    pub sawtooth: Vec<(usize, [f64; 2])>,
    /// Mean ΔK over the last quarter of the nodes minus that over the first.
    pub k_drift: f64,
}

/// The amplitude of a sawtooth of a coordinate of this size that is attributed to the computational mode, where the
/// reference has the amplitude `smooth` on the same nodes.
pub(super) fn rough_above(size: f64, smooth: f64) -> f64 {
    (SAWTOOTH * size).max(ROUGHER * smooth)
}

/// The status of a result; `active` are the coordinates that have an amplitude.
pub fn judge(evidence: &Evidence, sizes: &Sizes, active: &[usize]) -> CellStatus {
    let Some(errors) = &evidence.errors else { return CellStatus::Inaccurate };
    // Written so that a NaN is never accurate.
    if errors.iter().any(|error| error.is_nan()) || active.iter().any(|&a| errors[a] > DIVERGED * sizes.q[a]) {
        return CellStatus::Diverged;
    }
    if errors.iter().zip(&sizes.q).all(|(&error, &size)| error <= ACCURATE * size) {
        return CellStatus::Accurate;
    }
    if evidence.sawtooth.iter().any(|&(a, [amplitude, smooth])| amplitude > rough_above(sizes.q[a], smooth)) {
        return CellStatus::Sawtooth;
    }
    if evidence.k_drift.abs() > DRIFTING * sizes.k { CellStatus::Drifting } else { CellStatus::Inaccurate }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_status_has_its_rule() {
        let sizes = Sizes { q: vec![2.0, 1.0], k: 4.0 };
        let judge = |evidence: &Evidence| judge(evidence, &sizes, &[1]);
        let errors = |x, t| Evidence { errors: Some(vec![t, x]), ..Evidence::default() };
        assert_eq!(judge(&errors(1e-2, 2e-2)), CellStatus::Accurate);
        assert_eq!(judge(&errors(1e-2, 3e-2)), CellStatus::Inaccurate, "t counts as much as x");
        assert_eq!(judge(&errors(2e-2, 0.0)), CellStatus::Inaccurate);
        assert_eq!(judge(&errors(4.1, 0.0)), CellStatus::Diverged);
        assert_eq!(judge(&errors(0.0, 9.0)), CellStatus::Inaccurate, "time has no amplitude");
        assert_eq!(judge(&errors(f64::NAN, 0.0)), CellStatus::Diverged);
        assert_eq!(judge(&errors(0.0, f64::NAN)), CellStatus::Diverged);
        assert_eq!(judge(&Evidence::default()), CellStatus::Inaccurate, "nothing to be accurate against");
        let rough = |amplitude, smooth| Evidence { sawtooth: vec![(1, [amplitude, smooth])], ..errors(0.5, 0.0) };
        assert_eq!(judge(&rough(0.02, 0.001)), CellStatus::Sawtooth);
        assert_eq!(judge(&rough(0.02, 0.01)), CellStatus::Inaccurate, "the motion itself is as rough");
        assert_eq!(judge(&Evidence { k_drift: -0.05, ..errors(0.5, 0.0) }), CellStatus::Drifting);
        assert_eq!(judge(&Evidence { k_drift: 0.03, ..errors(0.5, 0.0) }), CellStatus::Inaccurate, "of W² = 4");
        assert_eq!(judge(&Evidence { k_drift: -0.05, ..rough(0.02, 0.0) }), CellStatus::Sawtooth);
        // A small error is enough for an accurate trajectory, even with a sawtooth.
        let small = Evidence { sawtooth: vec![(1, [0.02, 0.0])], ..errors(5e-3, 0.0) };
        assert_eq!(judge(&small), CellStatus::Accurate);
    }

    #[test]
    fn every_active_coordinate_is_judged_by_its_own_size() {
        let sizes = Sizes { q: vec![1.0, 100.0], k: 1.0 };
        let judge = |evidence: &Evidence| judge(evidence, &sizes, &[0, 1]);
        let errors = |errors: [f64; 2]| Evidence { errors: Some(errors.to_vec()), ..Evidence::default() };
        assert_eq!(judge(&errors([1e-2, 1.0])), CellStatus::Accurate);
        assert_eq!(judge(&errors([1.1e-2, 0.0])), CellStatus::Inaccurate);
        assert_eq!(judge(&errors([4.1, 0.0])), CellStatus::Diverged);
        assert_eq!(judge(&errors([0.0, 401.0])), CellStatus::Diverged);
        let rough = |a, amplitude| Evidence { sawtooth: vec![(a, [amplitude, 0.0])], ..errors([0.5, 0.0]) };
        assert_eq!(judge(&rough(0, 0.02)), CellStatus::Sawtooth);
        assert_eq!(judge(&rough(1, 0.02)), CellStatus::Inaccurate);
    }
}
