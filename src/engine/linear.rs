//! The linearised equations of a scene: registers, and the entries of the Jacobian that are not zero.

use pulp::Simd;

use super::kernel::{Evaluate, evaluate};
use super::rule::Order;
use crate::formula::{Register, Step};
use crate::geometry::{Geometry, Source};
use crate::number::vector::{Level, Nodes};

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
    /// True if values are to be mended that are finite although something on the way to them is not.
    pub(super) is_mended: bool,
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
            is_mended: false,
        }
    }

    /// Evaluates what varies, once the unknowns are in place.
    #[inline(always)]
    pub(super) fn evaluate<S: Simd>(&mut self, s: S) {
        let program = &self.geometry.hamiltonian.linearised().jacobian;
        evaluate(s, self.steps, &mut self.registers, self.is_mended.then_some(program));
    }
}
