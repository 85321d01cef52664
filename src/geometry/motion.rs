//! Hamilton's equations on the nodes of a window, a block of nodes at a time.

use std::ops::Range;
use std::sync::Arc;

use super::hamiltonian::Points;
use super::{Geometry, OutsideGeometry};
use crate::formula::{BLOCK, MOST_LOST};
use crate::number::Real;

/// The rates of positions and momenta, q̇^a = g^ab (p_b − A_b), ṗ_a = f_a + F_a, where only active coordinates and
/// their momenta are unknowns: the momenta of ignorable ones are constants, which `start` has.
#[derive(Debug)]
pub struct Motion<S> {
    block: Points<S, BLOCK>,
    /// The nodes whose linearised equations stand there.
    nodes: Range<usize>,
    /// q̇^a of ignorable coordinates on the nodes, where rates were computed last.
    pub ignorable: Vec<Vec<S>>,
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
    pub fn new(geometry: &Geometry<S>) -> Self {
        Self {
            block: Points::new(&geometry.hamiltonian, &geometry.signs),
            nodes: 0..0,
            ignorable: vec![Vec::new(); geometry.ignorable().count()],
        }
    }

    /// Computes all rates on the first nodes, and writes those of active coordinates into as many rows as there are:
    /// rows of q̇, and then rows of ṗ.
    ///
    /// # Errors
    /// The first node that is outside the domain.
    pub fn rates(&mut self, on: OnNodes<'_, S>, points: usize, out: &mut [Vec<S>]) -> Result<(), OutsideGeometry> {
        let hamiltonian = Arc::clone(&self.block.hamiltonian);
        let (own, others) = (hamiltonian.active_velocities(), hamiltonian.ignorable_velocities());
        let mut ignorable = std::mem::take(&mut self.ignorable);
        ignorable.iter_mut().for_each(|row| row.resize(points, S::ZERO));
        let found = self.each_block(on, points, |nodes, registers| {
            let active = out.iter_mut().zip(own.iter().chain(&hamiltonian.forces));
            for (row, &register) in active.chain(ignorable.iter_mut().zip(&others)) {
                row[nodes.clone()].copy_from_slice(&registers[register][..nodes.len()]);
            }
        });
        self.ignorable = ignorable;
        found
    }

    /// All rates on the first nodes: q̇^a of all coordinates, and then ṗ_a of active ones, in rows that may be there.
    ///
    /// # Errors
    /// The first node that is outside the domain.
    pub fn all_rates(
        &mut self,
        on: OnNodes<'_, S>,
        points: usize,
        out: &mut Vec<Vec<S>>,
    ) -> Result<(), OutsideGeometry> {
        let hamiltonian = Arc::clone(&self.block.hamiltonian);
        out.resize_with(on.q.len() + hamiltonian.active.len(), Vec::new);
        out.iter_mut().for_each(Vec::clear);
        self.each_block(on, points, |nodes, registers| {
            for (row, &register) in out.iter_mut().zip(hamiltonian.velocities.iter().chain(&hamiltonian.forces)) {
                row.extend_from_slice(&registers[register][..nodes.len()]);
            }
        })
    }

    /// Evaluates the equations on the first nodes, and shows the registers of each block of them.
    fn each_block(
        &mut self,
        on: OnNodes<'_, S>,
        points: usize,
        mut see: impl FnMut(Range<usize>, &[[S; BLOCK]]),
    ) -> Result<(), OutsideGeometry> {
        let (hamiltonian, mut chances) = (Arc::clone(&self.block.hamiltonian), MOST_LOST);
        self.nodes = 0..0;
        for first in (0..points).step_by(BLOCK) {
            let nodes = first..points.min(first + BLOCK);
            on.put(&hamiltonian.active, nodes.clone(), &mut self.block.registers);
            self.block.evaluate_there(nodes.len(), first, &mut chances)?;
            see(nodes, &self.block.registers);
        }
        Ok(())
    }

    /// Calls `see(row, column, value)` for the entries of ∂(q̇, ṗ)/∂(q, p) of the active coordinates that are not zero,
    /// at node k, where [`Self::rates`] was computed from the same numbers. Nodes are best asked for in order.
    pub fn jacobian(&mut self, on: OnNodes<'_, S>, k: usize, see: impl FnMut(usize, usize, S)) {
        if !self.nodes.contains(&k) {
            let first = k - k % BLOCK;
            self.nodes = first..(first + BLOCK).min(on.q[0].len());
            let (hamiltonian, nodes) = (Arc::clone(&self.block.hamiltonian), self.nodes.clone());
            self.block.linearise(nodes.len(), |registers| on.put(&hamiltonian.active, nodes, registers));
        }
        self.block.each_entry(k - self.nodes.start, see);
    }
}
