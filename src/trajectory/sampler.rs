//! World-lines between their nodes, and samples of a run that is handed out part by part.

use super::curve::Curve;
use super::{OutsideRun, partition, slack, within};
use crate::geometry::{Motion, Point, Start};
use crate::number::Real;
use crate::number::root::root;
use crate::sbp::polynomial::Tables;
use crate::solve::{Solution, Window, WindowNodes, WorldLine};

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
    pub(super) point: Point<S>,
    /// Rates on all nodes of a window are computed here, once they were asked for.
    pub(super) on_nodes: Option<Motion<S>>,
}

impl<'l, S: Real> Sampler<'l, S> {
    /// A sampler of `line`.
    pub fn new(line: &'l WorldLine<S>) -> Self {
        Self::with_tables(line, Tables::default())
    }

    pub(super) fn with_tables(line: &'l WorldLine<S>, tables: Tables<S>) -> Self {
        Self { line, current: None, tables, point: line.geometry().point(), on_nodes: None }
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
        self.at_place(window, place, true)
    }

    /// The same. Velocities are not known if they are not `wanted`.
    pub(super) fn at_place(&mut self, window: usize, place: S, wanted: bool) -> Sample<S> {
        let line = self.line;
        let [first, last] = line.windows[window].gamma;
        // The solver has left the state at the last joint: the curve there would only round it.
        if place == last - first && window + 1 == line.windows.len() {
            let Start { q, q_dot, p } = line.end();
            return Sample { gamma: line.gamma_at(last), q, q_dot, p };
        }
        let [q, p] = self.curve(window).at(place, line.geometry());
        if wanted {
            // A curve that leaves the domain between nodes inside it has velocities that mean as little as its
            // positions.
            let _ = self.point.evaluate(&q, &p);
        }
        let q_dot = (0..q.len()).map(|a| if wanted { self.point.q_dot(a) } else { S::ZERO }).collect();
        let Start { mut q, q_dot, p } = line.turned(Start { q, q_dot, p });
        q.iter_mut().enumerate().for_each(|(a, q)| *q += line.origin_of(a));
        Sample { gamma: line.gamma_at(first + place), q, q_dot, p }
    }

    /// The curve of a window.
    pub(super) fn curve(&mut self, window: usize) -> &Curve<S> {
        let Self { line, current, tables, point, on_nodes } = self;
        if current.as_ref().is_some_and(|(current, _)| *current != window) {
            *current = None;
        }
        let on_nodes = on_nodes.get_or_insert_with(|| Motion::new(line.geometry()));
        &current.get_or_insert_with(|| (window, Curve::new(line, &line.view(window), tables, (on_nodes, point)))).1
    }
}

/// Two values of a coordinate that differ by no more than so many roundings are equal.
const TIES: f64 = 4.0;

/// The distance in γ that counts as none.
pub(super) fn least<S: Real>(line: &WorldLine<S>, window: usize) -> S {
    let window = &line.windows[window];
    let gamma = line.gamma_i.abs().max(window.gamma[1]);
    let digits = S::from(0.1_f64.powi(line.digits as i32));
    S::EPSILON.max(digits) * gamma.max(window.length())
}

/// The quantity by which samples are requested.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Coordinate {
    /// γ.
    Gamma,
    /// The coordinate with this index, which must grow or fall all the way.
    Value(usize),
}

/// Takes samples at given values from the solutions of a run: its consecutive parts, or the whole run at once.
#[derive(Debug)]
pub struct SampleStream<S = f64> {
    coordinate: Coordinate,
    /// The values in the order of the run.
    values: Vec<S>,
    /// The number of those that lie before the start of the run.
    before: usize,
    /// True if that is the reverse of the requested order.
    reversed: bool,
    samples: Vec<Sample<S>>,
    /// The number of those before, which were taken.
    taken: usize,
    /// The value at the start of the run.
    first: S,
    /// True if the coordinate turned round in what was seen.
    has_turned: bool,
    tables: Tables<S>,
}

/// Why there are no samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum NoSamples<S> {
    /// One lies beyond the ends of the run by more than rounding.
    Outside(OutsideRun<S>),
    /// The coordinate does not grow, or fall, all the way: a value of it is not one place of the world-line.
    Turns,
}

