//! World-lines between their nodes.

use super::curve::Curve;
use super::legendre::Tables;
use super::{OutsideRun, partition, slack, within};
use crate::geometry::{Point, Start};
use crate::number::Real;
use crate::number::root::root;
use crate::solve::WorldLine;

/// A world-line at one value of γ.
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

/// Interpolates one world-line. A window is prepared when a value in it is requested, and kept until a value in another
/// window is.
#[derive(Debug)]
pub struct Sampler<'l, S: Real = f64> {
    pub(super) line: &'l WorldLine<S>,
    /// The window that was prepared last.
    current: Option<(usize, Curve<S>)>,
    pub(super) tables: Tables<S>,
    point: Point<S>,
}

impl<'l, S: Real> Sampler<'l, S> {
    /// A sampler of `line`.
    pub fn new(line: &'l WorldLine<S>) -> Self {
        Self::with_tables(line, Tables::default())
    }

    pub(super) fn with_tables(line: &'l WorldLine<S>, tables: Tables<S>) -> Self {
        Self { line, current: None, tables, point: line.geometry().point() }
    }

    /// The world-line at `gamma`.
    ///
    /// # Errors
    /// [`OutsideRun`] beyond the ends by more than rounding.
    pub fn at_gamma(&mut self, gamma: S) -> Result<Sample<S>, OutsideRun<S>> {
        let (line, WorldLine { gamma_i, windows, digits, .. }) = (self.line, self.line);
        let ends = windows.first().zip(windows.last()).map(|(first, last)| [first.gamma[0], last.gamma[1]]);
        let ends = ends.ok_or(OutsideRun { range: (*gamma_i, *gamma_i) })?;
        let from_start = within(line.signed(gamma - *gamma_i), ends, slack(*digits)).ok_or_else(|| {
            let [first, last] = [line.gamma_at(ends[0]), line.gamma_at(ends[1])];
            OutsideRun { range: if line.is_backward { (last, first) } else { (first, last) } }
        })?;
        let window = partition(windows.len(), |window| windows[window].gamma[0] <= from_start);
        // The number that was asked for stands in place of the one that was found.
        Ok(Sample { gamma, ..self.in_window(window, from_start - windows[window].gamma[0]) })
    }

    /// The world-line where coordinate `a`, which grows or falls all the way, has the given value.
    ///
    /// # Errors
    /// [`OutsideRun`] with the range of the coordinate, beyond it by more than rounding.
    pub fn at_value(&mut self, a: usize, value: S) -> Result<Sample<S>, OutsideRun<S>> {
        let (line, origin) = (self.line, self.line.origin_of(a));
        if line.windows.is_empty() {
            return Err(OutsideRun { range: (origin, origin) });
        }
        let [first, last] = [0, line.windows.len()].map(|joint| line.joint(joint).q[a]);
        let falls = last < first;
        let [low, high] = if falls { [last, first] } else { [first, last] };
        // The value as joints count it, inside the run.
        let inside = within(value - origin, [low, high], slack(line.digits))
            .ok_or(OutsideRun { range: (origin + low, origin + high) })?;
        let reached = |here: S| if falls { here >= inside } else { here <= inside };
        let window = partition(line.windows.len(), |window| reached(line.joint(window).q[a]));
        let [start, end] = [window, window + 1].map(|joint| line.joint(joint).q[a] - inside);
        let length = line.windows[window].length();
        let place = if start == S::ZERO {
            S::ZERO
        } else if end == S::ZERO {
            length
        } else {
            let curve = self.curve(window);
            let off = |place: S| curve.at(place, line.geometry())[0][a] - inside;
            root([S::ZERO, start], [length, end], least(line, window), off)
        };
        let mut sample = self.in_window(window, place);
        sample.q[a] = value;
        Ok(sample)
    }

    /// The world-line at `place`, which is γ from the start of a window.
    pub(super) fn in_window(&mut self, window: usize, place: S) -> Sample<S> {
        let line = self.line;
        let [first, last] = line.windows[window].gamma;
        // The end of what is kept is known exactly.
        if place == last - first && window + 1 == line.windows.len() {
            let Start { q, q_dot, p } = line.end();
            return Sample { gamma: line.gamma_at(last), q, q_dot, p };
        }
        let [q, p] = self.curve(window).at(place, line.geometry());
        // A curve that leaves the domain between nodes inside it has velocities that mean as little as its positions.
        let _ = self.point.evaluate(&q, &p);
        let q_dot = (0..q.len()).map(|a| self.point.q_dot(a)).collect();
        let Start { mut q, q_dot, p } = line.turned(Start { q, q_dot, p });
        q.iter_mut().enumerate().for_each(|(a, q)| *q += line.origin_of(a));
        Sample { gamma: line.gamma_at(first + place), q, q_dot, p }
    }

    /// The curve of a window.
    pub(super) fn curve(&mut self, window: usize) -> &Curve<S> {
        let Self { line, current, tables, point } = self;
        if current.as_ref().is_some_and(|(current, _)| *current != window) {
            *current = None;
        }
        &current.get_or_insert_with(|| (window, Curve::new(line, &line.view(window), tables, point))).1
    }
}

/// The distance in γ that counts as none.
pub(super) fn least<S: Real>(line: &WorldLine<S>, window: usize) -> S {
    let window = &line.windows[window];
    let gamma = line.gamma_i.abs().max(window.gamma[1]);
    let digits = S::from(0.1_f64.powi(line.digits as i32));
    S::EPSILON.max(digits) * gamma.max(window.length())
}
