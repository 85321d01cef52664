//! The equations of a scene on the nodes of a window, and the linearised ones: registers, and the steps that compute
//! what is wanted when.

use pulp::Simd;

use super::kernel::{Evaluate, evaluate};
use super::rule::Order;
use crate::formula::{Register, Step};
use crate::geometry::{Geometry, OutsideGeometry, Source};
use crate::number::vector::{Level, Nodes};

/// Slopes that are computed together, and then integrated.
#[derive(Debug, Clone)]
pub(super) struct Pass {
    pub(super) steps: Box<[Step]>,
    /// The first of their rows.
    pub(super) first: usize,
    /// The registers of the slopes, and those from which the program reads the unknowns.
    pub(super) slopes: Box<[Register]>,
    pub(super) unknowns: Box<[Register]>,
}

/// Hamilton's equations with a register for every value.
pub(super) struct System<'g, const N: usize> {
    pub(super) geometry: &'g Geometry,
    pub(super) registers: Vec<Nodes<N>>,
    pub(super) order: Order,
    pub(super) passes: Vec<Pass>,
    /// The steps that depend on nothing but momenta that are conserved.
    fixed: Box<[Step]>,
    /// The steps to the velocities of ignorable coordinates and the determinants, once the unknowns are known.
    pub(super) others: Box<[Step]>,
    /// The registers of q^a and p_a of active coordinates.
    pub(super) positions: Box<[Register]>,
    pub(super) momenta: Box<[Register]>,
    /// The registers of q̇^a of ignorable coordinates.
    pub(super) ignorable: Box<[Register]>,
    /// The blocks whose determinants vary, with the registers of these.
    determinants: Box<[(usize, Register)]>,
}

impl<'g, const N: usize> System<'g, N> {
    pub(super) fn new(geometry: &'g Geometry) -> Self {
        let equations = &geometry.hamiltonian;
        let (n, active, program) = (geometry.dimension(), geometry.active(), &equations.program);
        let is_momentum = |variable: usize| variable >= 2 * n && active.contains(&(variable - 2 * n));
        let varies = program.depends_on(|variable| variable < 2 * n || is_momentum(variable));
        let is_fixed = |register: Register| !varies[register];
        let positions: Box<[Register]> = active.into();
        let momenta: Box<[Register]> = active.iter().map(|&a| 2 * n + a).collect();
        let pass = |slopes: Vec<Register>, unknowns: &[Register], first: usize, is_known: &dyn Fn(Register) -> bool| {
            let steps = program.schedule(slopes.iter().copied(), is_known);
            Pass { steps, first, slopes: slopes.into(), unknowns: unknowns.into() }
        };
        let (order, passes) = match &equations.accelerations {
            Some(accelerations) => (Order::Second, vec![pass(accelerations.clone(), &positions, 0, &is_fixed)]),
            None => {
                let forces = pass(equations.forces.clone(), &momenta, active.len(), &is_fixed);
                // What does not depend on momenta is still known when these have changed.
                let moves = program.depends_on(is_momentum);
                let mut is_known: Vec<bool> = varies.iter().map(|varies| !varies).collect();
                forces.steps.iter().for_each(|step| is_known[step.to()] |= !moves[step.to()]);
                let velocities = pass(equations.active_velocities(), &positions, 0, &|register| is_known[register]);
                (Order::First, vec![forces, velocities])
            }
        };
        let ignorable = equations.ignorable_velocities();
        let determinants = equations.determinants.iter().copied().enumerate();
        let determinants: Box<[_]> = determinants.filter(|(_, register)| varies[*register]).collect();
        let outputs = ignorable.iter().chain(determinants.iter().map(|(_, register)| register));
        let others = program.schedule(outputs.copied(), is_fixed);
        let fixed = program.schedule(0..varies.len(), |register| varies[register]);
        Self {
            geometry,
            registers: program.registers(|constant| Nodes([constant; N])),
            order,
            passes,
            fixed,
            others,
            positions,
            momenta,
            ignorable: ignorable.into(),
            determinants,
        }
    }

