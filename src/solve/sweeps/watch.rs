//! Formulas at whose first change of sign a run ends: where it is in a window that was solved.

use crate::engine::{Accuracy, Dense, State, Touched, Window};
use crate::geometry::{Direction, Geometry, Observable};
use crate::number::Real;
use crate::number::root::root;
use crate::sbp::polynomial::{Expansion, Tables, expansion};
use crate::solve::beginning::{At, Beginning, Slack, noise, rounding};
use crate::solve::seen::Seen;
use crate::solve::setup::{Setup, Until};
use crate::solve::signs::{Along, Search, Sign, Wanted, Watched};
use crate::solve::world_line::Place;

/// The lengths next to a change are off from it by this share of its distance from the node before.
const ROOM: f64 = 1e-6;
/// A change near the start of a run is looked for in ever shorter parts of the window.
const MOST_TIMES_NEARER: usize = 60;

/// A change of sign between two lengths of the window.
pub(super) struct Change {
    /// The formula.
    pub(super) place: usize,
    pub(super) between: [f64; 2],
    /// The sign before.
    pub(super) side: f64,
    /// Values up to this are zero, if it is there that the formula comes to zero, and stays for a while.
    pub(super) none: Option<f64>,
    /// The length by a straight line between the two.
    near: f64,
}

/// A formula with what is known of its sign so far.
struct Watch {
    formula: Observable,
    direction: Direction,
    /// True if the formula belongs to an event that acts.
    acts: bool,
    /// The sign at the start of the run, at the start of the window, and at the end of the window that was looked at.
    begin: Sign<f64>,
    here: Sign<f64>,
    end: Sign<f64>,
    seen: Seen<f64>,
    touched: Touched,
}

/// The formulas, and what they read.
pub(super) struct Watches<'g> {
    inside: Inside<'g>,
    watches: Vec<Watch>,
    search: Search<f64>,
    tables: Tables<f64>,
    /// The first place in the window that was looked at where one may do what was not seen: its own, and γ.
    unseen: Option<(usize, f64)>,
    /// The same where one touches zero, nearer than this accuracy tells.
    touched: Option<(usize, f64)>,
    accuracy: f64,
}

impl<'g> Watches<'g> {
    pub(super) fn new<S: Real>(setup: &'g Setup<S>) -> Self {
        let Place { geometry, start } = &setup.rough;
        let norm = geometry.norm(&start.q, &start.q_dot);
        let watch = |(place, until): (usize, &Until<S>)| {
            let mut formula = until.rough.clone();
            let known = setup.sides.get(place).copied().unwrap_or_else(|| {
                let of_state = &mut |q: &[f64], q_dot: &[f64], p: &[f64]| formula.at(q, q_dot, p, norm);
                Beginning::new((geometry, start, f64::EPSILON), of_state, Slack::of_run(setup.reach())).known()
            });
            let begin = Sign::new(known[0], known[1]);
            let (direction, acts) = (until.direction, until.change.is_some());
            Watch {
                formula,
                direction,
                acts,
                begin,
                here: begin,
                end: begin,
                seen: Seen::default(),
                touched: Touched::default(),
            }
        };
        Self {
            watches: setup.until.iter().enumerate().map(watch).collect(),
            inside: Inside::new(geometry, norm, &start.p),
            search: Search::default(),
            tables: Tables::default(),
            unseen: None,
            touched: None,
            accuracy: setup.settings.accuracy.map_or(0.0, Accuracy::value),
        }
    }

    /// The run begins.
    pub(super) fn begin(&mut self) {
        self.watches.iter_mut().for_each(|watch| watch.here = watch.begin);
        self.inside.open.fill(0.0);
    }

    /// The window that was looked at is a part of the run, where so much is known of the formulas.
    pub(super) fn accept(&mut self, window: &Window<'_>, known: &mut Watched) {
        known.unseen = known.unseen.or(self.unseen);
        known.touched = known.touched.or(self.touched);
        known.sides.clear();
        known.sides.extend(self.watches.iter().map(|watch| watch.end.side));
        if self.watches.iter().any(|watch| watch.end.side == 0.0) {
            // What a window leaves open is open from there on.
            let Inside { geometry, dense, open, .. } = &mut self.inside;
            let dense = dense.get_or_insert_with(|| window.dense());
            open.iter_mut().enumerate().for_each(|(k, open)| *open += of_number(geometry, dense, k)[1]);
        }
        for watch in &mut self.watches {
            watch.here = watch.end;
        }
    }

