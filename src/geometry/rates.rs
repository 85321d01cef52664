//! Hamilton's equations of the active coordinates at one point after another, for rules that step from node to node.

use super::hamiltonian::{Hamiltonian, Point, set};
use super::{Geometry, OutsideGeometry, Start};
use crate::formula::{Register, Step, run_at};
use crate::number::Real;

/// Nothing but q̇^a and ṗ_a of active coordinates is computed at a point. The values that depend on conserved momenta
/// alone are computed once, and the signs of determinants are not looked at. In extended precision, where a point costs
/// as much alone as among others, q̇^a of ignorable coordinates and the determinants come with them.
#[derive(Debug)]
pub struct Rates<S> {
    point: Point<S>,
    steps: Box<[Step]>,
    /// The registers of q^a and then p_a of active coordinates, and those of their rates, with those of ignorable
    /// coordinates behind them.
    state: Box<[Register]>,
    rates: Box<[Register]>,
    determinants: Vec<Register>,
}

impl<S: Real> Rates<S> {
    /// The momenta of ignorable coordinates are those of the start.
    pub fn new(geometry: &Geometry<S>, start: &Start<S>) -> Self {
        let (n, hamiltonian, mut point) = (geometry.dimension(), &*geometry.hamiltonian, geometry.point());
        let Hamiltonian { program, active, forces, .. } = hamiltonian;
        let of_ignorable = if S::IS_EXTENDED { hamiltonian.ignorable_velocities() } else { Vec::new() };
        let of_active = hamiltonian.active_velocities().into_iter().chain(forces.iter().copied());
        let rates: Box<[Register]> = of_active.chain(of_ignorable).collect();
        let determinants = if S::IS_EXTENDED { hamiltonian.determinants.clone() } else { Vec::new() };
        let state: Box<[Register]> = active.iter().copied().chain(active.iter().map(|&a| 2 * n + a)).collect();
        let varies = program.depends_on(|variable| state.contains(&variable));
        set(&mut point.registers, &start.q, &start.p);
        run_at(&program.schedule(0..program.size(), |register| varies[register]), &mut point.registers);
        let steps = program.schedule(rates.iter().chain(&determinants).copied(), |register| !varies[register]);
        Self { point, steps, state, rates, determinants }
    }

    /// Sets an active coordinate, or with m added to its place its momentum.
    #[inline]
    pub fn set(&mut self, place: usize, value: S) {
        self.point.registers[self.state[place]] = [value];
    }

    /// True if rates of ignorable coordinates are evaluated, too.
    pub fn has_ignorable(&self) -> bool {
        self.rates.len() > self.state.len()
    }

    /// A rate as evaluated last, in the order of [`Self::set`], and from 2m on those of ignorable coordinates.
    #[inline]
    pub fn get(&self, place: usize) -> S {
        self.point.registers[self.rates[place]][0]
    }

    /// Evaluates the equations.
    ///
    /// # Errors
    /// [`OutsideGeometry`] with `index` 0 where a rate is not finite, or a determinant has the wrong sign.
    #[inline]
    pub fn evaluate(&mut self) -> Result<(), OutsideGeometry> {
        let Point { registers, signs, .. } = &mut self.point;
        run_at(&self.steps, registers);
        let mut determinants = self.determinants.iter().zip(&*signs);
        let is_inside = determinants.all(|(&block, &sign)| !super::is_outside(registers[block][0], sign));
        let is_finite = self.rates.iter().all(|&rate| registers[rate][0].is_finite());
        // Numbers of wider range may be finite, or the point is outside the domain.
        if is_finite && is_inside { Ok(()) } else { self.point.evaluate_there(1, 0, &mut 1) }
    }
}
