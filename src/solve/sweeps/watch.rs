//! Formulas at whose first change of sign a run ends.
//!
//! A window is looked at as [`EventSearch`](crate::trajectory::EventSearch) does: on its nodes, between them where the
//! polynomial through the values may be zero twice, and in halves where the nodes do not show a formula.

use crate::engine::{Dense, State, Window, WindowNodes};
use crate::geometry::{Direction, Geometry, Observable, Point};
use crate::number::root::root;
use crate::sbp::polynomial::{Tables, Through, expansion};
use crate::solve::setup::Until;
use crate::solve::world_line::Place;

/// A value at the start of a run counts as zero if it is this part of that at the next node.
const AT_START: f64 = 1e-6;
/// The lengths next to a change are off from it by this share of its distance from the node before.
const ROOM: f64 = 1e-6;
/// A change near the start of a run is looked for in ever shorter parts of the window.
const MOST_TIMES_NEARER: usize = 60;
/// Parts of a window are halved so many times at most where their points do not show a formula.
const MOST_HALVINGS: u32 = 16;

/// A change of sign between two lengths of the window.
pub(super) struct Change {
    /// The formula.
    pub(super) place: usize,
    pub(super) between: [f64; 2],
    /// The sign before.
    pub(super) side: f64,
    /// The length by a straight line between the two.
    near: f64,
}

/// A formula with what is known of its sign so far.
struct Watch {
    formula: Observable,
    direction: Direction,
    /// True if the formula belongs to an event that acts.
    acts: bool,
    /// The sign at the start of the run, 0 if it is not known, and the bound that values exceed before changes count.
    begin: [f64; 2],
    /// The sign at the start of the window, 0 as long as a value was 0, and the bound; 0 once a value has exceeded it.
    here: [f64; 2],
    /// The same at the end of the window that was looked at.
    end: [f64; 2],
}

/// The formulas, and what they read.
pub(super) struct Watches<'g> {
    geometry: &'g Geometry,
    watches: Vec<Watch>,
    /// True if the signs at the start of the run are known.
    are_known: bool,
    /// K of the run, and what formulas read: q^a and p_a of all coordinates, and velocities.
    norm: f64,
    point: Point,
    q: Vec<f64>,
    q_dot: Vec<f64>,
    p: Vec<f64>,
    /// p_a of active coordinates.
    momenta: Vec<f64>,
    seen: Seen,
    tables: Tables<f64>,
}

impl<'g> Watches<'g> {
    pub(super) fn new<S>(Place { geometry, start }: &'g Place, until: &[Until<S>], known: &[[f64; 2]]) -> Self {
        let watch = |(place, until): (usize, &Until<S>)| Watch {
            formula: until.rough.clone(),
            direction: until.direction,
            acts: until.change.is_some(),
            begin: known.get(place).copied().unwrap_or_default(),
            here: [0.0; 2],
            end: [0.0; 2],
        };
        Self {
            watches: until.iter().enumerate().map(watch).collect(),
            are_known: !known.is_empty(),
            norm: geometry.norm(&start.q, &start.q_dot),
            point: geometry.point(),
            q: start.q.clone(),
            q_dot: start.q_dot.clone(),
            p: start.p.clone(),
            momenta: vec![0.0; geometry.active().len()],
            seen: Seen::default(),
            tables: Tables::default(),
            geometry,
        }
    }

    /// The run begins.
    pub(super) fn begin(&mut self) {
        self.watches.iter_mut().for_each(|watch| watch.here = watch.begin);
    }

    /// The window that was looked at is a part of the run.
    pub(super) fn accept(&mut self) {
        self.watches.iter_mut().for_each(|watch| watch.here = watch.end);
    }

    /// The value of a formula at a state.
    pub(super) fn at(&mut self, place: usize, state: &State) -> f64 {
        self.q = state.positions();
        self.momenta = state.momenta();
        self.set_momenta();
        self.value(place)
    }

    fn set_momenta(&mut self) {
        self.geometry.active().iter().zip(&self.momenta).for_each(|(&a, &p)| self.p[a] = p);
    }

