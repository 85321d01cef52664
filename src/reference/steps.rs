//! The steps of the Taylor method.

use super::polynomials::{Step, increment, slope};
use super::series::SeriesMachine;
use super::{EndReason, ReferenceEnds, ReferencePoint};
use crate::geodesic::{InitialData, acceleration};
use crate::metric::Metric;
use crate::scalar::{Compensated, Real, sum};

/// Only a step below this share of the whole range can mean a singularity.
const LEAST_STEP: f64 = 1e-13;
/// Largest number of products of coefficients for each value of the potential's program. They take some seconds in
/// `f64`, and some minutes in extended precision.
const MOST_PRODUCTS: usize = 200_000_000;
/// After this many steps the integration ends early, if at that rate it would need the second number times as many
/// steps as are allowed.
const FIRST_STEPS: usize = 1000;
const HOPELESS: f64 = 4.0;
/// Steps that shrink to this share of the longest before them approach a singularity.
const SHRUNK: f64 = 1e-6;
/// How often the scale of the first step is corrected at most.
const FIRST_STEP_TRIES: usize = 8;
/// If steps shrink while g00 is below this share of its first value, the trajectory approaches a horizon.
const HORIZON: f64 = 1e-3;
/// A physical time is not reached if, at the present rate, it is further away than this many times the length that the
/// start suggested.
const FAR_TOO_LONG: f64 = 1e6;

/// Number of points at which the series of a step are compared with V, and how often a step is halved at most because
/// of a difference.
const PROBES: i32 = 32;
const MOST_HALVINGS: usize = 40;
/// The comparison of the series with V is accurate to this many digits fewer than the series themselves.
const SPARE_DIGITS: f64 = 4.0;

/// All steps from γ_i on.
#[derive(Debug, Clone)]
pub(super) struct Steps<S> {
    steps: Vec<Step<S>>,
    end: S,
}

/// The smaller of the two; if one is NaN, the other one.
fn smaller<S: Real>(a: S, b: S) -> S {
    if b < a || a.is_nan() { b } else { a }
}

/// The accuracy of an integration.
#[derive(Debug, Clone, Copy)]
pub(super) struct Accuracy {
    /// Order of the series.
    pub(super) order: usize,
    /// Share that is taken of the step that the truncation error allows.
    pub(super) share: f64,
    /// The last terms of a step's series are this many decimal digits below the first.
    pub(super) digits: u32,
}

/// The moving end of the integration.
struct Front<'m, S> {
    metric: &'m Metric<S>,
    q_t: S,
    order: usize,
    gamma: Compensated<S>,
    x: Compensated<S>,
    w: Compensated<S>,
    t: Compensated<S>,
    /// g00 at the start.
    g00_start: S,
    /// Length of the last step: the scale on which the state changes.
    last_step: S,
}

/// The series at one point.
struct Expansion<S> {
    x: Vec<S>,
    w: Vec<S>,
    t: Vec<S>,
    /// Estimated radius of convergence.
    radius: S,
}

impl<'m, S: Real> Front<'m, S> {
    fn new(metric: &'m Metric<S>, initial: InitialData<S>, order: usize, scale: S) -> Self {
        Self {
            metric,
            q_t: initial.invariants(metric).q_t,
            order,
            gamma: Compensated::default(),
            x: Compensated::from(initial.x),
            w: Compensated::from(initial.x_dot),
            t: Compensated::default(),
            g00_start: metric.at(initial.x).g00,
            last_step: scale,
        }
    }

