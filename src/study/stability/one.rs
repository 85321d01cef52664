//! What the atlas asks of one coordinate. Its coordinates are t, counted from the start, and x.

use super::arena::{amplitude, half_range, largest};
use super::line::Charted;
use super::status::Sizes;
use crate::geometry::geodesic::{InitialData, acceleration_slope};
use crate::geometry::metric::Metric;
use crate::solve::{Place, Setup};
use crate::study::space::{Point, Studied};

const X: usize = 1;

impl Charted for Metric {
    const IS_SCENE: bool = false;

    fn frequencies(place: &Place<f64, Self>, points: &[Point]) -> [f64; 2] {
        let metric = &*place.geometry;
        let q_t = Self::start(place).invariants(metric).q_t;
        let slope = |point: &Point| {
            let jet = metric.at(point.q[X]);
            acceleration_slope(q_t, jet.g00, jet.first, jet.second)
        };
        let slopes: Vec<f64> = points.iter().map(slope).filter(|slope| slope.is_finite()).collect();
        // ω² = −dẍ/dx where that is positive.
        [-1.0, 1.0].map(|sign: f64| slopes.iter().fold(0.0_f64, |most, slope| most.max(sign * slope)).sqrt())
    }

    fn sizes(place: &Place<f64, Self>, points: &[Point], _: f64) -> Sizes {
        let far = largest(points, |p| p.q[X]);
        let x = amplitude(half_range(points, X), far);
        let (speed, x_dot) = (largest(points, |p| p.q_dot[X] / p.q_dot[0]), largest(points, |p| p.q_dot[X]));
        let duration = points.last().map_or(0.0, |end| end.q[0].abs());
        let t = if speed > 0.0 { duration.min(x / speed) } else { duration };
        let k = || Self::start(place).invariants(&place.geometry).k.abs();
        Sizes { q: vec![t, x], k: if x_dot > 0.0 { x_dot * x_dot } else { k() } }
    }

    fn stretched(place: &Place<f64, Self>, tangent: f64) -> Place<f64, Self> {
        let initial: InitialData = Self::start(place);
        let initial = InitialData { t_dot: initial.t_dot * tangent, x_dot: initial.x_dot * tangent, ..initial };
        Setup::place((*place.geometry).clone(), initial)
    }
}
