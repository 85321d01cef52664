//! One march, each window allowed one share of the accuracy.

use std::ops::ControlFlow;

use super::control::{Controller, ONE_COORDINATE};
use super::force::Force;
use super::judge::{Joint, Judge};
use super::pace::{Pace, too_many};
use super::probe;
use super::view::WindowView;
use super::walk::{Length, Walk};
use super::window::{Precision, Solved};
use super::{Goal, MarchFailure, State, Statistics};
use crate::geometry::metric::Metric;
use crate::number::vector::Twofold;

/// Below this share the iteration goes to rounding and windows are summed with the full precision of the tables.
const ROUNDING_SHARE: f64 = 3e-18;

/// What a window adds to the distance because of rounding, if it is not evaluated in twofold precision.
const ROUNDS: f64 = 1e-16;

/// The same if it is.
const REFINED: f64 = 1e-18;

/// Windows shorter than this part of the first are taken for a singularity.
const SHORTEST: f64 = 1e-16;

/// The advance over many evaluations, in units of the first window, that counts as almost none.
const CRAWL: f64 = 0.1;

/// The most evaluations in a window: with more, two shorter ones are cheaper.
const MOST: usize = 24;

/// The margin between the error inside a window and the accuracy, and the one on runs where rounding takes most of it.
const INSIDE_MARGIN: f64 = 2.5;
const INSIDE_MARGIN_AT_ROUNDING: f64 = 20.0;

/// A run to a given time is given up after this many windows in which no time passes.
const MOST_IDLE: usize = 100;

/// A time is out of reach of a march that cannot keep its accuracy if γ would have to become this many times as large.
const FAR: f64 = 100.0;

/// Why an attempt did not reach its goal.
pub(super) enum Ended {
    Failed(MarchFailure),
    /// The march is to be begun again with another share.
    Inaccurate {
        next: f64,
    },
}

/// The request.
pub(super) struct Attempt<'a> {
    pub(super) metric: &'a Metric,
    pub(super) q_t: f64,
    pub(super) start: State,
    pub(super) goal: Goal,
    pub(super) accuracy: f64,
    /// The length of the whole, or an estimate.
    pub(super) length: f64,
    /// The first window to try.
    pub(super) first: f64,
    /// The factor by which the errors of windows must be smaller than usual.
    pub(super) caution: f64,
}

/// How far an attempt has come.
struct Progress<'m> {
    state: State,
    gamma: Twofold,
    judge: Judge<'m>,
    control: Controller,
    /// What windows of the length that the controller chose last are like.
    plan: Option<(f64, Task)>,
    pace: Pace,
    /// Windows in a row in which no time has passed.
    idle: usize,
}

/// A window to solve.
#[derive(Clone, Copy)]
pub(super) struct Task {
    pub(super) length: Length,
    /// Whether it ends at the goal.
    is_last: bool,
    /// What it may add to the error.
    share: f64,
    pub(super) precision: Precision,
    /// The time scale of the motion.
    scale: f64,
}

/// A window that was solved and is good enough.
struct Taken {
    solved: Solved,
    end: Joint,
    /// Its error in units of its share.
    excess: f64,
}

