//! Where formulas of the state change their sign along a world-line.
//!
//! In every window a formula is evaluated at enough points to resolve the motion: the nodes, where the solver has left
//! the states there, or points of the curve. The polynomial through these values has extrema between them, and there
//! the formula is evaluated, too, where it may be zero: two crossings that are close together have one between them.
//! Where arguments of functions change so much between the points that these do not show what the formula does, it is
//! looked at in halves. Between two values of different sign the crossing is a root of the formula on the curve itself.
//! Two crossings are missed only where the formula passes zero by less than its polynomial resolves.

use std::cmp::Ordering;

use super::sampler::least;
use super::{Sample, Sampler, slack};
use crate::geometry::{Direction, Observable};
use crate::number::Real;
use crate::number::root::root;
use crate::sbp::polynomial::{Expansion, Tables, Through, expansion};
use crate::solve::WorldLine;

/// A cell is halved so many times at most where its points do not show a formula.
const MOST_HALVINGS: u32 = 16;

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
    /// By how much γ and then every coordinate may be off, if that is known.
    pub off: Option<Vec<f64>>,
}

impl<S> Crossing<S> {
    /// One of which nothing more is known.
    fn new(watch: usize, sample: Sample<S>) -> Self {
        Self { watch, sample, off: None }
    }
}

impl<S: Real> Crossing<S> {
    /// The numbers of the sample as decimals of so many digits and, of a run that is judged on its way, those of `off`,
    /// or nothing in their place.
    pub(crate) fn cells(&self, digits: u32, is_judged: bool) -> Vec<String> {
        let Self { sample: Sample { gamma, q, q_dot, .. }, off, .. } = self;
        let errors = |k: usize| off.as_ref().map_or_else(String::new, |off| S::from(off[k]).to_decimal(digits));
        let numbers = std::iter::once(gamma).chain(q).chain(q_dot).map(|number| number.to_decimal(digits));
        numbers.chain((0..=q.len()).filter(|_| is_judged).map(errors)).collect()
    }
}

/// Every change of sign of the formulas of `watches` in their directions, in the order of γ. A formula that is zero at
/// the start of the run, up to rounding, does not change its sign there; one that is zero at the end does.
pub fn crossings<S: Real>(line: &WorldLine<S>, watches: &mut [Watch<S>]) -> Vec<Crossing<S>> {
    let mut search = EventSearch::new(watches);
    search.see(line);
    search.finish(line)
}

/// The search of [`crossings`] in a run that is computed window by window.
#[derive(Debug)]
pub struct EventSearch<'w, S: Real = f64> {
    watches: &'w mut [Watch<S>],
    progress: Option<Progress<S>>,
    tables: Tables<S>,
}

impl<'w, S: Real> EventSearch<'w, S> {
    /// A search for changes of sign of the formulas of `watches` in their directions.
    pub fn new(watches: &'w mut [Watch<S>]) -> Self {
        Self { watches, progress: None, tables: Tables::default() }
    }

    /// Goes on with other formulas of what is watched.
    pub fn replace(&mut self, watches: &[Watch<S>]) {
        self.watches.clone_from_slice(watches);
    }