    /// The value of a formula at a state.
    pub(super) fn at(&mut self, place: usize, state: &State) -> f64 {
        self.inside.set(state);
        self.inside.value(&mut self.watches[place].formula)
    }

    /// The first change of sign in a window that counts.
    pub(super) fn change(&mut self, window: &mut Window<'_>) -> Option<Change> {
        let (gamma, length, is_first) = (window.gamma, window.length, window.index == 0);
        let Self { inside, watches, search, tables, unseen, touched, accuracy } = self;
        let rule = &*expansion(tables, window.nodes().points());
        inside.see(window, watches, rule);
        let mut within = Within { inside, window };
        let (mut first, least): (Option<Change>, f64) = (None, f64::EPSILON * (gamma + length) / length);
        (*unseen, *touched) = (None, None);
        for (place, watch) in watches.iter_mut().enumerate() {
            let Watch { formula, direction, here, end, seen, touched: own, .. } = watch;
            if let Some(fraction) = own.look(&seen.places, &seen.values, *accuracy, is_first) {
                touched.get_or_insert((place, gamma + fraction * length));
            }
            let wanted = Wanted { direction: *direction, is_first: true, least, rule };
            *end = *here;
            search.begin();
            search.pass((&mut within, formula), &wanted, ([0.0, 1.0], Some(seen)), end);
            if let Some(fraction) = search.unseen {
                unseen.get_or_insert((place, gamma + fraction * length));
            }
            // What stays at zero has come to the other side as far as anyone can tell.
            let reached = end.end_window();
            let stays = reached.filter(|_| search.changes.is_empty() && direction.counts(end.goes_up()));
            let met = search.changes.first().map(|change| change.between.unwrap_or([[0.0; 2], [length, 0.0]]));
            let Some([[from, before], [to, value]]) = met.or(stays) else { continue };
            let share = if before * value < 0.0 { before / (before - value) } else { 1.0 };
            let near = length * (from + share * (to - from));
            if first.as_ref().is_none_or(|first| near < first.near) {
                let is_flat = stays.is_some() || value * end.side >= 0.0;
                let none = is_flat.then(|| within.noise(formula, to, false));
                first = Some(Change { place, between: [from * length, to * length], side: end.side, none, near });
            }
        }
        first
    }

    /// Lengths next to a change of an event that acts, by the motion inside the window: there are many events, and each
    /// length that is tried is a window that is solved.
    pub(super) fn near(&mut self, change: &Change, window: &Window<'_>) -> Option<[f64; 2]> {
        let Change { place, between, side, .. } = *change;
        let Self { inside, watches, .. } = self;
        if !watches[place].acts {
            return None;
        }
        let (h, mut within) = (window.length, Within { inside, window });
        let mut at = |length: f64| within.at(&mut watches[place].formula, length / h);
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

/// A window, and what formulas read in it.
struct Inside<'g> {
    geometry: &'g Geometry,
    at: At<'g, f64>,
    /// K of the run.
    norm: f64,
    /// q^a and then p_a of all coordinates, and p_a of active ones.
    state: Vec<f64>,
    momenta: Vec<f64>,
    /// The states at the ends of the window, and the motion over it.
    ends: [State; 2],
    dense: Option<Dense>,
    /// What windows before have left open of every number of a state.
    open: Vec<f64>,
}

impl<'g> Inside<'g> {
    fn new(geometry: &'g Geometry, norm: f64, p: &[f64]) -> Self {
        let n = p.len();
        Self {
            at: At::new(geometry),
            norm,
            state: [&vec![0.0; n], p].concat(),
            momenta: vec![0.0; geometry.active().len()],
            ends: Default::default(),
            dense: None,
            open: vec![0.0; 2 * n],
            geometry,
        }
    }

