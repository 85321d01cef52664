//! One march along a world-line, each window allowed one share of the accuracy.

use std::ops::ControlFlow;

use super::certificate::Certificate;
use super::course::Course;
use super::enclosed::{Look, Scales};
use super::growth::{Growth, will_miss};
use super::judge::{Judge, WindowErrors};
use super::probe;
use super::request::Request;
use super::rule::Rule;
use super::state::FlowState;
use super::stop::Watch;
use super::transport::Transport;
use super::tuning::TUNING;
use super::view::FlowView;
use super::window::{FlowWindow, Outcome, Task};
use super::{FlowFailure, Followed};
use crate::engine::lobatto::control::Controller;
use crate::engine::lobatto::pace::{Pace, too_many};
use crate::engine::lobatto::{Statistics, Twofold};
use crate::geometry::Geometry;

/// The first window to try, in radians of the motion at the start.
const FIRST: f64 = 1.0;

/// Windows shorter than this part of the first are taken for a singularity.
const SHORTEST: f64 = 1e-13;

/// The most excess of a window whose rates are a guess for a shorter one. Sweeps that diverge leave numbers that are
/// not.
const SANE: f64 = 1e8;

/// A share that follows a failed attempt aims at this part of the accuracy, and is at least that part of the one
/// before.
const RETRY: [f64; 2] = [0.2, 1e-4];

/// Why an attempt did not reach its goal.
pub(super) enum Ended {
    Failed(FlowFailure),
    /// The march is to be begun again with windows that are allowed this factor less, as its error would be this.
    Inaccurate {
        factor: f64,
        expected: f64,
    },
}

/// What marches along a world-line need, reusable for the next attempt.
pub(super) struct Walk<'g, 'r, const P: usize> {
    geometry: &'g Geometry,
    request: &'r Request<'r>,
    window: FlowWindow<'g, P>,
    transport: Transport<'g>,
    look: Look,
    certificate: Option<Certificate<'g, P>>,
    statistics: Statistics,
}

/// How far an attempt has come.
struct Progress<'g> {
    /// At the start and at the end of the last window.
    start: FlowState,
    state: FlowState,
    gamma: Twofold,
    /// The length of the run, as far as it can be foreseen.
    whole: f64,
    /// The first window to try.
    first: f64,
    /// The rate of the motion.
    rate: f64,
    /// The length of the last window.
    longest: f64,
    judge: Judge<'g>,
    control: Controller,
    growth: Growth,
    pace: Pace,
}

/// The next window.
#[derive(Clone, Copy)]
struct Next {
    h: f64,
    is_last: bool,
    /// The time scale of the motion.
    scale: f64,
    /// What it may add to the error.
    share: f64,
}

impl Next {
    /// How long an error of a velocity goes on, in units of the window.
    fn lasting(&self) -> f64 {
        (self.scale / self.h).max(1.0)
    }
}

/// A window that was solved.
#[derive(Clone, Copy)]
struct Solved {
    h: f64,
    sweeps: usize,
}

/// A window that was solved and is good enough.
struct Taken {
    solved: Solved,
    errors: WindowErrors,
    /// Its error in units of its share.
    excess: f64,
    stopped_by: Option<usize>,
}

impl<'g, 'r, const P: usize> Walk<'g, 'r, P> {
    pub(super) fn new(geometry: &'g Geometry, request: &'r Request<'r>, rule: Rule<P>) -> Self {
        Self {
            geometry,
            request,
            window: FlowWindow::new(geometry, rule),
            transport: Transport::new(geometry),
            look: Look::new(geometry),
            certificate: request.certify.then(|| Certificate::new(geometry, request.momenta)),
            statistics: Statistics::default(),
        }
    }

