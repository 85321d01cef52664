//! Whether a solve that serves to judge another one has itself stepped over a feature: a hump of V, say, that is
//! narrower than its windows and lies between their nodes.
//!
//! Such a solve is smooth where the motion is not, and nothing on its nodes tells. But K at a point between them is
//! that of V or the metric *there*: inside of a hump that it does not know, K is off by all that the hump does to the
//! motion.

/// So many points are looked at, spread evenly over the run.
pub(super) const PROBES: usize = 8192;
/// Of these so many in every window at least.
const IN_A_WINDOW: usize = 8;
/// A deviation of K below this share of the largest term of K can be rounding.
const ROUNDING: f64 = 1e4 * f64::EPSILON;

/// What K is off by at points between nodes.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Between {
    /// The integral of |ΔK| over γ.
    drift: f64,
    /// What motion contributes to K, at most.
    motion: f64,
    /// The length of γ that was looked at.
    length: f64,
}

impl Between {
    /// Takes a point into account, for this `length` of γ around it: the deviation of K there, the largest term of K,
    /// and what motion contributes to K.
    pub(super) fn see(&mut self, length: f64, delta_k: f64, largest_term: f64, motion: f64) {
        self.motion = self.motion.max(motion);
        self.length += length.abs();
        // NaN is no rounding.
        let is_rounding = delta_k.abs() <= ROUNDING * largest_term.abs();
        if !is_rounding {
            self.drift += length.abs() * delta_k.abs();
        }
    }

    /// The share of its way by which a motion may be off. Where K is off by ΔK, the velocity is by half the share that
    /// ΔK is of the motion.
    pub(super) fn share(self) -> f64 {
        if self.drift == 0.0 { 0.0 } else { 0.5 * self.drift / (self.motion * self.length) }
    }
}

/// The number of points in a window that is this share of the run.
pub(super) fn points_in(share: f64) -> usize {
    (((PROBES as f64) * share).ceil() as usize).clamp(IN_A_WINDOW, PROBES)
}

/// The places of that many points in a window, as fractions of it.
pub(super) fn fractions(points: usize) -> impl Iterator<Item = f64> {
    (0..points).map(move |k| (k as f64 + 0.5) / points as f64)
}
