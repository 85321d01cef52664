//! The size of a step of the Taylor method.

use super::equations::{Equations, Series};
use super::series::{increment, slope};
use crate::number::Real;

/// The most corrections of the scale of the first step.
const FIRST_STEP_TRIES: usize = 8;
/// Number of points at which the series of a step are compared with the equations, and how often a step is halved at
/// most because of a difference.
const PROBES: i32 = 32;
const MOST_HALVINGS: usize = 40;
/// The comparison of the series with the equations is accurate to this many digits fewer than the series themselves.
const SPARE_DIGITS: f64 = 4.0;

/// The smaller of the two; if one is NaN, the other one.
pub(super) fn smaller<S: Real>(a: S, b: S) -> S {
    if b < a || a.is_nan() { b } else { a }
}

/// The root test on the last two coefficients of each series, relative to the size of its first ones over a step `h`.
/// The radius is 0 where a coefficient is not finite: at a singularity there is no step to take.
pub(super) fn radius<S: Real>(equations: &Equations<'_, S>, series: &Series<S>, h: S) -> S {
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
pub(super) fn first_radius<S: Real>(equations: &Equations<'_, S>, series: &Series<S>, relative_step: S, range: S) -> S {
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
pub(super) fn seen<S: Real>(equations: &mut Equations<'_, S>, series: &Series<S>, h: S, digits: u32) -> S {
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
pub(super) fn step_to_kink<S: Real>(equations: &Equations<'_, S>, h: S) -> S {
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
