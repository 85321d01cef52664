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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wrong_k_makes_the_way_wrong_by_that_share() {
        // ẋ² is 4 but for a quarter of the run, in which K is off, and ẋ² with it.
        let (delta, v) = (1e-6, 2.0_f64);
        let off = 0.25 * ((v * v + delta).sqrt() / v - 1.0);
        for sign in [1.0, -1.0] {
            // In both directions of γ; the motion counts by its largest value.
            let mut between = Between::default();
            for k in 0..400 {
                let (here, motion) = (if k < 100 { sign * delta } else { 0.0 }, if k % 2 == 0 { v * v } else { 1.0 });
                between.see(sign * 0.005, here, -7.0, motion);
            }
            assert!((between.share() / off - 1.0).abs() < 1e-6, "{} and {off}", between.share());
        }
    }

    #[test]
    fn rounding_of_k_moves_nothing_and_a_nan_is_not_rounding() {
        let share = |delta_k: f64| {
            let mut between = Between::default();
            between.see(1.0, delta_k, 1e3, 1.0);
            between.share()
        };
        assert_eq!((share(0.0), share(1e-9), share(-1e-9)), (0.0, 0.0, 0.0));
        assert!(share(1e-8) > 0.0 && share(f64::NAN).is_nan());
        assert_eq!(Between::default().share(), 0.0);
    }

    #[test]
    fn points_are_the_middles_of_equal_parts() {
        for points in [1, 8, 9] {
            let places: Vec<f64> = fractions(points).collect();
            assert_eq!(places.len(), points);
            assert!(places.iter().zip(places.iter().rev()).all(|(a, b)| (a + b - 1.0).abs() < 1e-15), "{places:?}");
            assert!(places.windows(2).all(|pair| (pair[1] - pair[0] - 1.0 / points as f64).abs() < 1e-15));
        }
        // Windows of any length have the points of all of the run among them, and a few at least.
        assert_eq!([1.0, 0.5, 0.25, 1e-9].map(points_in), [PROBES, PROBES / 2, PROBES / 4, IN_A_WINDOW]);
    }
}
