//! Lengths of windows, h = h₀ 2^(k/4), with the tables of each, which are made when they are first used.
//!
//! The step controller leads from the errors of a window to the rung of the next one.

use std::sync::OnceLock;

use super::between::Kink;
use super::rule::{Continuation, Order, Rule, Tables};
use super::tuning::{AIM, HIDDEN, LARGEST_CUT, LARGEST_GROWTH, MOST_IDLE, PATIENCE, UNSOLVED};
use super::{MOST_POINTS, POINTS};
use crate::number::Compensated;

/// k runs from −REACH to REACH: at 2^−60 of the first length no place has digits for the nodes of a window.
const REACH: i32 = 240;
/// A window is continued into one that is longer by at most so many rungs,
const LONGEST: i32 = 8;
/// or shorter by at most so many.
const SHORTEST: i32 = -16;
/// The number of lengths into which a window is continued.
const CONTINUED: usize = (LONGEST - SHORTEST + 1) as usize;

/// The tables of all lengths that were used.
pub(super) struct Ladder {
    order: Order,
    is_exact: bool,
    /// h₀.
    first: f64,
    rungs: Vec<Option<Box<Rung>>>,
}

struct Rung {
    tables: Tables<POINTS>,
    /// Continuations from windows that are shorter by j = SHORTEST … LONGEST rungs.
    continuations: [Option<Continuation<POINTS>>; CONTINUED],
}

impl Ladder {
    /// The ladder whose rung 0 has the length `first`. Exact tables keep what rounding takes from their entries.
    pub(super) fn new(order: Order, first: f64, is_exact: bool) -> Self {
        Self { order, is_exact, first, rungs: (-REACH..=REACH).map(|_| None).collect() }
    }

    /// The rung k or the longest one; `None` if there is none so short.
    pub(super) fn nearest(k: i32) -> Option<i32> {
        (k >= -REACH).then(|| k.min(REACH))
    }

    /// The length of rung k. The fourth roots of powers of two are rounded alike in every unit of length.
    pub(super) fn length(&self, k: i32) -> f64 {
        let roots = [1.0, std::f64::consts::SQRT_2.sqrt(), std::f64::consts::SQRT_2, 2.0_f64.powf(0.75)];
        let power_of_two = f64::from_bits(((k.div_euclid(4) + 1023) as u64) << 52);
        self.first * roots[k.rem_euclid(4) as usize] * power_of_two
    }

    /// The tables of rung k, and the continuation of a window of rung `previous`, if that is near enough.
    pub(super) fn rung(
        &mut self,
        rule: &Rule<POINTS>,
        k: i32,
        previous: Option<i32>,
    ) -> (&Tables<POINTS>, Option<&Continuation<POINTS>>) {
        let (order, is_exact, h) = (self.order, self.is_exact, self.length(k));
        let rung = self.rungs[(k + REACH) as usize].get_or_insert_with(|| {
            let tables = rule.tables(order, Compensated::from(h), is_exact);
            Box::new(Rung { tables, continuations: [const { None }; CONTINUED] })
        });
        let longer = previous.map(|previous| k - previous).filter(|j| (SHORTEST..=LONGEST).contains(j));
        let continuation = longer.map(|j| {
            let place = (j - SHORTEST) as usize;
            &*rung.continuations[place]
                .get_or_insert_with(|| rule.continuation(order.power_of(h), continued(rule, order, j)))
        });
        (&rung.tables, continuation)
    }

    /// Tables for one window of any length. It is guessed without the window before: that would save a few sweeps,
    /// which cost a tenth of the matrix for it.
    #[cold]
    pub(super) fn odd(&self, rule: &Rule<POINTS>, h: f64) -> Tables<POINTS> {
        rule.tables(self.order, Compensated::from(h), self.is_exact)
    }
}