    /// One march with that factor of the usual shares. An attempt before would have `missed` the accuracy by that
    /// error.
    pub(super) fn attempt(
        &mut self,
        caution: f64,
        missed: f64,
        watches: &mut [Watch<'_>],
        observe: &mut dyn FnMut(&FlowView<'_>) -> ControlFlow<()>,
    ) -> Result<Followed, Ended> {
        watches.iter_mut().for_each(Watch::begin);
        let mut here = self.begin(caution);
        loop {
            self.budget(&mut here).map_err(Ended::Failed)?;
            let next = self.next(&mut here);
            let Some(mut taken) = self.solve(&mut here, next, watches).map_err(Ended::Failed)? else {
                if here.control.h <= SHORTEST * here.first {
                    return Err(Ended::Failed(self.why(&here.state, self.ahead(&here), here.gamma.hi)));
                }
                continue;
            };
            watches.iter_mut().for_each(Watch::accept);
            let gamma = here.gamma.hi;
            let (part, middle) = self.accept(&mut here, &mut taken);
            let estimate = self.check(&mut here, next, missed)?;
            let Taken { solved, errors, excess, stopped_by } = taken;
            let certificate = self.certificate.as_mut();
            let view = FlowView {
                index: self.statistics.windows,
                gamma,
                length: solved.h,
                points: self.window.points(),
                start: &here.start,
                end: &here.state,
                gradient_norm: certificate.map(|room| room.of(&self.window, &here.start, solved.h)),
                window: &self.window,
            };
            self.statistics.windows += 1;
            if observe(&view).is_break() || next.is_last && solved.h == next.h || stopped_by.is_some() {
                let is_whole = stopped_by.is_none() && next.is_last;
                return Ok(Followed {
                    end: here.state,
                    gamma: if is_whole { self.request.length } else { here.gamma.hi },
                    stopped_by,
                    statistics: self.statistics,
                    error_estimate: estimate,
                    attempts: 0,
                });
            }
            let before = std::mem::replace(&mut here.rate, here.judge.look_at(&self.transport));
            let course = Course { part, rates: [before, middle, here.rate], fall: errors.fall };
            let foreseen = |fit| if course.is_uneven(TUNING.uneven) { course.next(fit) } else { None };
            here.control.accept(solved.h, excess, solved.sweeps, foreseen);
        }
    }

    /// A march begins.
    fn begin(&mut self, caution: f64) -> Progress<'g> {
        let Request { target, accuracy, momenta, .. } = *self.request;
        self.window.begin(momenta);
        self.look.begin(momenta);
        (self.statistics.windows, self.statistics.unproved) = (0, 0);
        let state = self.request.start.clone();
        let mut judge = Judge::new(self.geometry, &state, momenta, target.map(|target| target.coordinate));
        self.transport.begin(momenta, &state);
        let rate = judge.look_at(&self.transport);
        let whole = self.request.whole(0.0, &state);
        let first = (FIRST / rate.max(1e-60)).min(whole).min(1e60);
        Progress {
            start: state.clone(),
            state,
            gamma: Twofold::ZERO,
            whole,
            first,
            rate,
            longest: 0.0,
            judge,
            control: Controller::new(TUNING.control, self.window.points(), caution * accuracy, first),
            growth: Growth::default(),
            pace: Pace::new(self.statistics.evaluations),
        }
    }

    /// The next window to try.
    fn next(&self, here: &mut Progress<'_>) -> Next {
        let rest = (Twofold::from(self.request.length) - here.gamma).hi;
        let is_last = rest <= here.control.h * 1.05;
        let h = if is_last { rest } else { here.control.h };
        let scale = h.max(here.gamma.hi / self.statistics.windows.max(1) as f64).max(here.first / 16.0);
        here.judge.set_scale(scale);
        Next { h, is_last, scale, share: here.control.share(scale / here.foreseen()) }
    }

    /// Solves a window, and shortens it to the first stop in it. `None` if it is too long: then the next one is
    /// shorter.
    fn solve(
        &mut self,
        here: &mut Progress<'_>,
        next: Next,
        watches: &mut [Watch<'_>],
    ) -> Result<Option<Taken>, FlowFailure> {
        let Next { h, share, scale, .. } = next;
        let Progress { state, judge, control, .. } = here;
        let accuracy = self.request.accuracy;
        let excess_of =
            |errors: WindowErrors| (errors.end / share).max((TUNING.margin * errors.inside / accuracy).powi(2));
        // A tail is one of the solution where it is more than what sweeps still change.
        let is_hopeless = |window: &FlowWindow<'_, P>, change: f64| {
            let errors = judge.of_window(window, next.lasting());
            errors.inside > change && control.is_hopeless(excess_of(errors))
        };
        let (tolerance, is_new) = (control.tolerance(share), h > here.longest);
        let task = Task { start: state, h, weights: &judge.weights, tolerance, is_new };
        let outcome = self.window.solve(task, &is_hopeless);
        let errors = match outcome {
            Outcome::Failed => WindowErrors::NONE,
            Outcome::TooLong | Outcome::Solved(_) => judge.of_window(&self.window, next.lasting()),
        };
        let excess = excess_of(errors);
        let mut excess = if excess.is_nan() { f64::INFINITY } else { excess };
        let mut taken = None;
        if let Outcome::Solved(sweeps) = outcome
            && control.accepts(excess)
        {
            let scales = Scales { accuracy, length: here.whole, gamma: here.gamma.hi, first: here.first, time: scale };
            let [hides, is_short] = self.look.at(&self.window, judge, scales);
            self.statistics.unproved += usize::from(hides && is_short);
            if hides && !is_short {
                excess = f64::INFINITY;
            } else {
                let mut solved = Solved { h, sweeps };
                let stopped_by = self.stop(watches, task, &mut solved, here.gamma.hi)?;
                taken = Some(Taken { solved, errors, excess, stopped_by });
            }
        }
        self.statistics.evaluations = self.window.sweeps;
        if taken.is_none() {
            self.window.reject(h, excess <= SANE);
            here.control.h = h;
            here.control.refuse(excess);
        }
        Ok(taken)
    }

    /// Accepts a window, and carries what errors have grown to over it. What part of it comes before a point near its
    /// middle, and the rate of the motion there.
    fn accept(&mut self, here: &mut Progress<'_>, taken: &mut Taken) -> (f64, f64) {
        let h = taken.solved.h;
        self.window.accept(h);
        std::mem::swap(&mut here.state, &mut here.start);
        here.state.clone_from(&self.window.end);
        here.longest = h;
        here.gamma = here.gamma + Twofold::from(h);
        here.whole = self.request.whole(here.gamma.hi, &here.state);
        let windows = (self.statistics.windows as f64).max(here.foreseen() / h);
        let judge = &mut here.judge;
        self.transport.follow(&self.window, &judge.weights, windows);
        let middle = judge.look_back(&self.transport);
        self.transport.enlarge(|row| judge.local(&self.window, row));
        if taken.stopped_by.is_some() {
            taken.errors = judge.of_window(&self.window, 1.0);
        }
        judge.see(&self.window, taken.errors.inside, &self.transport);
        middle
    }

    /// The error so far, if it is within the accuracy and will be.
    fn check(&self, here: &mut Progress<'_>, next: Next, missed: f64) -> Result<f64, Ended> {
        let (accuracy, estimate) = (self.request.accuracy, here.judge.so_far());
        let gamma = here.gamma.hi;
        let done = if here.whole.is_finite() { (gamma / here.whole).min(1.0) } else { 1.0 };
        let projected = here.growth.project(gamma, here.judge.at_ends(), done);
        let is_exhausted = here.control.is_exhausted(next.share);
        let is_missed = estimate.is_nan() || estimate > accuracy;
        if !is_missed && (is_exhausted || !will_miss(projected, accuracy, missed)) {
            return Ok(estimate);
        }
        Err(self.inaccurate(is_exhausted, projected.max(estimate), gamma, &here.start))
    }

    /// A window to be shortened or taken, however it fares.
    fn solve_anyway(&mut self, task: Task<'_>) -> Option<Solved> {
        match self.window.solve(task, &|_, _| false) {
            Outcome::Solved(sweeps) => Some(Solved { h: task.h, sweeps }),
            Outcome::TooLong | Outcome::Failed => None,
        }
    }

    /// Shortens the window that was solved to the first change of sign of a stop; which one.
    fn stop(
        &mut self,
        watches: &mut [Watch<'_>],
        task: Task<'_>,
        solved: &mut Solved,
        gamma: f64,
    ) -> Result<Option<usize>, FlowFailure> {
        let (start, mut first) = (task.start, None);
        for (index, watch) in watches.iter_mut().enumerate() {
            let longest = solved.h;
            let Some(bracket) = watch.look(&self.window, start, longest) else { continue };
            self.window.reject(longest, true);
            let root = bracket.root(gamma, longest, |h| {
                self.solve_anyway(Task { h, ..task })?;
                Some(watch.at_end(&self.window, start, h))
            });
            let Some(h) = root else {
                return Err(self.why(start, longest, gamma));
            };
            *solved = self.solve_anyway(Task { h, ..task }).ok_or_else(|| self.why(start, h, gamma))?;
            first = Some(index);
        }
        Ok(first)
    }

    /// How far to look for the end of the domain.
    fn ahead(&self, here: &Progress<'_>) -> f64 {
        here.first.min((Twofold::from(self.request.length) - here.gamma).hi)
    }

    /// Why there is no window from here, however short.
    fn why(&self, start: &FlowState, ahead: f64, gamma: f64) -> FlowFailure {
        probe::why(self.geometry, start, self.request.momenta, ahead, gamma)
    }

    /// What follows from an `estimate` for the whole run that is above the accuracy, at `gamma`.
    fn inaccurate(&self, is_exhausted: bool, estimate: f64, gamma: f64, start: &FlowState) -> Ended {
        if is_exhausted {
            let q = start.q.iter().map(|q| q.hi).collect();
            return Ended::Failed(FlowFailure::AccuracyNotReached { gamma, q, estimate });
        }
        let factor = RETRY[0] * self.request.accuracy / estimate;
        let factor = if factor.is_nan() { RETRY[1] } else { factor.max(RETRY[1]) };
        Ended::Inaccurate { factor, expected: estimate }
    }

    /// Ends a march that at its pace would take more evaluations than anybody would wait for.
    fn budget(&self, here: &mut Progress<'_>) -> Result<(), FlowFailure> {
        let (evaluations, gamma) = (self.statistics.evaluations, here.gamma.hi);
        if here.pace.advance(evaluations, gamma).is_none() {
            return Ok(());
        }
        let done = if here.whole.is_finite() { gamma / here.whole } else { 1.0 };
        let Some(needed) = too_many(evaluations, done) else { return Ok(()) };
        let q = here.state.q.iter().map(|q| q.hi).collect();
        Err(FlowFailure::EvaluationLimit { gamma, q, evaluations, needed })
    }
}

impl Progress<'_> {
    /// The length of the run. Without an end in sight nothing is foreseen but the first window.
    fn foreseen(&self) -> f64 {
        if self.whole.is_finite() { self.whole } else { self.first }
    }
}

#[cfg(test)]
mod tests;