    /// The same equations with the same constants for another number of nodes, with these momenta of ignorable
    /// coordinates.
    pub(super) fn with_lanes<const M: usize>(&self, momenta: &[f64]) -> System<'g, M> {
        let program = &self.geometry.hamiltonian.program;
        let mut registers = program.registers(|constant| Nodes([constant; M]));
        program.constants().for_each(|(register, _)| registers[register] = Nodes([self.registers[register].0[0]; M]));
        let mut system = System {
            geometry: self.geometry,
            registers,
            order: self.order,
            passes: self.passes.clone(),
            fixed: self.fixed.clone(),
            others: self.others.clone(),
            positions: self.positions.clone(),
            momenta: self.momenta.clone(),
            ignorable: self.ignorable.clone(),
            determinants: self.determinants.clone(),
        };
        system.begin(momenta);
        system
    }

    /// Number of unknowns that sweeps iterate.
    pub(super) fn iterated(&self) -> usize {
        self.passes.iter().map(|pass| pass.slopes.len()).sum()
    }

    /// True if a slope is not finite on some node.
    pub(super) fn is_broken(&self) -> bool {
        let mut slopes = self.passes.iter().flat_map(|pass| &pass.slopes);
        slopes.any(|&slope| self.registers[slope].0.iter().any(|value| !value.is_finite()))
    }

    /// The nodes of the position of an active coordinate, by its place among them.
    pub(super) fn position(&self, place: usize) -> &Nodes<N> {
        &self.registers[self.positions[place]]
    }

    /// Puts the momenta of ignorable coordinates in place.
    pub(super) fn begin(&mut self, momenta: &[f64]) {
        let n = self.geometry.dimension();
        for a in self.geometry.ignorable() {
            self.registers[2 * n + a].0 = [momenta[a]; N];
        }
        Level::Best.dispatch(Evaluate { registers: &mut self.registers, steps: &self.fixed });
    }

    /// Looks whether the determinants on the nodes have their signs.
    ///
    /// # Errors
    /// The first of `points` nodes that is outside the domain.
    pub(super) fn check_domain(&self, points: usize) -> Result<(), OutsideGeometry> {
        let signs = &self.geometry.signs;
        for &(block, register) in &self.determinants {
            let row = &self.registers[register].0[..points];
            let is_inside =
                |determinant: f64| determinant.is_finite() && determinant != 0.0 && determinant * signs[block] >= 0.0;
            if let Some(index) = row.iter().position(|&determinant| !is_inside(determinant)) {
                let position = self.positions.first().map_or(f64::NAN, |&register| self.registers[register].0[index]);
                return Err(OutsideGeometry { index, block: Some(block), determinant: row[index], position });
            }
        }
        Ok(())
    }
}

/// A term of an entry of the Jacobian: `factor` times what stands in a register.
#[derive(Debug, Clone, Copy)]
pub(super) struct Term {
    pub(super) row: usize,
    pub(super) column: usize,
    pub(super) register: Register,
    pub(super) factor: f64,
}

/// The linearised equations of 2m unknowns: positions and momenta, or positions and velocities in second order.
pub(super) struct Linear<'g, const N: usize> {
    geometry: &'g Geometry,
    pub(super) order: Order,
    pub(super) registers: Vec<Nodes<N>>,
    pub(super) steps: &'g [Step],
    /// The registers of q^a and p_a of active coordinates.
    pub(super) unknowns: Vec<Register>,
    /// ∂(slope)/∂(unknown) for each row that sweeps iterate.
    pub(super) rows: Vec<Term>,
    /// The same for velocities of ignorable coordinates, whose rows count from 0.
    pub(super) rates: Vec<Term>,
}

impl<'g, const N: usize> Linear<'g, N> {
    /// `momenta` are those of all coordinates, of which ignorable ones stay.
    pub(super) fn new(geometry: &'g Geometry, momenta: &[f64]) -> Self {
        let equations = geometry.hamiltonian.linearised();
        let program = &equations.jacobian;
        let (m, n, active) = (geometry.active().len(), geometry.dimension(), geometry.active());
        let mut registers = program.registers(|constant| Nodes([constant; N]));
        let (mut rows, mut rates) = (Vec::new(), Vec::new());
        for entry in &equations.entries {
            let register = match entry.value {
                Source::Row(output) => program.output(output),
                Source::Constant(value) => {
                    registers.push(Nodes([value; N]));
                    registers.len() - 1
                }
            };
            let term = |row: usize, factor: f64| Term { row, column: entry.column, register, factor };
            match (entry.row.checked_sub(2 * m), geometry.separable()) {
                (Some(place), _) => rates.push(term(place, 1.0)),
                (None, None) => rows.push(term(entry.row, 1.0)),
                // q̈^a = g^ab ṗ_b
                (None, Some(inverse)) if entry.row >= m => {
                    let column = inverse.iter().skip(entry.row - m).step_by(m).enumerate();
                    rows.extend(column.filter(|(_, g)| **g != 0.0).map(|(row, &g)| term(row, g)));
                }
                (None, Some(_)) => {}
            }
        }
        for a in geometry.ignorable() {
            registers[2 * n + a].0 = [momenta[a]; N];
        }
        Level::Best.dispatch(Evaluate { registers: &mut registers, steps: &equations.fixed });
        Self {
            geometry,
            order: if geometry.is_separable() { Order::Second } else { Order::First },
            registers,
            steps: &equations.varying,
            unknowns: active.iter().copied().chain(active.iter().map(|&a| 2 * n + a)).collect(),
            rows,
            rates,
        }
    }

    /// Evaluates what varies, once the unknowns are in place. Values may be mended that are finite although something
    /// on the way to them is not.
    #[inline(always)]
    pub(super) fn evaluate<S: Simd>(&mut self, s: S, is_mended: bool) {
        let program = &self.geometry.hamiltonian.linearised().jacobian;
        evaluate(s, self.steps, &mut self.registers, is_mended.then_some(program));
    }
}