    /// Writes p_a of active coordinates into the state.
    fn set_momenta(&mut self) {
        let n = self.geometry.dimension();
        self.geometry.active().iter().zip(&self.momenta).for_each(|(&a, &p)| self.state[n + a] = p);
    }

    fn set(&mut self, state: &State) {
        self.state.iter_mut().zip(&state.q).for_each(|(to, q)| *to = q.high);
        self.momenta.iter_mut().zip(&state.p).for_each(|(to, p)| *to = p.high);
        self.set_momenta();
    }

    /// The value of a formula at the state in place.
    fn value(&mut self, formula: &mut Observable) -> f64 {
        let Self { at, norm, state, .. } = self;
        at.value(&mut |q, q_dot, p| formula.at(q, q_dot, p, *norm), state)
    }

    /// Looks at all formulas on the nodes of a window with this rule.
    fn see(&mut self, window: &mut Window<'_>, watches: &mut [Watch], rule: &Expansion<f64>) {
        self.dense = None;
        self.ends[0].clone_from(window.start());
        self.ends[1].clone_from(window.end());
        watches.iter_mut().for_each(|watch| watch.seen.clear(rule));
        let (nodes, [begin, end]) = (window.nodes(), std::mem::take(&mut self.ends));
        let last = nodes.points() - 1;
        for node in 0..=last {
            // The ends are known as they are handed on.
            match node {
                0 => self.set(&begin),
                _ if node == last => self.set(&end),
                _ => {
                    for (a, start) in begin.q.iter().enumerate() {
                        let is_active = self.geometry.active().contains(&a);
                        self.state[a] = nodes.q(a)[node] + if is_active { 0.0 } else { start.high };
                    }
                    self.momenta.iter_mut().enumerate().for_each(|(place, p)| *p = nodes.p(place)[node]);
                    self.set_momenta();
                }
            }
            let is_inside = self.at.go(&self.state);
            for Watch { formula, seen, .. } in &mut *watches {
                let norm = self.norm;
                let value = self.at.here(is_inside, &self.state, &mut |q, q_dot, p| formula.at(q, q_dot, p, norm));
                seen.see(formula, value);
            }
        }
        self.ends = [begin, end];
    }
}

/// A window that is looked into. Places are fractions of it.
struct Within<'i, 'g, 'w> {
    inside: &'i mut Inside<'g>,
    window: &'i Window<'w>,
}

impl Within<'_, '_, '_> {
    /// Puts the state at a place into place.
    fn go(&mut self, place: f64) {
        let (inside, window) = (&mut *self.inside, self.window);
        if place == 0.0 {
            return inside.set(window.start());
        }
        if place == 1.0 {
            return inside.set(window.end());
        }
        let n = inside.geometry.dimension();
        let dense = inside.dense.get_or_insert_with(|| window.dense());
        dense.at(place, &mut inside.state[..n], &mut inside.momenta);
        inside.set_momenta();
    }
}

impl Along<f64> for Within<'_, '_, '_> {
    fn at(&mut self, formula: &mut Observable, place: f64) -> f64 {
        self.go(place);
        self.inside.value(formula)
    }

    fn noise(&mut self, formula: &mut Observable, place: f64, is_open: bool) -> f64 {
        self.go(place);
        let (window, Inside { geometry, at, norm, state, dense, open, .. }) = (self.window, &mut *self.inside);
        let (dense, reads) = (dense.get_or_insert_with(|| window.dense()), formula.reads());
        let off = |k: usize, value: f64| {
            if !reads[k] {
                return 0.0;
            }
            let [change, own] = of_number(geometry, dense, k);
            rounding(value, change, f64::EPSILON) + if is_open { open[k] + own } else { 0.0 }
        };
        noise(at, &mut |q, q_dot, p| formula.at(q, q_dot, p, *norm), state, off)
    }
}

/// By how much a number of the state changes in a window at most, and what the window leaves open of it.
fn of_number(geometry: &Geometry, dense: &Dense, k: usize) -> [f64; 2] {
    let n = geometry.dimension();
    match k.checked_sub(n) {
        None => dense.extent_of_q(k),
        Some(a) => {
            let place = geometry.active().iter().position(|&active| active == a);
            place.map_or([0.0; 2], |place| dense.extent_of_p(place))
        }
    }
}
