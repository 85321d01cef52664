//! Where a formula changes its sign over a window: the one search for all that ends a run, acts in it or is found.
//!
//! A formula is evaluated at the points of a rule, and the polynomial through these values has extrema between them,
//! where the formula is evaluated, too, if it may be zero twice. Where the points do not show what the formula does,
//! the window is looked at in parts: where an argument of abs, sign or step is zero it is cut in two, and elsewhere, or
//! where the polynomial does not tell how often it is zero, it is halved. What is not seen then is said.
//!
//! A value that is no more than its own rounding has no sign. A change of sign is where the formula reaches zero on its
//! way to the other side, and what comes back to the side that it was on has not changed it.

use crate::geometry::{Direction, Observable, Shown};
use crate::number::Real;
use crate::sbp::polynomial::{Expansion, Through};
use crate::solve::seen::Seen;

/// Parts are halved so many times at most wherever they need it: what changes everywhere is looked at on a million
/// points of a window.
const MOST_HALVINGS: u32 = 16;
/// The same once something was not seen: the rest is doubtful, and is worth some ten thousand points.
const FEW_HALVINGS: u32 = 10;
/// So many parts of a window may be cut at kinks, or halved again, for what is narrow at some places: a place needs two
/// parts for each digit of a double.
const MOST_DEEP: usize = 4096;

/// A window, in which a place is γ from its start, in any unit.
pub(crate) trait Along<S: Real> {
    /// The value of a formula at a place.
    fn at(&mut self, formula: &mut Observable<S>, place: S) -> S;
    /// By how much that value may be off as numbers are rounded or, if it `is_open`, as the window resolves the motion.
    fn noise(&mut self, formula: &mut Observable<S>, place: S, is_open: bool) -> S;

    /// Returns true if a value at a place is no more than that.
    fn is_none(&mut self, formula: &mut Observable<S>, [place, value]: Mark<S>, is_open: bool) -> bool {
        value.abs() <= self.noise(formula, place, is_open)
    }
}

/// What is known at the end of a run of the formulas that may end it.
#[derive(Debug, Clone, Default)]
pub(crate) struct Watched {
    /// The signs that they had on the way there, 0 of one that had none.
    pub(crate) sides: Vec<f64>,
    /// The first place where one may have changed its sign unseen: its own among them, and γ from the start.
    pub(crate) unseen: Option<(usize, f64)>,
    /// The first place where one turns so near to zero that the error of the run decides whether it changes its sign.
    pub(crate) touched: Option<(usize, f64)>,
}

/// A place, with the value there.
pub(crate) type Mark<S> = [S; 2];

/// Where a formula has reached zero, if it has had no sign since.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Reached<S> {
    Nowhere,
    /// In a window before.
    Before,
    /// Between two places of this one.
    Between([Mark<S>; 2]),
}

/// The sign of a formula on its way through windows.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sign<S> {
    /// 1 or −1, or 0 as long as it has had none.
    pub(crate) side: S,
    /// Values up to this are none, until one is larger.
    bound: S,
    /// The largest value since the first one that had a sign, if it had none at the start and has not changed it since.
    young: Option<S>,
    reached: Reached<S>,
}

impl<S: Real> Sign<S> {
    /// The sign at the start of a run, where values up to `bound` are none of their own.
    pub(crate) fn new(side: S, bound: S) -> Self {
        Self { side, bound, young: None, reached: Reached::Nowhere }
    }

    /// The formula is about to go to the positive side, or to the negative one.
    pub(crate) fn goes_up(&self) -> bool {
        self.side < S::ZERO
    }

    /// True if it has reached zero, and has had no sign since.
    pub(crate) fn has_reached(&self) -> bool {
        self.reached != Reached::Nowhere
    }

    /// The places between which it has reached zero, if it now changes between these; `None` in a window before.
    fn between(&self, here: [Mark<S>; 2]) -> Option<[Mark<S>; 2]> {
        match self.reached {
            Reached::Nowhere => Some(here),
            Reached::Before => None,
            Reached::Between(between) if between[1][1] == S::ZERO => Some(between),
            // What is only rounding has a root all the same.
            Reached::Between([from, _]) => Some([from, here[1]]),
        }
    }

    /// The window ends. Returns the places between which the formula has reached zero, if it stays there.
    pub(crate) fn end_window(&mut self) -> Option<[Mark<S>; 2]> {
        let Reached::Between(between) = self.reached else { return None };
        self.reached = Reached::Before;
        Some(between)
    }
}

