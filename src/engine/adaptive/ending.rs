//! The end of a run inside of the window that was solved last, where a formula changes its sign.

use super::{Accepted, Adaptive};
use crate::engine::between::{Kink, stays_at_one_place};
use crate::engine::stop::root_between;
use crate::engine::tuning::LEFT;
use crate::engine::window::{Known, Solver};
use crate::engine::{Failure, OfState, POINTS};
use crate::number::vector::Nodes;

/// A window with its slopes, from which shorter ones with the same start are guessed.
struct Whole {
    length: f64,
    slopes: Vec<Nodes<POINTS>>,
}

/// A window that ends before a place by so many units in the last place of γ ends there: a search ends within two, and
/// γ at the end of a window is rounded twice.
const HELD: f64 = 8.0;

/// A shorter part of a window than this is its start: in the square of it numbers would be below their range.
const NEAR_START: f64 = 1e-60;

/// Findings of windows of other lengths about a change of sign.
struct Tried {
    /// The longest window that was solved and ends before it, with the value at its end.
    ahead: (f64, f64),
    /// The shortest one that ends behind it, and whether that stays at one place.
    behind: (f64, bool),
    /// Why a window could not be solved.
    failure: Option<Failure>,
}

impl Tried {
    /// Where the run ends, if a search has `found` a place and that is one, up to this much of γ.
    fn end(&self, found: Option<f64>, at_start: f64, least: f64) -> Option<f64> {
        let (length, here) = self.ahead;
        // Windows on both sides meet.
        let is_met = self.failure.is_none() || self.behind.0 - length <= least || length == 0.0 && self.behind.1;
        // The rest of the way is rounding, or the failure has another reason.
        let is_held = length > 0.0 && here.abs() * length <= least * (at_start - here).abs();
        if is_met { found } else { is_held.then_some(length) }
    }
}

impl Adaptive<'_> {
    /// Ends the window where a value changes its sign from `side`, between two lengths of it, as
    /// [`Windows::end_where`](crate::engine::Windows::end_where) does.
    pub(super) fn end_at_change(&mut self, between: [f64; 2], side: f64, value: OfState<'_>) -> Result<bool, Failure> {
        let (before, gamma) = (self.attempt.accepted, self.attempt.gamma.high);
        let slopes = self.lent.solver.rows.iter().map(|row| row.slopes_before).collect();
        let (whole, least) = (Whole { length: before.length, slopes }, f64::EPSILON * (gamma + before.length));
        let at_start = value(&self.lent.solver.start);
        let mut tried = Tried { ahead: (0.0, at_start), behind: (f64::INFINITY, false), failure: None };
        let mut at = |h: f64| self.value_after(&whole, (h, side), value, &mut tried);
        let mut found = root_between(between, side, gamma, before.length, &mut at);
        // With a jump in it the motion inside tells little of where shorter windows end.
        if found.is_none() && before.kink.is_inside() {
            found = root_between([least, before.length], side, gamma, before.length, &mut at);
        }
        let end = tried.end(found, at_start, HELD * least).map(|length| length.max(NEAR_START * before.length));
        // A window that is not cut any more, as is one with a jump in it, is one place: where a force holds the motion,
        // it goes to and fro in there.
        let is_one_place = end.is_none() && before.length <= self.least();
        if is_one_place {
            self.attempt.accepted.kink = Kink::Inside;
        }
        let (length, is_last) = end.map_or((before.length, before.is_last), |length| (length, true));
        self.again(&whole, length, is_last)?;
        if is_one_place {
            self.attempt.accepted.is_last = true;
            return Ok(true);
        }
        match tried.failure.filter(|_| end.is_none()) {
            Some(failure) => {
                // The change is near, however far the window went that was solved first.
                self.attempt.failed_at = Some((gamma, self.lent.solver.start.positions()));
                Err(failure)
            }
            None => Ok(end.is_some()),
        }
    }

    /// The value at the end of the window with another length; `None` if there is no such window that is the longest.
    fn value_after(
        &mut self,
        whole: &Whole,
        (h, side): (f64, f64),
        value: OfState<'_>,
        tried: &mut Tried,
    ) -> Option<f64> {
        if h < NEAR_START * whole.length {
            return Some(value(&self.lent.solver.start));
        }
        if let Err(error) = self.again(whole, h, true) {
            // Where a force that jumps holds the motion, no window ends behind the change.
            tried.failure = Some(error);
            return (h > tried.ahead.0).then_some(-side * f64::MIN_POSITIVE);
        }
        let here = value(&self.lent.solver.end);
        if here * side > 0.0 && h > tried.ahead.0 {
            tried.ahead = (h, here);
        } else if here * side <= 0.0 && h < tried.behind.0 {
            tried.behind = (h, stays_at_one_place(&self.lent.solver));
        }
        Some(here)
    }

    /// Solves the accepted window again with another length, which is no longer.
    ///
    /// # Errors
    /// If it has no solution, or if a kink is in it that was not, which is more than one place.
    fn again(&mut self, whole: &Whole, length: f64, is_last: bool) -> Result<(), Failure> {
        let tables = self.ladder.odd(&self.lent.solver.rule, length);
        let share = self.share();
        self.lent.solver.is_patient = true;
        // Sweeps over a window that is as long as the motion allows need a good guess.
        let Solver { system, rule, rows, .. } = &mut self.lent.solver;
        rows.iter_mut().zip(&whole.slopes).for_each(|(row, slopes)| row.slopes_before = *slopes);
        let within = rule.within(system.order, length, length / whole.length);
        let swept = self.lent.solver.solve(&tables, Some(&within), LEFT * share);
        self.lent.solver.is_patient = false;
        let swept = swept?;
        self.sweeps += swept.sweeps;
        // Where the window begins at a jump, rounding may put its first node on the other side.
        let kink = self.attempt.accepted.kink;
        let has_kink = self.between.as_mut().is_some_and(|between| between.look(&self.lent.solver).decay == 1.0);
        let solver = &self.lent.solver;
        let is_met = length <= self.least() && (swept.local.end <= self.of_kink() || stays_at_one_place(solver));
        if has_kink && !kink.is_inside() && !is_met {
            return Err(Failure::NotConverged);
        }
        self.lent.solver.finish(&tables, Known::Ends);
        self.attempt.accepted = Accepted { length, is_last, kink, swept };
        Ok(())
    }
}
