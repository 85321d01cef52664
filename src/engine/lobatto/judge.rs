//! What an adaptive march knows about its error.

use super::State;
use super::window::Solved;
use crate::geometry::geodesic::acceleration_slope;
use crate::geometry::metric::Metric;
use crate::number::norm::{larger, times};
use crate::number::vector::Twofold;

/// The minimum of the estimate: the result is rounded.
pub(super) const ROUNDING: f64 = 2.0 * f64::EPSILON;

/// What the sums of local errors are multiplied by.
const CAUTION: f64 = 3.0;

/// The same if a window was accepted in which V is rough on its scale, as at a kink: there the modes say less.
const CAUTION_WHERE_ROUGH: f64 = 30.0;

/// The highest modes relative to the largest value in a window where V is rough.
const ROUGH: f64 = 0.03;

/// The error at the end of a window in units of the squared modes, at most: measured with a rule of one node less.
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

/// What is known of the error of a world-line, without a second one.
///
/// A deviation (δx, δw) from a geodesic is a shift along it and a change of its energy: in the frame of the flow
/// f = (w, a) and of its symplectic partner, the shift stays what it is but for the shear ∫δE/f², and δE = −½δK for
/// ever. K at the ends of windows is known exactly, so δE is measured. Shifts add up from the local errors of the
/// windows, which their highest modes bound. The error of x is the shift times dx/dγ: where the motion has become
/// faster since, as after a barrier, it has grown by as much.
pub(super) struct Judge<'m> {
    metric: &'m Metric,
    q_t: f64,
    /// n⁻².
    per_square: f64,
    start: Twofold,
    /// The largest |t − t_i| and |x|, at least 1.
    pub(super) sizes: [f64; 2],
    /// A time scale of the motion, which makes a velocity of an acceleration.
    time: f64,
    /// The length of the last window.
    length: f64,
    /// The sum of the local truncation errors as shifts in γ.
    shift: f64,
    rounding: Rounding,
    /// The integral of δE/f² over γ, and the largest so far: what K loses and regains over a turn does not add up.
    shear: f64,
    sheared: f64,
    /// The sum of the local errors of t.
    local_t: f64,
    /// The smallest and the largest dt/dγ.
    rates: [f64; 2],
    /// The largest relative error so far at the ends of windows, and inside one.
    worst: f64,
    inside: f64,
    caution: f64,
    /// At the start of the march and at the last joint.
    first: Joint,
    last: Joint,
}

/// K, how far it may be off because of rounding, the flow |f|, |da/dx|, |w|, |a| and |dt/dγ|.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Joint {
    k: f64,
    rounds: f64,
    flow: f64,
    slope: f64,
    speed: f64,
    push: f64,
    rate: f64,
}

/// What rounding errors add up to, as they do in a random walk. K does not show them, being rounded itself.
#[derive(Debug, Clone, Copy, Default)]
struct Rounding {
    /// Sums of the squares of shifts and of energies, and the shear by the latter.
    shifts: f64,
    energies: f64,
    shear: f64,
}

impl Rounding {
    /// Adds a window of length `h` in which x is rounded by `x`, where the motion has this time scale.
    fn add(&mut self, x: f64, time: f64, flow: [f64; 2], h: f64) {
        if x > 0.0 {
            self.shifts += (x / flow[1]).powi(2);
            self.energies += (x / time * flow[1]).powi(2);
            self.shear += self.energies.sqrt() * h / (flow[0] * flow[1]);
        }
    }

    /// As a shift in γ.
    fn shift(&self) -> f64 {
        self.shifts.sqrt() + self.shear
    }
}

impl Joint {
    /// How far K differs from the other, beyond rounding.
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
    /// For windows of `points` nodes from `start` on, where the motion has this time scale.
    pub(super) fn new(metric: &'m Metric, q_t: f64, points: usize, start: &State, time: f64) -> Self {
        let mut judge = Self {
            metric,
            q_t,
            per_square: (points as f64).powi(-2),
            start: start.t,
            sizes: [1.0; 2],
            // Squares of its reciprocal must not overflow.
            time: time.max(1e-100),
            length: 0.0,
            shift: 0.0,
            rounding: Rounding::default(),
            shear: 0.0,
            sheared: 0.0,
            local_t: 0.0,
            rates: [0.0; 2],
            worst: 0.0,
            inside: 0.0,
            caution: CAUTION,
            first: Joint::default(),
            last: Joint::default(),
        };
        judge.first = judge.joint(start);
        judge.last = judge.first;
        judge.rates = [judge.first.rate; 2];
        judge
    }

    /// What is known of the joint at `state`.
    pub(super) fn joint(&self, state: &State) -> Joint {
        let g = self.metric.at(state.x.hi);
        let u = self.q_t / g.g00;
        let (energy, motion) = (self.q_t * u, state.w.hi * state.w.hi);
        // g00 = c² + 2V/m is rounded at the size of its terms, and x at its own.
        let c_squared = self.metric.c_squared();
        let rounds = u * u * (c_squared + (g.g00 - c_squared).abs() + (g.first * state.x.hi).abs()) + motion;
        let (speed, push) = (state.w.hi.abs(), (0.5 * g.first * u * u).abs());
        let flow = speed.hypot(push * self.time);
        let slope = acceleration_slope(self.q_t, g.g00, g.first, g.second).abs();
        Joint { k: energy - motion, rounds: K_ROUNDS * rounds, flow, slope, speed, push, rate: u.abs() }
    }

