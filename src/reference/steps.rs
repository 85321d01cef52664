//! The steps of the Taylor method.

use super::equations::{Equations, Series};
use super::series::{increment, slope};
use super::size::{first_radius, radius, seen, smaller, step_to_kink};
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
    steps: Vec<Step<S>>,
    end: S,
}

/// The moving end of the integration.
struct Front<S> {
    gamma: Compensated<S>,
    state: Vec<Compensated<S>>,
}

impl<S: Real> Front<S> {
    fn values(&self) -> Vec<S> {
        self.state.iter().map(|component| component.high).collect()
    }

    fn advance(&mut self, series: Series<S>, h: S) -> Step<S> {
        let lows = self.state.iter().map(|component| component.low).collect();
        for (component, series) in self.state.iter_mut().zip(&series) {
            *component = component.plus(increment(series, h));
        }
        let step = Step { start: self.gamma, series, lows };
        self.gamma = self.gamma.plus(h);
        step
    }
}

impl<S: Real> Goal<S> {
    /// The step to take instead of `h`, and whether it is the last one.
    fn limit(self, front: &Front<S>, series: &Series<S>, h: S) -> (S, bool) {
        let Some((component, value, sign)) = self.value else {
            let remaining = (self.length - front.gamma.high) - front.gamma.low;
            return (smaller(h, remaining), h >= remaining);
        };
        let (series, low) = (&series[component], front.state[component].low);
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
        let mut front = Front { gamma: Compensated::default(), state };
        let most_steps = MOST_PRODUCTS / (order * order);
        let (mut steps, mut longest, mut last_step) = (Vec::new(), S::ZERO, scale);
        loop {
            let here = front.values();
            let series = equations.expand(&here, order);
            let radius = if steps.is_empty() {
                first_radius(equations, &series, relative_step, scale)
            } else {
                radius(equations, &series, last_step)
            };
            let h = smaller(relative_step * radius, scale);
            let stop = |equations: &mut Equations<'_, S>, reason| Err(equations.ends(reason, front.gamma.high, &here));
            if !equations.is_inside(&here) {
                return stop(equations, EndReason::OutsideDomain);
            }
            let shrinks = h <= S::from(LEAST_STEP) * scale && (h == S::ZERO || h < S::from(SHRUNK) * longest);
            if shrinks {
                // On the way to the edge of the domain the steps shrink without end.
                let is_edge = equations.is_near_the_edge(&here);
                return stop(equations, if is_edge { EndReason::OutsideDomain } else { EndReason::Singular });
            }
            let share = (front.gamma.high / scale).to_f64();
            let hopeless = steps.len() == FIRST_STEPS && share * HOPELESS * (most_steps as f64) < FIRST_STEPS as f64;
            if steps.len() >= most_steps || hopeless {
                return stop(equations, EndReason::TooLong { most_steps });
            }
            // At the start it may be at rest.
            if !steps.is_empty() && goal.is_far_too_far(&series) {
                return stop(equations, EndReason::TimeNotReached);
            }
            let (wanted, last) = goal.limit(&front, &series, step_to_kink(equations, h));
            let h = seen(equations, &series, wanted, digits);
            let last = last && h == wanted;
            longest = longest.max(h);
            last_step = h;
            steps.push(front.advance(series, h));
            if last {
                return Ok(Self { steps, end: front.gamma.high });
            }
        }
    }

    /// Returns true if the series at the start, and their squares, do not overflow.
    pub(super) fn can_begin(mut equations: Equations<'_, S>, order: usize) -> bool {
        let largest = (S::ONE / S::MIN_POSITIVE).sqrt();
        // The comparison is false for a NaN.
        equations.expand(&equations.state(), order).iter().flatten().all(|c| c.abs() < largest)
    }

    /// γ − γ_i at the end.
    pub(super) fn end(&self) -> S {
        self.end
    }

    pub(super) fn len(&self) -> usize {
        self.steps.len()
    }

    /// γ − γ_i at the ends of the steps.
    pub(super) fn ends(&self) -> impl Iterator<Item = S> + '_ {
        self.steps.iter().map(|step| step.start.high).chain([self.end])
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
