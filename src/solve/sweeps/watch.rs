//! Formulas at whose first change of sign a run ends.

use crate::engine::{Dense, State, Window, WindowNodes};
use crate::geometry::{Direction, Geometry, Observable, Point};
use crate::number::root::root;
use crate::solve::setup::Until;
use crate::solve::world_line::Place;

/// A value at the start of a run counts as zero if it is this part of that at the next node.
const AT_START: f64 = 1e-6;
/// A parabola through three nodes comes near to zero if its extremum is below this share of the least of its values.
const NEAR_ZERO: f64 = 0.5;
/// The lengths next to a change are off from it by this share of its distance from the node before.
const ROOM: f64 = 1e-6;
/// A change near the start of a run is looked for in ever shorter parts of the window.
const MOST_TIMES_NEARER: usize = 60;
/// Parts of a window are halved so many times at most where their points do not show a formula.
const MOST_HALVINGS: u32 = 16;
/// Parabolas through ever closer points that look for the extremum: their error falls like its power 1.3.
const STEPS_TO_EXTREMUM: usize = 16;

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
        self.set_momenta(&state.momenta());
        self.value(place)
    }

    fn set_momenta(&mut self, momenta: &[f64]) {
        self.geometry.active().iter().zip(momenta).for_each(|(&a, &p)| self.p[a] = p);
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
        let mut momenta = vec![0.0; self.geometry.active().len()];
        dense.at(fraction, &mut self.q, &mut momenta);
        self.set_momenta(&momenta);
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
        let momenta: Vec<f64> = (0..begin.p.len()).map(|place| nodes.p(place)[node]).collect();
        self.set_momenta(&momenta);
        self.value(place)
    }

    /// A formula at points of a window with these ends, each with its fraction: at the nodes, and where its arguments
    /// change much from one to the next, at more of them.
    fn points(&mut self, place: usize, window: &mut Window<'_>, ends: [&State; 2]) -> Vec<[f64; 2]> {
        let nodes = window.nodes();
        let fractions = nodes.fractions().to_vec();
        let mut arguments = Vec::new();
        let mut points: Vec<[f64; 2]> = Vec::with_capacity(fractions.len());
        for (node, &fraction) in fractions.iter().enumerate() {
            let value = if node == 0 { self.at(place, ends[0]) } else { self.at_node(place, nodes, ends, node) };
            points.push([fraction, value]);
            arguments.extend(self.watches[place].formula.arguments());
        }
        if self.watches[place].formula.is_shown(&fractions, &arguments) {
            return points;
        }
        let (dense, last) = (window.dense(), points[points.len() - 1]);
        points.truncate(1);
        let mut cells = vec![([0.5, 1.0], 1), ([0.0, 0.5], 1)];
        while let Some(([from, to], halvings)) = cells.pop() {
            arguments.clear();
            let inner: Vec<[f64; 2]> = fractions
                .iter()
                .map(|fraction| {
                    let at = from + fraction * (to - from);
                    let value = self.inside(place, &dense, at);
                    arguments.extend(self.watches[place].formula.arguments());
                    [at, value]
                })
                .collect();
            if halvings < MOST_HALVINGS && !self.watches[place].formula.is_shown(&fractions, &arguments) {
                let middle = 0.5 * (from + to);
                cells.extend([[middle, to], [from, middle]].map(|half| (half, halvings + 1)));
            } else {
                points.extend(&inner[1..]);
            }
        }
        // The end is known as it is handed on.
        points.pop();
        points.push(last);
        points
    }

    /// The first change of sign on the nodes of a window that counts.
    pub(super) fn change(&mut self, window: &mut Window<'_>) -> Option<Change> {
        let (h, begin, end) = (window.length, window.start().clone(), window.end().clone());
        let (mut first, mut dips): (Option<Change>, Vec<Dip>) = (None, Vec::new());
        for place in 0..self.watches.len() {
            let points = self.points(place, window, [&begin, &end]);
            let ([mut side, mut noise], mut before) = (self.watches[place].here, points[0][1]);
            if side == 0.0 && !self.are_known {
                // The start of a run. A root there is none.
                let (now, next) = (before, points[1][1]);
                let now = if now.abs() < AT_START * next.abs() { next } else { now };
                side = if now == 0.0 { 0.0 } else { now.signum() };
            }
            let mut earlier = [f64::NAN; 2];
            for pair in points.windows(2) {
                let ([mut from, _], [to, here]) = (pair[0], pair[1]);
                if noise > 0.0 {
                    if here.abs() <= noise {
                        continue;
                    }
                    // All before is no more than rounding.
                    (noise, before, from) = (0.0, 0.0, 0.0);
                }
                let is_change = here * side < 0.0 || here == 0.0 && side != 0.0;
                if is_change && self.watches[place].direction.counts(side < 0.0) {
                    let share = if before * here < 0.0 { before / (before - here) } else { 1.0 };
                    let near = h * (from + share * (to - from));
                    if first.as_ref().is_none_or(|first| near < first.near) {
                        first = Some(Change { place, between: [from * h, to * h], side, near });
                    }
                    break;
                }
                let dip = Dip { place, points: [earlier, [from, before], [to, here]], side };
                dips.extend((!is_change && dip.comes_near()).then_some(dip));
                earlier = [from, before];
                before = here;
                if here != 0.0 {
                    side = here.signum();
                }
            }
            self.watches[place].end = [side, noise];
        }
        if dips.is_empty() {
            return first;
        }
        let dense = window.dense();
        let changes = dips.into_iter().filter_map(|dip| self.change_in(dip, &dense, h));
        first.into_iter().chain(changes).min_by(|one, other| one.near.total_cmp(&other.near))
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

    /// The change of sign that counts between nodes at which a formula has one sign.
    fn change_in(&mut self, mut dip: Dip, dense: &Dense, h: f64) -> Option<Change> {
        let (place, side) = (dip.place, dip.side);
        let [first, .., last] = dip.points.map(|point| point[0]);
        let lowest = (0..STEPS_TO_EXTREMUM).find_map(|_| {
            let [at, _] = dip.extremum()?;
            let here = self.inside(place, dense, at);
            dip.narrow([at, here]);
            (here * side < 0.0).then_some(at)
        })?;
        let is_first = self.watches[place].direction.counts(side < 0.0);
        let (ends, side) = if is_first { ([first, lowest], side) } else { ([lowest, last], -side) };
        let between = ends.map(|fraction| fraction * h);
        Some(Change { place, between, side, near: between[0] })
    }
}

