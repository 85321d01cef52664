//! One march, each window allowed one share of the accuracy.

use std::ops::ControlFlow;

use super::adaptive::Goal;
use super::force::Force;
use super::judge::Judge;
use super::probe;
use super::view::WindowView;
use super::walk::{Length, Walk};
use super::window::Precision;
use super::{MarchFailure, State, Statistics};
use crate::metric::Metric;
use crate::vector::Twofold;

/// The smallest share of a window: no truncation error is left to reduce.
const LEAST_SHARE: f64 = 1e-22;

/// Below this share the iteration goes to rounding and windows are summed with the full precision of the tables.
const ROUNDING_SHARE: f64 = 3e-18;

/// The share of a single window, in units of the accuracy; it falls with the number of windows to the power 5/4. Errors
/// add up, and phase errors grow with those of K; but the errors of K of equal windows nearly cancel over a turn.
const SHARE: f64 = 0.05;

/// What a window adds to the distance because of rounding, if it is not evaluated in twofold precision.
const ROUNDS: f64 = 1e-16;

/// The same if it is.
const REFINED: f64 = 1e-18;

/// Windows shorter than this part of the first are taken for a singularity.
const SHORTEST: f64 = 1e-16;

/// The most evaluations of the force, on all nodes of a window, that a march to an accuracy may need: a day. At its
/// pace a march that needs more is stopped early.
pub const MOST_EVALUATIONS: f64 = 1e12;

/// After how many evaluations progress is checked again, and the advance, in units of the first window, that counts as
/// almost none.
const PACE: usize = 10_000;
const CRAWL: f64 = 0.1;

/// The most evaluations in a window: with more, two shorter ones are cheaper.
const MOST: usize = 24;

/// The number of evaluations that marks an iteration as slow.
const SLOW: usize = 14;

/// The margin between the error inside a window and the accuracy, and the one on runs where rounding takes most of it.
const INSIDE_MARGIN: f64 = 2.0;
const INSIDE_MARGIN_AT_ROUNDING: f64 = 20.0;

/// The part of a share that the iteration may leave. The modes do not show it; the estimate counts it separately.
const ITERATION: f64 = 0.03;

/// The target for the error of a window, in units of the share, and the maximum.
const AIM: f64 = 0.3;
const MOST_EXCESS: f64 = 4.0;

/// Windows are made longer after this many that would all have allowed it, or at once if they can be this much longer.
///
/// Windows of one length are the rule and others the exception: over a turn of an oscillation the errors of K of equal
/// windows cancel, as the scheme's leading error is reversible. With lengths that follow the force they add up, and the
/// same accuracy takes half as many windows again.
const PAUSE: usize = 12;
const MUCH_LONGER: f64 = 1.6;
const LONGER: f64 = 1.1;

/// Why an attempt did not reach its goal.
pub(super) enum Ended {
    Failed(MarchFailure),
    /// The march is to be begun again with another share.
    Inaccurate {
        next: f64,
    },
}

