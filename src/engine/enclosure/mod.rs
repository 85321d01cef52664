//! The look for something steep that may hide between nodes.
//!
//! The nodes know the force where they are. Its formulas say more: interval arithmetic bounds what they do on the boxes
//! that neighbouring nodes span. This is done in two stages.
//!
//! 1. In sums and products nothing hides that the polynomials of a window do not show; functions and quotients have
//!    scales of their own (see `formula::steep`). Their arguments are enclosed on all boxes. Where none changes much
//!    from a node to the next, the nodes see whatever they do.
//! 2. On the other boxes it is bounded what those functions and quotients, steep as they are, can do to the motion (see
//!    `influence`). If that is more than the accuracy allows, the window has not seen its force.
//!
//! A kink or a jump is seen if the argument that makes it changes its sign once on the way, and no other one does: of
//! two at once the nodes show the sum.
//!
//! A march asks whether this holds for a window, which it can shorten. Of a run on a given grid every pair of nodes is
//! asked for what it may hide (see `pieces`).

mod arithmetic;
mod influence;
mod pieces;
#[cfg(test)]
mod tests;

use self::arithmetic::Enclose;
use self::influence::Influence;
use crate::formula::{Kind, Program, Register, Steep, Step, Watched, turn};
use crate::geometry::Geometry;
use crate::number::vector::{Level, Nodes};

/// The number of boxes that are looked at side by side.
const BOXES: usize = 8;

/// An interval for each box: the lower bounds, then the upper ones.
type Intervals = Nodes<{ 2 * BOXES }>;

/// Relative to the result v, more than arithmetic rounds: |v| 2⁻⁵² is at least the distance from v to the next number
/// outwards, and what was rounded is half of that distance at most.
const ROUNDS: f64 = f64::EPSILON;

/// More than numbers next to 0 are rounded.
const TINY: f64 = f64::MIN_POSITIVE;

/// The part of an accuracy that may come from what is too small to be seen.
pub(crate) const HIDDEN_SHARE: f64 = 0.1;

/// Rounding of what a polynomial passes through, relative to its value.
const ROUNDING: f64 = 8.0 * f64::EPSILON;

/// The variables of a program along a window.
#[derive(Debug, Default)]
pub(crate) struct Path {
    /// The places of its nodes.
    nodes: Vec<f64>,
    /// The variables that vary.
    pub variables: Vec<usize>,
    /// Their values on the nodes, row by row.
    pub values: Vec<f64>,
    /// Their second derivatives in units of the distance of two neighbouring nodes, squared.
    bends: Vec<f64>,
}

impl Path {
    /// Forgets the last window, for one with these nodes.
    pub(crate) fn begin(&mut self, nodes: &[f64]) {
        self.nodes.clear();
        self.nodes.extend(nodes);
        self.variables.clear();
        self.values.clear();
        self.bends.clear();
    }

    /// Adds a variable by its values on the nodes and its second derivative from every node to the next, times the
    /// square of their distance.
    pub(crate) fn push(&mut self, variable: usize, values: &[f64], bend: impl Fn(usize) -> f64) {
        self.variables.push(variable);
        self.values.extend(&values[..self.points()]);
        self.bends.extend((0..self.points() - 1).map(bend));
    }

    /// The number of nodes.
    fn points(&self) -> usize {
        self.nodes.len()
    }

    /// The value of a row on a node.
    fn value(&self, row: usize, node: usize) -> f64 {
        self.values[row * self.points() + node]
    }

    /// The interval of a row from node `pair` to the next.
    fn interval(&self, row: usize, pair: usize) -> [f64; 2] {
        self.piece(row, pair, [0.0, 1.0])
    }