    /// Looks at a part of the run. It must continue the previous one or, if it contains the first window, begins the
    /// run again.
    pub fn see(&mut self, line: &WorldLine<S>) {
        if self.watches.is_empty() {
            return;
        }
        if line.window_count == line.windows.len() {
            self.progress = Some(Progress::new(line, self.watches));
        } else if line.windows.first().is_some_and(|window| window.gamma[0] == S::ZERO)
            && let Some(progress) = &mut self.progress
        {
            // It begins where an event has changed the state.
            let Progress { found, missed, .. } = std::mem::replace(progress, Progress::new(line, self.watches));
            (progress.from, progress.found, progress.missed) = (found.len(), found, missed);
        }
        let Self { watches, progress: Some(progress), tables } = self else { return };
        let mut sampler = Sampler::new(line);
        for window in 0..line.windows.len() {
            if sampler.has_states(window) {
                // The nodes are enough where nothing happens.
                let points = line.windows[window].points();
                let whole =
                    Interval::new(window, [S::ZERO, line.windows[window].length()], 0, expansion(tables, points));
                if progress.look(&mut sampler, watches, &whole, true) {
                    progress.pass(&mut sampler, watches, &whole);
                    continue;
                }
            }
            let (cells, points) = sampler.curve(window).cells();
            let expansion = expansion(tables, points);
            // Cells still to be looked at, the next one last, with how often each was halved.
            let mut cells: Vec<([S; 2], u32)> = cells.into_iter().rev().map(|ends| (ends, 0)).collect();
            while let Some((ends, halvings)) = cells.pop() {
                let interval = Interval::new(window, ends, halvings, expansion);
                if progress.look(&mut sampler, watches, &interval, false) {
                    progress.pass(&mut sampler, watches, &interval);
                } else {
                    let middle = (ends[0] + ends[1]).half();
                    cells.extend([[middle, ends[1]], [ends[0], middle]].map(|half| (half, halvings + 1)));
                }
            }
        }
    }

    /// Every change of sign in the parts that were seen, which the run ends behind, in the order of γ.
    pub fn found(self) -> Vec<Crossing<S>> {
        let Some(Progress { mut found, is_backward, .. }) = self.progress else { return Vec::new() };
        found.sort_by(|a, b| order(&a.sample.gamma, &b.sample.gamma));
        if is_backward {
            found.reverse();
        }
        found
    }

    /// The piece that was seen last ends, where the events `acted` change the state. `watches` has the indices
    /// of all that may do so.
    pub fn act(&mut self, line: &WorldLine<S>, acted: &[usize], watches: &[Option<usize>]) {
        self.close(line);
        let Some(progress) = &mut self.progress else { return };
        let Some(end) = end_of(line) else { return };
        // Events that act are met at the ends of pieces only, and there to the last bits.
        let is_met = |crossing: &Crossing<S>| watches.contains(&Some(crossing.watch));
        let of_piece: Vec<Crossing<S>> = progress.found.drain(progress.from..).collect();
        let inside = |crossing: &&Crossing<S>| is_met(crossing) && crossing.sample.gamma != end.gamma;
        progress.missed += of_piece.iter().filter(inside).count();
        progress.found.extend(of_piece.into_iter().filter(|crossing| !is_met(crossing)));
        progress.found.extend(acted.iter().map(|&watch| Crossing::new(watch, end.clone())));
    }

    /// The number of changes of sign at which an event should have acted, and has not.
    pub fn missed(&self) -> usize {
        self.progress.as_ref().map_or(0, |progress| progress.missed)
    }

    /// Every change of sign that was found, in the order of γ. `last` is the last part of the run that was seen.
    pub fn finish(mut self, last: &WorldLine<S>) -> Vec<Crossing<S>> {
        self.close(last);
        self.found()
    }

    /// Looks at the end of a piece.
    fn close(&mut self, last: &WorldLine<S>) {
        let (Some(progress), Some(end)) = (&mut self.progress, end_of(last)) else { return };
        for crossing in &mut progress.found[progress.from..] {
            if (end.gamma - crossing.sample.gamma).abs() <= progress.nowhere {
                crossing.sample = end.clone();
            }
        }
        // A formula that is zero at the end changes its sign there, whatever rounding says, and does so once.
        let is_met = |found: &[Crossing<S>], watch: usize| {
            found.iter().any(|crossing| crossing.watch == watch && crossing.sample.gamma == end.gamma)
        };
        for (watch, watched) in self.watches.iter().enumerate() {
            if is_met(&progress.found[progress.from..], watch) {
                continue;
            }
            let [value, slope, half] = progress.ends[watch];
            let is_positive = slope > S::ZERO;
            let is_change = slope != S::ZERO
                && progress.signs[watch] == Some(!is_positive)
                && watched.direction.counts(is_positive);
            if is_change && progress.is_at_zero(half, value, slope) {
                progress.found.push(Crossing::new(watch, end.clone()));
                progress.signs[watch] = Some(is_positive);
            }
        }
    }
}

