//! The steps of the Taylor method.

use super::series::SeriesMachine;
use super::{EndReason, ReferenceEnds, ReferencePoint};
use crate::geodesic::InitialData;
use crate::metric::Metric;

/// The last terms of a step's series, relative to the first.
const TRUNCATION: f64 = 1e-17;
/// A step below this share of the whole range means a singularity.
const LEAST_STEP: f64 = 1e-13;
const MOST_STEPS: usize = 2_000_000;
/// Below this share of its first value, g00 is on its way to a horizon.
const HORIZON: f64 = 1e-3;
/// A physical time is not reached if at the present rate it is this many times the length that the start suggested away.
const FAR_TOO_LONG: f64 = 1e6;

/// A sum of two numbers that carries its rounding error.
#[derive(Debug, Clone, Copy, Default)]
struct Compensated {
    high: f64,
    low: f64,
}

impl Compensated {
    fn from(value: f64) -> Self {
        Self { high: value, low: 0.0 }
    }

    /// Knuth's two-sum.
    fn plus(self, increment: f64) -> Self {
        let increment = increment + self.low;
        let high = self.high + increment;
        let back = high - self.high;
        Self { high, low: (self.high - (high - back)) + (increment - back) }
    }
}

/// One step: x and t − t_i as polynomials in γ minus its start.
#[derive(Debug, Clone)]
struct Step {
    start: Compensated,
    x: Vec<f64>,
    x_low: f64,
    t: Vec<f64>,
    t_low: f64,
}

/// All steps from γ_i on.
#[derive(Debug, Clone)]
pub(super) struct Steps {
    steps: Vec<Step>,
    end: f64,
}

/// Σ_{j≥1} c_j s^j: the small part of the polynomial, to be added to c_0 last.
fn increment(c: &[f64], s: f64) -> f64 {
    c[1..].iter().rev().fold(0.0, |sum, c| (sum + c) * s)
}

/// dc/ds.
fn slope(c: &[f64], s: f64) -> f64 {
    c.iter().enumerate().skip(1).rev().fold(0.0, |sum, (j, c)| sum * s + j as f64 * c)
}

impl Step {
    fn at(&self, gamma: f64) -> ReferencePoint {
        let s = (gamma - self.start.high) - self.start.low;
        ReferencePoint {
            elapsed: self.t[0] + (self.t_low + increment(&self.t, s)),
            x: self.x[0] + (self.x_low + increment(&self.x, s)),
            t_dot: slope(&self.t, s),
            x_dot: slope(&self.x, s),
        }
    }
}

/// The moving end of the integration.
struct Front<'m> {
    metric: &'m Metric,
    q_t: f64,
    order: usize,
    gamma: Compensated,
    x: Compensated,
    w: Compensated,
    t: Compensated,
    /// g00 at the start.
    g00_start: f64,
    /// Length of the last step: the scale on which the state changes.
    last_step: f64,
}

/// The series at one point.
struct Expansion {
    x: Vec<f64>,
    w: Vec<f64>,
    t: Vec<f64>,
    /// Estimated radius of convergence.
    radius: f64,
}

