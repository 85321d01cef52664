//! Where formulas of the state change their sign along a world-line.
//!
//! In every window a formula is evaluated at enough points of the curve to resolve the motion. The polynomial through
//! these values has extrema between them, and there the formula is evaluated, too: two crossings that are close
//! together have an extremum between them. Between two values of different sign the crossing is a root of the formula
//! on the curve itself. Two crossings are missed only where the formula passes zero by less than its polynomial
//! resolves.

use std::cmp::Ordering;

use super::super::legendre::Tables;
use super::super::{Sampler, slack};
use super::shape::Shape;
use super::{Sample, least, root};
use crate::geometry::{Direction, Observable};
use crate::number::Real;
use crate::solve::WorldLine;

/// A formula whose changes of sign are looked for.
#[derive(Debug, Clone)]
pub struct Watch<S = f64> {
    /// The formula.
    pub formula: Observable<S>,
    /// Which changes count.
    pub direction: Direction,
}

/// A change of sign.
#[derive(Debug, Clone, PartialEq)]
pub struct Crossing<S = f64> {
    /// The index of what was watched.
    pub watch: usize,
    /// The world-line there.
    pub sample: Sample<S>,
}

/// Every change of sign of the formulas of `watches` in their directions, in the order of γ. A formula that is zero at
/// the start of the run, up to rounding, does not change its sign there; one that is zero at the end does.
pub fn crossings<S: Real>(line: &WorldLine<S>, watches: &mut [Watch<S>]) -> Vec<Crossing<S>> {
    let start = &line.place.start;
    let norm = line.geometry().norm(&start.q, &start.q_dot);
    let mut walk = Walk {
        norm,
        starts: watches.iter_mut().map(|w| w.formula.at(&start.q, &start.q_dot, &start.p, norm)).collect(),
        nowhere: slack::<S>(line.digits) * line.length.max(line.gamma_i.abs()),
        signs: vec![None; watches.len()],
        found: Vec::new(),
    };
    let (mut sampler, mut tables, windows) = (Sampler::new(line), Tables::default(), line.windows.len());
    for window in 0..windows {
        let (cells, points) = sampler.of_window(window).0.cells();
        let expansion = tables.of(points);
        let last = cells.len() - 1;
        for (index, ends) in cells.into_iter().enumerate() {
            let inner = expansion.nodes.iter().map(|&node| ends[0] + node * (ends[1] - ends[0]));
            let mut places: Vec<S> = inner.collect();
            places[points - 1] = ends[1];
            let (is_first, is_last) = (window + index == 0, window + 1 == windows && index == last);
            let cell = Cell { window, ends, places, is_first, is_last };
            let samples: Vec<_> = cell.places.iter().map(|&place| sampler.in_window(window, place)).collect();
            for (watch, watched) in watches.iter_mut().enumerate() {
                let values: Vec<S> = samples.iter().map(|sample| value(watched, sample, walk.norm)).collect();
                let shape = Shape::new(&expansion.coefficients(&values));
                walk.pass(&mut sampler, &cell, (watch, watched), &values, &shape);
            }
        }
    }
    walk.found.sort_by(|a, b| order(&a.sample.gamma, &b.sample.gamma));
    walk.found
}

fn value<S: Real>(watched: &mut Watch<S>, sample: &Sample<S>, norm: S) -> S {
    watched.formula.at(&sample.q, &sample.q_dot, &sample.p, norm)
}

fn order<S: Real>(a: &S, b: &S) -> Ordering {
    a.partial_cmp(b).unwrap_or(Ordering::Equal)
}

/// A piece of a window on which the curve is one polynomial.
struct Cell<S> {
    window: usize,
    /// γ at its ends, counted from the start of the window.
    ends: [S; 2],
    /// γ at its points, counted in the same way.
    places: Vec<S>,
    /// Whether the run begins, or ends, with it.
    is_first: bool,
    is_last: bool,
}

