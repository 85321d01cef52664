//! Where formulas of the state change their sign along a world-line.
//!
//! In every window a formula is evaluated at enough points to resolve the motion: the nodes, where the solver has left
//! the states there, or points of the curve. [`Search`] tells from these where it changes its sign, and between two
//! values of different sign the crossing is a root of the formula on the curve itself.

use std::cmp::Ordering;

use super::inside::{epsilon, of_inside};
use super::late::{Late, late_at};
use super::nodes::States;
use super::sampler::least;
use super::{Sample, Sampler, slack};
use crate::geometry::{Direction, Observable, Start};
use crate::number::Real;
use crate::number::root::root;
use crate::sbp::polynomial::{Expansion, Tables, expansion};
use crate::solve::{Along, At, Beginning, Search, Seen, Sign, Slack, Wanted, WorldLine, noise, rounding};

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
    /// By how much γ is open since the formula rounds.
    pub late: S,
    /// By how much γ and then every coordinate may be off, if that is known.
    pub off: Option<Vec<f64>>,
}

impl<S: Real> Crossing<S> {
    /// One of which nothing more is known.
    fn new(watch: usize, sample: Sample<S>) -> Self {
        Self { watch, sample, late: S::ZERO, off: None }
    }

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

/// The search of [`crossings`] in a run that is handed out part by part.
#[derive(Debug)]
pub struct EventSearch<'w, S: Real = f64> {
    watches: &'w mut [Watch<S>],
    progress: Option<Progress<S>>,
    search: Search<S>,
    tables: Tables<S>,
}

impl<'w, S: Real> EventSearch<'w, S> {
    /// A search for changes of sign of the formulas of `watches` in their directions.
    pub fn new(watches: &'w mut [Watch<S>]) -> Self {
        Self { watches, progress: None, search: Search::default(), tables: Tables::default() }
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
            let Progress { found, missed, unseen, .. } = std::mem::replace(progress, Progress::new(line, self.watches));
            (progress.from, progress.found, progress.missed, progress.unseen) = (found.len(), found, missed, unseen);
        }
        let Self { watches, progress: Some(progress), search, tables } = self else { return };
        let (mut open, mut at) = (std::mem::take(&mut progress.open), None);
        let mut sampler = Sampler::with_tables(line, std::mem::take(tables));
        for window in 0..line.windows.len() {
            // The nodes are enough where nothing happens.
            let has_states = sampler.has_states(window);
            let (cells, points) = if has_states {
                (vec![[S::ZERO, line.windows[window].length()]], line.windows[window].points())
            } else {
                sampler.curve(window).cells()
            };
            let rule = &*expansion(&mut sampler.tables, points);
            if has_states {
                progress.see_nodes(&mut sampler, watches, (window, rule));
            }
            for (watch, watched) in watches.iter_mut().enumerate() {
                let least = least(line, window);
                let wanted = Wanted { direction: watched.direction, is_first: false, least, rule };
                let mut within =
                    Within { sampler: &mut sampler, window, norm: progress.norm, open: &open, at: &mut at };
                search.begin();
                for &cell in &cells {
                    let first = has_states.then_some(&mut progress.seen[watch]);
                    search.pass(
                        (&mut within, &mut watched.formula),
                        &wanted,
                        (cell, first),
                        &mut progress.signs[watch],
                    );
                }
                progress.take(&mut within, (watch, watched), (search, least));
            }
            if progress.signs.iter().any(|sign| sign.side == S::ZERO) {
                // What a window leaves open is open from there on, for what has not begun to move.
                let extents = sampler.curve(window).extents(line.geometry());
                open.iter_mut().zip(extents).for_each(|(open, [_, own])| *open += own);
            }
        }
        (progress.open, *tables) = (open, sampler.tables);
    }

    /// Every change of sign in the parts that were seen, which the run ends behind, in the order of γ and, at one
    /// place, in that of the formulas.
    pub fn found(self) -> Vec<Crossing<S>> {
        let Some(Progress { mut found, is_backward, .. }) = self.progress else { return Vec::new() };
        found.sort_by(|a, b| {
            let order = order(&a.sample.gamma, &b.sample.gamma);
            let order = if is_backward { order.reverse() } else { order };
            order.then(a.watch.cmp(&b.watch))
        });
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

    /// The first place where a formula changes so narrowly that it may have changed its sign unseen: its index, and γ.
    pub fn unseen(&self) -> Option<(usize, S)> {
        self.progress.as_ref().and_then(|progress| progress.unseen)
    }

    /// Every change of sign that was found, in the order of γ. `last` is the last part of the run that was seen.
    pub fn finish(mut self, last: &WorldLine<S>) -> Vec<Crossing<S>> {
        self.close(last);
        self.found()
    }

    /// Looks at the end of a piece. A formula that is zero there changes its sign there, whatever rounding says, and
    /// does so once.
    fn close(&mut self, last: &WorldLine<S>) {
        let (Some(progress), Some(end)) = (&mut self.progress, end_of(last)) else { return };
        let nowhere = nowhere(last);
        let snap = |sample: &mut Sample<S>| {
            if (end.gamma - sample.gamma).abs() <= nowhere {
                sample.clone_from(&end);
            }
        };
        let is_at_end = |crossing: &Crossing<S>| crossing.sample.gamma == end.gamma;
        let mut met = vec![false; self.watches.len()];
        for mut crossing in progress.found.split_off(progress.from) {
            snap(&mut crossing.sample);
            // A force that jumps may send the motion to and fro within rounding.
            let is_again = is_at_end(&crossing) && std::mem::replace(&mut met[crossing.watch], true);
            progress.found.extend((!is_again).then_some(crossing));
        }
        for (watch, watched) in self.watches.iter_mut().enumerate() {
            let (side, goes_up) = (progress.signs[watch].side, progress.signs[watch].goes_up());
            if met[watch] || side == S::ZERO || !watched.direction.counts(goes_up) {
                continue;
            }
            let reached = progress.reached[watch].take().filter(|_| progress.signs[watch].has_reached());
            if let Some(mut reached) = reached {
                snap(&mut reached.sample);
                progress.found.push(reached);
            } else if progress.is_zero_at(last, watched, &last.end_inside(), side) {
                progress.found.push(Crossing::new(watch, end.clone()));
            }
        }
    }
}

