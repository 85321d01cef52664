//! What an adaptive march knows about its error.

use super::State;
use super::twofold::Twofold;
use super::window::Solved;
use crate::metric::Metric;

/// The minimum of the estimate: the result is rounded.
pub(super) const ROUNDING: f64 = 2.0 * f64::EPSILON;

/// The estimate in units of the distance, which may lie on either side of the world-line.
const CAUTION: f64 = 3.0;

/// The same if a window was accepted in which V is rough on its scale, as at a kink: there the errors of the two are of
/// the same kind.
const CAUTION_WHERE_ROUGH: f64 = 30.0;

/// The highest modes relative to the largest value in a window where V is rough.
const ROUGH: f64 = 0.03;

/// The companion's measured error in units of the squared modes.
const CALIBRATION: f64 = 0.03;

/// The error of x and t at the nodes inside a window in units of its highest modes, at most; measured on oscillators it
/// is 1e-4 to 1.3e-3 and 2e-3 to 2e-2, on steep powers and walls up to 4.3e-3 at the first node. It has the order of
/// the modes and not of their square, and ends with the window. That of x is in units of n⁻²: 4.3e-3 with 16 nodes and
/// 2.2e-3 with 24.
const INSIDE: [f64; 2] = [1.4, 3e-2];

/// The same in a window where V is rough: modes beyond the highest fall as slowly as those before.
const INSIDE_WHERE_ROUGH: [f64; 2] = [6.0, 0.3];

/// What K is off by because it is rounded, in units of the rounding of its terms.
const K_ROUNDS: f64 = 8.0 * f64::EPSILON;

/// What an error of the energy means for x, in units of its first-order effect along the way: a turn of an anharmonic
/// oscillator takes longer or shorter too.
const PHASE: f64 = 2.0;

/// The largest |t − t_i| and |x|, at least 1, the largest distance of the two world-lines relative to them, and what K
/// says.
///
/// K of the world-line is known exactly: K_i. Its deviation at the end of a window is an error that no comparison with
/// a companion can hide. With ½δK = a δx − w δw it is a lower bound of the errors there, and it gives the energy of the
/// orbit that is followed from there on: x departs from the exact one at the rate ½|δK|/|w|.
pub(super) struct Judge<'m> {
    metric: &'m Metric,
    q_t: f64,
    /// n⁻².
    per_square: f64,
    start: Twofold,
    pub(super) sizes: [f64; 2],
    distance: f64,
    /// The largest error inside a window.
    inside: f64,
    caution: f64,
    /// K at the start of the march and at the last joint.
    first: Norm,
    last: Norm,
    /// The integral of ½δK/|w| over γ, and the largest so far: what K loses and regains over a turn does not add up.
    drift: f64,
    drifted: f64,
}

/// K, and how far it may be off because of rounding.
#[derive(Debug, Clone, Copy, Default)]
struct Norm {
    k: f64,
    rounds: f64,
}

impl Norm {
    /// How far it differs from the other, beyond rounding.
    fn off(self, other: Self) -> f64 {
        let (off, rounds) = (self.k - other.k, self.rounds + other.rounds);
        if off.abs() > rounds { off - rounds.copysign(off) } else { 0.0 }
    }
}

/// Whether V is rough on the scale of the window.
fn is_rough(solved: &Solved) -> bool {
    (0..2).any(|k| solved.tail[k] > ROUGH * solved.largest[k])
}

impl<'m> Judge<'m> {
    /// For windows of `points` nodes from `start` on.
    pub(super) fn new(metric: &'m Metric, q_t: f64, points: usize, start: &State) -> Self {
        let mut judge = Self {
            metric,
            q_t,
            per_square: (points as f64).powi(-2),
            start: start.t,
            sizes: [1.0; 2],
            distance: 0.0,
            inside: 0.0,
            caution: CAUTION,
            first: Norm::default(),
            last: Norm::default(),
            drift: 0.0,
            drifted: 0.0,
        };
        judge.first = judge.norm(start);
        judge.last = judge.first;
        judge
    }

    fn norm(&self, state: &State) -> Norm {
        let g = self.metric.at(state.x.hi);
        let u = self.q_t / g.g00;
        let (energy, motion) = (self.q_t * u, state.w.hi * state.w.hi);
        // g00 = c² + 2V/m is rounded at the size of its terms, and x at its own.
        let c_squared = self.metric.c_squared();
        let rounds = u * u * (c_squared + (g.g00 - c_squared).abs() + (g.first * state.x.hi).abs()) + motion;
        Norm { k: energy - motion, rounds: K_ROUNDS * rounds }
    }

