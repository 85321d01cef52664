//! The step controller: from the errors of a window to the length of the next one.

use super::tuning::{AIM, HIDDEN, LARGEST_CUT, LARGEST_GROWTH, MOST_IDLE, PATIENCE, UNSOLVED};

/// Chooses rungs of the ladder of window lengths.
#[derive(Debug, Clone, Copy)]
pub(super) struct Control {
    /// Rungs for each factor of two in the excess.
    rungs_per_octave: f64,
    /// The order of the error at the end of a window, relative to that inside.
    relative_order: f64,
    /// The rung of the next window.
    pub(super) rung: i32,
    /// After a refusal no window is longer than this rung, for so many windows.
    longest: i32,
    patience: u32,
    /// Number of windows in turn that are too short to be cut.
    idle: usize,
}

impl Control {
    /// For windows of n nodes, whose errors inside grow like hⁿ and those at the end like h²ⁿ⁻¹. The first one has
    /// rung 0.
    pub(super) fn new(nodes: usize) -> Self {
        let n = nodes as f64;
        let relative_order = (2.0 * n - 1.0) / n;
        Self { rungs_per_octave: 4.0 / n, relative_order, rung: 0, longest: i32::MAX, patience: 0, idle: 0 }
    }

    /// True if a window is good enough, by its errors inside and at the end, each divided by what is allowed. Chooses
    /// the rung of the next window, or of the same one again.
    pub(super) fn accepts(&mut self, inside: f64, end: f64) -> bool {
        if !(inside.is_finite() && end.is_finite()) {
            self.refuse();
            return false;
        }
        // As powers of two of an error inside that is as much too large.
        let excess = log2(inside.max(1e-300)).max(log2(end.max(1e-300)) / self.relative_order);
        let fits = ((AIM - excess) * self.rungs_per_octave).floor();
        if excess > 0.0 {
            self.shorten(fits.clamp(LARGEST_CUT, -1.0) as i32);
            return false;
        }
        self.rung += if excess > 0.5 * AIM { -1 } else { fits.clamp(0.0, LARGEST_GROWTH) as i32 };
        self.patience = self.patience.saturating_sub(1);
        if self.patience > 0 {
            self.rung = self.rung.min(self.longest);
        }
        true
    }

    /// The window was not solved, or it does not resolve the motion.
    pub(super) fn refuse(&mut self) {
        self.shorten(-UNSOLVED);
    }

    /// True if too many windows in turn are as short as no more than one that passes a kink has to be: something holds
    /// the motion there.
    pub(super) fn is_stuck(&mut self, is_short: bool) -> bool {
        self.idle = if is_short { self.idle + 1 } else { 0 };
        self.idle > MOST_IDLE
    }

    /// Something may hide in the window of this rung, which was good enough.
    pub(super) fn hides(&mut self, rung: i32) {
        self.rung = rung;
        self.shorten(-HIDDEN);
    }

    fn shorten(&mut self, rungs: i32) {
        (self.longest, self.patience) = (self.rung - 1, PATIENCE);
        self.rung += rungs;
    }
}

/// log₂ of a positive number, exact for powers of two and off by 0.09 at most.
#[inline]
fn log2(x: f64) -> f64 {
    (x.to_bits().cast_signed() as f64 - 1023.0 * 2.0_f64.powi(52)) * 2.0_f64.powi(-52)
}

#[cfg(test)]
mod tests {
    use super::Control;

    /// By how many rungs the next window is longer, and whether this one is kept.
    fn judged(inside: f64, end: f64) -> (bool, i32) {
        let mut control = Control::new(8);
        (control.accepts(inside, end), control.rung)
    }

    #[test]
    fn length_follows_the_orders() {
        assert_eq!(judged(0.9, 0.0), (true, -1));
        assert_eq!(judged(0.4, 0.0), (true, 0));
        // A factor of 2⁻⁸ halves the length: 4 rungs, of which two are taken at once.
        assert_eq!(judged(2.0_f64.powi(-9), 0.0), (true, 2));
        assert_eq!(judged(2.0_f64.powi(7), 0.0), (false, -4));
        assert_eq!(judged(0.0, 2.0_f64.powi(13)), (false, -4));
        assert_eq!(judged(f64::NAN, 0.0), (false, -2));
    }

    #[test]
    fn lengths_do_not_return_at_once_to_what_was_refused() {
        let mut control = Control::new(16);
        control.refuse();
        let rungs: Vec<i32> = (0..6).map(|_| (control.accepts(1e-9, 0.0), control.rung).1).collect();
        assert_eq!(rungs, [-1, -1, -1, 1, 3, 5]);
    }
}
