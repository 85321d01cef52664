//! World-lines of scenes between the nodes, and where a formula of their state changes its sign.

mod crossings;
mod curve;
mod shape;

pub use crossings::{Crossing, Watch, crossings};

use self::curve::Curve;
use super::cursor::Reached;
use super::curved::Curved;
use super::legendre::Tables;
use crate::geometry::{Geometry, Point, Start};
use crate::number::Real;
use crate::number::root::root;
use crate::solve::WorldLine;

/// The world-line of a scene at one value of γ.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneSample<S = f64> {
    /// γ.
    pub gamma: S,
    /// q^a.
    pub q: Vec<S>,
    /// dq^a/dγ.
    pub q_dot: Vec<S>,
    /// p_a.
    pub p: Vec<S>,
}

#[expect(private_interfaces, reason = "only this module interpolates")]
impl<S: Real> Curved<S> for Geometry<S> {
    type Sample = SceneSample<S>;
    type Curve = Curve<S>;
    type Rates = Point<S>;

    fn rates_room(&self) -> Point<S> {
        self.point()
    }

    fn curve(line: &WorldLine<S>, window: usize, tables: &mut Tables<S>, point: &mut Point<S>) -> Curve<S> {
        Curve::new(line, &line.view(window), tables, point)
    }

    fn sample(line: &WorldLine<S>, window: usize, curve: &Curve<S>, place: S, point: &mut Point<S>) -> SceneSample<S> {
        let [first, last] = line.windows[window].gamma;
        let gamma = line.gamma_i + first + place;
        // The end of the run is known exactly.
        if place == last - first && window + 1 == line.windows.len() {
            let Start { q, q_dot, p } = line.end();
            return SceneSample { gamma: line.gamma_f(), q, q_dot, p };
        }
        let Start { q, p, .. } = curve.at(place, line.geometry());
        // A curve that leaves the domain between nodes inside it has velocities that mean as little as its positions.
        let _ = point.evaluate(&q, &p);
        let q_dot = (0..q.len()).map(|a| point.q_dot(a)).collect();
        SceneSample { gamma, q, q_dot, p }
    }

    fn sample_at_value(
        line: &WorldLine<S>,
        (a, &Reached { window, value, .. }): (usize, &Reached<S>),
        curve: &Curve<S>,
        point: &mut Point<S>,
    ) -> SceneSample<S> {
        let [start, end] = [window, window + 1].map(|joint| line.joint(joint).q[a] - value);
        let length = line.windows[window].length();
        let mut at = |place: S| Self::sample(line, window, curve, place, point);
        let place = if start == S::ZERO {
            S::ZERO
        } else if end == S::ZERO {
            length
        } else {
            root([S::ZERO, start], [length, end], least(line, window), |place| at(place).q[a] - value)
        };
        at(place)
    }

    fn as_asked(mut sample: SceneSample<S>, gamma: Option<S>, value: Option<(usize, S)>) -> SceneSample<S> {
        sample.gamma = gamma.unwrap_or(sample.gamma);
        if let Some((a, value)) = value {
            sample.q[a] = value;
        }
        sample
    }
}

/// The distance in γ that counts as none.
fn least<S: Real>(line: &WorldLine<S>, window: usize) -> S {
    let window = &line.windows[window];
    let gamma = line.gamma_i.abs().max(window.gamma[1]);
    let digits = S::from(0.1_f64.powi(line.digits as i32));
    S::EPSILON.max(digits) * gamma.max(window.length())
}
