//! The steps of the Taylor method.

use super::equations::{Equations, Series};
use super::series::{increment, slope};
use super::{EndReason, ReferenceEnds};
use crate::number::{Compensated, Real};

/// Only a step below this share of the whole range can mean a singularity.
const LEAST_STEP: f64 = 1e-13;
/// Largest number of products of coefficients for each value of the equations' program. They take some seconds in
/// `f64`, and some minutes in extended precision.
const MOST_PRODUCTS: usize = 200_000_000;
/// After this many steps the integration ends early, if at that rate it would need the second number times as many
/// steps as are allowed.
const FIRST_STEPS: usize = 1000;
const HOPELESS: f64 = 4.0;
/// Steps that shrink to this share of the longest before them approach a singularity.
const SHRUNK: f64 = 1e-6;
/// A value is not reached if, at the present rate, it is further away than this many times the length that the start
/// suggested.
const FAR_TOO_LONG: f64 = 1e6;

/// The most corrections of the scale of the first step.
const FIRST_STEP_TRIES: usize = 8;
/// Number of points at which the series of a step are compared with the equations, and how often a step is halved at
/// most because of a difference.
const PROBES: i32 = 32;
const MOST_HALVINGS: usize = 40;
/// The comparison of the series with the equations is accurate to this many digits fewer than the series themselves.
const SPARE_DIGITS: f64 = 4.0;

/// One step.
#[derive(Debug, Clone)]
pub(super) struct Step<S> {
    start: Compensated<S>,
    /// The components of the state, as polynomials in the parameter counted from the start of the step.
    series: Series<S>,
    /// The rounding errors of their first coefficients, which are compensated sums.
    lows: Vec<S>,
}

impl<S: Real> Step<S> {
    pub(super) fn value(&self, component: usize, s: S) -> S {
        let series = &self.series[component];
        series[0] + (self.lows[component] + increment(series, s))
    }

    pub(super) fn slope(&self, component: usize, s: S) -> S {
        slope(&self.series[component], s)
    }
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

/// Where an integration ends.
#[derive(Debug, Clone, Copy)]
pub(super) struct Goal<S> {
    /// At this γ − γ_i; for a value it is the length that the start suggests.
    pub(super) length: S,
    /// When a component, which only grows or only falls, has a value; with 1 if it grows and −1 if it falls.
    pub(super) value: Option<(usize, S, S)>,
}

/// All steps from γ_i on.
#[derive(Debug, Clone)]
pub(super) struct Steps<S> {
    pub(super) steps: Vec<Step<S>>,
    /// γ − γ_i at their end, and the state there.
    pub(super) end: Compensated<S>,
    state: Vec<Compensated<S>>,
}

impl<S: Real> Goal<S> {
    /// The step to take instead of `h`, and whether it is the last one.
    fn limit(self, steps: &Steps<S>, series: &Series<S>, h: S) -> (S, bool) {
        let Some((component, value, sign)) = self.value else {
            let remaining = (self.length - steps.end.high) - steps.end.low;
            return (smaller(h, remaining), h >= remaining);
        };
        let (series, low) = (&series[component], steps.state[component].low);
        let excess = |s: S| sign * ((series[0] - value) + (low + increment(series, s)));
        if excess(h) < S::ZERO {
            return (h, false);
        }
        // Newton's method from the end of the step: the excess increases with s.
        let mut s = h;
        for _ in 0..50 {
            let next = smaller((s - excess(s) / (sign * slope(series, s))).max(S::ZERO), h);
            let change = (next - s).abs();
            s = next;
            if change <= S::EPSILON * h {
                break;
            }
        }
        (s, true)
    }