/// The factor by which the length of a window is to be multiplied.
fn fit(excess: f64, order: f64) -> f64 {
    (AIM / excess).powf(1.0 / order)
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
        let rule = walk.kit.rule;
        let order = (2 * rule.points() - 4) as f64;
        let mut gamma = Twofold::ZERO;
        let mut state = self.start;
        let mut judge = Judge::new(self.metric, self.q_t, rule.points(), &self.start, self.first);
        let (mut idle, mut refused) = (0, 0);
        // Evaluations and γ − γ_i when progress was looked at last.
        let mut pace = (statistics.evaluations, 0.0);
        // The largest excess since the lengths were judged last.
        let mut worst = 0.0_f64;
        let may_grow = AIM * MUCH_LONGER.powi(-(order as i32));
        let mut length = Length::near(self.first, self.q_t);
        let (mut share, mut precision) = self.share(self.first, &state);
        loop {
            let (mut this, mut is_last) = (length, false);
            if let Goal::Gamma(whole) = self.goal {
                let rest = Twofold::from(whole) - gamma;
                if rest.hi <= length.h.hi * 1.05 {
                    (this, is_last) = (Length::exactly(rest, self.q_t), true);
                }
            }
            if statistics.evaluations - pace.0 > PACE {
                self.budget(statistics, gamma.hi, gamma.hi - pace.1, &state).map_err(Ended::Failed)?;
                pace = (statistics.evaluations, gamma.hi);
            }
            let solved = walk.solve(this, &state, precision, statistics);
            let scale = self.scale(this.h.hi, gamma.hi, statistics.windows);
            let solved = solved.map(|solved| (judge.joint(&solved.end), solved));
            let excess = solved.as_ref().map_or(f64::INFINITY, |(end, s)| {
                let margin = if precision.refine { INSIDE_MARGIN_AT_ROUNDING } else { INSIDE_MARGIN };
                let inside = margin * judge.inside(s) / self.accuracy;
                (judge.of_window(s, *end, &state, this.h.hi, scale) / share).max(inside * inside)
            });
            let hides = excess <= MOST_EXCESS && self.hides(walk, (this, &state), &judge, statistics);
            let excess = if hides { f64::INFINITY } else { excess };
            let Some((mut end, mut solved)) = solved.filter(|_| excess <= MOST_EXCESS) else {
                if excess.is_finite() {
                    walk.reject(this);
                }
                refused += 1;
                let factor = if excess.is_finite() { fit(excess, order).clamp(0.1, 0.9) } else { 0.5 };
                // Where V is not smooth, errors shrink more slowly than the order promises.
                let h = this.h.hi * if refused > 3 { factor.min(0.3) } else { factor };
                if h <= SHORTEST * self.first {
                    return Err(Ended::Failed(self.why(&state, statistics.windows, gamma.hi)));
                }
                length = Length::near(h, self.q_t);
                (share, precision) = self.share(self.scale(h, gamma.hi, statistics.windows), &state);
                worst = 0.0;
                continue;
            };
            refused = 0;
            if let Goal::Time(duration) = self.goal {
                if self.lack(duration, &solved.end) * duration <= 0.0 {
                    is_last = true;
                    (this, solved) =
                        self.hit(walk, this, solved, &state, precision, statistics, duration).map_err(Ended::Failed)?;
                    end = judge.joint(&solved.end);
                }
                idle = if (solved.end.t - state.t).hi.abs() <= 1e-15 * duration.abs() { idle + 1 } else { 0 };
                if idle > 100 || this.h.hi > 1e100 {
                    let elapsed = (solved.end.t - self.start.t).hi;
                    return Err(Ended::Failed(MarchFailure::TimeNotReached { gamma: (gamma + this.h).hi, elapsed }));
                }
            }
            walk.accept(this);
            let start = state;
            state = solved.end;
            let rounds = if precision.refine && walk.refines() { REFINED } else { ROUNDS };
            judge.see(&solved, end, this.h.hi, scale, rounds);
            let next = gamma + this.h;
            self.check(&judge, &start, next.hi, statistics.windows, share)?;
            walk.certify(this, &start);
            let view = WindowView {
                index: statistics.windows,
                gamma,
                length: this.h,
                rule,
                start,
                end: solved.end,
                nodes: walk.nodes(this),
                certified: walk.certified(),
            };
            statistics.windows += 1;
            gamma = next;
            if observe(&view).is_break() || is_last {
                let estimate = match self.goal {
                    Goal::Gamma(_) => judge.so_far(),
                    Goal::Time(_) => judge.at_time(),
                };
                return Ok((solved.end, gamma, estimate + self.left_by_iterations()));
            }
            worst = worst.max(excess);
            let at_once = excess > 1.0 || excess < may_grow;
            if at_once || statistics.windows.is_multiple_of(PAUSE) {
                let fit = fit(if at_once { excess } else { worst }, order);
                // Where the iteration is slow, longer windows are not cheaper.
                let fit = if solved.evaluations > SLOW { fit.min(1.0) } else { fit };
                if !(1.0..=LONGER).contains(&fit) {
                    length = Length::near(this.h.hi * fit.clamp(0.5, 2.0), self.q_t);
                }
                (share, precision) = self.share(self.scale(length.h.hi, gamma.hi, statistics.windows), &state);
                worst = 0.0;
            }
        }
    }

    /// The time scale of the motion, as far as windows show it: a few very short ones, at a kink of V, do not change
    /// it.
    fn scale(&self, h: f64, gamma: f64, windows: usize) -> f64 {
        h.max(gamma / windows.max(1) as f64).max(self.first / 16.0)
    }

    /// What the iterations may have left.
    fn left_by_iterations(&self) -> f64 {
        2.0 * ITERATION * SHARE * self.caution * self.accuracy
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

    /// Ends a march that makes no progress, the last evaluations having advanced by no more than `advance` in γ:
    /// because it is about to leave the domain, or because at this pace it would take more evaluations than anybody
    /// would wait for.
    fn budget(&self, statistics: &Statistics, gamma: f64, advance: f64, state: &State) -> Result<(), MarchFailure> {
        if advance < CRAWL * self.first
            && let Some((elapsed, x, g00)) = probe::follow(self.metric, self.q_t, state, self.ahead(gamma))
        {
            return Err(MarchFailure::OutsideDomain { window: statistics.windows, gamma: gamma + elapsed, x, g00 });
        }
        let done = match self.goal {
            Goal::Gamma(length) => gamma / length,
            Goal::Time(duration) => (state.t - self.start.t).hi / duration,
        };
        let evaluations = statistics.evaluations as f64;
        if evaluations > done * MOST_EVALUATIONS {
            let needed = evaluations / done;
            return Err(MarchFailure::EvaluationLimit {
                gamma,
                x: state.x.hi,
                evaluations: statistics.evaluations,
                needed,
            });
        }
        Ok(())
    }

    /// What a window of length h may add to the error, and how accurately it is to be solved.
    fn share(&self, h: f64, start: &State) -> (f64, Precision) {
        let windows = (self.length / h).max(1.0);
        let share = (SHARE * self.caution * self.accuracy / (windows * windows.sqrt().sqrt())).max(LEAST_SHARE);
        let refine =
            self.caution < 1.0 && self.accuracy < 1e-9 || ROUNDS * windows * windows.sqrt() > 0.3 * self.accuracy;
        let tolerance = if share <= ROUNDING_SHARE { 0.0 } else { ITERATION * share / start.x.hi.abs().max(1.0) };
        (share, Precision { tolerance, refine, most: MOST })
    }

    /// Whether the error of a window that ends at `gamma` is within the accuracy.
    fn check(&self, judge: &Judge, start: &State, gamma: f64, window: usize, share: f64) -> Result<(), Ended> {
        let estimate = judge.so_far() + self.left_by_iterations();
        if estimate <= self.accuracy {
            return Ok(());
        }
        if share <= LEAST_SHARE && !estimate.is_finite() {
            return Err(Ended::Failed(self.why(start, window, gamma)));
        }
        if share <= LEAST_SHARE {
            // Errors grow without bound before a horizon: then the horizon is the reason, not the accuracy.
            let failure = match probe::follow(self.metric, self.q_t, start, self.ahead(gamma)) {
                Some((elapsed, x, g00)) => MarchFailure::OutsideDomain { window, gamma: gamma + elapsed, x, g00 },
                None => MarchFailure::AccuracyNotReached { gamma, estimate },
            };
            return Err(Ended::Failed(failure));
        }
        let at_the_end = estimate * (self.length / gamma).max(1.0);
        Err(Ended::Inaccurate { next: self.caution * (0.1 * self.accuracy / at_the_end).max(1e-4) })
    }
}