/// The end of a world-line.
fn end_of<S: Real>(line: &WorldLine<S>) -> Option<Sample<S>> {
    let window = line.windows.len().checked_sub(1)?;
    Some(Sampler::new(line).in_window(window, line.windows[window].length()))
}

fn value<S: Real>(watched: &mut Watch<S>, sample: &Sample<S>, norm: S) -> S {
    watched.formula.at(&sample.q, &sample.q_dot, &sample.p, norm)
}

fn order<S: Real>(a: &S, b: &S) -> Ordering {
    a.partial_cmp(b).unwrap_or(Ordering::Equal)
}

/// A piece of a window on which the curve is one polynomial.
struct Interval<'e, S> {
    window: usize,
    /// γ at its ends, counted from the start of the window.
    ends: [S; 2],
    /// How often the piece was halved.
    halvings: u32,
    /// The polynomials through its points, and γ at these, counted as the ends are.
    expansion: &'e Expansion<S>,
    places: Vec<S>,
}

impl<'e, S: Real> Interval<'e, S> {
    fn new(window: usize, ends: [S; 2], halvings: u32, expansion: &'e Expansion<S>) -> Self {
        let mut places: Vec<S> = expansion.nodes.iter().map(|&node| ends[0] + node * (ends[1] - ends[0])).collect();
        *places.last_mut().expect("rules have two points or more") = ends[1];
        Self { window, ends, halvings, expansion, places }
    }

    /// Half of its length in γ, by which it is longer than the interval of z.
    fn half(&self) -> S {
        (self.ends[1] - self.ends[0]).half()
    }
}

/// The values of a formula and its [arguments](Observable::arguments) at the points of an interval.
#[derive(Debug, Clone)]
struct Seen<S> {
    values: Vec<S>,
    arguments: Vec<f64>,
}

/// The state of a search along a world-line.
#[derive(Debug)]
struct Progress<S> {
    is_begun: bool,
    is_backward: bool,
    norm: S,
    /// Room for the state at a point.
    here: Sample<S>,
    /// The value of each formula at the start of the run. The first node of the weak form is close to it only.
    starts: Vec<S>,
    /// A root that is closer than this to an end of the run is there.
    nowhere: S,
    /// True if each formula was positive where it was not zero last.
    signs: Vec<Option<bool>>,
    /// The value and the slope of each formula at the end of the last interval, and half of that interval's length.
    ends: Vec<[S; 3]>,
    /// Each formula in the interval that was looked at last.
    seen: Vec<Seen<S>>,
    found: Vec<Crossing<S>>,
    /// The index of the first of these in the current piece.
    from: usize,
    /// The number of changes of sign at which an event should have acted.
    missed: usize,
}

impl<S: Real> Progress<S> {
    fn new(line: &WorldLine<S>, watches: &mut [Watch<S>]) -> Self {
        let start = line.turned((*line.place.start).clone());
        let norm = line.geometry().norm(&start.q, &start.q_dot);
        Self {
            is_begun: false,
            is_backward: line.is_backward,
            norm,
            here: Sample { gamma: line.gamma_i, q: start.q.clone(), q_dot: start.q_dot.clone(), p: start.p.clone() },
            starts: watches.iter_mut().map(|w| w.formula.at(&start.q, &start.q_dot, &start.p, norm)).collect(),
            nowhere: slack::<S>(line.digits) * line.length.max(line.gamma_i.abs()),
            signs: vec![None; watches.len()],
            ends: vec![[S::ZERO; 3]; watches.len()],
            seen: vec![Seen { values: Vec::new(), arguments: Vec::new() }; watches.len()],
            found: Vec::new(),
            from: 0,
            missed: 0,
        }
    }