impl Attempt<'_> {
    /// End, γ − γ_i there, and the error estimate.
    pub(super) fn walk<const P: usize, F: Force>(
        &self,
        walk: &mut Walk<P, F>,
        statistics: &mut Statistics,
        observe: &mut dyn FnMut(&WindowView<'_>) -> ControlFlow<()>,
    ) -> Result<(State, Twofold, f64), Ended> {
        walk.forget();
        (statistics.windows, statistics.unproved) = (0, 0);
        let points = walk.kit.rule.points();
        let mut here = Progress {
            state: self.start,
            gamma: Twofold::ZERO,
            judge: Judge::new(self.metric, self.q_t, points, &self.start, self.first),
            control: Controller::new(ONE_COORDINATE, points, self.caution * self.accuracy, self.first),
            plan: None,
            pace: Pace::new(statistics.evaluations),
            idle: 0,
        };
        loop {
            self.budget(&mut here, statistics).map_err(Ended::Failed)?;
            let mut task = self.next(&mut here, statistics);
            let Some(mut taken) = self.solve(walk, &mut here, task, statistics) else {
                if here.control.h <= SHORTEST * self.first {
                    return Err(Ended::Failed(self.why(&here.state, statistics.windows, here.gamma.hi)));
                }
                continue;
            };
            if let Goal::Time(duration) = self.goal {
                self.look_at_time(walk, &mut here, (&mut task, &mut taken), statistics, duration)
                    .map_err(Ended::Failed)?;
            }
            let is_over = self.accept(walk, &mut here, task, &taken, statistics, observe)?;
            if is_over {
                let estimate = match self.goal {
                    Goal::Gamma(_) => here.judge.so_far(),
                    Goal::Time(_) => here.judge.at_time(),
                };
                return Ok((here.state, here.gamma, estimate + here.control.left()));
            }
            here.control.accept(task.length.h.hi, taken.excess, taken.solved.evaluations, |_| None);
        }
    }

    /// The next window to try.
    fn next(&self, here: &mut Progress<'_>, statistics: &Statistics) -> Task {
        if here.plan.is_none_or(|(h, _)| h != here.control.h) {
            here.plan = Some((here.control.h, self.plan(here, statistics)));
        }
        let (_, mut task) = here.plan.expect("there is one now");
        if let Goal::Gamma(whole) = self.goal {
            let rest = Twofold::from(whole) - here.gamma;
            if rest.hi <= task.length.h.hi * 1.05 {
                (task.length, task.is_last) = (Length::exactly(rest, self.q_t), true);
            }
        }
        Task { scale: self.scale(task.length.h.hi, here.gamma.hi, statistics.windows), ..task }
    }

    /// Windows of the length that the controller has chosen.
    fn plan(&self, here: &Progress<'_>, statistics: &Statistics) -> Task {
        let length = Length::near(here.control.h, self.q_t);
        let scale = self.scale(length.h.hi, here.gamma.hi, statistics.windows);
        let part = scale / self.length;
        let share = here.control.share(part);
        let windows = part.recip().max(1.0);
        let refine =
            self.caution < 1.0 && self.accuracy < 1e-9 || ROUNDS * windows * windows.sqrt() > 0.3 * self.accuracy;
        let size = here.state.x.hi.abs().max(1.0);
        let tolerance = if share <= ROUNDING_SHARE { 0.0 } else { here.control.tolerance(share) / size };
        Task { length, is_last: false, share, precision: Precision { tolerance, refine, most: MOST }, scale }
    }

    /// Solves a window. `None` if it is too long: then the next one is shorter.
    fn solve<const P: usize, F: Force>(
        &self,
        walk: &mut Walk<P, F>,
        here: &mut Progress<'_>,
        Task { length, share, precision, scale, .. }: Task,
        statistics: &mut Statistics,
    ) -> Option<Taken> {
        let (judge, state, h) = (&here.judge, &here.state, length.h.hi);
        let taken = walk.solve(length, state, precision, statistics).map(|solved| {
            let end = judge.joint(&solved.end);
            let margin = if precision.refine { INSIDE_MARGIN_AT_ROUNDING } else { INSIDE_MARGIN };
            let inside = margin * judge.inside(&solved) / self.accuracy;
            let excess = (judge.of_window(&solved, end, state, h, scale) / share).max(inside * inside);
            Taken { solved, end, excess }
        });
        let excess = taken.as_ref().map_or(f64::INFINITY, |taken| taken.excess);
        let hides = here.control.accepts(excess) && self.hides(walk, (length, state), judge, statistics);
        let excess = if hides { f64::INFINITY } else { excess };
        let taken = taken.filter(|_| here.control.accepts(excess));
        if taken.is_none() {
            if excess.is_finite() {
                walk.reject(length);
            }
            here.control.h = h;
            here.control.refuse(excess);
        }
        taken
    }

    /// Shortens a window that goes beyond the given time to one that ends there, and sees whether time passes at all.
    fn look_at_time<const P: usize, F: Force>(
        &self,
        walk: &mut Walk<P, F>,
        here: &mut Progress<'_>,
        (task, taken): (&mut Task, &mut Taken),
        statistics: &mut Statistics,
        duration: f64,
    ) -> Result<(), MarchFailure> {
        if self.lack(duration, &taken.solved.end) * duration <= 0.0 {
            task.is_last = true;
            let hit = self.hit(walk, *task, taken.solved, &here.state, statistics, duration);
            (task.length, taken.solved) =
                hit.map_err(|(length, end)| self.time_not_reached(here.gamma + length, &end))?;
            taken.end = here.judge.joint(&taken.solved.end);
        }
        let passed = (taken.solved.end.t - here.state.t).hi;
        here.idle = if passed.abs() <= 1e-15 * duration.abs() { here.idle + 1 } else { 0 };
        if here.idle > MOST_IDLE {
            return Err(self.time_not_reached(here.gamma + task.length.h, &taken.solved.end));
        }
        Ok(())
    }

    fn time_not_reached(&self, gamma: Twofold, end: &State) -> MarchFailure {
        MarchFailure::TimeNotReached { gamma: gamma.hi, elapsed: (end.t - self.start.t).hi }
    }

    /// Accepts a window and shows it; whether it is the last.
    fn accept<const P: usize, F: Force>(
        &self,
        walk: &mut Walk<P, F>,
        here: &mut Progress<'_>,
        Task { length, is_last, share, precision, scale }: Task,
        Taken { solved, end, .. }: &Taken,
        statistics: &mut Statistics,
        observe: &mut dyn FnMut(&WindowView<'_>) -> ControlFlow<()>,
    ) -> Result<bool, Ended> {
        walk.accept(length);
        let start = std::mem::replace(&mut here.state, solved.end);
        let rounds = if precision.refine && walk.refines() { REFINED } else { ROUNDS };
        here.judge.see(solved, *end, length.h.hi, scale, rounds);
        let gamma = here.gamma;
        here.gamma = gamma + length.h;
        self.check(here, &start, statistics.windows, share)?;
        walk.certify(length, &start);
        let view = WindowView {
            index: statistics.windows,
            gamma,
            length: length.h,
            rule: walk.kit.rule,
            start,
            end: solved.end,
            nodes: walk.nodes(length),
            certified: walk.certified(),
        };
        statistics.windows += 1;
        Ok(observe(&view).is_break() || is_last)
    }

    /// The time scale of the motion, as far as windows show it: a few very short ones, at a kink of V, do not change
    /// it.
    fn scale(&self, h: f64, gamma: f64, windows: usize) -> f64 {
        h.max(gamma / windows.max(1) as f64).max(self.first / 16.0)
    }

    /// Why there is no window from here, however short.
    fn why(&self, start: &State, window: usize, gamma: f64) -> MarchFailure {
        probe::why(self.metric, self.q_t, start, self.ahead(gamma), window, gamma)
    }

    /// How far to look for the end of the domain.
    fn ahead(&self, gamma: f64) -> f64 {
        match self.goal {
            Goal::Gamma(length) => self.first.min(length - gamma),
            Goal::Time(_) => self.first,
        }
    }

    /// Ends a march that makes no progress: because it is about to leave the domain, or because at this pace it would
    /// take more evaluations than anybody would wait for.
    fn budget(&self, here: &mut Progress<'_>, statistics: &Statistics) -> Result<(), MarchFailure> {
        let (evaluations, gamma) = (statistics.evaluations, here.gamma.hi);
        let Some(advance) = here.pace.advance(evaluations, gamma) else { return Ok(()) };
        let state = &here.state;
        if advance < CRAWL * self.first
            && let Some((elapsed, x, g00)) = probe::follow(self.metric, self.q_t, state, self.ahead(gamma))
        {
            return Err(MarchFailure::OutsideDomain { window: statistics.windows, gamma: gamma + elapsed, x, g00 });
        }
        let done = match self.goal {
            Goal::Gamma(length) => gamma / length,
            Goal::Time(duration) => (state.t - self.start.t).hi / duration,
        };
        match too_many(evaluations, done) {
            Some(needed) => Err(MarchFailure::EvaluationLimit { gamma, x: state.x.hi, evaluations, needed }),
            None => Ok(()),
        }
    }

    /// Whether the error of the last window, which began at `start`, is within the accuracy.
    fn check(&self, here: &Progress<'_>, start: &State, window: usize, share: f64) -> Result<(), Ended> {
        let (gamma, estimate) = (here.gamma.hi, here.judge.so_far() + here.control.left());
        if estimate <= self.accuracy {
            return Ok(());
        }
        if here.control.is_exhausted(share) {
            return Err(Ended::Failed(self.why_inaccurate(here, start, window, estimate)));
        }
        let at_the_end = estimate * (self.length / gamma).max(1.0);
        Err(Ended::Inaccurate { next: self.caution * (0.1 * self.accuracy / at_the_end).max(1e-4) })
    }

    /// Why the error is `estimate`, which is not within the accuracy, after a window that began at `start`, however
    /// small the shares. Before a horizon, and where t comes to rest, errors grow without bound: then that is why.
    fn why_inaccurate(&self, here: &Progress<'_>, start: &State, window: usize, estimate: f64) -> MarchFailure {
        let gamma = here.gamma.hi;
        if !estimate.is_finite() {
            return self.why(start, window, gamma);
        }
        match (probe::follow(self.metric, self.q_t, start, self.ahead(gamma)), self.goal) {
            (Some((elapsed, x, g00)), _) => MarchFailure::OutsideDomain { window, gamma: gamma + elapsed, x, g00 },
            (None, Goal::Time(duration)) if self.is_out_of_reach(duration, [start, &here.state], gamma) => {
                self.time_not_reached(here.gamma, &here.state)
            }
            (None, _) => MarchFailure::AccuracyNotReached { gamma, estimate },
        }
    }

    /// Whether t has almost come to rest: over [`FAR`] times `gamma`, at its pace at both of these `states`, it would
    /// grow by less than is left, and by less than it has grown.
    fn is_out_of_reach(&self, duration: f64, states: [&State; 2], gamma: f64) -> bool {
        states.into_iter().all(|state| {
            let passes = FAR * gamma * self.q_t / self.metric.g00(state.x.hi);
            let (left, passed) = (self.lack(duration, state), (state.t - self.start.t).hi);
            passes.abs() < left.abs().min(passed.abs())
        })
    }
}

#[cfg(test)]
mod tests;