    /// Sees an accepted window of length `h` that ends at the joint `here`, where the motion has the time scale
    /// `scale`. `rounds` is what rounding adds to x and w in it, relative to their sizes.
    pub(super) fn see(&mut self, solved: &Solved, here: Joint, h: f64, scale: f64, rounds: f64) {
        let end = &solved.end;
        self.sizes[0] = self.sizes[0].max((end.t.hi - self.start.hi).abs());
        self.sizes[1] = self.sizes[1].max(end.x.hi.abs());
        self.inside = self.inside.max(self.inside(solved));
        if is_rough(solved) {
            self.caution = CAUTION_WHERE_ROUGH;
        }
        let before = self.last.off(self.first);
        let from = self.last;
        (self.last, self.length) = (here, h);
        let off = 0.25 * (before + here.off(self.first));
        if off != 0.0 {
            let bend = (self.time * self.time * from.slope.max(here.slope)).max(1.0);
            self.shear += off * h * bend / (from.flow * here.flow);
            self.sheared = self.sheared.max(self.shear.abs());
        }
        let [x, t] = local(solved);
        let x = x * (scale / h).max(1.0);
        if x > 0.0 {
            self.shift += x / here.flow;
        }
        let rounds = rounds * end.x.hi.abs().max(here.speed * self.time);
        self.rounding.add(rounds, self.time, [from.flow, here.flow], h);
        self.local_t += t;
        let [least, most] = solved.u.map(|u| u.abs() / h);
        self.rates = [self.rates[0].min(least.min(most)), self.rates[1].max(least.max(most))];
        let [t, x] = self.errors();
        self.worst = larger(larger(self.worst, t), x);
    }

    /// The relative errors of t and x at the last joint.
    fn errors(&self) -> [f64; 2] {
        let shift = self.caution * self.shift + self.rounding.shift() + PHASE * self.sheared;
        let energy = 0.5 * self.last.off(self.first).abs();
        let across = if energy > 0.0 { self.time * energy / self.last.flow } else { 0.0 };
        // A shift moves x by dx/dγ, up to its largest value in the window.
        let reach = self.last.speed + self.last.push * self.length;
        let x = times(reach, shift) + across;
        // Where dt/dγ is constant, a shift along the world-line does not move t.
        let t = times(2.0 * (self.rates[1] - self.rates[0]), shift) + self.caution * self.local_t;
        [t / self.sizes[0], x / self.sizes[1]]
    }

    fn beyond(&self, error: f64) -> f64 {
        error + self.inside + ROUNDING
    }

    /// The error so far.
    pub(super) fn so_far(&self) -> f64 {
        self.beyond(self.worst)
    }

    /// The error where t is given, at the end of a march: there an error of t becomes one of x.
    pub(super) fn at_time(&self) -> f64 {
        let [t, x] = self.errors();
        let velocity = self.last.speed / self.last.rate;
        self.beyond(self.worst.max(x + velocity * t * self.sizes[0] / self.sizes[1]))
    }

    /// The error of a window at the nodes inside it.
    pub(super) fn inside(&self, solved: &Solved) -> f64 {
        let factors = if is_rough(solved) { INSIDE_WHERE_ROUGH } else { INSIDE };
        let error = |k: usize| factors[k] * if k == 0 { self.per_square } else { 1.0 } * solved.tail[k];
        let t_size = self.sizes[0].max((solved.end.t.hi - self.start.hi).abs());
        (error(0) / self.sizes[1].max(solved.end.x.hi.abs())).max(error(1) / t_size)
    }

    /// What a window of length `h` that ends at the joint `end` adds to the error of x and t in the long run, relative
    /// to the sizes, where the motion has the time scale `scale`.
    ///
    /// An error of w = dx/dγ goes on after the window, which counts if it is much shorter than others. What K has lost
    /// is such an error, too.
    pub(super) fn of_window(&self, solved: &Solved, end: Joint, start: &State, h: f64, scale: f64) -> f64 {
        let [x, t] = local(solved);
        let lasting = (scale / h).max(1.0);
        let lost = end.off(self.last).abs();
        let lost = if lost > 0.0 { 0.5 * lost * h.max(scale) / speed(solved, start, h, scale) } else { 0.0 };
        ((x * lasting).max(lost) / self.sizes[1]).max(t / self.sizes[0])
    }
}

/// The errors of x and t at the end of a window, as its highest modes show them.
///
/// They are the square of what these modes are: the truncations of forces and of test functions multiply. Where V is
/// rough they do not fall off beyond the highest, and the error has their own size.
fn local(solved: &Solved) -> [f64; 2] {
    [0, 1].map(|k| {
        let ratio = if solved.largest[k] > 0.0 { solved.tail[k] / solved.largest[k] } else { 0.0 };
        solved.tail[k] * if ratio > ROUGH { 1.0 } else { CALIBRATION * ratio }
    })
}

/// |dx/dγ| on a window or, where that is about to change sign, its value shortly afterwards.
fn speed(solved: &Solved, start: &State, h: f64, scale: f64) -> f64 {
    let acceleration = solved.largest[0] / (h * h);
    start.w.hi.abs().max(solved.end.w.hi.abs()).max(acceleration * scale)
}

#[cfg(test)]
mod tests;