/// A change of sign.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Change<S> {
    /// Two places, with a value of the sign before at the first one and none of it at the second; `None` if it has
    /// reached zero in a window before.
    pub(crate) between: Option<[Mark<S>; 2]>,
    /// The sign before.
    pub(crate) side: S,
}

/// A part of a window.
#[derive(Debug, Clone, Copy)]
struct Part<S> {
    ends: [S; 2],
    halvings: u32,
}

impl<S: Real> Part<S> {
    /// The place that is this share of the way through it.
    fn at(&self, share: S) -> S {
        let [from, to] = self.ends;
        if share == S::ONE { to } else { from + share * (to - from) }
    }
}

/// What is looked for in a window.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Wanted<'e, S> {
    pub(crate) direction: Direction,
    /// True if the first change is enough. The sign is that before it then.
    pub(crate) is_first: bool,
    /// The distance of two places that counts as none.
    pub(crate) least: S,
    /// The rule whose points are looked at.
    pub(crate) rule: &'e Expansion<S>,
}

/// The search, with its room.
#[derive(Debug, Clone, Default)]
pub(crate) struct Search<S> {
    /// Parts still to be looked at, the next one last.
    parts: Vec<Part<S>>,
    seen: Seen<S>,
    through: Through<S>,
    marks: Vec<Mark<S>>,
    /// The last place that was passed, and how many parts may be cut still.
    last: Option<Mark<S>>,
    deep: usize,
    /// The changes of sign in the window that was looked at last.
    pub(crate) changes: Vec<Change<S>>,
    /// A place of it where the formula may do what was not seen.
    pub(crate) unseen: Option<S>,
}

impl<S: Real> Search<S> {
    /// Begins a window for a formula.
    pub(crate) fn begin(&mut self) {
        (self.last, self.deep, self.unseen) = (None, MOST_DEEP, None);
        self.changes.clear();
    }

    /// Looks at the next cell of the window, of which the points were seen if `first` has them. Returns false if it has
    /// found enough.
    pub(crate) fn pass<A: Along<S>>(
        &mut self,
        (along, formula): (&mut A, &mut Observable<S>),
        wanted: &Wanted<'_, S>,
        (cell, mut first): ([S; 2], Option<&mut Seen<S>>),
        sign: &mut Sign<S>,
    ) -> bool {
        self.parts.clear();
        self.parts.push(Part { ends: cell, halvings: 0 });
        while let Some(part) = self.parts.pop() {
            match first.take() {
                Some(seen) => std::mem::swap(seen, &mut self.seen),
                None => self.look(along, formula, (&part, wanted.rule)),
            }
            if self.is_cut(along, formula, (&part, wanted)) {
                continue;
            }
            self.mark(along, formula, &part);
            if !self.walk((along, formula), wanted, sign) {
                return false;
            }
        }
        true
    }

    /// Evaluates the formula at the points of a part.
    fn look<A: Along<S>>(
        &mut self,
        along: &mut A,
        formula: &mut Observable<S>,
        (part, rule): (&Part<S>, &Expansion<S>),
    ) {
        self.seen.clear(rule);
        for &node in &rule.nodes {
            let value = along.at(formula, part.at(node));
            self.seen.see(formula, value);
        }
    }

