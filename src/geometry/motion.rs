//! Hamilton's equations on the nodes of a window, a block of nodes at a time.

use std::ops::Range;
use std::sync::Arc;

use super::hamiltonian::Hamiltonian;
use super::{Geometry, OutsideGeometry};
use crate::formula::{BLOCK, MOST_LOST, Register};
use crate::number::Real;

/// The rates of positions and momenta, q̇^a = g^ab (p_b − A_b), ṗ_a = f_a + F_a, where only active coordinates and
/// their momenta are unknowns: the momenta of ignorable ones are constants, which `start` has.
#[derive(Debug)]
pub struct Motion<S> {
    hamiltonian: Arc<Hamiltonian<S>>,
    signs: Vec<S>,
    /// The registers of a block of nodes: of the equations, and of their linearisation.
    rates: Vec<[S; BLOCK]>,
    linearised: Vec<[S; BLOCK]>,
    /// The nodes whose linearised equations stand there.
    nodes: Range<usize>,
    /// q̇^a of ignorable coordinates on the nodes, where rates were computed last.
    ignorable: Vec<Vec<S>>,
}

/// Positions of all coordinates and momenta of active ones on the nodes, and momenta of all at the start.
#[derive(Debug, Clone, Copy)]
pub struct OnNodes<'n, S> {
    /// q^a, a row for each coordinate.
    pub q: &'n [Vec<S>],
    /// p_a, a row for each active coordinate.
    pub p: &'n [Vec<S>],
    /// p_a of all coordinates at the start.
    pub start: &'n [S],
}

impl<S: Real> OnNodes<'_, S> {
    /// Puts a block of nodes into registers.
    fn put(&self, active: &[usize], nodes: Range<usize>, registers: &mut [[S; BLOCK]]) {
        let n = self.q.len();
        for (a, &p) in self.start.iter().enumerate() {
            registers[2 * n + a] = [p; BLOCK];
        }
        for (place, &a) in active.iter().enumerate() {
            registers[a][..nodes.len()].copy_from_slice(&self.q[a][nodes.clone()]);
            registers[2 * n + a][..nodes.len()].copy_from_slice(&self.p[place][nodes.clone()]);
        }
    }
}

impl<S: Real> Motion<S> {
    /// Room for all that is computed here.
    pub(super) fn new(geometry: &Geometry<S>) -> Self {
        let hamiltonian = Arc::clone(&geometry.hamiltonian);
        Self {
            rates: hamiltonian.program.registers(|constant| [constant; BLOCK]),
            linearised: Vec::new(),
            nodes: 0..0,
            ignorable: vec![Vec::new(); geometry.ignorable().count()],
            hamiltonian,
            signs: geometry.signs.clone(),
        }
    }

    /// Computes the rates of active coordinates on all nodes, and writes rows of q̇, then rows of ṗ, into `out`.
    ///
    /// # Errors
    /// The first node that is outside the domain.
    pub fn rates(&mut self, on: OnNodes<'_, S>, out: &mut [Vec<S>]) -> Result<(), OutsideGeometry> {
        self.sweep(on, on.q.first().map_or(0, Vec::len), out)
    }

    /// Computes the rates of ignorable coordinates on the first nodes, a row for each.
    ///
    /// # Errors
    /// The first node that is outside the domain.
    pub fn ignorable_rates(&mut self, on: OnNodes<'_, S>, points: usize) -> Result<&[Vec<S>], OutsideGeometry> {
        self.sweep(on, points, &mut [])?;
        Ok(&self.ignorable)
    }

    /// Computes all rates on the first nodes, and writes those of active coordinates into as many rows as there are.
    fn sweep(&mut self, on: OnNodes<'_, S>, points: usize, out: &mut [Vec<S>]) -> Result<(), OutsideGeometry> {
        let (hamiltonian, mut chances) = (Arc::clone(&self.hamiltonian), MOST_LOST);
        let (own, others) = (hamiltonian.active_velocities(), hamiltonian.ignorable_velocities());
        self.nodes = 0..0;
        self.ignorable.iter_mut().for_each(|row| row.resize(points, S::ZERO));
        for first in (0..points).step_by(BLOCK) {
            let nodes = first..points.min(first + BLOCK);
            on.put(&hamiltonian.active, nodes.clone(), &mut self.rates);
            hamiltonian.program.run_block(hamiltonian.point, nodes.len(), &mut self.rates, &mut chances);
            self.check(nodes.clone())?;
            let take = |row: &mut Vec<S>, register: Register| {
                row[nodes.clone()].copy_from_slice(&self.rates[register][..nodes.len()]);
            };
            out.iter_mut().zip(own.iter().chain(&hamiltonian.forces)).for_each(|(row, &register)| take(row, register));
            self.ignorable.iter_mut().zip(&others).for_each(|(row, &register)| take(row, register));
        }
        Ok(())
    }

    /// Looks whether a block of nodes is inside the domain.
    fn check(&self, nodes: Range<usize>) -> Result<(), OutsideGeometry> {
        let Hamiltonian { velocities, forces, determinants, .. } = &*self.hamiltonian;
        let is_good = |register: &usize, is_good: &dyn Fn(S) -> bool| {
            self.rates[*register][..nodes.len()].iter().fold(true, |all, &value| all & is_good(value))
        };
        let is_finite = velocities.iter().chain(forces).all(|register| is_good(register, &|value| value.is_finite()));
        let mut blocks = determinants.iter().zip(&self.signs);
        if is_finite && blocks.all(|(block, &sign)| is_good(block, &|value| !super::is_outside(value, sign))) {
            return Ok(());
        }
        let mut values = nodes.zip(0..);
        values.try_for_each(|(node, k)| self.hamiltonian.check(&self.signs, node, |register| self.rates[register][k]))
    }

    /// The rates of the ignorable coordinates times `h`, a row for each, where [`Self::rates`] was computed last.
    pub fn steps(&self, h: S) -> Vec<Vec<S>> {
        self.ignorable.iter().map(|row| row.iter().map(|&rate| h * rate).collect()).collect()
    }

    /// Calls `see(row, column, value)` for the entries of ∂(q̇, ṗ)/∂(q, p) of the active coordinates that are not zero,
    /// at node k, where [`Self::rates`] was computed from the same numbers. Nodes are best asked for in order.
    pub fn jacobian(&mut self, on: OnNodes<'_, S>, k: usize, see: impl FnMut(usize, usize, S)) {
        let equations = self.hamiltonian.linearised();
        let program = &equations.jacobian;
        if !self.nodes.contains(&k) {
            let first = k - k % BLOCK;
            self.nodes = first..(first + BLOCK).min(on.q[0].len());
            if self.linearised.is_empty() {
                self.linearised = program.registers(|constant| [constant; BLOCK]);
            }
            on.put(&self.hamiltonian.active, self.nodes.clone(), &mut self.linearised);
            program.run_block(
                equations.varying_entries(),
                self.nodes.len(),
                &mut self.linearised,
                &mut MOST_LOST.clone(),
            );
        }
        let place = k - self.nodes.start;
        equations.each_entry(|output| self.linearised[program.output(output)][place], see);
    }
}
