//! World-lines of scenes between the nodes, and where a formula of their state changes its sign.

mod crossings;
mod curve;
mod shape;

pub use crossings::{Crossing, EventSearch, Watch, crossings};

pub(super) use self::curve::Curve;
use super::cursor::Reached;
use crate::geometry::{Point, Start};
use crate::number::Real;
use crate::number::root::root;
use crate::solve::WorldLine;

/// The world-line of a scene at one value of γ.
#[derive(Debug, Clone, PartialEq)]
pub struct Sample<S = f64> {
    /// γ.
    pub gamma: S,
    /// q^a.
    pub q: Vec<S>,
    /// dq^a/dγ.
    pub q_dot: Vec<S>,
    /// p_a.
    pub p: Vec<S>,
}

/// The world-line at `place`, which is γ from the start of that window.
pub(super) fn sample<S: Real>(
    line: &WorldLine<S>,
    window: usize,
    curve: &Curve<S>,
    place: S,
    point: &mut Point<S>,
) -> Sample<S> {
    let [first, last] = line.windows[window].gamma;
    // The end of what is kept is known exactly.
    let is_end = place == last - first && window + 1 == line.windows.len();
    let gamma = line.gamma_at(if is_end { last } else { first + place });
    if is_end {
        let Start { q, q_dot, p } = line.end();
        return Sample { gamma, q, q_dot, p };
    }
    let Start { q, p, .. } = curve.at(place, line.geometry());
    // A curve that leaves the domain between nodes inside it has velocities that mean as little as its positions.
    let _ = point.evaluate(&q, &p);
    let q_dot = (0..q.len()).map(|a| point.q_dot(a)).collect();
    let Start { mut q, q_dot, p } = line.turned(Start { q, q_dot, p });
    q.iter_mut().enumerate().for_each(|(a, q)| *q += line.origin_of(a));
    Sample { gamma, q, q_dot, p }
}

/// The world-line where coordinate `a` has a value in the window of that curve.
pub(super) fn sample_at_value<S: Real>(
    line: &WorldLine<S>,
    (a, &Reached { window, value }): (usize, &Reached<S>),
    curve: &Curve<S>,
    point: &mut Point<S>,
) -> Sample<S> {
    let [start, end] = [window, window + 1].map(|joint| line.joint(joint).q[a] - value);
    let length = line.windows[window].length();
    let place = if start == S::ZERO {
        S::ZERO
    } else if end == S::ZERO {
        length
    } else {
        let off = |place: S| curve.at(place, line.geometry()).q[a] - value;
        root([S::ZERO, start], [length, end], least(line, window), off)
    };
    sample(line, window, curve, place, point)
}

/// The distance in γ that counts as none.
fn least<S: Real>(line: &WorldLine<S>, window: usize) -> S {
    let window = &line.windows[window];
    let gamma = line.gamma_i.abs().max(window.gamma[1]);
    let digits = S::from(0.1_f64.powi(line.digits as i32));
    S::EPSILON.max(digits) * gamma.max(window.length())
}
