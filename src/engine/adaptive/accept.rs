//! The search for a window that is accurate enough, and that hides nothing.

use super::{Accepted, Adaptive};
use crate::engine::between::{Kink, MET, ONE_PLACE, Seen, is_at_one_place};
use crate::engine::ladder::Ladder;
use crate::engine::local::LocalErrors;
use crate::engine::sizes::Size;
use crate::engine::tuning::{INSIDE, KINK, LEAST, LEAST_KINK, LEFT, MOST_LANDINGS, RESOLVED, ROUNDED, STRETCH};
use crate::engine::window::Known;
use crate::engine::{Failure, POINTS};

/// A window to try.
struct Trial {
    rung: i32,
    /// Its length, if that is not the one of its rung.
    length: Option<f64>,
    is_last: bool,
}

impl Adaptive<'_> {
    /// Solves windows until one is accurate enough.
    pub(super) fn accept(&mut self) -> Result<Accepted, Failure> {
        let (mut landing, mut landings, mut refusals) = (None, 0, 0);
        loop {
            let trial = self.trial(landing.take())?;
            let length = trial.length.unwrap_or_else(|| self.ladder.length(trial.rung));
            let share = self.share();
            let odd = trial.length.map(|length| self.ladder.odd(&self.lent.solver.rule, length));
            self.lent.solver.is_shortest = length <= self.least();
            let (tables, continuation) = match &odd {
                Some(tables) => (tables, None),
                None => self.ladder.rung(&self.lent.solver.rule, trial.rung, self.attempt.previous),
            };
            let Ok(mut swept) = self.lent.solver.solve(tables, continuation, LEFT * share) else {
                // Behind the value that ends the run there may be nothing: a table may end there.
                let has_values = !self.lent.solver.system.is_broken();
                let can_land = |rest: &f64| !has_values && *rest < length && landings < MOST_LANDINGS;
                let rest = self.rest_to_target().filter(can_land);
                (landing, landings) = (rest, landings + usize::from(rest.is_some()));
                if rest.is_none() {
                    self.attempt.control.refuse();
                }
                continue;
            };
            self.sweeps += swept.sweeps;
            let seen = self.between.as_mut().map(|between| between.look(&self.lent.solver));
            if let Some(part) = seen.and_then(|seen| seen.knot).filter(|_| landings < MOST_LANDINGS) {
                (landing, landings) = (Some(part * length), landings + 1);
                continue;
            }
            let (kink, allowed) = self.kink(seen, share, length);
            self.attempt.control.meets_kink(kink.is_inside(), trial.rung);
            if refusals > 1 || swept.local.roughness >= RESOLVED {
                self.leave_out_noise(&mut swept.local, length);
            }
            if kink != Kink::Met && !self.is_accurate(swept.local, allowed, seen) {
                refusals += 1;
                continue;
            }
            if kink != Kink::Met && self.misses(trial.rung, length, allowed) {
                continue;
            }
            if self.must_be_shorter(trial.rung, length, kink) {
                continue;
            }
            self.see_touch(length, kink);
            let tables = match &odd {
                Some(tables) => tables,
                None => self.ladder.rung(&self.lent.solver.rule, trial.rung, None).0,
            };
            self.lent.solver.finish(tables, Known::Ends);
            let is_one_place = self.is_one_place(length, ONE_PLACE);
            let kink = self.attempt.control.passes_kink(kink, is_one_place);
            // A window of another length than that of its rung cannot be continued by matrices.
            self.attempt.previous = trial.length.is_none().then_some(trial.rung);
            return Ok(Accepted { length, is_last: trial.is_last, kink, swept });
        }
    }

    /// The next window to try, which ends at a knot of a table after `landing`, if that is known.
    fn trial(&mut self, landing: Option<f64>) -> Result<Trial, Failure> {
        let Some(rung) = Ladder::nearest(self.attempt.control.rung) else {
            return Err(self.reason(Failure::TooShort));
        };
        self.attempt.control.rung = rung;
        let end = if self.target.is_some() { f64::INFINITY } else { self.length };
        let (rest, full) = ((end - self.attempt.gamma.high) - self.attempt.gamma.low, self.ladder.length(rung));
        let is_last = rest <= full * (1.0 + STRETCH);
        let length = landing.or((is_last && rest != full).then_some(rest));
        Ok(Trial { rung, is_last: is_last && length.is_none_or(|length| length == rest), length })
    }

    /// True if places in a window of this length differ by no more than this part of them. Where nothing is known to
    /// have moved, that is a window which is as nothing to the first one.
    fn is_one_place(&self, length: f64, place: f64) -> bool {
        if self.has_moved() {
            is_at_one_place(&self.lent.solver, self.attempt.gamma.high, length, place)
        } else {
            length <= f64::EPSILON * self.ladder.length(0)
        }
    }

    fn has_moved(&self) -> bool {
        let solver = &self.lent.solver;
        solver.rows[..solver.system.positions.len()].iter().any(|row| !row.size.grows())
    }

    /// Looks whether the window that was solved has a kink in it, and what error it may make at its end.
    fn kink(&self, seen: Option<Seen>, share: f64, length: f64) -> (Kink, f64) {
        let allowed = share.max(ROUNDED);
        if seen.is_none_or(|seen| seen.decay != 1.0) {
            return (Kink::Far, allowed);
        }
        (if self.is_one_place(length, MET) { Kink::Met } else { Kink::Inside }, allowed.max(self.of_kink()))
    }

    /// The error that a window with a kink in it may add at its end.
    pub(super) fn of_kink(&self) -> f64 {
        (KINK * self.tolerance).max(LEAST_KINK)
    }

    /// Returns true if something begins to move by a kink in the window, whose place is not known to rounding: its
    /// error is as large as its way in every window with the kink in it, and what it comes to depends on the place
    /// alone.
    fn begins_at_a_kink(&self, seen: Option<Seen>) -> bool {
        let begins = |size: Size| size.before == 0.0 && size.inverse > 0.0;
        seen.is_some_and(|seen| seen.decay == 1.0) && self.lent.solver.rows.iter().any(|row| begins(row.size))
    }

    /// Measures the errors once more without what rounding makes of rates, where that matters: no window is short
    /// enough for it.
    fn leave_out_noise(&mut self, local: &mut LocalErrors, length: f64) {
        let solver = &mut self.lent.solver;
        if !solver.is_noisy && solver.measure_noise(length) {
            *local = solver.measured(length);
        }
    }

    /// Returns true if the errors of the window that was solved are small enough, and adapts the step.
    fn is_accurate(&mut self, mut local: LocalErrors, allowed: f64, seen: Option<Seen>) -> bool {
        if self.begins_at_a_kink(seen) {
            self.attempt.control.refuse();
            return false;
        }
        if let Some(Seen { decay, .. }) = seen {
            local.end = local.with_unseen(decay.powi(POINTS as i32 - 1));
        }
        if local.roughness < RESOLVED {
            self.attempt.control.accepts(local.inside / (INSIDE * self.tolerance), local.end / allowed)
        } else {
            self.attempt.control.refuse();
            false
        }
    }

    /// Returns true if the window that was solved misses the equations between its nodes, and can be shorter.
    fn misses(&mut self, rung: i32, length: f64, allowed: f64) -> bool {
        let error = self.defect.look(&self.lent.solver, length);
        let is_small = error <= allowed;
        if !is_small && length > self.least() {
            self.attempt.control.hides(rung);
            return true;
        }
        // Where there is no value between the nodes, nothing is known.
        self.attempt.unresolved += usize::from(!error.is_finite());
        false
    }

    /// Returns true if something may hide in a window that can be shorter.
    fn must_be_shorter(&mut self, rung: i32, length: f64, kink: Kink) -> bool {
        let (run, accuracy, least) = (self.length, self.accuracy, self.least());
        let hides = self.between.as_mut().and_then(|it| it.hides(&self.lent.solver, length, run, accuracy));
        let Some(hidden) = hides else { return false };
        self.attempt.control.meets_kink(hidden.has_kink, rung);
        // A run that starts at a kink leaves it, and nothing is known of sizes there.
        let is_left = !self.has_moved() && length <= least;
        let is_one_place = hidden.has_kink && (kink == Kink::Met || self.is_one_place(length, ONE_PLACE) || is_left);
        // A pole at the place is none of what a jump is off by.
        let is_harmless = is_one_place && hidden.is_kink_alone;
        // What kinks do in a gap is less in a shorter one, until rounding hides where they are. For what begins to move
        // there everything is too much, and it has no size to divide by.
        let has_end = hidden.change.is_finite() || hidden.is_kink_alone;
        let is_shrinking = hidden.has_kink && has_end && !is_one_place;
        // Where numbers overflow, intervals can tell nothing of windows of any length.
        let is_known = hidden.change.is_finite() || !self.lent.solver.is_mended;
        let can_be_shorter = !is_harmless && (length > least || is_shrinking) && is_known;
        if can_be_shorter {
            self.attempt.control.hides(rung);
        } else {
            self.attempt.unresolved += usize::from(!is_harmless);
        }
        can_be_shorter
    }

    /// Looks whether the motion touches a place where a force jumps in a window of this length.
    fn see_touch(&mut self, length: f64, kink: Kink) {
        let accuracy = self.accuracy;
        let Some(between) = self.between.as_mut().filter(|_| !kink.is_inside()) else { return };
        let part = between.touches(&self.lent.solver, accuracy, self.attempt.windows == 0);
        let gamma = part.map(|part| self.attempt.gamma.high + part * length);
        self.attempt.touched = self.attempt.touched.or(gamma);
    }

    /// Windows that are shorter are not cut any more.
    pub(super) fn least(&self) -> f64 {
        LEAST * self.ladder.length(0)
    }
}
