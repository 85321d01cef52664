//! The equations of a scene for a proof: x′ = f(x) with x = (q and p of active coordinates, q of the others).
//!
//! Nothing depends on the others, so their columns of J = Df are zero. Those among them whose velocity is constant, as
//! that of t without a force on it, are left out of x, and so is s, by which Newton's law is lifted.

use super::Generator;
use super::algebras::LANES;
use crate::formula::{Program, Register, Step};
use crate::geometry::{Geometry, Hamiltonian, Source, Start};
use crate::number::Extended;
use crate::number::ball::{Ball, OFF};

/// A number of the case.
pub(super) fn number(value: Extended) -> Ball {
    Ball::of(value, OFF)
}

/// An entry of J that is not zero.
#[derive(Debug, Clone, Copy)]
pub(super) struct Entry {
    pub(super) row: usize,
    pub(super) column: usize,
    pub(super) value: Source<Extended>,
}

/// f and J as programs.
#[derive(Debug)]
pub(super) struct Equations<'g> {
    hamiltonian: &'g Hamiltonian<Extended>,
    pub(super) jacobian: &'g Program<Extended>,
    /// The number of unknowns, of which the first `active` are q and p of active coordinates.
    pub(super) unknowns: usize,
    pub(super) active: usize,
    /// The coordinate of every unknown, and whether it is its momentum.
    pub(super) of: Vec<(usize, bool)>,
    /// The first unknown that has the same unit: coordinates with the same g_aa at the start, and their momenta.
    kinds: Vec<usize>,
    /// The registers of the active unknowns, in both programs, and of f.
    pub(super) variables: Vec<Register>,
    pub(super) slopes: Vec<Register>,
    /// The steps to all of f, to ṗ and to q̇ of active coordinates, and to J.
    pub(super) all: Box<[Step]>,
    /// The steps to f and to all velocities: that of s has the potential in it, which may jump where no force shows it.
    pub(super) all_formulas: Box<[Step]>,
    pub(super) forces: Box<[Step]>,
    pub(super) velocities: Box<[Step]>,
    pub(super) of_jacobian: Box<[Step]>,
    pub(super) entries: Vec<Entry>,
    /// Momenta of ignorable coordinates, which are constants.
    momenta: Vec<(Register, Extended)>,
    /// The values of the unknowns at the start.
    pub(super) start: Vec<Extended>,
    /// What they are off by, besides `OFF`.
    off: Vec<f64>,
    /// Coordinates that move at a constant velocity.
    pub(super) steady: Vec<usize>,
    /// True if something depends on the place of a coordinate without a force along it: it jumps.
    pub(super) has_jump: bool,
}

impl<'g> Equations<'g> {
    /// From a start. Of the coordinates `unused` is no result, and the last ones are `watched`, with what their starts
    /// are off by. One is `followed`, also if it moves at a constant velocity.
    pub(super) fn new(
        geometry: &'g Geometry<Extended>,
        start: &Start<Extended>,
        [unused, followed]: [Option<usize>; 2],
        watched: &[f64],
    ) -> Self {
        let first_watched = geometry.dimension() - watched.len();
        let hamiltonian = &*geometry.hamiltonian;
        let (n, active, program) = (geometry.dimension(), geometry.active(), &hamiltonian.program);
        let is_variable = |register: Register| active.iter().any(|&a| register == a || register == 2 * n + a);
        let varies = program.depends_on(is_variable);
        let is_constant = |a: usize| a < first_watched && !varies[hamiltonian.velocities[a]];
        let is_steady = |a: usize| is_constant(a) && followed != Some(a);
        let ignorable: Vec<usize> = geometry.ignorable().collect();
        let is_kept: Vec<bool> = ignorable.iter().map(|&a| !is_steady(a) && unused != Some(a)).collect();
        let kept: Vec<usize> = ignorable.iter().zip(&is_kept).filter(|(_, kept)| **kept).map(|(&a, _)| a).collect();
        let of: Vec<(usize, bool)> = (active.iter().map(|&a| (a, false)))
            .chain(active.iter().map(|&a| (a, true)))
            .chain(kept.iter().map(|&a| (a, false)))
            .collect();
        let velocities = hamiltonian.active_velocities();
        let others = kept.iter().map(|&a| hamiltonian.velocities[a]);
        let slopes: Vec<Register> = velocities.iter().chain(&hamiltonian.forces).copied().chain(others).collect();
        let linear = hamiltonian.linearised();
        let all_formulas = || slopes.iter().chain(&hamiltonian.velocities).copied();
        let of_places = program.depends_on(|register| ignorable.contains(&register));
        let has_jump = all_formulas().any(|register| of_places[register]);
        let entries = entries(hamiltonian, &is_kept);
        let wanted = entries.iter().filter_map(|entry| match entry.value {
            Source::Row(output) => Some(linear.jacobian.output(output)),
            Source::Constant(_) => None,
        });
        Self {
            all: program.schedule(slopes.iter().copied(), |_| false),
            all_formulas: program.schedule(all_formulas().collect::<Vec<_>>(), |_| false),
            has_jump,
            forces: program.schedule(hamiltonian.forces.iter().copied(), |_| false),
            velocities: program.schedule(velocities.iter().copied(), |_| false),
            of_jacobian: linear.jacobian.schedule(wanted.collect::<Vec<_>>(), |_| false),
            jacobian: &linear.jacobian,
            entries,
            momenta: ignorable.iter().map(|&a| (2 * n + a, start.p[a])).collect(),
            variables: active.iter().copied().chain(active.iter().map(|&a| 2 * n + a)).collect(),
            off: of.iter().map(|&(a, _)| a.checked_sub(first_watched).map_or(0.0, |k| watched[k])).collect(),
            start: of.iter().map(|&(a, is_momentum)| if is_momentum { start.p[a] } else { start.q[a] }).collect(),
            steady: (ignorable.into_iter()).filter(|&a| is_steady(a) && unused != Some(a)).collect(),
            unknowns: slopes.len(),
            active: 2 * active.len(),
            kinds: kinds(&of, &geometry.diagonal(&start.q)[..results(geometry, watched.len())]),
            of,
            slopes,
            hamiltonian,
        }
    }

