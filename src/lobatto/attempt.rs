//! One march of a world-line and its companion with one share of the accuracy a window.

use std::ops::ControlFlow;

use super::adaptive::Goal;
use super::force::Force;
use super::pair::{Length, Pair};
use super::probe;
use super::twofold::Twofold;
use super::view::WindowView;
use super::window::{Precision, Solved};
use super::{MarchFailure, State, Statistics};
use crate::metric::Metric;

/// The smallest share of a window: there is no truncation left to be reduced.
const LEAST_SHARE: f64 = 1e-22;

/// Below this share the iteration goes to rounding and windows are summed with everything that the tables have.
const ROUNDING_SHARE: f64 = 3e-18;

/// The share of a single window, in units of the accuracy; it falls with the number of windows to the power 5/4. Errors add up, and phases run away with those of K; but the errors of K of equal windows nearly cancel over a turn.
const SHARE: f64 = 0.05;

/// What a window adds to the distance because of rounding, if it is not evaluated in twofold precision.
const ROUNDS: f64 = 1e-16;

/// Windows shorter than this part of the first are taken for a singularity.
const SHORTEST: f64 = 1e-11;

/// The most evaluations in a window: with more, two shorter ones are cheaper.
const MOST: usize = 24;

/// The evaluations of an iteration that is slow.
const SLOW: usize = 14;

/// What the estimate is at least: the result is rounded.
pub(super) const ROUNDING: f64 = 2.0 * f64::EPSILON;

/// The estimate in units of the distance, which may lie on either side of the world-line.
const CAUTION: f64 = 3.0;

/// The same if a window was accepted in which V is rough on its scale, as at a kink: there the errors of the two are of
/// one kind.
const CAUTION_WHERE_ROUGH: f64 = 30.0;

/// The highest modes relative to the largest value in a window where V is rough.
const ROUGH: f64 = 0.03;

/// The companion's measured error in units of the squared modes.
const CALIBRATION: f64 = 0.03;

/// The error of x and t at the nodes inside a window in units of its highest modes, at most; measured on oscillators it is
/// 1e-4 to 1.3e-3 and 2e-3 to 2e-2. It has the order of the modes and not of their square, and ends with the window.
const INSIDE: [f64; 2] = [2e-3, 3e-2];

/// What that is to stay away from the accuracy by, and on runs on which rounding takes most of it.
const INSIDE_MARGIN: f64 = 2.5;
const INSIDE_MARGIN_AT_ROUNDING: f64 = 25.0;

/// The part of a share that the iteration may leave. The companion starts where the world-line's iteration ended, so
/// that of this the distance sees only a part; the estimate counts it apart.
const ITERATION: f64 = 0.03;

/// What the error of a window is to be, in units of the share, and at most.
const AIM: f64 = 0.3;
const MOST_EXCESS: f64 = 4.0;

/// Windows are made longer after so many that would all have allowed for it, or at once if they can be as much longer.
///
/// Windows of one length are the rule and others the exception: over a turn of an oscillation the errors of K of equal
/// windows cancel, as the scheme's leading error is reversible. With lengths that follow the force they add up, and at
/// the same accuracy there are half as many windows again.
const PAUSE: usize = 12;
const MUCH_LONGER: f64 = 1.6;
const LONGER: f64 = 1.1;

/// Steps of Newton's method towards the end time.
const END_TIME_STEPS: usize = 12;

/// Why an attempt did not come to its goal.
pub(super) enum Ended {
    Failed(MarchFailure),
    /// It is to be begun again with another share.
    Inaccurate {
        next: f64,
    },
}

/// By what the length of a window is to be multiplied.
fn fit(excess: f64, order: f64) -> f64 {
    (AIM / excess).powf(1.0 / order)
}

/// What is asked for.
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
    /// The errors of windows are to be smaller by this than they usually have to be.
    pub(super) caution: f64,
}

/// The largest |t − t_i| and |x|, at least 1, and the largest distance of the two world-lines, relative to them.
struct Judge {
    start: Twofold,
    sizes: [f64; 2],
    distance: f64,
    /// The largest error inside a window.
    inside: f64,
    caution: f64,
}

impl Judge {
    fn see(&mut self, [main, companion]: &[State; 2]) {
        self.sizes[0] = self.sizes[0].max((main.t.hi - self.start.hi).abs());
        self.sizes[1] = self.sizes[1].max(main.x.hi.abs());
        let [t, x] = self.parts(main, companion);
        self.distance = self.distance.max(t).max(x);
    }

