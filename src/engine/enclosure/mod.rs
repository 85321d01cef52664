//! The look for something steep that may hide between nodes.
//!
//! The nodes know the force where they are. Its formulas say more: interval arithmetic bounds what they do on the boxes
//! that neighbouring nodes span. This is done in two stages.
//!
//! 1. In sums and products nothing hides that the polynomials of a window do not show; functions and quotients have
//!    scales of their own (see `formula::steep`). Their arguments are enclosed on all boxes. Where none changes by more
//!    than `RATIO` or `STEP` from a node to the next, the nodes see whatever they do.
//! 2. On the other boxes it is bounded what those functions and quotients, steep as they are, can do to the motion (see
//!    `influence`). If that is more than the accuracy allows, the window has not seen its force.
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
use crate::formula::{Kind, Program, Register, Steep, Step};
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

/// Largest over smallest value of a divisor between neighbouring nodes, at most. What the nodes do not see is then at
/// most so many times what they see, and they see it if their modes are small beside it. On the built-in cases with
/// smooth motion the ratio stays below.
const RATIO: f64 = 8.0;

/// The change of an argument of exp and the like, and of an angle.
const STEP: f64 = 2.0;
const ANGLE: f64 = 1.5;

/// The part of an accuracy that may come from what is too small to be seen.
pub(crate) const HIDDEN_SHARE: f64 = 0.1;

/// Rounding of what a polynomial passes through, relative to its value.
const ROUNDING: f64 = 8.0 * f64::EPSILON;

/// The variables of a program along a window.
#[derive(Debug, Default)]
pub(crate) struct Path {
    /// Number of nodes.
    points: usize,
    /// The variables that vary.
    pub variables: Vec<usize>,
    /// Their values on the nodes, row by row.
    pub values: Vec<f64>,
    /// Their second derivatives in units of the distance of two neighbouring nodes, squared.
    bends: Vec<f64>,
}

impl Path {
    /// Forgets the last window.
    pub(crate) fn begin(&mut self, points: usize) {
        self.points = points;
        self.variables.clear();
        self.values.clear();
        self.bends.clear();
    }

    /// Adds a variable by its values on the nodes and its second derivative from every node to the next, times the
    /// square of their distance.
    pub(crate) fn push(&mut self, variable: usize, values: &[f64], bend: impl Fn(usize) -> f64) {
        self.variables.push(variable);
        self.values.extend(&values[..self.points]);
        self.bends.extend((0..self.points - 1).map(bend));
    }

    /// The value of a row on a node.
    fn value(&self, row: usize, node: usize) -> f64 {
        self.values[row * self.points + node]
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
        let bends = &self.bends[row * (self.points - 1)..][..self.points - 1];
        let around = &bends[pair.saturating_sub(1)..(pair + 2).min(bends.len())];
        let largest = around.iter().fold(0.0_f64, |most, bend| most.max(bend.abs()));
        let on_chord = |at: f64| (1.0 - at) * values[0] + at * values[1];
        let ends = [on_chord(from), on_chord(to)];
        // Where the parabola is furthest from the chord.
        let middle = 0.5_f64.clamp(from, to);
        let margin = middle * (1.0 - middle) * largest + ROUNDING * values[0].abs().max(values[1].abs());
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
    /// The registers of the arguments that must not change much.
    watched: Vec<(Register, Kind)>,
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
        let Steep { program, watched } = Steep::new(program, outputs, &varies)?;
        let depends = program.depends_on(varies);
        let arguments = program.schedule(watched.iter().map(|look| look.0), |register| !depends[register]);
        let fixed = program.schedule(0..program.size(), |register| depends[register]);
        let mut enclosure = Self {
            path: Path::default(),
            watched,
            arguments,
            drive: program.schedule(0..program.size(), |register| !depends[register]),
            influence: Influence::new(&program),
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
        let is_steep =
            |k: usize| watched.iter().any(|&(register, kind)| !is_gentle(kind, enclosed.interval(register, k)));
        (0..some.len()).filter(|&k| is_steep(k)).map(|k| some[k]).collect()
    }

    /// By how much what is steep between pairs of nodes changes what drives the motion, in units of `tolerances`, pair
    /// by pair.
    fn changes(&mut self, pairs: &[usize], tolerances: &[f64]) -> impl Iterator<Item = (usize, f64)> {
        let Self { path, enclosed, drive, influence, .. } = self;
        influence.see_nodes(path, enclosed, drive);
        pairs.chunks(BOXES).flat_map(move |some| {
            enclosed.place_pairs(path, some);
            enclosed.run(drive);
            some.iter().copied().zip(influence.largest(enclosed, some, tolerances))
        })
    }
}

/// True if an argument in that interval makes nothing steep.
#[inline(always)]
pub(super) fn is_gentle(kind: Kind, [lo, hi]: [f64; 2]) -> bool {
    match kind {
        Kind::Ratio => lo > 0.0 && hi <= RATIO * lo || hi < 0.0 && -lo <= -RATIO * hi,
        Kind::Exponent | Kind::Step => hi - lo <= STEP,
        Kind::Angle => hi - lo <= ANGLE,
        Kind::Sign => lo > 0.0 || hi < 0.0,
        // No piece is left out.
        Kind::Table(table) => table.passed([lo, hi]).is_some_and(|knots| knots <= 1),
        Kind::Edge => {
            let (near, far) = (1.0 - lo.abs().max(hi.abs()), 1.0 - lo.max(-hi).max(0.0));
            near > 0.0 && far <= RATIO * near
        }
    }
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
    for state in states {
        point.jacobian(&state[..n], &state[n..], |row, column, value| {
            if row < m && column >= m {
                couplings[column - m] = couplings[column - m].max(value.abs() * weights[active[row]]);
            }
        });
    }
    let velocity = |a: usize| share / (length * weights[a]);
    let velocities = active.iter().filter(|_| !geometry.is_separable()).map(|&a| velocity(a));
    // An error of a momentum is one of velocities, for the rest of the way.
    let forces = couplings.iter().map(|coupling| share / (length * length * coupling));
    velocities.chain(forces).chain(geometry.ignorable().map(velocity)).collect()
}