/// The end of a world-line.
fn end_of<S: Real>(line: &WorldLine<S>) -> Option<Sample<S>> {
    let window = line.windows.len().checked_sub(1)?;
    Some(Sampler::new(line).in_window(window, line.windows[window].length()))
}

fn order<S: Real>(a: &S, b: &S) -> Ordering {
    a.partial_cmp(b).unwrap_or(Ordering::Equal)
}

/// The length of a run so far, or of the whole, if that is known.
fn reach<S: Real>(line: &WorldLine<S>) -> S {
    line.windows.last().map_or(line.length, |window| line.length.max(window.gamma[1]))
}

/// A root that is closer than this to an end of the run is there.
fn nowhere<S: Real>(line: &WorldLine<S>) -> S {
    slack::<S>(line.digits) * reach(line).max(line.gamma_i.abs())
}

/// A window of a world-line that is looked into.
struct Within<'s, 'l, S: Real> {
    sampler: &'s mut Sampler<'l, S>,
    window: usize,
    norm: S,
    /// What windows before have left open of the numbers of a state.
    open: &'s [S],
    /// What evaluates formulas at states that are off by their rounding, once that was asked for.
    at: &'s mut Option<At<'l, S>>,
}

impl<S: Real> Along<S> for Within<'_, '_, S> {
    fn at(&mut self, formula: &mut Observable<S>, place: S) -> S {
        let sample = self.sampler.at_place(self.window, place, formula.has_velocities());
        formula.at(&sample.q, &sample.q_dot, &sample.p, self.norm)
    }

    fn noise(&mut self, formula: &mut Observable<S>, place: S, is_open: bool) -> S {
        let line = self.sampler.line;
        let (curve, geometry) = (self.sampler.curve(self.window), line.geometry());
        let mut state = curve.at(place, geometry).concat();
        let (epsilon, extents, reads) = (epsilon(line), curve.extents(geometry), formula.reads());
        let off = |k: usize, value: S| {
            if !reads[k] {
                return S::ZERO;
            }
            let [change, own] = extents[k];
            rounding(value, change, epsilon) + if is_open { self.open[k] + own } else { S::ZERO }
        };
        let at = self.at.get_or_insert_with(|| At::new(geometry));
        noise(at, &mut of_inside(line, formula, self.norm), &mut state, off)
    }

    fn is_none(&mut self, formula: &mut Observable<S>, [place, value]: [S; 2], is_open: bool) -> bool {
        // Most values are far from rounding, which a node tells without the curve.
        let node = if is_open { None } else { self.sampler.node_at(self.window, place) };
        let is_far = node.is_some_and(|node| {
            let at = self.at.get_or_insert_with(|| At::new(self.sampler.line.geometry()));
            value.abs() > self.sampler.most_noise((self.window, node), at, (formula, self.norm))
        });
        !is_far && value.abs() <= self.noise(formula, place, is_open)
    }
}