    /// Returns true if a coordinate moves at a constant velocity, whether something depends on it or not.
    pub(super) fn is_steady(&self, a: usize) -> bool {
        self.hamiltonian.is_steady(a)
    }

    /// Registers of the program of f, or of J, with constants in place.
    pub(super) fn registers<V: Clone>(&self, of_jacobian: bool, constant: impl Fn(Extended) -> V) -> Vec<V> {
        let program = if of_jacobian { self.jacobian } else { &self.hamiltonian.program };
        let mut registers = program.registers(&constant);
        self.momenta.iter().for_each(|&(register, p)| registers[register] = constant(p));
        registers
    }

    /// About how many operations a window takes, in units of one operation of a formula on one place. Formulas are run
    /// in balls and in discs, each as costly as some ten doubles, and the products of matrices are sums of doubles.
    pub(super) fn operations(&self) -> f64 {
        let products = self.unknowns.pow(3) / 8;
        (LANES * (self.all.len() + self.of_jacobian.len() + products)) as f64
    }

    /// The value of an entry of J among registers of its program.
    pub(super) fn value<V: Copy>(&self, entry: &Entry, registers: &[V], constant: impl Fn(Extended) -> V) -> V {
        match entry.value {
            Source::Constant(value) => constant(value),
            Source::Row(output) => registers[self.jacobian.output(output)],
        }
    }

    /// The rows of generators, one for each unknown. `None` if they change a constant on which the motion depends, or
    /// if it is not known how they change a momentum on which it does.
    pub(super) fn columns(&self, generators: &[Generator]) -> Option<Vec<Vec<f64>>> {
        let (n, program) = (self.hamiltonian.velocities.len(), &self.hamiltonian.program);
        for a in 0..n {
            let depends = program.depends_on(|register| register == 2 * n + a);
            let rates = self.steady.iter().map(|&a| self.hamiltonian.velocities[a]);
            let matters = || self.slopes.iter().copied().chain(rates.clone()).any(|slope| depends[slope]);
            let is_constant = self.momenta.iter().any(|&(register, _)| register == 2 * n + a);
            let is_bad = |generator: &Generator| generator.p[a].is_nan() || is_constant && generator.p[a] != 0.0;
            if generators.iter().any(is_bad) && matters() {
                return None;
            }
        }
        let of = |generator: &Generator, (a, is_momentum): (usize, bool)| match generator.p[a] {
            _ if !is_momentum => generator.q[a],
            unknown if unknown.is_nan() => 0.0,
            p => p,
        };
        Some(self.of.iter().map(|&at| generators.iter().map(|generator| of(generator, at)).collect()).collect())
    }

    /// The start in doubles, what that leaves of it, and a bound of the rest.
    pub(super) fn split_start(&self) -> [Vec<f64>; 3] {
        let start = self.start.iter().zip(&self.off);
        let balls: Vec<Ball> = start.map(|(&value, &off)| number(value).widened(off)).collect();
        [
            balls.iter().map(|ball| ball.hi).collect(),
            balls.iter().map(|ball| ball.lo).collect(),
            balls.iter().map(|ball| ball.rad).collect(),
        ]
    }

    /// For every unknown the largest of the sizes of its kind.
    pub(super) fn shared(&self, sizes: &[f64]) -> Vec<f64> {
        let most = |kind: &usize| {
            let same = self.kinds.iter().zip(sizes).filter(|(other, _)| *other == kind);
            same.fold(0.0_f64, |most, (_, size)| most.max(*size))
        };
        self.kinds.iter().map(most).collect()
    }
}

/// The number of coordinates that are neither unknown parameters nor formulas that are watched; they are the first.
pub(super) fn results(geometry: &Geometry<Extended>, watched: usize) -> usize {
    geometry.dimension() - watched - geometry.hamiltonian.unknown().len()
}

/// The first of the unknowns that has the unit of each: those with the same g_aa, of which there is one for each
/// coordinate that is a result.
fn kinds(of: &[(usize, bool)], diagonal: &[Extended]) -> Vec<usize> {
    let is_alike = |one: &(usize, bool), other: &(usize, bool)| {
        let both = diagonal.get(one.0).zip(diagonal.get(other.0));
        one == other || one.1 == other.1 && both.is_some_and(|(one, other)| one == other)
    };
    of.iter().map(|own| of.iter().position(|other| is_alike(own, other)).unwrap_or_default()).collect()
}

/// The entries of J, whose rows count all ignorable coordinates in the linearised equations, and here those that are
/// kept.
fn entries(hamiltonian: &Hamiltonian<Extended>, is_kept: &[bool]) -> Vec<Entry> {
    let first = 2 * hamiltonian.active.len();
    let row_of = |row: usize| match row.checked_sub(first) {
        None => Some(row),
        Some(place) => is_kept[place].then(|| first + is_kept[..place].iter().filter(|kept| **kept).count()),
    };
    let entries = hamiltonian.linearised().entries.iter();
    let kept = entries.filter_map(|of| row_of(of.row).map(|row| Entry { row, column: of.column, value: of.value }));
    kept.collect()
}