/// The numbers of [`Rule::continued`] for a window that is longer by j rungs, made once in the life of the program.
pub(super) fn continued<const N: usize>(rule: &Rule<N>, order: Order, j: i32) -> &'static [f64] {
    static TABLES: [OnceLock<Vec<f64>>; 4 * (MOST_POINTS + 1) * CONTINUED] =
        [const { OnceLock::new() }; 4 * (MOST_POINTS + 1) * CONTINUED];
    let kind = 2 * usize::from(rule.has_end()) + usize::from(order == Order::Second);
    let table = &TABLES[(4 * rule.points() + kind) * CONTINUED + (j - SHORTEST) as usize];
    table.get_or_init(|| rule.continued(order, 2.0_f64.powf(0.25 * f64::from(j))))
}

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
    /// Number of windows since γ was looked at, and γ then.
    idle: usize,
    since: f64,
    /// The rung before windows were cut to meet a kink, until they have.
    before_kink: Option<i32>,
    /// True once a window has passed it.
    is_at_kink: bool,
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

    /// A window of this rung was tried, and there may be a kink in it, which shorter ones are going to meet.
    pub(super) fn meets_kink(&mut self, has_kink: bool, rung: i32) {
        if has_kink && self.before_kink.is_none() {
            self.before_kink = Some(rung);
        }
    }

    /// A window was accepted, and may pass a kink, or meet the one place where rounding hides it. Behind the last one
    /// that does, the motion is as smooth as it was before, so that the next window is as long as those were: in
    /// shorter ones that grow slowly, what begins to move at the kink would be nothing but rounding. Returns `kink`, or
    /// that one is near.
    pub(super) fn passes_kink(&mut self, kink: Kink, is_one_place: bool) -> Kink {
        self.is_at_kink |= kink.is_inside() || is_one_place;
        let Some(rung) = self.before_kink else { return kink };
        if self.is_at_kink && !kink.is_inside() {
            (self.before_kink, self.is_at_kink, self.patience) = (None, false, 0);
            self.rung = self.rung.max(rung);
        }
        if kink == Kink::Far { Kink::Ahead } else { kink }
    }

    /// True if the last [`MOST_IDLE`] windows together, the next of which begins at γ, came no further than as many
    /// that are too short to be cut: something holds the motion there. Between two kinks that are close together some
    /// windows are longer.
    pub(super) fn is_stuck(&mut self, gamma: f64, least: f64) -> bool {
        self.idle += 1;
        if self.idle <= MOST_IDLE {
            return false;
        }
        let way = gamma - self.since;
        (self.idle, self.since) = (0, gamma);
        way <= MOST_IDLE as f64 * least
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
    use crate::engine::between::Kink;

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
    fn behind_a_kink_windows_are_as_long_as_before() {
        let mut control = Control::default();
        let mut try_at = |rung: i32, has_kink: bool, inside: f64| {
            control.meets_kink(has_kink, rung);
            if control.accepts(inside, 0.0) {
                control.passes_kink(if has_kink { Kink::Inside } else { Kink::Far }, false);
            }
            control.rung
        };
        assert_eq!(try_at(0, true, 2.0_f64.powi(30)), -8);
        assert_eq!(try_at(-8, true, 2.0_f64.powi(30)), -16);
        assert_eq!(try_at(-16, false, 1e-9), -14);
        assert_eq!(try_at(-14, true, 1e-9), -12);
        assert_eq!(try_at(-12, true, 1e-9), -10);
        assert_eq!(try_at(-10, false, 1e-9), 0);
    }

    #[test]
    fn windows_that_come_no_further_than_short_ones_are_stuck() {
        let is_stuck = |lengths: [f64; 2]| {
            let (mut control, mut gamma) = (Control::default(), 5.0);
            lengths.into_iter().cycle().take(2000).any(|length| {
                gamma += length;
                control.is_stuck(gamma, 1e-9)
            })
        };
        assert!(is_stuck([1e-9, 1e-12]) && is_stuck([1.5e-9, 1e-10]));
        assert!(!is_stuck([1e-9, 2e-9]) && !is_stuck([1e-12, 1e-6]));
    }

    #[test]
    fn lengths_do_not_return_at_once_to_what_was_refused() {
        let mut control = Control::default();
        control.refuse();
        let rungs: Vec<i32> = (0..6).map(|_| (control.accepts(1e-9, 0.0), control.rung).1).collect();
        assert_eq!(rungs, [-1, -1, -1, 1, 3, 5]);
    }
}