    /// Cuts the part that was looked at if it does not show enough, and if that may help.
    fn is_cut<A: Along<S>>(
        &mut self,
        along: &mut A,
        formula: &mut Observable<S>,
        (part, wanted): (&Part<S>, &Wanted<'_, S>),
    ) -> bool {
        let Seen { places, values, arguments, margins } = &mut self.seen;
        let shown = formula.shows(places, arguments, margins);
        if let Shown::Kink { argument, point } = shown
            && self.deep > 0
        {
            self.deep -= 1;
            let ends = [point, point + 1].map(|point| part.at(wanted.rule.nodes[point]));
            let [low, high] = kink((along, formula), argument, ends, wanted.least);
            let halvings = part.halvings;
            self.parts.push(Part { ends: [high, part.ends[1]], halvings });
            self.parts.push(Part { ends: [part.ends[0], low], halvings });
            self.parts.retain(|part| part.ends[1] > part.ends[0]);
            return true;
        }
        self.through.fit(wanted.rule, values);
        if shown == Shown::All {
            if self.through.is_clear() {
                return false;
            }
            // Slopes are told only where values are more than n² of their rounding.
            let most = values.iter().fold(S::ZERO, |most, value| most.max(value.abs()));
            let noise = along.noise(formula, part.at(S::ONE.half()), false);
            if most <= S::from((values.len() * values.len()) as f64) * noise {
                return false;
            }
        }
        self.halve(part, wanted.least)
    }

    /// Halves a part, if it is not as nothing and was not halved too often.
    fn halve(&mut self, &Part { ends: [from, to], halvings }: &Part<S>, least: S) -> bool {
        let middle = (from + to).half();
        // What is narrower than rounding is not there.
        if to - from <= least + least || middle <= from || middle >= to {
            return false;
        }
        let most = if self.unseen.is_some() { FEW_HALVINGS } else { MOST_HALVINGS };
        if halvings >= most {
            if self.deep == 0 {
                self.unseen.get_or_insert(from);
                return false;
            }
            self.deep -= 1;
        }
        let halves = [[middle, to], [from, middle]];
        self.parts.extend(halves.map(|ends| Part { ends, halvings: halvings + 1 }));
        true
    }

    /// Puts the points of the part in order with the extrema between them.
    fn mark<A: Along<S>>(&mut self, along: &mut A, formula: &mut Observable<S>, part: &Part<S>) {
        let Self { seen, through, marks, .. } = self;
        marks.clear();
        marks.extend(seen.places.iter().zip(&seen.values).map(|(&share, &value)| [part.at(S::from(share)), value]));
        for &share in through.extrema() {
            let place = part.at(S::from(share));
            marks.push([place, along.at(formula, place)]);
        }
        if !through.extrema().is_empty() {
            marks.sort_unstable_by(|a, b| a[0].partial_cmp(&b[0]).unwrap_or(std::cmp::Ordering::Equal));
        }
    }

    /// Goes from mark to mark. Returns false if it has found enough.
    fn walk<A: Along<S>>(
        &mut self,
        (along, formula): (&mut A, &mut Observable<S>),
        wanted: &Wanted<'_, S>,
        sign: &mut Sign<S>,
    ) -> bool {
        let mut last = self.last.unwrap_or(self.marks[0]);
        for at in 0..self.marks.len() {
            let mark @ [place, value] = self.marks[at];
            if place <= last[0] || value.is_nan() {
                continue;
            }
            if sign.bound > S::ZERO {
                if value.abs() <= sign.bound {
                    continue;
                }
                sign.bound = S::ZERO;
            }
            let mut is_none =
                |mark: Mark<S>, is_open: bool| mark[1] == S::ZERO || along.is_none(formula, mark, is_open);
            if sign.side == S::ZERO {
                // What leaves the surface that it was on has changed no sign.
                if !is_none(mark, true) {
                    (sign.side, sign.young) = (value.signum(), Some(value.abs()));
                }
                last = mark;
            } else if value * sign.side > S::ZERO {
                sign.young = sign.young.map(|most| most.max(value.abs()));
                if sign.reached == Reached::Nowhere {
                    last = mark;
                } else if !is_none(mark, false) {
                    (sign.reached, last) = (Reached::Nowhere, mark);
                }
            } else if sign.young.is_some_and(|most| is_none([place, most], true)) {
                // It has not left it as far as this window can tell.
                (sign.side, sign.young, sign.reached, last) = (S::ZERO, None, Reached::Nowhere, mark);
            } else if is_none(mark, false) {
                if sign.reached == Reached::Nowhere {
                    // Values before may be none, too.
                    let held = |mark: &&Mark<S>| mark[0] < place && !is_none(**mark, false);
                    let from = self.marks[..at].iter().rev().find(held).copied().unwrap_or(last);
                    let to = self.marks[..=at].iter().find(|mark| mark[0] > from[0]).copied().unwrap_or(mark);
                    sign.reached = Reached::Between([from, to]);
                }
            } else {
                if wanted.direction.counts(sign.goes_up()) {
                    self.changes.push(Change { between: sign.between([last, mark]), side: sign.side });
                    if wanted.is_first {
                        return false;
                    }
                }
                (sign.side, sign.young, sign.reached, last) = (value.signum(), None, Reached::Nowhere, mark);
            }
        }
        self.last = Some(last);
        true
    }
}

/// Two places next to each other between which an argument of a formula changes its sign, as it does between two
/// others.
fn kink<S: Real, A: Along<S>>(
    (along, formula): (&mut A, &mut Observable<S>),
    argument: usize,
    [mut low, mut high]: [S; 2],
    least: S,
) -> [S; 2] {
    let mut is_low = |place: S| {
        along.at(formula, place);
        formula.arguments().nth(argument).is_some_and(|value| value < 0.0)
    };
    let side = is_low(low);
    while high - low > least {
        let middle = (low + high).half();
        if middle <= low || middle >= high {
            break;
        }
        if is_low(middle) == side { low = middle } else { high = middle }
    }
    [low, high]
}
