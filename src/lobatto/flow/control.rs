//! How long the next window is.

use super::course::Course;
use super::work::Tail;

/// The constants of the controller. Errors are relative to the sizes of the coordinates.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tuning {
    /// The share of a single window in units of the accuracy; it falls with the number of windows to the power 5/4:
    /// errors add up, and errors of the period grow with those of the energy.
    pub(super) share: f64,
    /// The least share: no truncation error is left to reduce.
    pub(super) least_share: f64,
    /// The part of a share that the sweeps may leave.
    pub(super) sweeps: f64,
    /// The target for the error of a window in units of its share, and the maximum.
    pub(super) aim: f64,
    pub(super) most_excess: f64,
    /// The excess that marks a window as far too long before it is solved.
    pub(super) hopeless: f64,
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
    /// Windows are made longer after this many that would all have allowed it, or at once if they can be this much
    /// longer: over a turn the errors of equal windows nearly cancel.
    pub(super) pause: usize,
    pub(super) much_longer: f64,
    pub(super) longer: f64,
    /// The rate of the motion is uneven if it changes by more than this factor in a window.
    pub(super) uneven: f64,
    /// The number of sweeps that marks a window as slow: longer ones would not be cheaper.
    pub(super) slow: usize,
}

/// The constants in use.
pub(super) const TUNING: Tuning = Tuning {
    share: 0.04,
    least_share: 1e-22,
    sweeps: 0.0015,
    aim: 0.3,
    most_excess: 4.0,
    hopeless: 1e4,
    end: 0.9,
    end_where_rough: 30.0,
    inside: [2.0, 50.0],
    rough: 0.03,
    margin: 2.5,
    pause: 12,
    much_longer: 1.6,
    longer: 1.1,
    uneven: 1.35,
    slow: 14,
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

/// Chooses lengths from the excess of windows: their error in units of their share.
#[derive(Debug, Clone)]
pub(super) struct Controller {
    tuning: Tuning,
    /// The error of a window falls with this power of its length.
    order: f64,
    /// What windows of this run may add together.
    accuracy: f64,
    /// The length to try next.
    pub(super) h: f64,
    /// The largest excess since the length was judged last, and how many windows that was.
    worst: f64,
    count: usize,
    refused: usize,
}

impl Controller {
    /// For windows of `points` nodes, the first of length `h`.
    pub(super) fn new(tuning: Tuning, points: usize, accuracy: f64, h: f64) -> Self {
        let order = (2 * points - 4) as f64;
        Self { tuning, order, accuracy, h, worst: 0.0, count: 0, refused: 0 }
    }

    /// What a window may add to the error that is this part of the run.
    pub(super) fn share(&self, part: f64) -> f64 {
        let windows = (1.0 / part).max(1.0);
        (self.tuning.share * self.accuracy / (windows * windows.sqrt().sqrt())).max(self.tuning.least_share)
    }

    /// Whether nothing is gained by shares smaller than this.
    pub(super) fn is_exhausted(&self, share: f64) -> bool {
        share <= self.tuning.least_share
    }

    /// The error that the sweeps may leave in a window that may add `share`.
    pub(super) fn tolerance(&self, share: f64) -> f64 {
        self.tuning.sweeps * share
    }

    fn fit(&self, excess: f64) -> f64 {
        (self.tuning.aim / excess).powf(1.0 / self.order)
    }

    /// A window with that excess, infinite if it was not solved, is tried again shorter.
    pub(super) fn refuse(&mut self, excess: f64) {
        self.refused += 1;
        let factor = if excess.is_finite() { self.fit(excess).clamp(0.1, 0.9) } else { 0.5 };
        // Where the metric is not smooth, errors shrink more slowly than the order promises.
        self.h *= if self.refused > 3 { factor.min(0.3) } else { factor };
        (self.worst, self.count) = (0.0, 0);
    }

    /// Whether a window is far too long, as its first sweeps show.
    pub(super) fn is_hopeless(&self, excess: f64) -> bool {
        excess.is_nan() || excess > self.tuning.hopeless
    }

    /// Whether a window with that excess is good enough.
    pub(super) fn accepts(&self, excess: f64) -> bool {
        excess <= self.tuning.most_excess
    }

    /// A window of length `h` with that excess, solved in so many sweeps, was accepted. The rate of the motion in it
    /// took that `course`.
    ///
    /// Where the rate changes much, as towards a periapsis and away from it, the length of the next window follows from
    /// the poles of the course.
    pub(super) fn accept(&mut self, h: f64, excess: f64, sweeps: usize, course: Course) {
        self.refused = 0;
        if course.is_uneven(self.tuning.uneven) {
            let fit = self.fit(excess).clamp(0.5, 1.5);
            let fit = if sweeps > self.tuning.slow { fit.min(1.0) } else { fit };
            if let Some(next) = course.next(fit) {
                self.h = h * next.clamp(0.1, 4.0);
                (self.worst, self.count) = (0.0, 0);
                return;
            }
        }
        self.worst = self.worst.max(excess);
        self.count += 1;
        let at_once = excess > 1.0 || excess < self.tuning.aim * self.tuning.much_longer.powf(-self.order);
        if !at_once && self.count < self.tuning.pause {
            return;
        }
        let fit = self.fit(if at_once { excess } else { self.worst });
        let fit = if sweeps > self.tuning.slow { fit.min(1.0) } else { fit };
        if !(1.0..=self.tuning.longer).contains(&fit) {
            self.h = h * fit.clamp(0.5, 2.0);
        }
        (self.worst, self.count) = (0.0, 0);
    }
}

#[cfg(test)]
mod tests {
    use super::{Controller, Course, TUNING, Tail};

    const EVEN: Course = Course { part: 0.5, rates: [1.0; 3], fall: 0.3 };

    fn controller() -> Controller {
        Controller::new(TUNING, 24, 1e-10, 1.0)
    }

    #[test]
    fn lengths_follow_the_excess() {
        let mut control = controller();
        control.refuse(1e6);
        assert!(control.h > 0.6 && control.h < 0.8, "{}", control.h);
        control.refuse(f64::INFINITY);
        assert!(control.h < 0.4);
        // Much shorter than need be: longer at once, but at most twice.
        let h = control.h;
        control.accept(h, 1e-40, 8, EVEN);
        assert_eq!(control.h, 2.0 * h);
        // A little: only after a pause.
        let h = control.h;
        for _ in 1..TUNING.pause {
            control.accept(h, 1e-3, 8, EVEN);
            assert_eq!(control.h, h);
        }
        control.accept(h, 1e-3, 8, EVEN);
        assert!(control.h > h);
        // Slow windows do not grow.
        let h = control.h;
        control.accept(h, 1e-40, TUNING.slow + 1, EVEN);
        assert_eq!(control.h, h);
    }

    #[test]
    fn shares_add_up_to_less_than_the_accuracy() {
        let control = controller();
        for part in [1e-4, 0.01, 2.0] {
            assert!(control.share(part) * (1.0_f64 / part).max(1.0) <= TUNING.share * 1e-10);
        }
        assert!(control.is_exhausted(control.share(1e-30)) && !control.is_exhausted(control.share(0.01)));
    }

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
}