/// Three points at which a formula has one sign, where a parabola comes near to zero between them.
struct Dip {
    place: usize,
    points: [[f64; 2]; 3],
    side: f64,
}

impl Dip {
    /// Where the parabola is nearest to zero, if that is between the points, and how far it is from zero there.
    fn extremum(&self) -> Option<[f64; 2]> {
        let [[a, at_a], [b, at_b], [c, at_c]] = self.points;
        let [left, right] = [(at_b - at_a) / (b - a), (at_c - at_b) / (c - b)];
        let curvature = (right - left) / (c - a);
        let at = 0.5 * (a + b) - 0.5 * left / curvature;
        let lowest = self.side * (at_a + left * (at - a) + curvature * (at - a) * (at - b));
        (curvature * self.side > 0.0 && at > a && at < c).then_some([at, lowest])
    }

    /// Returns true if the parabola is much nearer to zero there than at the points, which are all on one side.
    fn comes_near(&self) -> bool {
        // Behind a zero at which a run goes on, the side that it goes on to may be left before the next point.
        if !self.points.iter().all(|[_, value]| value * self.side > 0.0) {
            return false;
        }
        let least = self.points.iter().fold(f64::INFINITY, |least, [_, value]| least.min(value.abs()));
        self.extremum().is_some_and(|[_, lowest]| lowest < NEAR_ZERO * least)
    }

    /// Takes in the value at another place between the points.
    fn narrow(&mut self, point: [f64; 2]) {
        let [low, middle, high] = &mut self.points;
        let is_lower = (point[1] - middle[1]) * self.side < 0.0;
        match (is_lower, point[0] < middle[0]) {
            (true, true) => (*high, *middle) = (*middle, point),
            (true, false) => (*low, *middle) = (*middle, point),
            (false, true) => *low = point,
            (false, false) => *high = point,
        }
    }
}
