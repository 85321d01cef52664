//! The step controller: from the errors of a window to the length of the next one.

use super::POINTS;
use super::tuning::{AIM, HIDDEN, LARGEST_CUT, LARGEST_GROWTH, MOST_IDLE, PATIENCE, UNSOLVED};

/// Rungs for each factor of two in the error inside a window, which grows like hⁿ for n nodes.
const RUNGS_PER_OCTAVE: f64 = 4.0 / POINTS as f64;
/// The order of the error at the end of a window, which grows like h²ⁿ⁻¹, relative to that inside.
const RELATIVE_ORDER: f64 = (2 * POINTS - 1) as f64 / POINTS as f64;

/// Chooses rungs of the ladder of window lengths, of which the first window has rung 0.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Control {
    /// The rung of the next window.
    pub(super) rung: i32,
    /// After a refusal no window is longer than this rung, for so many windows.
    longest: i32,
    patience: u32,
    /// Number of windows in turn that are too short to be cut.
    idle: usize,
}

impl Control {
    /// True if a window is good enough, by its errors inside and at the end, each divided by what is allowed. Chooses
    /// the rung of the next window, or of the same one again.
    pub(super) fn accepts(&mut self, inside: f64, end: f64) -> bool {
        if !(inside.is_finite() && end.is_finite()) {
            self.refuse();
            return false;
        }
        // As powers of two of an error inside that is as much too large.
        let excess = log2(inside.max(1e-300)).max(log2(end.max(1e-300)) / RELATIVE_ORDER);
        let fits = ((AIM - excess) * RUNGS_PER_OCTAVE).floor();
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
        let mut control = Control::default();
        (control.accepts(inside, end), control.rung)
    }

    #[test]
    fn length_follows_the_orders() {
        assert_eq!(judged(0.9, 0.0), (true, -1));
        assert_eq!(judged(0.4, 0.0), (true, 0));
        // A factor of 2¹⁶ halves the length, by 4 rungs; it grows by two of them at once at most.
        assert_eq!(judged(2.0_f64.powi(-17), 0.0), (true, 2));
        assert_eq!(judged(2.0_f64.powi(15), 0.0), (false, -4));
        assert_eq!(judged(0.0, 2.0_f64.powi(29)), (false, -4));
        assert_eq!(judged(f64::NAN, 0.0), (false, -2));
    }

    #[test]
    fn lengths_do_not_return_at_once_to_what_was_refused() {
        let mut control = Control::default();
        control.refuse();
        let rungs: Vec<i32> = (0..6).map(|_| (control.accepts(1e-9, 0.0), control.rung).1).collect();
        assert_eq!(rungs, [-1, -1, -1, 1, 3, 5]);
    }
}