    /// Looks at the formulas at the points of an interval, which are nodes if `are_nodes` says so. Returns true if the
    /// points show what the formulas do between them, or the interval may not be halved again.
    fn look(
        &mut self,
        sampler: &mut Sampler<'_, S>,
        watches: &mut [Watch<S>],
        interval: &Interval<'_, S>,
        are_nodes: bool,
    ) -> bool {
        for seen in &mut self.seen {
            seen.values.clear();
            seen.arguments.clear();
        }
        for (node, &place) in interval.places.iter().enumerate() {
            if are_nodes {
                sampler.at_node(interval.window, node, &mut self.here);
            } else {
                self.here = sampler.in_window(interval.window, place);
            }
            for (watched, seen) in watches.iter_mut().zip(&mut self.seen) {
                seen.values.push(value(watched, &self.here, self.norm));
                seen.arguments.extend(watched.formula.arguments());
            }
        }
        let places: Vec<f64> = interval.places.iter().map(|place| place.to_f64()).collect();
        let is_shown = |(watched, seen): (&Watch<S>, &Seen<S>)| watched.formula.is_shown(&places, &seen.arguments);
        interval.halvings == MOST_HALVINGS || watches.iter().zip(&self.seen).all(is_shown)
    }

    /// Finds the changes of sign in the interval that was looked at last.
    fn pass(&mut self, sampler: &mut Sampler<'_, S>, watches: &mut [Watch<S>], interval: &Interval<'_, S>) {
        for (watch, watched) in watches.iter_mut().enumerate() {
            let values = std::mem::take(&mut self.seen[watch].values);
            let through = Through::new(interval.expansion, &values);
            let [first, last] = through.end_slopes(&values);
            let start = self.starts[watch];
            if !self.is_begun && !self.is_at_zero(interval.half(), start, first) {
                self.signs[watch] = Some(start > S::ZERO);
            }
            self.ends[watch] = [values[values.len() - 1], last, interval.half()];
            let extrema = through.extrema(&values);
            self.pass_one(sampler, interval, (watch, watched), &values, &extrema);
            self.seen[watch].values = values;
        }
        self.is_begun = true;
    }

    /// Finds the changes of sign of one formula, which has these values at the points of the interval, and may have
    /// extrema at these shares of it.
    fn pass_one(
        &mut self,
        sampler: &mut Sampler<'_, S>,
        interval: &Interval<'_, S>,
        (watch, watched): (usize, &mut Watch<S>),
        values: &[S],
        extrema: &[f64],
    ) {
        let (norm, direction, least) = (self.norm, watched.direction, least(sampler.line, interval.window));
        let mut at = |place: S| value(watched, &sampler.in_window(interval.window, place), norm);
        let [first, last] = interval.ends;
        let mut marks: Vec<[S; 2]> =
            interval.places.iter().zip(values).map(|(&place, &value)| [place, value]).collect();
        if !extrema.is_empty() {
            let places = extrema.iter().map(|&s| first + S::from(s) * (last - first));
            marks.extend(places.map(|place| [place, at(place)]));
            marks.sort_by(|a, b| order(&a[0], &b[0]));
        }
        // The start of an interval is the end of the one before, whose sign counts.
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
        let roots = roots.into_iter().map(|root| Crossing::new(watch, sampler.in_window(interval.window, root)));
        self.found.extend(roots);
    }

    /// Returns true if a formula with this value and slope at an end of an interval of twice the length `half` is zero
    /// there but for rounding.
    fn is_at_zero(&self, half: S, value: S, slope: S) -> bool {
        value == S::ZERO || value.abs() * half <= slope.abs() * self.nowhere
    }
}

/// The value at the start of an interval, with the sign that the end of the interval before had.
fn carried<S: Real>(sign: Option<bool>, value: S) -> S {
    match sign {
        Some(true) if value <= S::ZERO => S::MIN_POSITIVE,
        Some(false) if value >= S::ZERO => -S::MIN_POSITIVE,
        _ => value,
    }
}