    /// The value of a formula at the q and p in place.
    fn value(&mut self, place: usize) -> f64 {
        let Self { watches, norm, point, q, q_dot, p, .. } = self;
        if point.evaluate(q, p).is_err() {
            return f64::NAN;
        }
        q_dot.iter_mut().enumerate().for_each(|(a, q_dot)| *q_dot = point.q_dot(a));
        watches[place].formula.at(q, q_dot, p, *norm)
    }

    /// The value of a formula inside a window, at this fraction of it.
    fn inside(&mut self, place: usize, dense: &Dense, fraction: f64) -> f64 {
        dense.at(fraction, &mut self.q, &mut self.momenta);
        self.set_momenta();
        self.value(place)
    }

    /// The value of a formula at a node of a window with these ends.
    fn at_node(&mut self, place: usize, nodes: &dyn WindowNodes, [begin, end]: [&State; 2], node: usize) -> f64 {
        if node + 1 == nodes.points() {
            return self.at(place, end);
        }
        for a in 0..self.q.len() {
            let is_active = self.geometry.active().contains(&a);
            self.q[a] = nodes.q(a)[node] + if is_active { 0.0 } else { begin.q[a].high };
        }
        self.momenta.iter_mut().enumerate().for_each(|(place, p)| *p = nodes.p(place)[node]);
        self.set_momenta();
        self.value(place)
    }

    /// A formula on the nodes of a window with these ends or, of a part of it, at places like them.
    fn look(&mut self, place: usize, (window, inside): Inside<'_, '_>, ends: [&State; 2], part: &Part) {
        let mut seen = std::mem::take(&mut self.seen);
        seen.clear();
        let dense = (!part.is_whole()).then(|| &*inside.get_or_insert_with(|| window.dense()));
        let nodes = window.nodes();
        for (node, &fraction) in nodes.fractions().iter().enumerate() {
            let at = part.at(fraction);
            let value = match &dense {
                // The ends are known as they are handed on.
                _ if at == 0.0 => self.at(place, ends[0]),
                None => self.at_node(place, nodes, ends, node),
                Some(dense) => self.inside(place, dense, at),
            };
            seen.points.push([at, value]);
            seen.arguments.extend(self.watches[place].formula.arguments());
        }
        seen.is_shown =
            part.halvings == MOST_HALVINGS || self.watches[place].formula.is_shown(nodes.fractions(), &seen.arguments);
        self.seen = seen;
    }

    /// Adds the extrema at which the formula may be beyond zero to its points in a part of a window.
    fn add_extrema(&mut self, place: usize, (window, inside): Inside<'_, '_>, part: &Part) {
        let values: Vec<f64> = self.seen.points.iter().map(|[_, value]| *value).collect();
        let extrema = Through::new(expansion(&mut self.tables, values.len()), &values).extrema(&values);
        if extrema.is_empty() {
            return;
        }
        let dense = inside.get_or_insert_with(|| window.dense());
        for at in extrema.into_iter().map(|s| part.at(s)) {
            let value = self.inside(place, dense, at);
            self.seen.points.push([at, value]);
        }
        self.seen.points.sort_by(|one, other| one[0].total_cmp(&other[0]));
    }

    /// The first change of sign in a window that counts.
    pub(super) fn change(&mut self, window: &mut Window<'_>) -> Option<Change> {
        let (begin, end) = (window.start().clone(), window.end().clone());
        let mut inside = None;
        let changes =
            (0..self.watches.len()).filter_map(|place| self.change_of(place, (window, &mut inside), [&begin, &end]));
        changes.min_by(|one, other| one.near.total_cmp(&other.near))
    }

    /// The first change of sign of one formula.
    fn change_of(&mut self, place: usize, (window, inside): Inside<'_, '_>, ends: [&State; 2]) -> Option<Change> {
        let mut sides = Sides { place, now: self.watches[place].here, before: None, is_known: self.are_known };
        // Parts still to be looked at, the next one last.
        let mut parts = vec![Part::WHOLE];
        let mut change = None;
        while let Some(part) = parts.pop() {
            self.look(place, (window, inside), ends, &part);
            if !self.seen.is_shown {
                parts.extend(part.halves());
                continue;
            }
            self.add_extrema(place, (window, inside), &part);
            change = sides.pass(&self.seen.points, self.watches[place].direction, window.length);
            if change.is_some() {
                break;
            }
        }
        self.watches[place].end = sides.now;
        change
    }

