//! One march of a world-line and its companion with one share of the accuracy a window.

use std::ops::ControlFlow;

use super::adaptive::Goal;
use super::force::Force;
use super::ladder;
use super::pair::{Length, Pair};
use super::probe;
use super::twofold::Twofold;
use super::view::WindowView;
use super::window::{Precision, Solved};
use super::{MarchFailure, State, Statistics};
use crate::metric::Metric;

/// The smallest share of a window: there is no truncation left to be reduced.
const LEAST_SHARE: f64 = 1e-18;

/// A share below this is at the level of rounding, and windows are iterated to it.
const ROUNDING_SHARE: f64 = 1e-15;

/// Windows shorter than this part of the first are taken for a singularity.
const SHORTEST: f64 = 1e-7;

/// What the estimate is at least: the result is rounded.
const ROUNDING: f64 = 2.0 * f64::EPSILON;

/// The estimate in units of the distance, which may lie on either side of the world-line.
const CAUTION: f64 = 3.0;

/// The companion's measured error in units of the squared modes.
const CALIBRATION: f64 = 0.03;

/// The part of a share that the iteration may leave. It is small because the companion starts where the world-line's
/// iteration ended: of what that left the distance sees only a part.
const ITERATION: f64 = 3e-3;

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
    /// The error that a window may make; by default the attempt finds out.
    pub(super) share: Option<f64>,
}

/// The largest |t − t_i| and |x|, at least 1, and the largest distance of the two world-lines, relative to them.
struct Judge {
    start: Twofold,
    sizes: [f64; 2],
    distance: f64,
}

impl Judge {
    fn see(&mut self, [main, companion]: &[State; 2]) {
        self.sizes[0] = self.sizes[0].max((main.t - self.start).hi.abs());
        self.sizes[1] = self.sizes[1].max(main.x.hi.abs());
        let [t, x] = self.parts(main, companion);
        self.distance = self.distance.max(t).max(x);
    }

    fn parts(&self, main: &State, companion: &State) -> [f64; 2] {
        let [t, x] = self.sizes;
        [(main.t - companion.t).hi.abs() / t, (main.x - companion.x).hi.abs() / x]
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
        let first = ladder::rung_below(self.first);
        let (mut rung, mut longest) = (first, i32::MAX);
        let mut gamma = Twofold::ZERO;
        let mut states = [self.start; 2];
        let mut judge = Judge { start: self.start.t, sizes: [1.0; 2], distance: 0.0 };
        let mut idle = 0;
        loop {
            let (mut length, mut is_last) = (Length::Rung(rung), false);
            if let Goal::Gamma(whole) = self.goal {
                let rest = Twofold::from(whole) - gamma;
                if rest.hi <= ladder::length(rung).hi {
                    (length, is_last) = (Length::Odd(rest), true);
                }
            }
            // A few very short windows, at a kink of V, leave the share of one as it is.
            let average = gamma.hi / statistics.windows.max(1) as f64;
            let share = self.share_of(ladder::length(rung).hi.max(average).max(self.first / 16.0));
            let precision = self.precision(share, &states[0]);
            let mut h = pair.prepare(length);
            let solved = pair.main(length, &states[0], precision, statistics);
            let order = 2 * pair.rules[1].points() - 2;
            let excess = solved.as_ref().map_or(f64::INFINITY, |s| self.error(s, h.hi, &judge) / share);
            let Some(mut solved) = solved.filter(|_| excess <= 1.0) else {
                // Each rung takes a factor of 2^(order/2) off the error; what does not converge gets two rungs less.
                let rungs = (2.0 * excess.log2() / order as f64).ceil();
                rung = ladder::rung_below(h.hi * 1.000_001)
                    - if rungs.is_finite() { rungs.clamp(1.0, 8.0) as i32 } else { 2 };
                longest = rung;
                if ladder::length(rung).hi <= SHORTEST * self.first.min(ladder::length(first).hi) {
                    let window = statistics.windows;
                    let failure = probe::why(self.metric, self.q_t, &states[0], 64.0 * h.hi, window, gamma.hi);
                    return Err(Ended::Failed(failure));
                }
                continue;
            };
            if let Goal::Time(duration) = self.goal {
                let lack = |s: &Solved| ((self.start.t + Twofold::from(duration)) - s.end.t).hi;
                if lack(&solved) * duration <= 0.0 {
                    is_last = true;
                    (length, solved) =
                        self.hit(pair, h, solved, &states[0], precision, statistics, &lack).map_err(Ended::Failed)?;
                    h = pair.prepare(length);
                }
                idle = if (solved.end.t - states[0].t).hi.abs() <= 1e-15 * duration.abs() { idle + 1 } else { 0 };
                if idle > 100 || h.hi > 1e100 {
                    let elapsed = (solved.end.t - self.start.t).hi;
                    return Err(Ended::Failed(MarchFailure::TimeNotReached { gamma: (gamma + h).hi, elapsed }));
                }
            }
            let Some(companion) = pair.companion(length, &states[1], precision, statistics) else {
                (rung, longest) = (rung - 1, rung - 1);
                pair.forget();
                continue;
            };
            let start = states[0];
            states = [solved.end, companion.end];
            judge.see(&states);
            let next = gamma + h;
            self.check(&judge, next.hi, share)?;
            let [x, t_dot, acceleration] = pair.nodes();
            let view = WindowView {
                index: statistics.windows,
                gamma,
                length: h,
                rule: pair.rules[0],
                start,
                end: solved.end,
                x,
                t_dot,
                acceleration,
                metric: self.metric,
                q_t: self.q_t,
            };
            statistics.windows += 1;
            gamma = next;
            if observe(&view).is_break() || is_last {
                return Ok((solved.end, gamma, self.estimate(&judge, &states)));
            }
            // A rung more if it fits easily; after a window that was too long, not before eight have passed.
            if excess * 4.0 * 2.0_f64.powf(0.5 * order as f64) <= 1.0 && rung < longest {
                rung += 1;
            } else if statistics.windows.is_multiple_of(8) {
                longest = i32::MAX;
            }
        }
    }

