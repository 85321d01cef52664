//! The status of a cell, and the rules for it.
//!
//! A result is judged by its trajectory and never by its charges. `docs/trust.md` has the rules, of which the first
//! that holds gives the status, and the sizes A, W and T that errors are compared with. They come from the reference
//! over the same length. With Γ, the shortest range of γ in which an active coordinate of a scene moves by its A, at
//! most the length of the run, the T of an ignorable one is max |q̇|·Γ. In the rules x stands for every active
//! coordinate, and t for every ignorable one.
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
#[derive(Debug, Clone)]
pub(super) struct Sizes {
    /// A of active coordinates and T of ignorable ones, in the order of the coordinates.
    pub(super) q: Vec<f64>,
    /// W².
    pub(super) k: f64,
}

/// The amplitude of a sawtooth of a coordinate of this size that is attributed to the computational mode, where the
/// reference has the amplitude `smooth` on the same nodes.
pub(super) fn rough_above(size: f64, smooth: f64) -> f64 {
    (SAWTOOTH * size).max(ROUGHER * smooth)
}

/// The status of a result, from the largest error of every coordinate; from the amplitude of the (−1)^k component of
/// active coordinates, and that of the reference on the same nodes; and from the drift of K: its mean over the last
/// quarter of the nodes minus that over the first. `active` are the coordinates that have an amplitude.
pub(super) fn judge(
    errors: &[f64],
    sawtooth: &[(usize, [f64; 2])],
    k_drift: f64,
    sizes: &Sizes,
    active: &[usize],
) -> CellStatus {
    // Written so that a NaN is never accurate.
    if errors.iter().any(|error| error.is_nan()) || active.iter().any(|&a| errors[a] > DIVERGED * sizes.q[a]) {
        return CellStatus::Diverged;
    }
    if errors.iter().zip(&sizes.q).all(|(&error, &size)| error <= ACCURATE * size) {
        return CellStatus::Accurate;
    }
    if sawtooth.iter().any(|&(a, [amplitude, smooth])| amplitude > rough_above(sizes.q[a], smooth)) {
        return CellStatus::Sawtooth;
    }
    if k_drift.abs() > DRIFTING * sizes.k { CellStatus::Drifting } else { CellStatus::Inaccurate }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_status_has_its_rule() {
        // Of t and x, and of two active coordinates, of which each is judged by its own size.
        let (one, both) = ((vec![2.0, 1.0], &[1][..]), (vec![1.0, 100.0], &[0, 1][..]));
        let rough = |a: usize, amplitude, smooth| vec![(a, [amplitude, smooth])];
        for ((sizes, active), errors, sawtooth, k_drift, status, why) in [
            (&one, [2e-2, 1e-2], vec![], 0.0, CellStatus::Accurate, ""),
            (&one, [3e-2, 1e-2], vec![], 0.0, CellStatus::Inaccurate, "t counts as much as x"),
            (&one, [0.0, 2e-2], vec![], 0.0, CellStatus::Inaccurate, ""),
            (&one, [0.0, 4.1], vec![], 0.0, CellStatus::Diverged, ""),
            (&one, [9.0, 0.0], vec![], 0.0, CellStatus::Inaccurate, "time has no amplitude"),
            (&one, [0.0, f64::NAN], vec![], 0.0, CellStatus::Diverged, ""),
            (&one, [f64::NAN, 0.0], vec![], 0.0, CellStatus::Diverged, ""),
            (&one, [0.0, 0.5], rough(1, 0.02, 0.001), 0.0, CellStatus::Sawtooth, ""),
            (&one, [0.0, 0.5], rough(1, 0.02, 0.01), 0.0, CellStatus::Inaccurate, "the motion itself is as rough"),
            (&one, [0.0, 0.5], vec![], -0.05, CellStatus::Drifting, ""),
            (&one, [0.0, 0.5], vec![], 0.03, CellStatus::Inaccurate, "of W² = 4"),
            (&one, [0.0, 0.5], rough(1, 0.02, 0.0), -0.05, CellStatus::Sawtooth, ""),
            (&one, [0.0, 5e-3], rough(1, 0.02, 0.0), 0.0, CellStatus::Accurate, "a small error is enough"),
            (&both, [1e-2, 1.0], vec![], 0.0, CellStatus::Accurate, ""),
            (&both, [1.1e-2, 0.0], vec![], 0.0, CellStatus::Inaccurate, ""),
            (&both, [4.1, 0.0], vec![], 0.0, CellStatus::Diverged, ""),
            (&both, [0.0, 401.0], vec![], 0.0, CellStatus::Diverged, ""),
            (&both, [0.5, 0.0], rough(0, 0.02, 0.0), 0.0, CellStatus::Sawtooth, ""),
            (&both, [0.5, 0.0], rough(1, 0.02, 0.0), 0.0, CellStatus::Inaccurate, ""),
        ] {
            let found = judge(&errors, &sawtooth, k_drift, &Sizes { q: sizes.clone(), k: 4.0 }, active);
            assert_eq!(found, status, "{errors:?} {sawtooth:?}: {why}");
        }
    }
}