impl Front<'_> {
    fn expand(&self, machine: &mut SeriesMachine<'_>) -> Expansion {
        let order = self.order;
        let (mut x, mut w, mut t) = (vec![self.x.high], vec![self.w.high], vec![self.t.high]);
        let (mut g00, mut t_dot, mut t_dot_squared, mut slope) = (vec![], vec![], vec![], vec![]);
        let convolve = |a: &[f64], b: &[f64], k: usize| -> f64 { (0..=k).map(|j| a[j] * b[k - j]).sum() };
        machine.restart();
        for k in 0..order {
            let [v, first] = machine.extend(&x);
            g00.push(self.metric.two_over_mass() * v + if k == 0 { self.metric.c_squared() } else { 0.0 });
            slope.push(self.metric.two_over_mass() * first);
            // g00 · ṫ = Q_t, coefficient by coefficient.
            let known: f64 = (1..=k).map(|j| g00[j] * t_dot[k - j]).sum();
            t_dot.push((if k == 0 { self.q_t } else { 0.0 } - known) / g00[0]);
            t_dot_squared.push(convolve(&t_dot, &t_dot, k));
            let next = (k + 1) as f64;
            x.push(w[k] / next);
            w.push(-0.5 * convolve(&slope, &t_dot_squared, k) / next);
            t.push(t_dot[k] / next);
        }
        // At a singularity of V some coefficient is not finite, and there is no step to take.
        let regular = [&x, &w, &t].into_iter().flatten().all(|c| c.is_finite());
        let radius = if regular { self.radius(&x, &w, &t) } else { 0.0 };
        Expansion { x, w, t, radius }
    }

    /// The root test on the last two coefficients of each series, relative to the size of its first ones.
    fn radius(&self, x: &[f64], w: &[f64], t: &[f64]) -> f64 {
        let scale =
            |c: &[f64]| (0..3).map(|j| c[j].abs() * self.last_step.powi(j as i32)).fold(f64::MIN_POSITIVE, f64::max);
        [x, w, &t[1..]].into_iter().fold(f64::INFINITY, |radius, series| {
            let scale = scale(series);
            (series.len() - 2..series.len())
                .filter(|&j| series[j] != 0.0)
                .fold(radius, |radius, j| radius.min((scale / series[j].abs()).powf(1.0 / j as f64)))
        })
    }

    fn advance(&mut self, expansion: Expansion, h: f64) -> Step {
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
fn step_to_kink(machine: &SeriesMachine<'_>, h: f64) -> f64 {
    let mut step = h;
    for series in machine.kink_arguments() {
        let value = |s: f64| series[0] + increment(series, s);
        // Just beyond the kink, so that the next expansion is safely on the other side.
        let margin =
            |s: f64| 8.0 * f64::EPSILON * (1.0 + series[0].abs()) / slope(series, s).abs().max(f64::MIN_POSITIVE);
        if series[0] == 0.0 {
            step = step.min(margin(0.0));
            continue;
        }
        let (mut inside, mut beyond) = (0.0, step);
        // A few probes, so that two crossings in one step are not missed.
        let probe = (1..=16).map(|i| step * f64::from(i) / 16.0).find(|&s| value(s) * series[0] <= 0.0);
        let Some(first) = probe else { continue };
        beyond = first.min(beyond);
        while beyond - inside > 2.0 * f64::EPSILON * beyond {
            let middle = 0.5 * (inside + beyond);
            if middle <= inside || middle >= beyond {
                break;
            }
            if value(middle) * series[0] > 0.0 { inside = middle } else { beyond = middle }
        }
        step = step.min(beyond + margin(beyond));
    }
    step.min(h)
}

/// Where an integration ends.
#[derive(Debug, Clone, Copy)]
pub(super) enum Goal {
    /// At this γ − γ_i.
    Gamma(f64),
    /// When t − t_i has this value.
    Time(f64),
}

impl Goal {
    /// The step to take instead of `h`, and whether it is the last one.
    fn limit(self, front: &Front<'_>, t: &[f64], h: f64) -> (f64, bool) {
        match self {
            Self::Gamma(length) => {
                let remaining = (length - front.gamma.high) - front.gamma.low;
                (h.min(remaining), h >= remaining)
            }
            Self::Time(duration) => {
                let excess = |s: f64| (t[0] - duration) + (front.t.low + increment(t, s));
                if excess(h) < 0.0 {
                    return (h, false);
                }
                // Newton's method from the end of the step: t increases with s.
                let mut s = h;
                for _ in 0..50 {
                    let next = (s - excess(s) / slope(t, s)).clamp(0.0, h);
                    let change = (next - s).abs();
                    s = next;
                    if change <= f64::EPSILON * h {
                        break;
                    }
                }
                (s, true)
            }
        }
    }
}

impl Steps {
    /// Integrates with series of the given order and `share` of the step that the truncation error allows.
    pub(super) fn integrate(
        metric: &Metric,
        initial: InitialData,
        goal: Goal,
        order: usize,
        share: f64,
    ) -> Result<Self, ReferenceEnds> {
        let program = metric.potential().program();
        let mut machine = SeriesMachine::new(&program, order);
        let scale = match goal {
            Goal::Gamma(length) => length,
            Goal::Time(duration) => duration / initial.t_dot,
        };
        let mut front = Front {
            metric,
            q_t: initial.invariants(metric).q_t,
            order,
            gamma: Compensated::default(),
            x: Compensated::from(initial.x),
            w: Compensated::from(initial.x_dot),
            t: Compensated::default(),
            g00_start: metric.at(initial.x).g00,
            last_step: scale,
        };
        let mut steps = Vec::new();
        loop {
            let expansion = front.expand(&mut machine);
            let h = (share * expansion.radius * TRUNCATION.powf(1.0 / order as f64)).min(scale);
            let here = metric.at(front.x.high);
            let end = |reason| ReferenceEnds { reason, gamma: front.gamma.high, x: front.x.high, g00: here.g00 };
            if !here.is_inside() {
                return Err(end(EndReason::OutsideDomain));
            }
            if h <= LEAST_STEP * scale || steps.len() >= MOST_STEPS {
                // Before g00 = 0 the steps shrink without end.
                let horizon = here.g00 < HORIZON * front.g00_start;
                return Err(end(if horizon { EndReason::OutsideDomain } else { EndReason::Singular }));
            }
            if let Goal::Time(duration) = goal {
                // At this rate it would take far too long: t saturates while x runs away.
                if (duration - front.t.high) * here.g00 > FAR_TOO_LONG * scale * front.q_t {
                    return Err(end(EndReason::TimeNotReached));
                }
            }
            let (h, last) = goal.limit(&front, &expansion.t, step_to_kink(&machine, h));
            steps.push(front.advance(expansion, h));
            if last {
                return Ok(Self { steps, end: front.gamma.high });
            }
        }
    }

    /// γ − γ_i at the end.
    pub(super) fn end(&self) -> f64 {
        self.end
    }

    pub(super) fn len(&self) -> usize {
        self.steps.len()
    }

    pub(super) fn at(&self, gamma: f64) -> ReferencePoint {
        let next = self.steps.partition_point(|step| step.start.high <= gamma);
        self.steps[next.saturating_sub(1)].at(gamma)
    }

    /// Largest relative difference in t or x at the starts of the steps and at the end.
    pub(super) fn distance(&self, other: &Self) -> f64 {
        let (mut t, mut x, mut t_size, mut x_size) = (0.0_f64, 0.0_f64, f64::MIN_POSITIVE, f64::MIN_POSITIVE);
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
        (t / t_size).max(x / x_size)
    }
}