    fn expand(&self, machine: &mut SeriesMachine<'_, S>) -> Expansion<S> {
        let order = self.order;
        let (mut x, mut w, mut t) = (vec![self.x.high], vec![self.w.high], vec![self.t.high]);
        let (mut g00, mut t_dot, mut t_dot_squared, mut slope) = (vec![], vec![], vec![], vec![]);
        let convolve = |a: &[S], b: &[S], k: usize| sum((0..=k).map(|j| a[j] * b[k - j]));
        machine.restart();
        for k in 0..order {
            let [v, first] = machine.extend(&x);
            g00.push(self.metric.two_over_mass() * v + if k == 0 { self.metric.c_squared() } else { S::ZERO });
            slope.push(self.metric.two_over_mass() * first);
            // g00 · ṫ = Q_t, coefficient by coefficient.
            let known = sum((1..=k).map(|j| g00[j] * t_dot[k - j]));
            t_dot.push((if k == 0 { self.q_t } else { S::ZERO } - known) / g00[0]);
            t_dot_squared.push(convolve(&t_dot, &t_dot, k));
            let next = S::from((k + 1) as f64);
            x.push(w[k] / next);
            w.push(-convolve(&slope, &t_dot_squared, k).half() / next);
            t.push(t_dot[k] / next);
        }
        // At a singularity of V some coefficient is not finite, and there is no step to take.
        let regular = [&x, &w, &t].into_iter().flatten().all(|c| c.is_finite());
        let radius = if regular { self.radius(&x, &w, &t) } else { S::ZERO };
        Expansion { x, w, t, radius }
    }

    /// The root test on the last two coefficients of each series, relative to the size of its first ones.
    fn radius(&self, x: &[S], w: &[S], t: &[S]) -> S {
        let (h, tiny) = (self.last_step, S::MIN_POSITIVE);
        let scale =
            |c: &[S]| [c[0], c[1] * h, c[2] * (h * h)].iter().fold(tiny, |largest, term| largest.max(term.abs()));
        [x, w, &t[1..]].into_iter().fold(S::from(f64::INFINITY), |radius, series| {
            let scale = scale(series);
            (series.len() - 2..series.len())
                .filter(|&j| series[j] != S::ZERO)
                .map(|j| (scale / series[j].abs()).powf(S::ONE / S::from(j as f64)))
                .fold(radius, smaller)
        })
    }

    /// The longest of h, h/2, h/4, … over which the series agree with V. They may miss a feature of V that is too far
    /// away, or too narrow, to show in the coefficients.
    fn seen(&self, expansion: &Expansion<S>, h: S, digits: u32) -> S {
        let [small, large] =
            [SPARE_DIGITS - f64::from(digits), -0.5 * f64::from(digits)].map(|e| S::from(10.0_f64.powf(e)));
        let mut h = h;
        let mut missed = self.missed(expansion, h);
        for _ in 0..MOST_HALVINGS {
            if missed <= small {
                break;
            }
            let of_half = self.missed(expansion, h.half());
            // A small difference that hardly falls when the step is halved is rounding. One that comes from a feature
            // of V is either large, or falls.
            if missed <= large && S::from(4.0) * of_half > missed {
                break;
            }
            (h, missed) = (h.half(), of_half);
        }
        h
    }

    /// The largest difference of dw/dγ between the series and V at points of a step, relative to the size of its terms.
    fn missed(&self, Expansion { x, w, .. }: &Expansion<S>, h: S) -> S {
        let size = w[1].abs().max((w[2] * h).abs()).max(w[0].abs() / h).max(x[0].abs() / (h * h)).max(S::MIN_POSITIVE);
        let at = |k: i32| {
            let s = h * S::from(f64::from(2 * k + 1) / f64::from(2 * PROBES));
            let g = self.metric.at(x[0] + increment(x, s));
            let difference = (slope(w, s) - acceleration(self.q_t, g.g00, g.first)).abs();
            if difference.is_nan() { S::from(f64::INFINITY) } else { difference }
        };
        (0..PROBES).map(at).fold(S::ZERO, S::max) / size
    }

    /// Finds the scale of the first step. At first it is taken to be the length of the whole run, which may be far too
    /// long: then the terms of the series are compared with something much too large, and the radius is wrong.
    fn settle_first_step(&mut self, expansion: &mut Expansion<S>, relative_step: S) {
        for _ in 0..FIRST_STEP_TRIES {
            let h = relative_step * expansion.radius;
            if !(h > S::ZERO && h < self.last_step) {
                break;
            }
            self.last_step = h;
            expansion.radius = self.radius(&expansion.x, &expansion.w, &expansion.t);
        }
    }