impl<S: Real> SampleStream<S> {
    /// Takes the samples that lie in `solution`. It must continue the previous one or, if it contains the first window,
    /// begins the run again.
    pub fn see(&mut self, solution: &Solution<S>) {
        if solution.window_count == solution.windows.len() {
            self.samples.clear();
            (self.before, self.taken, self.has_turned) = (0, 0, false);
        }
        if solution.windows.is_empty() {
            return;
        }
        let (origin, end) = self.coordinate.ends(solution);
        let mut sampler = Sampler::with_tables(solution, std::mem::take(&mut self.tables));
        if solution.window_count == solution.windows.len() {
            self.first = origin;
            let is_before = |value: S| if end < S::ZERO { value > origin } else { value < origin };
            let mut outside = |value: S| is_before(value) && sampler.at(self.coordinate, value).is_err();
            self.before = self.values.iter().take_while(|&&value| outside(value)).count();
        }
        if let Coordinate::Value(a) = self.coordinate {
            let passed = |window: &Window<S>| window.gamma[1] - window.gamma[0];
            let rate = end / solution.windows.iter().fold(S::ZERO, |sum, window| sum + passed(window));
            let turns = |view: WindowNodes<'_, S>| {
                let change = view.end.q[a] - view.start.q[a];
                // In a window that is shorter than the rounding of the coordinate, it says nothing.
                let rounding = S::from(TIES) * S::EPSILON * view.end.q[a].abs();
                let is_tie = change.abs().max((rate * passed(view.window)).abs()) <= rounding;
                // Written so that no change at all is a turn.
                !(is_tie || if end < S::ZERO { change < S::ZERO } else { change > S::ZERO })
            };
            self.has_turned |= solution.views().any(turns);
        }
        // A sample at the end of this solution is left to the next one, which starts there.
        let beyond = |value: S| if end < S::ZERO { value - origin <= end } else { value - origin >= end };
        let from = self.before + self.taken + self.samples.len();
        let reached = self.values[from..].iter().take_while(|&&value| !beyond(value)).count();
        let values = self.values[from..from + reached].iter();
        self.samples.extend(values.map_while(|&value| sampler.at(self.coordinate, value).ok()));
        self.tables = sampler.tables;
    }

    /// True if they are found in the requested order.
    pub fn is_in_order(&self) -> bool {
        !self.reversed
    }

    /// Takes those that were found since the last time. The stream has no more of them.
    pub fn take(&mut self) -> std::vec::Drain<'_, Sample<S>> {
        self.taken += self.samples.len();
        self.samples.drain(..)
    }

    /// The samples of what was seen so far, in the requested order.
    pub fn so_far(mut self) -> Vec<Sample<S>> {
        if self.reversed {
            self.samples.reverse();
        }
        self.samples
    }

    /// All samples, in the requested order. `last` is the last solution that was seen.
    ///
    /// # Errors
    /// [`NoSamples`] if one does not lie in the run, or cannot be told from another one.
    pub fn finish(self, last: &Solution<S>) -> Result<Vec<Sample<S>>, NoSamples<S>> {
        match self.finish_inside(last) {
            (samples, None) => Ok(samples),
            (_, Some(none)) => Err(none),
        }
    }

    /// The samples that lie in the run, in the requested order, and why there are no others, if there are none. `last`
    /// is the last solution that was seen.
    pub fn finish_inside(mut self, last: &Solution<S>) -> (Vec<Sample<S>>, Option<NoSamples<S>>) {
        if self.has_turned {
            return (Vec::new(), Some(NoSamples::Turns));
        }
        let mut sampler = Sampler::with_tables(last, self.tables);
        let rest = &self.values[self.before + self.taken + self.samples.len()..];
        self.samples.extend(rest.iter().map_while(|&value| sampler.at(self.coordinate, value).ok()));
        let is_whole = self.taken + self.samples.len() == self.values.len();
        if self.reversed {
            self.samples.reverse();
        }
        let outside = || {
            let (first, change) = self.coordinate.ends(last);
            let end = first + change;
            let range = if end < self.first { (end, self.first) } else { (self.first, end) };
            NoSamples::Outside(OutsideRun { range })
        };
        let others = (!is_whole).then(outside);
        (self.samples, others)
    }

    /// A stream of samples at `values`, which must be in ascending or descending order. `backwards` says whether γ, or
    /// the coordinate, falls along the run.
    pub fn new(coordinate: Coordinate, mut values: Vec<S>, backwards: bool) -> Self {
        let descending = values.first() > values.last();
        let reversed = descending != backwards;
        if reversed {
            values.reverse();
        }
        Self {
            coordinate,
            values,
            before: 0,
            reversed,
            samples: Vec::new(),
            taken: 0,
            first: S::ZERO,
            has_turned: false,
            tables: Tables::default(),
        }
    }
}

impl<S: Real> Sampler<'_, S> {
    fn at(&mut self, coordinate: Coordinate, value: S) -> Result<Sample<S>, OutsideRun<S>> {
        match coordinate {
            Coordinate::Gamma => self.at_gamma(value),
            Coordinate::Value(a) => self.at_value(a, value),
        }
    }
}

impl Coordinate {
    /// Where it starts, and how much it has changed at the end of what is kept.
    fn ends<S: Real>(self, line: &Solution<S>) -> (S, S) {
        match self {
            Self::Gamma => (line.gamma_i, line.signed(line.windows.last().map_or(line.length, |last| last.gamma[1]))),
            Self::Value(a) => {
                let first = line.place.start.q[a];
                (line.origin_of(a) + first, line.last_joint().q[a] - first)
            }
        }
    }
}