    /// Returns true if at the present rate the goal would be reached far too late.
    fn is_far_too_far(self, series: &Series<S>) -> bool {
        self.value.is_some_and(|(component, value, sign)| {
            let series = &series[component];
            sign * (value - series[0]) > S::from(FAR_TOO_LONG) * self.length * (sign * series[1])
        })
    }
}

impl<S: Real> Steps<S> {
    /// Integrates from the start with series and steps of the given accuracy.
    pub(super) fn integrate(
        mut equations: Equations<'_, S>,
        goal: Goal<S>,
        accuracy: Accuracy,
    ) -> Result<Self, ReferenceEnds> {
        let equations = &mut equations;
        let Accuracy { order, share, digits } = accuracy;
        let relative_step = S::from(share * 10.0_f64.powf(-f64::from(digits) / order as f64));
        let scale = goal.length;
        let state = equations.state().into_iter().map(Compensated::from).collect();
        let mut all = Self { steps: Vec::new(), end: Compensated::default(), state };
        let most_steps = MOST_PRODUCTS / (order * order);
        let (mut longest, mut last_step) = (S::ZERO, scale);
        loop {
            let (here, count): (Vec<S>, _) = (all.state.iter().map(|it| it.high).collect(), all.steps.len());
            let series = equations.expand(&here, order);
            let radius = if count == 0 {
                first_radius(equations, &series, relative_step, scale)
            } else {
                radius(equations, &series, last_step)
            };
            let h = smaller(relative_step * radius, scale);
            let stop = |equations: &mut Equations<'_, S>, reason| Err(equations.ends(reason, all.end.high, &here));
            if !equations.is_inside(&here) {
                return stop(equations, EndReason::OutsideDomain);
            }
            let shrinks = h <= S::from(LEAST_STEP) * scale && (h == S::ZERO || h < S::from(SHRUNK) * longest);
            if shrinks {
                // On the way to the edge of the domain the steps shrink without end.
                let is_edge = equations.is_near_the_edge(&here);
                return stop(equations, if is_edge { EndReason::OutsideDomain } else { EndReason::Singular });
            }
            let share = (all.end.high / scale).to_f64();
            let hopeless = count == FIRST_STEPS && share * HOPELESS * (most_steps as f64) < FIRST_STEPS as f64;
            if count >= most_steps || hopeless {
                return stop(equations, EndReason::TooLong { most_steps });
            }
            // At the start it may be at rest.
            if count > 0 && goal.is_far_too_far(&series) {
                return stop(equations, EndReason::TimeNotReached);
            }
            let (wanted, last) = goal.limit(&all, &series, step_to_kink(equations, h));
            let h = seen(equations, &series, wanted, digits);
            let last = last && h == wanted;
            longest = longest.max(h);
            last_step = h;
            all.advance(series, h);
            if last {
                return Ok(all);
            }
        }
    }

    fn advance(&mut self, series: Series<S>, h: S) {
        let lows = self.state.iter().map(|component| component.low).collect();
        for (component, series) in self.state.iter_mut().zip(&series) {
            *component = component.plus(increment(series, h));
        }
        self.steps.push(Step { start: self.end, series, lows });
        self.end = self.end.plus(h);
    }

    /// Returns true if the series at the start, and their squares, do not overflow.
    pub(super) fn can_begin(mut equations: Equations<'_, S>, order: usize) -> bool {
        let largest = (S::ONE / S::MIN_POSITIVE).sqrt();
        // The comparison is false for a NaN.
        equations.expand(&equations.state(), order).iter().flatten().all(|c| c.abs() < largest)
    }

    /// γ − γ_i at the ends of the steps.
    pub(super) fn ends(&self) -> impl Iterator<Item = S> + '_ {
        self.steps.iter().map(|step| step.start.high).chain([self.end.high])
    }

    /// The step at `gamma`, and its parameter there.
    pub(super) fn at(&self, gamma: S) -> (&Step<S>, S) {
        let next = self.steps.partition_point(|step| step.start.high <= gamma);
        let step = &self.steps[next.saturating_sub(1)];
        (step, (gamma - step.start.high) - step.start.low)
    }

    /// For each of the first `components` the largest difference to `other` and the largest value, at the ends of the
    /// steps. Differences that are not numbers are infinite.
    pub(super) fn distances(&self, other: &Self, components: usize) -> Vec<(S, S)> {
        let mut distances = vec![(S::ZERO, S::MIN_POSITIVE); components];
        for gamma in self.ends() {
            let ((own, s), (others, r)) = (self.at(gamma), other.at(gamma));
            for (component, (distance, size)) in distances.iter_mut().enumerate() {
                let (a, b) = (own.value(component, s), others.value(component, r));
                let gap = (a - b).abs();
                // `max` would drop a NaN.
                *distance = if gap.is_finite() { distance.max(gap) } else { S::from(f64::INFINITY) };
                *size = size.max(a.abs());
            }
        }
        distances
    }
}

/// The smaller of the two; if one is NaN, the other one.
fn smaller<S: Real>(a: S, b: S) -> S {
    if b < a || a.is_nan() { b } else { a }
}

