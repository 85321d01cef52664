//! Formulas at whose first change of sign a run ends.

use crate::engine::{State, Window};
use crate::geometry::{Direction, Geometry, Observable, Point, Start};
use crate::solve::setup::Until;

/// A value at the start of a run counts as zero if it is this part of that at the next node.
const AT_START: f64 = 1e-6;

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

/// The formulas, with their signs so far.
pub(super) struct Watches<'g> {
    geometry: &'g Geometry,
    formulas: Vec<Observable>,
    directions: Vec<Direction>,
    /// Signs at the start of the window, and at the end of the one that was looked at; 0 as long as a value was 0.
    sides: Vec<f64>,
    sides_at_end: Vec<f64>,
    /// K of the run, and what formulas read: q^a and p_a of all coordinates, and velocities.
    norm: f64,
    point: Point,
    q: Vec<f64>,
    q_dot: Vec<f64>,
    p: Vec<f64>,
}

impl<'g> Watches<'g> {
    pub(super) fn new<S>(geometry: &'g Geometry, start: &Start, until: &[Until<S>]) -> Self {
        Self {
            formulas: until.iter().map(|until| until.rough.clone()).collect(),
            directions: until.iter().map(|until| until.direction).collect(),
            sides: vec![0.0; until.len()],
            sides_at_end: vec![0.0; until.len()],
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
        self.sides.fill(0.0);
    }

    /// The window that was looked at is a part of the run.
    pub(super) fn accept(&mut self) {
        self.sides.copy_from_slice(&self.sides_at_end);
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
        let Self { formulas, norm, point, q, q_dot, p, .. } = self;
        if point.evaluate(q, p).is_err() {
            return f64::NAN;
        }
        q_dot.iter_mut().enumerate().for_each(|(a, q_dot)| *q_dot = point.q_dot(a));
        formulas[place].at(q, q_dot, p, *norm)
    }

    /// The first change of sign on the nodes of a window that counts.
    pub(super) fn change(&mut self, window: &mut Window<'_>) -> Option<Change> {
        if self.formulas.is_empty() {
            return None;
        }
        let (h, begin, end) = (window.length, window.start().clone(), window.end().clone());
        let nodes = window.nodes();
        let last = nodes.points() - 1;
        let mut first: Option<Change> = None;
        for place in 0..self.formulas.len() {
            let at = |watches: &mut Self, node: usize| {
                if node == last {
                    return watches.at(place, &end);
                }
                for a in 0..watches.q.len() {
                    let is_active = watches.geometry.active().contains(&a);
                    watches.q[a] = nodes.q(a)[node] + if is_active { 0.0 } else { begin.q[a].high };
                }
                let momenta: Vec<f64> = (0..begin.p.len()).map(|place| nodes.p(place)[node]).collect();
                watches.set_momenta(&momenta);
                watches.value(place)
            };
            let (mut side, mut before) = (self.sides[place], self.at(place, &begin));
            if side == 0.0 {
                // The start of a run. A root there is none.
                let (now, next) = (before, at(self, 1));
                let now = if now.abs() < AT_START * next.abs() { next } else { now };
                side = if now == 0.0 { 0.0 } else { now.signum() };
            }
            for node in 1..=last {
                let here = at(self, node);
                let is_change = here * side < 0.0 || here == 0.0 && side != 0.0;
                if is_change && self.directions[place].counts(side < 0.0) {
                    let between = [node - 1, node].map(|node| nodes.fractions()[node] * h);
                    let share = if before * here < 0.0 { before / (before - here) } else { 1.0 };
                    let near = between[0] + share * (between[1] - between[0]);
                    if first.as_ref().is_none_or(|first| near < first.near) {
                        first = Some(Change { place, between, side, near });
                    }
                    break;
                }
                before = here;
                if here != 0.0 {
                    side = here.signum();
                }
            }
            self.sides_at_end[place] = side;
        }
        first
    }
}