    /// The interval of a row on a part of the way from node `pair` to the next, by its ends as fractions of that way.
    ///
    /// Between two nodes the variable is taken for the parabola with the bend between them, which leaves a chord by at
    /// most an eighth of the bend. As bends change from pair to pair, twice that is allowed, with the largest bend of
    /// this pair and its neighbours.
    fn piece(&self, row: usize, pair: usize, [from, to]: [f64; 2]) -> [f64; 2] {
        let values = [pair, pair + 1].map(|node| self.value(row, node));
        let bends = &self.bends[row * (self.points() - 1)..][..self.points() - 1];
        let around = &bends[pair.saturating_sub(1)..(pair + 2).min(bends.len())];
        let largest = around.iter().fold(0.0_f64, |most, bend| most.max(bend.abs()));
        let on_chord = |at: f64| (1.0 - at) * values[0] + at * values[1];
        let ends = [on_chord(from), on_chord(to)];
        // Where the parabola is furthest from the chord.
        let middle = 0.5_f64.clamp(from, to);
        // What rests is not rounded.
        let rounding = if values[0] == values[1] { 0.0 } else { ROUNDING * values[0].abs().max(values[1].abs()) };
        let margin = middle * (1.0 - middle) * largest + rounding;
        [ends[0].min(ends[1]) - margin, ends[0].max(ends[1]) + margin]
    }
}

/// A program with the registers in which it is enclosed.
struct Enclosed {
    program: Program<f64>,
    registers: Vec<Intervals>,
}

impl Enclosed {
    fn new(program: Program<f64>) -> Self {
        let registers = program.registers(|constant| Nodes([constant; 2 * BOXES]));
        Self { program, registers }
    }

    /// Encloses what these steps compute.
    fn run(&mut self, steps: &[Step]) {
        Level::Best.dispatch(Enclose { steps, registers: &mut self.registers });
    }

    /// The bounds of a value on box `k`.
    fn interval(&self, register: Register, k: usize) -> [f64; 2] {
        let lanes = &self.registers[register].0;
        [lanes[k], lanes[BOXES + k]]
    }

    /// Sets box `k` of a variable.
    fn set(&mut self, variable: usize, k: usize, [lo, hi]: [f64; 2]) {
        let lanes = &mut self.registers[variable].0;
        (lanes[k], lanes[BOXES + k]) = (lo, hi);
    }

    /// Sets the boxes of all variables of a path by its rows.
    fn place(&mut self, path: &Path, interval: impl Fn(usize, usize) -> [f64; 2]) {
        for (row, &variable) in path.variables.iter().enumerate() {
            (0..BOXES).for_each(|k| self.set(variable, k, interval(row, k)));
        }
    }

    /// Sets the boxes to those of pairs of nodes; the last is repeated.
    fn place_pairs(&mut self, path: &Path, pairs: &[usize]) {
        self.place(path, |row, k| path.interval(row, pairs[k.min(pairs.len() - 1)]));
    }
}

/// Looks between the nodes of a path.
pub(crate) struct Enclosure {
    /// The path that is looked at.
    pub path: Path,
    /// The values that must not change much, and their intervals on the nodes, once they were looked at.
    watched: Vec<Watched>,
    seen: Vec<Vec<[f64; 2]>>,
    /// The program in intervals, which all steps share.
    enclosed: Enclosed,
    /// The steps to what is watched, and those to all that drives the motion.
    arguments: Box<[Step]>,
    drive: Box<[Step]>,
    influence: Influence,
}

impl Enclosure {
    /// For Hamilton's equations of a scene, of which only the momenta of ignorable coordinates are read; `None` where
    /// nothing can hide. Variables of its path are q^a and, from 2n on, p_a of active coordinates.
    pub(crate) fn of_geometry(geometry: &Geometry, momenta: &[f64]) -> Option<Self> {
        let (n, active) = (geometry.dimension(), geometry.active());
        let varies = |variable: usize| active.contains(&variable) || active.iter().any(|a| 2 * n + a == variable);
        // Velocities of active coordinates are outputs of their own, unless momenta say the same.
        let outputs = if geometry.is_separable() { n } else { n + active.len() };
        Self::new(&geometry.hamiltonian.program, outputs, varies, (2 * n..).zip(momenta))
    }

    /// For motion that the first `outputs` outputs of `program` drive, where some of its variables vary, and others
    /// have values; `None` where nothing can hide.
    fn new<'v>(
        program: &Program<f64>,
        outputs: usize,
        varies: impl Fn(usize) -> bool,
        values: impl Iterator<Item = (usize, &'v f64)>,
    ) -> Option<Self> {
        let Steep { program, watched, causes } = Steep::new(program, outputs, &varies)?;
        let depends = program.depends_on(varies);
        let arguments = program.schedule(watched.iter().map(|look| look.register), |register| !depends[register]);
        let fixed = program.schedule(0..program.size(), |register| depends[register]);
        let mut enclosure = Self {
            path: Path::default(),
            seen: vec![Vec::new(); watched.len()],
            watched,
            arguments,
            drive: program.schedule(0..program.size(), |register| !depends[register]),
            influence: Influence::new(&program, causes),
            enclosed: Enclosed::new(program),
        };
        values.for_each(|(variable, &value)| enclosure.enclosed.registers[variable].0.fill(value));
        enclosure.enclosed.run(&fixed);
        Some(enclosure)
    }