/// The root test on the last two coefficients of each series, relative to the size of its first ones over a step `h`.
/// The radius is 0 where a coefficient is not finite: at a singularity there is no step to take.
fn radius<S: Real>(equations: &Equations<'_, S>, series: &Series<S>, h: S) -> S {
    if !series.iter().flatten().all(|c| c.is_finite()) {
        return S::ZERO;
    }
    let tiny = S::MIN_POSITIVE;
    let scale = |c: &[S]| [c[0], c[1] * h, c[2] * (h * h)].iter().fold(tiny, |largest, term| largest.max(term.abs()));
    let counted = series.iter().enumerate().map(|(component, c)| &c[equations.first_of_scale(component)..]);
    counted.fold(S::from(f64::INFINITY), |radius, series| {
        let scale = scale(series);
        (series.len() - 2..series.len())
            .filter(|&j| series[j] != S::ZERO)
            .map(|j| (scale / series[j].abs()).powf(S::ONE / S::from(j as f64)))
            .fold(radius, smaller)
    })
}

/// The radius at the first step. At first the scale is taken to be the `range` of the whole run, which may be far too
/// long: then the terms of the series are compared with something much too large, and the radius is wrong.
fn first_radius<S: Real>(equations: &Equations<'_, S>, series: &Series<S>, relative_step: S, range: S) -> S {
    let (mut scale, mut first) = (range, radius(equations, series, range));
    for _ in 0..FIRST_STEP_TRIES {
        let h = relative_step * first;
        if !(h > S::ZERO && h < scale) {
            break;
        }
        scale = h;
        first = radius(equations, series, scale);
    }
    first
}

/// The longest of h, h/2, h/4, … over which the series agree with the equations. They may miss a feature of a formula
/// that is too far away, or too narrow, to show in the coefficients.
fn seen<S: Real>(equations: &mut Equations<'_, S>, series: &Series<S>, h: S, digits: u32) -> S {
    let [small, large] =
        [SPARE_DIGITS - f64::from(digits), -0.5 * f64::from(digits)].map(|e| S::from(10.0_f64.powf(e)));
    let mut missed = |h: S| {
        let probe = |k: i32| h * S::from(f64::from(2 * k + 1) / f64::from(2 * PROBES));
        (0..PROBES).fold(S::ZERO, |largest, k| largest.max(equations.missed(series, h, probe(k), small)))
    };
    let mut h = h;
    let mut missed_by_it = missed(h);
    for _ in 0..MOST_HALVINGS {
        if missed_by_it <= small {
            break;
        }
        let of_half = missed(h.half());
        // A small difference that hardly falls when the step is halved is rounding. One that comes from a feature of a
        // formula is either large, or falls.
        if missed_by_it <= large && S::from(4.0) * of_half > missed_by_it {
            break;
        }
        (h, missed_by_it) = (h.half(), of_half);
    }
    h
}

/// The first s in (0, h) at which the argument of a function with kinks has just passed one; h if there is none.
fn step_to_kink<S: Real>(equations: &Equations<'_, S>, h: S) -> S {
    let mut step = h;
    for (series, kink) in equations.values.kink_arguments() {
        let ahead = series[0] - kink;
        let value = |s: S| ahead + increment(series, s);
        // Just beyond the kink, so that the next expansion is safely on the other side.
        let size = series[0].abs() + kink.abs() + (series[1] * h).abs();
        let margin = |s: S| S::from(8.0) * S::EPSILON * size / slope(series, s).abs().max(S::MIN_POSITIVE);
        if ahead == S::ZERO {
            step = smaller(step, margin(S::ZERO));
            continue;
        }
        let (mut inside, mut beyond) = (S::ZERO, step);
        // A few probes, so that two changes of sign in one step are not missed.
        let probe = (1..=16).map(|i| step * S::from(f64::from(i) / 16.0)).find(|&s| value(s) * ahead <= S::ZERO);
        let Some(first) = probe else { continue };
        beyond = smaller(first, beyond);
        while beyond - inside > (S::EPSILON + S::EPSILON) * beyond {
            let middle = (inside + beyond).half();
            if middle <= inside || middle >= beyond {
                break;
            }
            if value(middle) * ahead > S::ZERO { inside = middle } else { beyond = middle }
        }
        step = smaller(step, beyond + margin(beyond));
    }
    smaller(step, h)
}