    fn advance(&mut self, expansion: Expansion<S>, h: S) -> Step<S> {
        let Expansion { x, w, t, .. } = expansion;
        let step = Step { start: self.gamma, x_low: self.x.low, t_low: self.t.low, x, t };
        self.x = self.x.plus(increment(&step.x, h));
        self.w = self.w.plus(increment(&w, h));
        self.t = self.t.plus(increment(&step.t, h));
        self.gamma = self.gamma.plus(h);
        self.last_step = h;
        step
    }
}

/// The first s in (0, h) at which an argument of `abs` has just changed its sign; h if there is none.
fn step_to_kink<S: Real>(machine: &SeriesMachine<'_, S>, h: S) -> S {
    let mut step = h;
    for series in machine.kink_arguments() {
        let value = |s: S| series[0] + increment(series, s);
        // Just beyond the kink, so that the next expansion is safely on the other side.
        let margin =
            |s: S| S::from(8.0) * S::EPSILON * (S::ONE + series[0].abs()) / slope(series, s).abs().max(S::MIN_POSITIVE);
        if series[0] == S::ZERO {
            step = smaller(step, margin(S::ZERO));
            continue;
        }
        let (mut inside, mut beyond) = (S::ZERO, step);
        // A few probes, so that two changes of sign in one step are not missed.
        let probe = (1..=16).map(|i| step * S::from(f64::from(i) / 16.0)).find(|&s| value(s) * series[0] <= S::ZERO);
        let Some(first) = probe else { continue };
        beyond = smaller(first, beyond);
        while beyond - inside > (S::EPSILON + S::EPSILON) * beyond {
            let middle = (inside + beyond).half();
            if middle <= inside || middle >= beyond {
                break;
            }
            if value(middle) * series[0] > S::ZERO { inside = middle } else { beyond = middle }
        }
        step = smaller(step, beyond + margin(beyond));
    }
    smaller(step, h)
}

/// Where an integration ends.
#[derive(Debug, Clone, Copy)]
pub(super) enum Goal<S> {
    /// At this γ − γ_i.
    Gamma(S),
    /// When t − t_i has this value.
    Time(S),
}

impl<S: Real> Goal<S> {
    /// The length of the whole range of γ; for a time, the length that dt/dγ at the start suggests.
    fn scale(self, initial: InitialData<S>) -> S {
        match self {
            Self::Gamma(length) => length,
            Self::Time(duration) => duration / initial.t_dot,
        }
    }

    /// The step to take instead of `h`, and whether it is the last one.
    fn limit(self, front: &Front<'_, S>, t: &[S], h: S) -> (S, bool) {
        match self {
            Self::Gamma(length) => {
                let remaining = (length - front.gamma.high) - front.gamma.low;
                (smaller(h, remaining), h >= remaining)
            }
            Self::Time(duration) => {
                let excess = |s: S| (t[0] - duration) + (front.t.low + increment(t, s));
                if excess(h) < S::ZERO {
                    return (h, false);
                }
                // Newton's method from the end of the step: t increases with s.
                let mut s = h;
                for _ in 0..50 {
                    let next = smaller((s - excess(s) / slope(t, s)).max(S::ZERO), h);
                    let change = (next - s).abs();
                    s = next;
                    if change <= S::EPSILON * h {
                        break;
                    }
                }
                (s, true)
            }
        }
    }
}

