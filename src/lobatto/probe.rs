//! Why a window failed.

use super::{MarchFailure, State};
use crate::geodesic::acceleration;
use crate::metric::{Metric, MetricJet};

/// Explicit steps across the failed window when nothing is in the way, and the most of them.
const STEPS: f64 = 256.0;
const MOST_STEPS: usize = 20_000;

/// By how much g00 may change in a step, and how often a step is halved until it does not.
const CHANGE: f64 = 0.7;
const MOST_HALVINGS: usize = 60;

/// Below this share of its first value, g00 is on its way to a horizon.
const HORIZON: f64 = 1e-3;

/// x, w and the metric there.
type Point = (f64, f64, MetricJet);

/// Follows the geodesic across a failed window by the classical Runge–Kutta method: it either leaves the domain or
/// shows that the window as such is passable, only too long.
pub(super) fn why(metric: &Metric, q_t: f64, start: &State, length: f64, window: usize, gamma: f64) -> MarchFailure {
    match follow(metric, q_t, start, length) {
        Some((elapsed, x, g00)) => MarchFailure::OutsideDomain { window, gamma: gamma + elapsed, x, g00 },
        None => MarchFailure::NotConverged { window, gamma, x: start.x.hi },
    }
}

/// γ from `start` on, x and g00 where the geodesic leaves the domain within `length`.
///
/// Towards a horizon dx/dγ grows without bound, and a step of constant length would jump over it. Steps are therefore
/// short enough for g00 to change only by a fraction.
pub(super) fn follow(metric: &Metric, q_t: f64, start: &State, length: f64) -> Option<(f64, f64, f64)> {
    let (mut x, mut w) = (start.x.hi, start.w.hi);
    let mut here = metric.at(x);
    let first = here.g00;
    let mut done = 0.0;
    let usual = length / STEPS;
    let mut h = usual;
    for _ in 0..MOST_STEPS {
        if !here.is_inside() {
            return Some((done, x, here.g00));
        }
        if done >= length {
            return None;
        }
        let mut outside = None;
        let mut halvings = 0;
        loop {
            match step(metric, q_t, (x, w, here), h) {
                Ok((next_x, next_w, next)) => {
                    if (CHANGE * here.g00..=here.g00 / CHANGE).contains(&next.g00) {
                        (x, w, here) = (next_x, next_w, next);
                        break;
                    }
                }
                Err(point) => outside = Some(point),
            }
            halvings += 1;
            if halvings == MOST_HALVINGS || done + h == done {
                // However short the step, something is not smooth: the end of the domain, or a jump.
                let (x, g00) = outside.or_else(|| (here.g00 < HORIZON * first).then(|| beyond(metric, x, here)))?;
                return Some((done, x, g00));
            }
            h *= 0.5;
        }
        done += h;
        h = (2.0 * h).min(usual);
    }
    (here.g00 < HORIZON * first).then(|| {
        let (x, g00) = beyond(metric, x, here);
        (done, x, g00)
    })
}

/// A point behind the horizon that is so near, and g00 there.
fn beyond(metric: &Metric, x: f64, here: MetricJet) -> (f64, f64) {
    let next = x - 2.0 * here.g00 / here.first;
    let there = metric.at(next);
    if there.is_inside() { (x, here.g00) } else { (next, there.g00) }
}

/// One step of the classical Runge–Kutta method.
///
/// # Errors
/// x and g00 of a point outside the domain that it meets.
fn step(metric: &Metric, q_t: f64, (x, w, here): Point, h: f64) -> Result<Point, (f64, f64)> {
    let force = |x: f64| {
        let g = metric.at(x);
        if g.is_inside() { Ok((acceleration(q_t, g.g00, g.first), g)) } else { Err((x, g.g00)) }
    };
    let a1 = acceleration(q_t, here.g00, here.first);
    let (a2, _) = force(x + 0.5 * h * w)?;
    let (a3, _) = force(x + 0.5 * h * w + 0.25 * h * h * a1)?;
    let (a4, _) = force(x + h * w + 0.5 * h * h * a2)?;
    let x = x + h * w + h * h / 6.0 * (a1 + a2 + a3);
    let w = w + h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
    force(x).map(|(_, next)| (x, w, next))
}
