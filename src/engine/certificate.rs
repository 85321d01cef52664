//! The gradient of the weak action at a window that was solved.
//!
//! With D̄ᵀH = −HD + E_N the gradient of E_weak with respect to one of two equal branches is −H (D̄p_a − f_a − F_a),
//! where p_a = g_ab D̄q^b + A_a, and D̄ contains the initial data. It is computed from the nodes alone, with the
//! formulas of the Lagrangian; `action` computes the same for any operator and any two branches.

use super::kernel::{Evaluate, Product};
use super::window::Solver;
use crate::formula::{Register, Step};
use crate::geometry::Geometry;
use crate::number::Compensated;
use crate::number::vector::{Level, Nodes};

/// Room for certificates.
pub(super) struct Certificate<'g, const N: usize> {
    steps: &'g [Step],
    registers: Vec<Nodes<N>>,
    /// The registers of p_a of all coordinates, then f_a + F_a of active ones.
    outputs: Vec<Register>,
    rows: Vec<Nodes<N>>,
}

impl<'g, const N: usize> Certificate<'g, N> {
    pub(super) fn new(geometry: &'g Geometry) -> Self {
        let program = &geometry.lagrangian().momenta;
        let (n, active) = (geometry.dimension(), geometry.active());
        let outputs = n + active.len();
        Self {
            steps: program.steps_to(outputs),
            registers: program.registers(|constant| Nodes([constant; N])),
            outputs: (0..outputs).map(|output| program.output(output)).collect(),
            rows: vec![Nodes::ZERO; n],
        }
    }

    /// The largest entry of the gradient of the action of a solved window of length `h`.
    pub(super) fn of(&mut self, window: &Solver<'_, N>, h: f64) -> f64 {
        let n = self.rows.len();
        let slopes = &mut self.registers[n..2 * n];
        for (a, elapsed) in window.geometry.ignorable().zip(&window.elapsed) {
            slopes[a] = *elapsed;
        }
        for (place, &a) in window.geometry.active().iter().enumerate() {
            let Compensated { high, low } = window.start.q[a];
            slopes[a] = Nodes(window.position(place).0.map(|q| (q - high) - low));
        }
        let matrix = &*window.rule.derivative;
        Level::Best.dispatch(Product { matrix, factor: 1.0 / h, rows: slopes });
        for (place, &a) in window.geometry.active().iter().enumerate() {
            self.registers[a] = *window.position(place);
        }
        Level::Best.dispatch(Evaluate { registers: &mut self.registers, steps: self.steps });
        for (a, row) in self.rows.iter_mut().enumerate() {
            let start = window.start_momentum(a);
            *row = Nodes(self.registers[self.outputs[a]].0.map(|p| p - start));
        }
        Level::Best.dispatch(Product { matrix, factor: 1.0, rows: &mut self.rows });
        self.largest(window, h)
    }

    fn largest(&self, window: &Solver<'_, N>, h: f64) -> f64 {
        let (n, weights) = (self.rows.len(), &window.rule.weights.0);
        // The maximum may lose a NaN, the sum does not.
        let (mut most, mut sum) = ([0.0_f64; N], [0.0; N]);
        let mut place = 0;
        for (a, slope) in self.rows.iter().enumerate() {
            let is_active = window.geometry.active().get(place) == Some(&a);
            let force = if is_active { &self.registers[self.outputs[n + place]] } else { &Nodes::ZERO };
            place += usize::from(is_active);
            for k in 0..N {
                // Weights are 0 beyond the last node, which repeats it.
                let entry = weights[k] * (slope.0[k] - h * force.0[k]);
                most[k] = most[k].max(entry.abs());
                sum[k] += entry;
            }
        }
        if sum.iter().sum::<f64>().is_finite() { most.into_iter().fold(0.0, f64::max) } else { f64::INFINITY }
    }
}
