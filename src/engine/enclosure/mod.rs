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

mod boxes;
mod functions;
mod influence;
mod lanes;
mod path;
mod pieces;
mod scene;
#[cfg(test)]
mod tests;

pub(crate) use path::Path;
pub(crate) use scene::{Weights, negligible_rates};

use std::ops::Range;

use self::boxes::{BOXES, Lanes};
use self::influence::Influence;
use self::lanes::Enclose;
use crate::formula::{Kind, Program, Register, Steep, Step};
use crate::number::vector::{Level, Nodes};

/// Largest over smallest value of a divisor between neighbouring nodes, at most. What the nodes do not see is then at
/// most so many times what they see, and they see it if their modes are small beside it. On the built-in cases with
/// smooth motion the ratio stays below.
const RATIO: f64 = 8.0;

/// The change of an argument of exp and the like, and of an angle.
const STEP: f64 = 2.0;
const ANGLE: f64 = 1.5;

/// The part of an accuracy that may come from what is too small to be seen.
pub(crate) const UNSEEN: f64 = 0.1;

/// The result of a look between nodes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Found {
    /// Nothing hides.
    Nothing,
    /// Something may hide between the nodes.
    Hidden,
}

/// A program with the registers in which it is enclosed.
struct Enclosed {
    program: Program<f64>,
    registers: Vec<Lanes>,
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

    /// The bounds of a value on all boxes.
    fn register(&self, register: Register) -> (&[f64], &[f64]) {
        self.registers[register].0.split_at(BOXES)
    }

    /// Sets box `k` of a variable.
    fn set(&mut self, variable: usize, k: usize, [lo, hi]: [f64; 2]) {
        let lanes = &mut self.registers[variable].0;
        (lanes[k], lanes[BOXES + k]) = (lo, hi);
    }
}

/// Looks between the nodes of a path.
pub(crate) struct Enclosure {
    /// The path that is looked at.
    pub path: Path,
    /// The registers of the arguments that must not change much.
    watched: Vec<(Register, Kind)>,
    /// True for every register that these arguments are computed from.
    reads: Vec<bool>,
    /// The program in intervals, which all steps share.
    enclosed: Enclosed,
    /// The steps that do not depend on the path, those to what is watched, and those to all that drives the motion.
    fixed: Box<[Step]>,
    arguments: Box<[Step]>,
    drive: Box<[Step]>,
    influence: Influence,
    /// Room for pairs of nodes.
    steep: Vec<usize>,
}

impl Enclosure {
    /// For motion that the first `outputs` outputs of `program` drive, where some of its variables vary; `None` where
    /// nothing can hide.
    pub(crate) fn new(program: &Program<f64>, outputs: usize, varies: impl Fn(usize) -> bool) -> Option<Self> {
        let Steep { program, watched } = Steep::new(program, outputs, &varies)?;
        let depends = program.depends_on(varies);
        let arguments = program.schedule(watched.iter().map(|look| look.0), |register| !depends[register]);
        let mut reads = vec![false; program.size()];
        watched.iter().for_each(|look| reads[look.0] = true);
        arguments.iter().flat_map(|step| step.operation().operands()).for_each(|operand| reads[operand] = true);
        let mut enclosure = Self {
            path: Path::default(),
            watched,
            reads,
            fixed: program.schedule(0..program.size(), |register| depends[register]),
            arguments,
            drive: program.schedule(0..program.size(), |register| !depends[register]),
            influence: Influence::new(&program),
            enclosed: Enclosed::new(program),
            steep: Vec::new(),
        };
        // Registers that are computed from constants alone.
        enclosure.fix(&[]);
        Some(enclosure)
    }

    /// Sets the variables that stay.
    pub(crate) fn fix(&mut self, values: &[(usize, f64)]) {
        values.iter().for_each(|&(variable, value)| self.enclosed.registers[variable].0.fill(value));
        self.enclosed.run(&self.fixed);
    }

    /// Looks at the window that [`Self::path`] describes. Changes of what drives the motion by `tolerances` do nothing.
    pub(crate) fn look(&mut self, tolerances: impl FnOnce() -> Vec<f64>) -> Found {
        let mut steep = std::mem::take(&mut self.steep);
        steep.clear();
        self.add_steep(0..self.path.points - 1, &mut steep);
        let is_seen = steep.is_empty() || self.prove(&steep, &tolerances());
        self.steep = steep;
        if is_seen { Found::Nothing } else { Found::Hidden }
    }

    /// Adds the pairs of nodes, each named by its first node, between which an argument changes much. The boxes that
    /// are looked at first hold some pairs each.
    fn add_steep(&mut self, pairs: Range<usize>, steep: &mut Vec<usize>) {
        let groups = pairs.len().min(BOXES);
        let ends = |group: usize| pairs.start + group * pairs.len() / groups;
        let rows = 0..self.path.variables.len();
        for row in rows.filter(|&row| self.reads[self.path.variables[row]]) {
            for k in 0..BOXES {
                let group = k.min(groups - 1);
                let pieces = (ends(group)..ends(group + 1)).map(|pair| self.path.interval(row, pair));
                let hull = pieces.fold([f64::INFINITY, -f64::INFINITY], |a, b| [a[0].min(b[0]), a[1].max(b[1])]);
                self.enclosed.set(self.path.variables[row], k, hull);
            }
        }
        let flags = self.flags();
        let first = steep.len();
        steep.extend((0..groups).filter(|&group| flags[group]).flat_map(|group| ends(group)..ends(group + 1)));
        if pairs.len() == groups {
            return;
        }
        // Each of several pairs in a box is looked at by itself.
        let mut kept = first;
        for from in (first..steep.len()).step_by(BOXES) {
            let to = steep.len().min(from + BOXES);
            Self::place(&self.path, &mut self.enclosed, &steep[from..to]);
            let flags = self.flags();
            for k in (from..to).filter(|k| flags[k - from]) {
                steep[kept] = steep[k];
                kept += 1;
            }
        }
        steep.truncate(kept);
    }

    /// Which boxes have an argument that changes much.
    fn flags(&mut self) -> [bool; BOXES] {
        self.enclosed.run(&self.arguments);
        let mut flags = [false; BOXES];
        for &(register, kind) in &self.watched {
            let (lo, hi) = self.enclosed.register(register);
            for k in 0..BOXES {
                flags[k] |= !is_gentle(kind, lo[k], hi[k]);
            }
        }
        flags
    }

    /// Puts pairs of nodes into the boxes of a program; the last is repeated.
    fn place(path: &Path, to: &mut Enclosed, pairs: &[usize]) {
        for (row, &variable) in path.variables.iter().enumerate() {
            for k in 0..BOXES {
                to.set(variable, k, path.interval(row, pairs[k.min(pairs.len() - 1)]));
            }
        }
    }

    /// Bounds what is steep from node to node by what it does to the motion. Whether that is nothing.
    fn prove(&mut self, pairs: &[usize], tolerances: &[f64]) -> bool {
        let Self { path, enclosed, drive, influence, .. } = self;
        influence.see_nodes(path, enclosed, drive);
        pairs.chunks(BOXES).all(|some| {
            Self::place(path, enclosed, some);
            enclosed.run(drive);
            influence.largest(enclosed, some, tolerances)[..some.len()].iter().all(|&bound| bound <= 1.0)
        })
    }
}

/// True if an argument in that interval makes nothing steep.
#[inline(always)]
pub(super) fn is_gentle(kind: Kind, lo: f64, hi: f64) -> bool {
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
