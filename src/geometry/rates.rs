//! Hamilton's equations of the active coordinates at one point after another, for rules that step from node to node.

use std::sync::Arc;

use super::hamiltonian::{Hamiltonian, Point};
use super::{Geometry, OutsideGeometry};
use crate::formula::{Register, Step, run_at_point};
use crate::number::Real;

/// Nothing but q̇^a and ṗ_a of active coordinates is computed at a point. The values that depend on conserved momenta
/// alone are computed once, and the signs of determinants are not looked at. In extended precision, where a point costs
/// as much alone as among others, q̇^a of ignorable coordinates and the determinants come with them.
#[derive(Debug)]
pub struct Rates<S> {
    hamiltonian: Arc<Hamiltonian<S>>,
    point: Point<S>,
    /// Positions and momenta of all coordinates.
    q: Vec<S>,
    p: Vec<S>,
    registers: Vec<S>,
    steps: Box<[Step]>,
    /// The registers of q^a and then p_a of active coordinates, and those of their rates, with those of ignorable
    /// coordinates behind them.
    state: Box<[Register]>,
    rates: Box<[Register]>,
    determinants: Vec<Register>,
}

impl<S: Real> Rates<S> {
    /// The momenta of ignorable coordinates are those of a start at `q` and `p`.
    pub(super) fn new(geometry: &Geometry<S>, q: &[S], p: &[S]) -> Self {
        let (n, hamiltonian) = (q.len(), Arc::clone(&geometry.hamiltonian));
        let Hamiltonian { program, active, forces, .. } = &*hamiltonian;
        let of_ignorable = if S::IS_EXTENDED { hamiltonian.ignorable_velocities() } else { Vec::new() };
        let of_active = hamiltonian.active_velocities().into_iter().chain(forces.iter().copied());
        let rates: Box<[Register]> = of_active.chain(of_ignorable).collect();
        let determinants = if S::IS_EXTENDED { hamiltonian.determinants.clone() } else { Vec::new() };
        let state: Box<[Register]> = active.iter().copied().chain(active.iter().map(|&a| 2 * n + a)).collect();
        let varies = program.depends_on(|variable| state.contains(&variable));
        let mut registers = program.registers(|constant| constant);
        registers[..n].copy_from_slice(q);
        registers[2 * n..3 * n].copy_from_slice(p);
        run_at_point(&program.schedule(0..program.size(), |register| varies[register]), &mut registers);
        Self {
            point: geometry.point(),
            q: q.to_vec(),
            p: p.to_vec(),
            steps: program.schedule(rates.iter().chain(&determinants).copied(), |register| !varies[register]),
            registers,
            state,
            rates,
            determinants,
            hamiltonian,
        }
    }

    /// Sets an active coordinate, or with m added to its place its momentum.
    #[inline]
    pub fn set(&mut self, place: usize, value: S) {
        self.registers[self.state[place]] = value;
    }

    /// True if rates of ignorable coordinates are evaluated, too.
    pub fn has_ignorable(&self) -> bool {
        self.rates.len() > self.state.len()
    }

    /// A rate as evaluated last, in the order of [`Self::set`], and from 2m on those of ignorable coordinates.
    #[inline]
    pub fn get(&self, place: usize) -> S {
        self.registers[self.rates[place]]
    }

    /// Evaluates the equations.
    ///
    /// # Errors
    /// [`OutsideGeometry`] with `index` 0 where a rate is not finite, or a determinant has the wrong sign.
    #[inline]
    pub fn evaluate(&mut self) -> Result<(), OutsideGeometry> {
        run_at_point(&self.steps, &mut self.registers);
        let mut determinants = self.determinants.iter().zip(self.point.signs());
        let is_inside = determinants.all(|(&block, &sign)| !super::is_outside(self.registers[block], sign));
        let is_finite = self.rates.iter().all(|&rate| self.registers[rate].is_finite());
        if is_finite && is_inside { Ok(()) } else { self.mend() }
    }

    /// Computes the rates with numbers of wider range, and looks at the domain.
    #[cold]
    fn mend(&mut self) -> Result<(), OutsideGeometry> {
        let Self { hamiltonian, point, q, p, registers, state, .. } = self;
        let m = hamiltonian.active.len();
        for (place, &a) in hamiltonian.active.iter().enumerate() {
            (q[a], p[a]) = (registers[state[place]], registers[state[m + place]]);
        }
        point.evaluate(q, p)?;
        for (place, &a) in hamiltonian.active.iter().enumerate() {
            registers[self.rates[place]] = point.q_dot(a);
            registers[self.rates[m + place]] = point.p_dot(place);
        }
        let ignorable = (0..q.len()).filter(|a| !hamiltonian.active.contains(a));
        for (&rate, a) in self.rates[2 * m..].iter().zip(ignorable) {
            registers[rate] = point.q_dot(a);
        }
        Ok(())
    }
}