    /// Lengths next to a change of an event that acts, by the motion inside the window: there are many events, and each
    /// length that is tried is a window that is solved.
    pub(super) fn near(&mut self, change: &Change, window: &Window<'_>) -> Option<[f64; 2]> {
        let Change { place, between, side, .. } = *change;
        if !self.watches[place].acts {
            return None;
        }
        let (dense, h) = (window.dense(), window.length);
        let mut at = |length: f64| self.inside(place, &dense, length / h);
        let [low, mut high] = between;
        let mut at_high = at(high);
        let at_low = if low > 0.0 { at(low) } else { side * at_high.abs() };
        if at_low * side <= 0.0 {
            return None;
        }
        for _ in 0..MOST_TIMES_NEARER {
            if at_high * side >= 0.0 {
                return None;
            }
            let root = root([low, at_low], [high, at_high], f64::EPSILON * high, &mut at);
            if 2.0 * root > 0.5 * high || low > 0.0 {
                let room = ROOM * (root - low).min(high - low);
                return Some([root - room, (root + room).min(h)]);
            }
            high = 2.0 * root;
            at_high = at(high);
        }
        None
    }
}

/// A window, with the motion over it once that was asked for.
type Inside<'w, 'e> = (&'w mut Window<'e>, &'w mut Option<Dense>);

/// The sign of a formula on its way through a window, as far as it is known.
struct Sides {
    place: usize,
    /// The sign, 0 as long as the value was 0, and the bound that values exceed before changes count.
    now: [f64; 2],
    /// The last place, as a fraction of the window, with the value there.
    before: Option<[f64; 2]>,
    /// True if the sign at the start of the run is known.
    is_known: bool,
}

impl Sides {
    /// Goes through points in turn, up to the first change that counts.
    fn pass(&mut self, points: &[[f64; 2]], direction: Direction, h: f64) -> Option<Change> {
        let ([mut from, mut before], is_first) = (self.before.unwrap_or(points[0]), self.before.is_none());
        let [side, noise] = &mut self.now;
        if is_first && *side == 0.0 && !self.is_known {
            // The start of a run. A root there is none.
            let (now, next) = (before, points[1][1]);
            let now = if now.abs() < AT_START * next.abs() { next } else { now };
            *side = if now == 0.0 { 0.0 } else { now.signum() };
        }
        for &[to, here] in &points[1..] {
            if *noise > 0.0 {
                if here.abs() <= *noise {
                    continue;
                }
                // All before is no more than rounding.
                (*noise, before, from) = (0.0, 0.0, 0.0);
            }
            let is_change = here * *side < 0.0 || here == 0.0 && *side != 0.0;
            if is_change && direction.counts(*side < 0.0) {
                let share = if before * here < 0.0 { before / (before - here) } else { 1.0 };
                let near = h * (from + share * (to - from));
                return Some(Change { place: self.place, between: [from * h, to * h], side: *side, near });
            }
            (from, before) = (to, here);
            if here != 0.0 {
                *side = here.signum();
            }
        }
        self.before = Some([from, before]);
        None
    }
}

/// A part of a window, by the fractions at its ends.
struct Part {
    ends: [f64; 2],
    halvings: u32,
}

impl Part {
    const WHOLE: Self = Self { ends: [0.0, 1.0], halvings: 0 };

    fn is_whole(&self) -> bool {
        self.halvings == 0
    }

    /// The fraction of the window at this one of the part.
    fn at(&self, fraction: f64) -> f64 {
        let [from, to] = self.ends;
        if fraction == 1.0 { to } else { from + fraction * (to - from) }
    }

    /// Its halves, the later one first.
    fn halves(&self) -> [Self; 2] {
        let ([from, to], halvings) = (self.ends, self.halvings + 1);
        let middle = 0.5 * (from + to);
        [[middle, to], [from, middle]].map(|ends| Self { ends, halvings })
    }
}

/// Points of a part of a window at which a formula was evaluated.
#[derive(Default)]
struct Seen {
    /// Fractions of the window with the values there.
    points: Vec<[f64; 2]>,
    /// Its [arguments](Observable::arguments) there.
    arguments: Vec<f64>,
    /// True if these show what it does between them.
    is_shown: bool,
}

impl Seen {
    fn clear(&mut self) {
        self.points.clear();
        self.arguments.clear();
    }
}