    /// Those of some pairs of nodes, each named by its first node, between which an argument changes much.
    fn steep(&mut self, some: &[usize]) -> Vec<usize> {
        let Self { path, watched, enclosed, arguments, .. } = self;
        enclosed.place_pairs(path, some);
        enclosed.run(arguments);
        let is_steep = |k: usize| watched.iter().any(|look| !look.is_gentle(enclosed.interval(look.register, k)));
        (0..some.len()).filter(|&k| is_steep(k)).map(|k| some[k]).collect()
    }

    /// Looks at what is watched on the nodes.
    fn see_nodes(&mut self) {
        let Self { path, watched, seen, enclosed, arguments, .. } = self;
        seen.iter_mut().for_each(Vec::clear);
        for first in (0..path.points()).step_by(BOXES) {
            let node = |k: usize| (first + k).min(path.points() - 1);
            enclosed.place(path, |row, k| [path.value(row, node(k)); 2]);
            enclosed.run(arguments);
            for (look, seen) in watched.iter().zip(&mut *seen) {
                seen.extend((0..BOXES).map(|k| enclosed.interval(look.register, k)));
            }
        }
    }

    /// By how much what is steep between pairs of nodes changes what drives the motion, in units of `tolerances`, pair
    /// by pair.
    fn changes(&mut self, pairs: &[usize], tolerances: &[f64]) -> Vec<Hidden> {
        let mut found = Vec::with_capacity(pairs.len());
        for some in pairs.chunks(BOXES) {
            self.enclosed.place_pairs(&self.path, some);
            self.enclosed.run(&self.drive);
            let steep: Vec<Vec<bool>> = some.iter().enumerate().map(|(k, &pair)| self.steep_between(pair, k)).collect();
            let changes = self.influence.largest(&self.enclosed, &steep, tolerances);
            found.extend(some.iter().zip(&steep).zip(changes).map(|((&pair, steep), change)| {
                let mut steep = self.watched.iter().zip(steep).filter(|(_, is_steep)| **is_steep);
                let is_kink = |(look, _): (&Watched, &bool)| matches!(look.kind, Kind::Side(_));
                let (is_kink_alone, has_kink) = (steep.clone().all(is_kink), steep.any(is_kink));
                Hidden { pair, change, has_kink, is_kink_alone }
            }));
        }
        found
    }

    /// Which of what is watched hides something on the way from node `pair` to the next, which box `k` is.
    fn steep_between(&self, pair: usize, k: usize) -> Vec<bool> {
        let hides = |(place, look): (usize, &Watched)| {
            let interval = self.enclosed.interval(look.register, k);
            let ends = [pair, pair + 1].map(|node| middle(self.seen[place][node]));
            let is_seen = matches!(look.kind, Kind::Side(_)) && self.shows_side(place, pair, k);
            !(is_seen || look.is_gentle_between(interval, ends))
        };
        self.watched.iter().enumerate().map(hides).collect()
    }

    /// Returns true if the nodes show whatever a change of sign of this argument makes on the way from node `pair` to
    /// the next, which box `k` is: there is none, or one and no other argument changes its sign. The nodes tell only of
    /// arguments that are smooth: one may have another one's kink in it, as in step(w − |t|), and where that is on the
    /// way its interval tells.
    fn shows_side(&self, place: usize, pair: usize, k: usize) -> bool {
        let mut others = (0..self.watched.len()).filter(|&other| {
            let is_side = matches!(self.watched[other].kind, Kind::Side(_));
            is_side && other != place && !self.is_multiple(place, other, pair)
        });
        match self.sign_changes(place, pair) {
            Some(0) => {
                let has_no_kink = |other| self.keeps_side(other, k) || self.sign_changes(other, pair) == Some(0);
                self.keeps_side(place, k) || others.all(has_no_kink)
            }
            Some(_) => others.all(|other| self.keeps_side(other, k)),
            None => self.keeps_side(place, k),
        }
    }