impl<S: Real> Steps<S> {
    /// Integrates with series and steps of the given accuracy.
    pub(super) fn integrate(
        metric: &Metric<S>,
        initial: InitialData<S>,
        goal: Goal<S>,
        accuracy: Accuracy,
    ) -> Result<Self, ReferenceEnds> {
        let Accuracy { order, share, digits } = accuracy;
        let relative_step = S::from(share * 10.0_f64.powf(-f64::from(digits) / order as f64));
        let program = metric.potential().program();
        let mut machine = SeriesMachine::new(&program, order);
        let scale = goal.scale(initial);
        let mut front = Front::new(metric, initial, order, scale);
        let most_steps = MOST_PRODUCTS / (order * order);
        let (mut steps, mut longest) = (Vec::new(), S::ZERO);
        loop {
            let mut expansion = front.expand(&mut machine);
            if steps.is_empty() {
                front.settle_first_step(&mut expansion, relative_step);
            }
            let h = smaller(relative_step * expansion.radius, scale);
            let here = metric.at(front.x.high);
            let end = |reason| ReferenceEnds {
                reason,
                gamma: front.gamma.high.to_f64(),
                x: front.x.high.to_f64(),
                g00: here.g00.to_f64(),
            };
            if !here.is_inside() {
                return Err(end(EndReason::OutsideDomain));
            }
            let shrinks = h <= S::from(LEAST_STEP) * scale && (h == S::ZERO || h < S::from(SHRUNK) * longest);
            if shrinks {
                // On the way to g00 = 0 the steps shrink without end.
                let horizon = here.g00 < S::from(HORIZON) * front.g00_start;
                return Err(end(if horizon { EndReason::OutsideDomain } else { EndReason::Singular }));
            }
            let share = (front.gamma.high / scale).to_f64();
            let hopeless = steps.len() == FIRST_STEPS && share * HOPELESS * (most_steps as f64) < FIRST_STEPS as f64;
            if steps.len() >= most_steps || hopeless {
                return Err(end(EndReason::TooLong { most_steps }));
            }
            if let Goal::Time(duration) = goal {
                // At this rate it would take far too long: dt/dγ tends to 0 as x grows without bound.
                if (duration - front.t.high) * here.g00 > S::from(FAR_TOO_LONG) * scale * front.q_t {
                    return Err(end(EndReason::TimeNotReached));
                }
            }
            let (wanted, last) = goal.limit(&front, &expansion.t, step_to_kink(&machine, h));
            let h = front.seen(&expansion, wanted, digits);
            let last = last && h == wanted;
            longest = longest.max(h);
            steps.push(front.advance(expansion, h));
            if last {
                return Ok(Self { steps, end: front.gamma.high });
            }
        }
    }

    /// Whether the series at the start, and their squares, do not overflow.
    pub(super) fn can_begin(metric: &Metric<S>, initial: InitialData<S>, accuracy: Accuracy) -> bool {
        let program = metric.potential().program();
        let mut machine = SeriesMachine::new(&program, accuracy.order);
        let Expansion { x, w, t, .. } = Front::new(metric, initial, accuracy.order, S::ONE).expand(&mut machine);
        let largest = (S::ONE / S::MIN_POSITIVE).sqrt();
        // The comparison is false for a NaN.
        [x, w, t].iter().flatten().all(|c| c.abs() < largest)
    }

    /// γ − γ_i at the end.
    pub(super) fn end(&self) -> S {
        self.end
    }

    pub(super) fn len(&self) -> usize {
        self.steps.len()
    }

    pub(super) fn at(&self, gamma: S) -> ReferencePoint<S> {
        let next = self.steps.partition_point(|step| step.start.high <= gamma);
        self.steps[next.saturating_sub(1)].at(gamma)
    }

    /// The largest relative difference in t or x to `other`, at the starts of the steps and at the end.
    pub(super) fn distance(&self, other: &Self) -> f64 {
        let (mut t, mut x, mut t_size, mut x_size) = (S::ZERO, S::ZERO, S::MIN_POSITIVE, S::MIN_POSITIVE);
        for gamma in self.steps.iter().map(|step| step.start.high).chain([self.end]) {
            let (a, b) = (self.at(gamma), other.at(gamma));
            // `f64::max` would drop a NaN.
            if !(a.elapsed - b.elapsed + a.x - b.x).is_finite() {
                return f64::INFINITY;
            }
            t = t.max((a.elapsed - b.elapsed).abs());
            x = x.max((a.x - b.x).abs());
            t_size = t_size.max(a.elapsed.abs());
            x_size = x_size.max(a.x.abs());
        }
        (t / t_size).max(x / x_size).to_f64()
    }
}