    /// Sees an accepted window of the two from `start` to `ends`, of length `h`, where the motion has the time scale
    /// `scale`.
    pub(super) fn see(&mut self, solved: &Solved, start: &State, ends: &[State; 2], h: f64, scale: f64) {
        let [main, companion] = ends;
        self.sizes[0] = self.sizes[0].max((main.t.hi - self.start.hi).abs());
        self.sizes[1] = self.sizes[1].max(main.x.hi.abs());
        let [t, x] = self.parts(main, companion);
        self.distance = self.distance.max(t).max(x);
        self.inside = self.inside.max(self.inside(solved));
        if is_rough(solved) {
            self.caution = CAUTION_WHERE_ROUGH;
        }
        let before = self.last.off(self.first);
        self.last = self.norm(main);
        let off = 0.5 * (before + self.last.off(self.first));
        if off != 0.0 {
            self.drift += 0.5 * off * h / speed(solved, start, h, scale);
            self.drifted = self.drifted.max(self.drift.abs());
        }
    }

    /// What a distance between the two means for the error.
    pub(super) fn beyond(&self, distance: f64) -> f64 {
        (self.caution * distance).max(PHASE * self.drifted / self.sizes[1]) + self.inside + ROUNDING
    }

    /// The error so far.
    pub(super) fn so_far(&self) -> f64 {
        self.beyond(self.distance)
    }

    /// The error where t is given, at the end of a march: there an error of t becomes one of x.
    pub(super) fn at_time(&self, [main, companion]: &[State; 2]) -> f64 {
        let [t, x] = self.parts(main, companion);
        let velocity = main.w.hi * self.metric.at(main.x.hi).g00 / self.q_t;
        self.beyond(self.distance.max(x + (velocity * t * self.sizes[0] / self.sizes[1]).abs()))
    }

    /// The error of a window at the nodes inside it.
    pub(super) fn inside(&self, solved: &Solved) -> f64 {
        let factors = if is_rough(solved) { INSIDE_WHERE_ROUGH } else { INSIDE };
        let error = |k: usize| factors[k] * if k == 0 { self.per_square } else { 1.0 } * solved.tail[k];
        let t_size = self.sizes[0].max((solved.end.t.hi - self.start.hi).abs());
        (error(0) / self.sizes[1].max(solved.end.x.hi.abs())).max(error(1) / t_size)
    }

    /// What a window of length `h` adds to the error of x and t in the long run, relative to the sizes, where the
    /// motion has the time scale `scale`.
    ///
    /// At the end of a window the companion's error is the square of what its highest modes are. Where V is rough they
    /// do not fall off beyond the highest, and the error has their own size. An error of w = dx/dγ goes on after the
    /// window, which counts if it is much shorter than others. What K has lost is such an error of the world-line
    /// itself.
    pub(super) fn of_window(&self, solved: &Solved, start: &State, h: f64, scale: f64) -> f64 {
        let error = |k: usize| {
            let ratio = if solved.largest[k] > 0.0 { solved.tail[k] / solved.largest[k] } else { 0.0 };
            solved.tail[k] * if ratio > ROUGH { 1.0 } else { CALIBRATION * ratio }
        };
        let lasting = (scale / h).max(1.0);
        let lost = self.norm(&solved.end).off(self.last).abs();
        let lost = if lost > 0.0 { 0.5 * lost * h.max(scale) / speed(solved, start, h, scale) } else { 0.0 };
        ((error(0) * lasting).max(lost) / self.sizes[1]).max(error(1) / self.sizes[0])
    }

    /// The distances of the two in t and x, relative to the sizes.
    fn parts(&self, main: &State, companion: &State) -> [f64; 2] {
        let [t, x] = self.sizes;
        let distance = |a: Twofold, b: Twofold| ((a.hi - b.hi) + (a.lo - b.lo)).abs();
        [distance(main.t, companion.t) / t, distance(main.x, companion.x) / x]
    }
}

/// |dx/dγ| on a window or, where that is about to change sign, its value shortly afterwards.
fn speed(solved: &Solved, start: &State, h: f64, scale: f64) -> f64 {
    let acceleration = solved.largest[0] / (h * h);
    start.w.hi.abs().max(solved.end.w.hi.abs()).max(acceleration * scale)
}