    /// True if all of box `k` is on one side of a kink or a jump, or if its argument has one value there.
    fn keeps_side(&self, place: usize, k: usize) -> bool {
        let look = &self.watched[place];
        let interval = self.enclosed.interval(look.register, k);
        look.is_gentle(interval) || interval[0] == interval[1]
    }

    /// How often an argument changes its sign on the way from node `pair` to the next, if it does not turn there.
    fn sign_changes(&self, place: usize, pair: usize) -> Option<usize> {
        let seen = &self.seen[place];
        let value = |node: usize| middle(seen[node]);
        let [a, b] = [value(pair), value(pair + 1)];
        let curvature = bent(&self.path.nodes, value, pair);
        // A parabola that turns between the nodes bends by twice as much as it changes, at least.
        if (b - a).abs() > curvature {
            return Some(usize::from((a < 0.0) != (b < 0.0)));
        }
        (a.abs().min(b.abs()) > 0.25 * curvature && (a < 0.0) == (b < 0.0)).then_some(0)
    }

    /// Returns true if one argument is a multiple of another one there: their signs change at one place.
    fn is_multiple(&self, one: usize, other: usize, pair: usize) -> bool {
        let value = |place: usize, node: usize| middle(self.seen[place][node]);
        let products = [value(one, pair) * value(other, pair + 1), value(one, pair + 1) * value(other, pair)];
        (products[0] - products[1]).abs() <= ROUNDING * products[0].abs()
    }
}

/// What may hide between two nodes, the first of which is `pair`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Hidden {
    pub(crate) pair: usize,
    /// By how much it changes what drives the motion, in units of what is tolerated on all of the way.
    pub(crate) change: f64,
    /// True if an argument of abs, sign or step may change its sign unseen there.
    pub(crate) has_kink: bool,
    /// True if that is all.
    pub(crate) is_kink_alone: bool,
}

fn middle([lo, hi]: [f64; 2]) -> f64 {
    0.5 * lo + 0.5 * hi
}

/// By how much a value that is this on the nodes bends from node `pair` to the next: its second derivative times the
/// square of their distance, from the nodes around them.
fn bent(nodes: &[f64], value: impl Fn(usize) -> f64, pair: usize) -> f64 {
    let distance = nodes[pair + 1] - nodes[pair];
    let around = pair.saturating_sub(1)..(pair + 1).min(nodes.len() - 2);
    let bends = around.map(|k| turn([k, k + 1, k + 2].map(|k| nodes[k]), [k, k + 1, k + 2].map(&value)));
    bends.fold(0.0, f64::max) * distance * distance
}

/// By how much rates may change on all of the way, `length`, without moving a coordinate by more than a `share` of its
/// size, in the order of the program's outputs. `weights` are one over the size of every coordinate. Momenta count by
/// what they make of velocities in `states`, each of them q^a and then p_a of all coordinates.
pub(crate) fn tolerated_rates<'s>(
    geometry: &Geometry,
    weights: &[f64],
    states: impl IntoIterator<Item = &'s [f64]>,
    length: f64,
    share: f64,
) -> Vec<f64> {
    let (n, active, m) = (geometry.dimension(), geometry.active(), geometry.active().len());
    let (mut point, mut couplings) = (geometry.point(), vec![0.0_f64; m]);
    // Where nothing is known of a size, nothing is small.
    let weight = |a: usize| if weights[a] > 0.0 { weights[a] } else { f64::INFINITY };
    for state in states {
        point.jacobian(&state[..n], &state[n..], |row, column, value| {
            if row < m && column >= m && value != 0.0 {
                couplings[column - m] = couplings[column - m].max(value.abs() * weight(active[row]));
            }
        });
    }
    let velocity = |a: usize| share / (length * weight(a));
    let velocities = active.iter().filter(|_| !geometry.is_separable()).map(|&a| velocity(a));
    // An error of a momentum is one of velocities, for the rest of the way.
    let forces = couplings.iter().map(|coupling| share / (length * length * coupling));
    velocities.chain(forces).chain(geometry.ignorable().map(velocity)).collect()
}
