//! Why a window failed.

use super::{MarchFailure, State};
use crate::geometry::geodesic::acceleration;
use crate::geometry::metric::{Metric, MetricJet};

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

#[cfg(test)]
mod tests {
    use super::{follow, step, why};
    use crate::engine::lobatto::{MarchFailure, State};
    use crate::geometry::metric::Metric;
    use crate::geometry::potential::{Formula, Potential};

    const HORIZON: f64 = -0.5;

    /// g00 = 1 + 2x.
    fn horizon() -> Metric {
        Metric::new(Potential::linear(1.0), 1.0, 1.0)
    }

    fn at(x: f64, w: f64) -> State {
        State { t: 0.0.into(), x: x.into(), w: w.into() }
    }

    /// γ from there to the horizon with Q_t = 1: dγ = dg/2w with w² = 1/g − K.
    fn to_horizon(w: f64) -> f64 {
        let k = 1.0 - w * w;
        let angle = k.sqrt().min(1.0).asin();
        (angle - angle.sin() * angle.cos()) / (2.0 * k.powf(1.5))
    }

    #[test]
    fn a_horizon_is_met_where_it_is() {
        let metric = horizon();
        for (w, length) in [(0.0, 1.0), (0.0, 40.0), (-0.5, 0.5), (-0.9, 7.0)] {
            let failure = why(&metric, 1.0, &at(0.0, w), length, 7, 3.0);
            let MarchFailure::OutsideDomain { window, gamma, x, g00 } = failure else { panic!("{failure}") };
            let expected = 3.0 + to_horizon(w);
            assert!(window == 7 && (gamma - expected).abs() < 2e-3, "{w} {length}: {gamma}, {expected}");
            assert!((x - HORIZON).abs() < 1e-3 && g00 < 1e-3, "{w} {length}: {x} {g00:e}");
            // In units in which c is 2⁷ nothing is different.
            let (unit, c) = (2.0_f64.powi(14), 2.0_f64.powi(7));
            let scaled = Metric::new(Potential::linear(unit), 1.0, c);
            let same = MarchFailure::OutsideDomain { window, gamma, x, g00: unit * g00 };
            assert_eq!(why(&scaled, c, &at(0.0, w), length, 7, 3.0), same);
        }
    }

    #[test]
    fn what_lies_beyond_the_window_does_not_count() {
        let metric = horizon();
        for w in [0.0, -0.5] {
            let [before, behind] = [0.99, 1.01].map(|share| follow(&metric, 1.0, &at(0.0, w), share * to_horizon(w)));
            assert!(before.is_none() && behind.is_some(), "{w}: {before:?}, {behind:?}");
        }
        let failure = why(&metric, 1.0, &at(0.25, 0.5), 0.3, 2, 3.0);
        assert_eq!(failure, MarchFailure::NotConverged { window: 2, gamma: 3.0, x: 0.25 });
    }

    /// Steps that follow every fold of V do not get far, and where they end is no horizon: g00 was nowhere smaller than
    /// at the start.
    #[test]
    fn a_way_that_is_too_long_to_follow_is_no_horizon() {
        let formula = Formula::new("0.5*(1e-6*exp(8*sin(1e6*x)) - 1)", &Default::default()).unwrap();
        let metric = Metric::new(Potential::Formula(formula), 1.0, 1.0);
        let start = at(-0.5e-6 * std::f64::consts::PI, 10.0);
        assert_eq!(follow(&metric, 1e-6, &start, 1.0), None);
    }

    /// The steps keep K up to an error that falls with the fifth power of their length.
    #[test]
    fn steps_are_of_fourth_order() {
        let metric = Metric::new(Potential::quartic(0.5), 1.0, 1.0);
        let off = |h: f64| {
            let (x, w, here) = step(&metric, 2.0, (1.0, 0.3, metric.at(1.0)), h).unwrap();
            assert_eq!(here, metric.at(x));
            // The other invariant is the place after a given γ: two half steps know it better.
            let half = |from| step(&metric, 2.0, from, 0.5 * h).unwrap();
            let better = half(half((1.0, 0.3, metric.at(1.0))));
            [4.0 / here.g00 - w * w - (4.0 / metric.at(1.0).g00 - 0.09), x - better.0, w - better.1]
        };
        let [long, short] = [0.02, 0.01].map(off);
        for (long, short) in long.into_iter().zip(short) {
            let power = (long / short).abs().log2();
            assert!((4.8..6.2).contains(&power), "{long:e}, {short:e}: {power}");
        }
    }

    /// What is outside is said with the place and g00 there.
    #[test]
    fn a_step_out_of_the_domain_says_where() {
        let metric = horizon();
        let (x, g00) = step(&metric, 1.0, (-0.4, -3.0, metric.at(-0.4)), 0.1).unwrap_err();
        assert!(x < HORIZON && g00 == metric.at(x).g00);
        // A jump out of the domain has no horizon: the particle leaves at once.
        let (elapsed, ..) = follow(&metric, 1.0, &at(-0.6, 0.0), 1.0).unwrap();
        assert_eq!(elapsed, 0.0);
    }
}