    /// The share of a window where windows are typically of length h. Errors add up, and phases run away with errors of
    /// K; measured on oscillators, a power of 3/2 is enough.
    fn share_of(&self, h: f64) -> f64 {
        let windows = (self.length / h).max(1.0);
        self.share.unwrap_or(0.1 * self.accuracy / windows.powf(1.5)).max(LEAST_SHARE)
    }

    fn precision(&self, share: f64, start: &State) -> Precision {
        let rounds = share <= ROUNDING_SHARE;
        let tolerance = if rounds { 0.0 } else { ITERATION * share / start.x.hi.abs().max(1.0) };
        Precision { tolerance, refine: rounds }
    }

    /// The companion's error at the end of a window: the square of what its highest modes are, relative to the sizes.
    fn error(&self, solved: &Solved, h: f64, judge: &Judge) -> f64 {
        let relative = |k: usize| if solved.largest[k] > 0.0 { solved.tail[k] / solved.largest[k] } else { 0.0 };
        let x = h * h * solved.largest[0] * relative(0) * relative(0) / judge.sizes[1];
        let t = h * solved.largest[1] * relative(1) * relative(1) / judge.sizes[0];
        CALIBRATION * x.max(t)
    }

    /// Whether the distance can stay within the accuracy up to the end.
    fn check(&self, judge: &Judge, gamma: f64, share: f64) -> Result<(), Ended> {
        let estimate = CAUTION * judge.distance + ROUNDING;
        if estimate <= self.accuracy {
            return Ok(());
        }
        if share <= LEAST_SHARE {
            return Err(Ended::Failed(MarchFailure::AccuracyNotReached { gamma, estimate }));
        }
        let at_the_end = judge.distance * (self.length / gamma).max(1.0).powi(2);
        Err(Ended::Inaccurate { next: share * (0.03 * self.accuracy / at_the_end).min(0.01) })
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
        CAUTION * judge.distance.max(at_the_end) + ROUNDING
    }

    /// The length, and the window, at whose end t has the value asked for.
    #[allow(clippy::too_many_arguments)]
    fn hit<const P: usize, F: Force>(
        &self,
        pair: &mut Pair<P, F>,
        length: Twofold,
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
            let odd = Length::Odd(length);
            let at_rounding = lack(&solved).abs() <= 0.25 * f64::EPSILON * solved.end.t.hi.abs();
            if at_rounding || (length + Twofold::from(step)) == length {
                pair.prepare(odd);
                return Ok((odd, solved));
            }
            length = length + Twofold::from(step.max(-0.9 * length.hi));
            pair.prepare(Length::Odd(length));
            let Some(next) = pair.main(Length::Odd(length), start, precision, statistics) else { break };
            solved = next;
        }
        let elapsed = (solved.end.t - self.start.t).hi;
        Err(MarchFailure::TimeNotReached { gamma: length.hi, elapsed })
    }
}