/// The state of a search along a world-line.
#[derive(Debug)]
struct Progress<S> {
    is_backward: bool,
    norm: S,
    /// Room for the states at the nodes of a window.
    states: States<S>,
    signs: Vec<Sign<S>>,
    /// Where each formula has reached zero, if it has had no sign since.
    reached: Vec<Option<Crossing<S>>>,
    /// The rounding of each formula at its zeros.
    late: Vec<Late<S>>,
    /// Each formula on the nodes of a window.
    seen: Vec<Seen<S>>,
    /// What windows have left open of q^a and p_a of all coordinates.
    open: Vec<S>,
    found: Vec<Crossing<S>>,
    /// The index of the first of these in the current piece.
    from: usize,
    /// The number of changes of sign at which an event should have acted.
    missed: usize,
    /// The first place where a formula may do what was not seen.
    unseen: Option<(usize, S)>,
}

impl<S: Real> Progress<S> {
    fn new(line: &WorldLine<S>, watches: &mut [Watch<S>]) -> Self {
        let (inside, start) = (&*line.place.start, line.turned((*line.place.start).clone()));
        let norm = line.geometry().norm(&start.q, &start.q_dot);
        let mut progress = Self {
            is_backward: line.is_backward,
            norm,
            states: States::default(),
            signs: Vec::new(),
            reached: vec![None; watches.len()],
            late: vec![Late::default(); watches.len()],
            seen: vec![Seen::default(); watches.len()],
            open: vec![S::ZERO; 2 * start.q.len()],
            found: Vec::new(),
            from: 0,
            missed: 0,
            unseen: None,
        };
        progress.signs = watches.iter_mut().map(|watched| progress.begin(line, watched, inside)).collect();
        progress
    }

    /// The sign of a formula at the start.
    fn begin(&self, line: &WorldLine<S>, watched: &mut Watch<S>, start: &Start<S>) -> Sign<S> {
        let [side, bound] = self.beginning(line, watched, start, reach(line)).known();
        Sign::new(S::from(side), S::from(bound))
    }

    fn beginning(&self, line: &WorldLine<S>, watched: &mut Watch<S>, start: &Start<S>, before: S) -> Beginning {
        let slack = Slack { before, late: nowhere(line), zero: S::ZERO };
        let formula = &mut of_inside(line, &mut watched.formula, self.norm);
        Beginning::new((line.geometry(), start, epsilon(line)), formula, slack)
    }

    /// Returns true if a formula that had this sign is zero at a state, and about to have another one.
    fn is_zero_at(&self, line: &WorldLine<S>, watched: &mut Watch<S>, state: &Start<S>, side: S) -> bool {
        let [ahead, behind] = [reach(line), -reach(line)].map(|before| self.beginning(line, watched, state, before));
        // Where a force that jumps holds the motion, only the way there tells.
        let comes_to_it = behind.order == 1 && S::from(behind.side) == -side;
        ahead.is_zero && (S::from(ahead.side) != side || comes_to_it)
    }

    /// Looks at all formulas on the nodes of a window with this rule.
    fn see_nodes(
        &mut self,
        sampler: &mut Sampler<'_, S>,
        watches: &mut [Watch<S>],
        (window, rule): (usize, &Expansion<S>),
    ) {
        let has_velocities = watches.iter().any(|watched| watched.formula.has_velocities());
        sampler.states(window, has_velocities, &mut self.states);
        let rows = self.states.rows();
        for (watched, seen) in watches.iter_mut().zip(&mut self.seen) {
            seen.see_all(rule, &mut watched.formula, [&rows[0], &rows[1], &rows[2]], self.norm);
        }
    }

    /// Takes what was found of a formula in a window.
    fn take(
        &mut self,
        within: &mut Within<'_, '_, S>,
        (watch, watched): (usize, &mut Watch<S>),
        (search, least): (&Search<S>, S),
    ) {
        let window = within.window;
        let gamma = |place: S| within.sampler.line.gamma_at(within.sampler.line.windows[window].gamma[0] + place);
        self.unseen = self.unseen.or(search.unseen.map(|place| (watch, gamma(place))));
        let mut root_between = |[low, high]: [[S; 2]; 2], side: S| {
            let low = [low[0], if low[1] * side > S::ZERO { low[1] } else { side * S::MIN_POSITIVE }];
            // Where it stays at zero, the place is the first one.
            let is_flat = high[1] * side >= S::ZERO;
            let none = |value: S| if is_flat && value * side <= S::ZERO { -side * S::MIN_POSITIVE } else { value };
            let place =
                root(low, [high[0], none(high[1])], least, |place| none(within.at(&mut watched.formula, place)));
            let late = &mut self.late[watch];
            let late = late_at(late, (within.sampler, within.at), (&mut watched.formula, within.norm), (window, place));
            Crossing { late, ..Crossing::new(watch, within.sampler.in_window(window, place)) }
        };
        for change in &search.changes {
            let reached = self.reached[watch].take();
            let at = change.between.map(|between| root_between(between, change.side)).or(reached);
            self.found.extend(at);
        }
        let sign = &mut self.signs[watch];
        if let Some(between) = sign.end_window() {
            self.reached[watch] = Some(root_between(between, sign.side));
        }
    }
}
