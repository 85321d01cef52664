//! How long the next window is.

/// The constants of a controller. Errors are relative to the sizes of the coordinates.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tuning {
    /// The share of a single window in units of the accuracy; it falls with the number of windows to the power 5/4:
    /// errors add up, and errors of the period grow with those of the energy.
    pub(super) share: f64,
    /// The least share: no truncation error is left to reduce.
    pub(super) least_share: f64,
    /// The part of a share that the iteration may leave. The modes do not show it.
    pub(super) iteration: f64,
    /// The target for the error of a window in units of its share, and the maximum.
    pub(super) aim: f64,
    pub(super) most_excess: f64,
    /// The excess that marks a window as far too long before it is solved.
    pub(super) hopeless: f64,
    /// Windows are made longer after this many that would all have allowed it, or at once if they can be this much
    /// longer.
    ///
    /// Windows of one length are the rule and others the exception: over a turn of an oscillation the errors of K of
    /// equal windows cancel, as the scheme's leading error is reversible. With lengths that follow the force they add
    /// up, and the same accuracy takes half as many windows again.
    pub(super) pause: usize,
    pub(super) much_longer: f64,
    pub(super) longer: f64,
    /// The number of evaluations that marks a window as slow: longer ones would not be cheaper.
    pub(super) slow: usize,
}

/// The constants in use with one coordinate. Scenes have two of their own.
pub(super) const ONE_COORDINATE: Tuning = Tuning {
    share: 0.05,
    least_share: 1e-22,
    iteration: 0.03,
    aim: 0.3,
    most_excess: 4.0,
    hopeless: 1e4,
    pause: 12,
    much_longer: 1.6,
    longer: 1.1,
    slow: 14,
};

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
        self.tuning.iteration * share
    }

    /// What the iterations of all windows may leave together.
    pub(super) fn left(&self) -> f64 {
        2.0 * self.tuning.iteration * self.tuning.share * self.accuracy
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

    /// A window of length `h` with that excess, solved in so many evaluations, was accepted.
    ///
    /// `foreseen` may know the length of the next one in units of this, so that it comes out as well as one that is
    /// `fit` times as long as this: where the rate of the motion changes much, as towards a periapsis and away from it.
    pub(super) fn accept(
        &mut self,
        h: f64,
        excess: f64,
        evaluations: usize,
        foreseen: impl FnOnce(f64) -> Option<f64>,
    ) {
        self.refused = 0;
        // Where the iteration is slow, longer windows are not cheaper.
        let most = if evaluations > self.tuning.slow { 1.0 } else { f64::INFINITY };
        if let Some(next) = foreseen(self.fit(excess).clamp(0.5, 1.5).min(most)) {
            self.h = h * next.clamp(0.1, 4.0);
            (self.worst, self.count) = (0.0, 0);
            return;
        }
        self.worst = self.worst.max(excess);
        self.count += 1;
        let at_once = excess > 1.0 || excess < self.tuning.aim * self.tuning.much_longer.powf(-self.order);
        if !at_once && self.count < self.tuning.pause {
            return;
        }
        let fit = self.fit(if at_once { excess } else { self.worst }).min(most);
        if !(1.0..=self.tuning.longer).contains(&fit) {
            self.h = h * fit.clamp(0.5, 2.0);
        }
        (self.worst, self.count) = (0.0, 0);
    }
}

#[cfg(test)]
mod tests {
    use super::{Controller, ONE_COORDINATE};

    const EVEN: fn(f64) -> Option<f64> = |_| None;

    fn controller() -> Controller {
        Controller::new(ONE_COORDINATE, 24, 1e-10, 1.0)
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
        for _ in 1..ONE_COORDINATE.pause {
            control.accept(h, 1e-3, 8, EVEN);
            assert_eq!(control.h, h);
        }
        control.accept(h, 1e-3, 8, EVEN);
        assert!(control.h > h);
        // Slow windows do not grow.
        let h = control.h;
        control.accept(h, 1e-40, ONE_COORDINATE.slow + 1, EVEN);
        assert_eq!(control.h, h);
        // What is foreseen decides, within limits; it is asked for as much as the excess allows.
        control.accept(1.0, ONE_COORDINATE.aim, 8, |fit| (fit == 1.0).then_some(0.25));
        assert_eq!(control.h, 0.25);
        control.accept(1.0, 1e-40, 8, |fit| Some(10.0 * fit));
        assert_eq!(control.h, 4.0);
    }

    #[test]
    fn shares_add_up_to_less_than_the_accuracy() {
        let control = controller();
        for part in [1e-4, 0.01, 2.0] {
            assert!(control.share(part) * (1.0_f64 / part).max(1.0) <= ONE_COORDINATE.share * 1e-10);
        }
        assert!(control.is_exhausted(control.share(1e-30)) && !control.is_exhausted(control.share(0.01)));
    }

    /// What iterations may leave is a small part of a share, and in all windows no more than is counted.
    #[test]
    fn what_iterations_leave_adds_up_to_less_than_is_counted() {
        let control = controller();
        for windows in [1, 10, 10_000] {
            let share = control.share(1.0 / f64::from(windows));
            let tolerance = control.tolerance(share);
            assert!(tolerance > 0.0 && tolerance < 0.1 * share);
            assert!(f64::from(windows) * tolerance <= control.left());
        }
        assert!(control.left() < 0.01 * control.accuracy);
        assert!(control.is_hopeless(f64::NAN) && control.is_hopeless(1e30) && !control.is_hopeless(1.0));
    }
}