    /// The error of a window at the nodes inside it.
    fn inside(&self, solved: &Solved) -> f64 {
        let error = |k: usize| INSIDE[k] * solved.tail[k];
        let t_size = self.sizes[0].max((solved.end.t.hi - self.start.hi).abs());
        (error(0) / self.sizes[1].max(solved.end.x.hi.abs())).max(error(1) / t_size)
    }

    fn parts(&self, main: &State, companion: &State) -> [f64; 2] {
        let [t, x] = self.sizes;
        let distance = |a: Twofold, b: Twofold| ((a.hi - b.hi) + (a.lo - b.lo)).abs();
        [distance(main.t, companion.t) / t, distance(main.x, companion.x) / x]
    }
}

impl Attempt<'_> {
    /// End, γ − γ_i there, and the error estimate.
    pub(super) fn walk<const P: usize, F: Force>(
        &self,
        pair: &mut Pair<P, F>,
        statistics: &mut Statistics,
        observe: &mut dyn FnMut(&WindowView<'_>) -> ControlFlow<()>,
    ) -> Result<(State, Twofold, f64), Ended> {
        pair.forget();
        statistics.windows = 0;
        let rules = pair.kit.rules;
        let order = (2 * rules[1].points() - 2) as f64;
        let mut gamma = Twofold::ZERO;
        let mut states = [self.start; 2];
        let mut judge = Judge { start: self.start.t, sizes: [1.0; 2], distance: 0.0, inside: 0.0, caution: CAUTION };
        let (mut idle, mut refused) = (0, 0);
        // The largest excess since the lengths were judged last.
        let mut worst = 0.0_f64;
        let may_grow = AIM * MUCH_LONGER.powi(-(order as i32));
        let mut length = Length::near(self.first, self.q_t);
        let (mut share, mut precision) = self.share(self.first, &states[0]);
        loop {
            let (mut this, mut is_last) = (length, false);
            if let Goal::Gamma(whole) = self.goal {
                let rest = Twofold::from(whole) - gamma;
                if rest.hi <= length.h.hi * 1.05 {
                    (this, is_last) = (Length::exactly(rest, self.q_t), true);
                }
            }
            let solved = pair.main(this, &states[0], precision, statistics);
            let excess = solved.as_ref().map_or(f64::INFINITY, |s| {
                let margin = if precision.refine { INSIDE_MARGIN_AT_ROUNDING } else { INSIDE_MARGIN };
                let inside = margin * judge.inside(s) / self.accuracy;
                (self.error(s, &judge) / share).max(inside * inside)
            });
            let Some(mut solved) = solved.filter(|_| excess <= MOST_EXCESS) else {
                if excess.is_finite() {
                    pair.reject(this);
                }
                refused += 1;
                let factor = if excess.is_finite() { fit(excess, order).clamp(0.1, 0.9) } else { 0.5 };
                // Where V is not smooth, errors shrink more slowly than the order promises.
                let h = this.h.hi * if refused > 3 { factor.min(0.3) } else { factor };
                if h <= SHORTEST * self.first {
                    let window = statistics.windows;
                    let failure = probe::why(self.metric, self.q_t, &states[0], 64.0 * h, window, gamma.hi);
                    return Err(Ended::Failed(failure));
                }
                length = Length::near(h, self.q_t);
                // A few very short windows, at a kink of V, leave the share of one as it is.
                let average = gamma.hi / statistics.windows.max(1) as f64;
                (share, precision) = self.share(h.max(average).max(self.first / 16.0), &states[0]);
                worst = 0.0;
                continue;
            };
            refused = 0;
            if let Goal::Time(duration) = self.goal {
                let lack = |s: &Solved| ((self.start.t + Twofold::from(duration)) - s.end.t).hi;
                if lack(&solved) * duration <= 0.0 {
                    is_last = true;
                    (this, solved) = self
                        .hit(pair, this, solved, &states[0], precision, statistics, &lack)
                        .map_err(Ended::Failed)?;
                }
                idle = if (solved.end.t - states[0].t).hi.abs() <= 1e-15 * duration.abs() { idle + 1 } else { 0 };
                if idle > 100 || this.h.hi > 1e100 {
                    let elapsed = (solved.end.t - self.start.t).hi;
                    return Err(Ended::Failed(MarchFailure::TimeNotReached { gamma: (gamma + this.h).hi, elapsed }));
                }
            }
            let Some(companion) = pair.companion(this, &states[1], precision, statistics) else {
                length = Length::near(0.7 * this.h.hi, self.q_t);
                pair.forget();
                continue;
            };
            let start = states[0];
            states = [solved.end, companion.end];
            judge.see(&states);
            judge.inside = judge.inside.max(judge.inside(&solved));
            if (0..2).any(|k| solved.tail[k] > ROUGH * solved.largest[k]) {
                judge.caution = CAUTION_WHERE_ROUGH;
            }
            let next = gamma + this.h;
            self.check(&judge, next.hi, share)?;
            let index = statistics.windows;
            let view = WindowView {
                index,
                gamma,
                length: this.h,
                rule: rules[0],
                start,
                end: solved.end,
                nodes: pair.nodes(this),
            };
            statistics.windows += 1;
            gamma = next;
            if observe(&view).is_break() || is_last {
                return Ok((solved.end, gamma, self.estimate(&judge, &states)));
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
                let average = gamma.hi / statistics.windows as f64;
                (share, precision) = self.share(length.h.hi.max(average).max(self.first / 16.0), &states[0]);
                worst = 0.0;
            }
        }
    }

    /// What a window of length h may add to the error, and how well it is to be solved.
    fn share(&self, h: f64, start: &State) -> (f64, Precision) {
        let windows = (self.length / h).max(1.0);
        let share = (SHARE * self.caution * self.accuracy / (windows * windows.sqrt().sqrt())).max(LEAST_SHARE);
        let refine =
            self.caution < 1.0 && self.accuracy < 1e-9 || ROUNDS * windows * windows.sqrt() > 0.3 * self.accuracy;
        let tolerance = if share <= ROUNDING_SHARE { 0.0 } else { ITERATION * share / start.x.hi.abs().max(1.0) };
        (share, Precision { tolerance, refine, most: MOST })
    }

    /// The companion's error at the end of a window: the square of what its highest modes are, relative to the sizes.
    fn error(&self, solved: &Solved, judge: &Judge) -> f64 {
        let error = |k: usize| {
            if solved.largest[k] > 0.0 { solved.tail[k] * (solved.tail[k] / solved.largest[k]) } else { 0.0 }
        };
        CALIBRATION * (error(0) / judge.sizes[1]).max(error(1) / judge.sizes[0])
    }

    /// Whether the distance is within the accuracy.
    fn check(&self, judge: &Judge, gamma: f64, share: f64) -> Result<(), Ended> {
        let estimate = self.beyond(judge.distance, judge);
        if estimate <= self.accuracy {
            return Ok(());
        }
        if share <= LEAST_SHARE {
            return Err(Ended::Failed(MarchFailure::AccuracyNotReached { gamma, estimate }));
        }
        let at_the_end = estimate * (self.length / gamma).max(1.0);
        Err(Ended::Inaccurate { next: self.caution * (0.1 * self.accuracy / at_the_end).max(1e-4) })
    }

    /// What a distance means for the error.
    fn beyond(&self, distance: f64, judge: &Judge) -> f64 {
        judge.caution * distance + judge.inside + 2.0 * ITERATION * SHARE * self.caution * self.accuracy + ROUNDING
    }

    /// The estimate at the end; where t is given, an error of t is one of x.
    fn estimate(&self, judge: &Judge, [main, companion]: &[State; 2]) -> f64 {
        let at_the_end = match self.goal {
            Goal::Gamma(_) => 0.0,
            Goal::Time(_) => {
                let [t, x] = judge.parts(main, companion);
                let velocity = main.w.hi * self.metric.at(main.x.hi).g00 / self.q_t;
                x + (velocity * t * judge.sizes[0] / judge.sizes[1]).abs()
            }
        };
        self.beyond(judge.distance.max(at_the_end), judge)
    }

    /// The length, and the window, at whose end t has the value asked for.
    #[allow(clippy::too_many_arguments)]
    fn hit<const P: usize, F: Force>(
        &self,
        pair: &mut Pair<P, F>,
        length: Length,
        too_long: Solved,
        start: &State,
        precision: Precision,
        statistics: &mut Statistics,
        lack: &dyn Fn(&Solved) -> f64,
    ) -> Result<(Length, Solved), MarchFailure> {
        let (mut length, mut solved) = (length, too_long);
        for _ in 0..END_TIME_STEPS {
            let u = self.q_t / self.metric.at(solved.end.x.hi).g00;
            let step = lack(&solved) / u;
            let at_rounding = lack(&solved).abs() <= 0.25 * f64::EPSILON * solved.end.t.hi.abs();
            if at_rounding || (length.h + Twofold::from(step)) == length.h {
                return Ok((length, solved));
            }
            pair.reject(length);
            length = Length::exactly(length.h + Twofold::from(step.max(-0.9 * length.h.hi)), self.q_t);
            let Some(next) = pair.main(length, start, precision, statistics) else { break };
            solved = next;
        }
        let elapsed = (solved.end.t - self.start.t).hi;
        Err(MarchFailure::TimeNotReached { gamma: length.h.hi, elapsed })
    }
}
