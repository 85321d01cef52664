//! What the modes of a window mean for its error.

use super::work::Tail;
use crate::engine::lobatto::control;

/// The constants of scenes. Errors are relative to the sizes of the coordinates.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tuning {
    /// Of the controller.
    pub(super) control: control::Tuning,
    /// The error at the end of a window in units of the squared modes over the largest value, at most.
    pub(super) end: f64,
    /// The same in units of the modes in a window where the metric is rough.
    pub(super) end_where_rough: f64,
    /// The error inside a window in units of the modes that it does not see: of what is integrated once, and n² times
    /// that of what is integrated twice.
    pub(super) inside: [f64; 2],
    /// Modes above this share of the largest value do not fall off: the error at the end has their own size.
    pub(super) rough: f64,
    /// The margin of the error inside a window.
    pub(super) margin: f64,
    /// The rate of the motion is uneven if it changes by more than this factor in a window.
    pub(super) uneven: f64,
}

/// The constants in use.
pub(super) const TUNING: Tuning = Tuning {
    control: control::Tuning { share: 0.04, iteration: 0.0015, ..control::ONE_COORDINATE },
    end: 0.9,
    end_where_rough: 30.0,
    inside: [2.0, 50.0],
    rough: 0.03,
    margin: 2.5,
    uneven: 1.35,
};

/// A size below which the values of a row are noise, in units of the error's weight.
const NOISE: f64 = 1e-12;

/// The tail relative to the largest value, or to noise where that is more.
pub(super) fn ratio(tail: Tail, weight: f64) -> f64 {
    let floor = if weight > 0.0 { NOISE / weight } else { 0.0 };
    let largest = tail.largest.max(floor);
    if largest > 0.0 { tail.tail / largest } else { 0.0 }
}

impl Tuning {
    /// The error at the end of a window that this tail shows, in units of the row.
    pub(super) fn end_of(&self, tail: Tail, weight: f64) -> f64 {
        let ratio = ratio(tail, weight);
        tail.tail * if ratio > self.rough { self.end_where_rough } else { self.end * ratio }
    }
}

/// The factor by which modes fall from one to the next, in a window where the tail is this part of the largest value.
pub(super) fn fall(ratio: f64, points: usize) -> f64 {
    ratio.min(0.5).powf(1.0 / (points - 2) as f64)
}

/// The modes beyond the highest in units of the tail: r² + r³ + … together, as they fall by the factor r.
pub(super) fn unseen(r: f64) -> f64 {
    r * r / (1.0 - r)
}

#[cfg(test)]
mod tests {
    use super::{NOISE, TUNING, Tail, fall, ratio, unseen};

    #[test]
    fn the_error_at_the_end_is_the_square_of_the_tail() {
        let end = |tail, largest| TUNING.end_of(Tail { tail, largest }, 1.0);
        let tail = 0.5_f64.powi(16);
        assert_eq!(end(tail, 1.0), TUNING.end * tail * tail);
        assert_eq!(end(0.5, 1.0), 0.5 * TUNING.end_where_rough);
        // The tail of nothing but noise counts as little.
        assert!(end(1e-17, 1e-17) < 1e-22);
        assert_eq!(end(0.0, 0.0), 0.0);
    }

    #[test]
    fn modes_beyond_the_highest_fall_on() {
        for (ratio, points) in [(1e-3, 16), (1e-9, 24), (0.3, 20)] {
            let r = fall(ratio, points);
            assert!((r.powi(points as i32 - 2) / ratio - 1.0).abs() < 1e-12);
            let sum: f64 = (2..2000).map(|k| r.powi(k)).sum();
            assert!((unseen(r) / sum - 1.0).abs() < 1e-9, "{r}");
        }
        // Where they do not fall, they are taken to fall a little.
        assert_eq!(fall(1.0, 16), fall(0.5, 16));
    }

    #[test]
    fn noise_is_in_units_of_the_row() {
        let of = |tail, largest, weight| ratio(Tail { tail, largest }, weight);
        assert_eq!(of(1e-3, 2.0, 1.0), 5e-4);
        assert_eq!(of(1e-15, 1e-15, 4.0), 1e-15 / (NOISE / 4.0));
        assert_eq!((of(1e-3, 2e-3, 0.0), of(0.0, 0.0, 0.0)), (0.5, 0.0));
    }
}