/// What a search along a world-line remembers.
struct Walk<S> {
    norm: S,
    /// The value of each formula at the start of the run. The first node of the weak form is close to it only.
    starts: Vec<S>,
    /// A root that is closer than this to an end of the run is there.
    nowhere: S,
    /// Whether each formula was positive where it was not zero last.
    signs: Vec<Option<bool>>,
    found: Vec<Crossing<S>>,
}

impl<S: Real> Walk<S> {
    /// Finds the changes of sign in a cell, where the formula has these values at its points.
    fn pass(
        &mut self,
        sampler: &mut Sampler<'_, S>,
        cell: &Cell<S>,
        (watch, watched): (usize, &mut Watch<S>),
        values: &[S],
        shape: &Shape<S>,
    ) {
        let (norm, direction, least) = (self.norm, watched.direction, least(sampler.cursor.line, cell.window));
        let mut at = |place: S| value(watched, &sampler.in_window(cell.window, place), norm);
        let marks = cell.marks(values, shape, &mut at);
        let start = self.starts[watch];
        if cell.is_first && !self.is_at_zero(cell, start, shape.slope(-1.0)) {
            self.signs[watch] = Some(start > S::ZERO);
        }
        // The start of a cell is the end of the one before, whose sign counts.
        let mut before = [marks[0][0], carried(self.signs[watch], marks[0][1])];
        let mut roots = Vec::new();
        for &[place, here] in marks[1..].iter().filter(|mark| mark[1] != S::ZERO && !mark[1].is_nan()) {
            let is_positive = here > S::ZERO;
            let is_change = self.signs[watch].is_some_and(|sign| sign != is_positive);
            if is_change && direction.counts(is_positive) {
                roots.push(root(before, [place, here], least, &mut at));
            }
            self.signs[watch] = Some(is_positive);
            before = [place, here];
        }
        // A formula that is zero at the end changes its sign there, whatever rounding says.
        let (slope, last) = (shape.slope(1.0), values[values.len() - 1]);
        let is_positive = slope > S::ZERO;
        let is_change = slope != S::ZERO && self.signs[watch] == Some(!is_positive) && direction.counts(is_positive);
        if cell.is_last && is_change && self.is_at_zero(cell, last, slope) {
            roots.push(cell.ends[1]);
        }
        let is_end = |place: S| cell.is_last && cell.ends[1] - place <= self.nowhere;
        let places = roots.into_iter().map(|place| if is_end(place) { cell.ends[1] } else { place });
        self.found.extend(places.map(|place| Crossing { watch, sample: sampler.in_window(cell.window, place) }));
    }

    /// Whether a formula with this value and slope at an end of a cell is zero there but for rounding.
    fn is_at_zero(&self, cell: &Cell<S>, value: S, slope: S) -> bool {
        let half = (cell.ends[1] - cell.ends[0]).half();
        value == S::ZERO || value.abs() * half <= slope.abs() * self.nowhere
    }
}

impl<S: Real> Cell<S> {
    /// Places with values of the formula, in order: the points of the cell, and the extrema of the polynomial through
    /// its values there.
    fn marks(&self, values: &[S], shape: &Shape<S>, at: &mut impl FnMut(S) -> S) -> Vec<[S; 2]> {
        let [first, last] = self.ends;
        let points = self.places.iter().zip(values).map(|(&place, &value)| [place, value]);
        let mut marks: Vec<[S; 2]> = points.collect();
        let extrema = shape.extrema().into_iter().map(|z| first + S::from(0.5 * (z + 1.0)) * (last - first));
        marks.extend(extrema.map(|place| [place, at(place)]));
        marks.sort_by(|a, b| order(&a[0], &b[0]));
        marks
    }
}

/// The value at the start of a cell, with the sign that the end of the cell before had.
fn carried<S: Real>(sign: Option<bool>, value: S) -> S {
    match sign {
        Some(true) if value <= S::ZERO => S::MIN_POSITIVE,
        Some(false) if value >= S::ZERO => -S::MIN_POSITIVE,
        _ => value,
    }
}
