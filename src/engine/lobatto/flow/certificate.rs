//! The gradient of the weak action at a window that was solved.
//!
//! With D̄ᵀH = −HD + E_N the gradient of E_weak with respect to one of two equal branches is −H (D̄p_a − f_a − F_a),
//! where p_a = g_ab D̄q^b + A_a, and D̄ contains the initial data. `action` computes the same for any operator
//! and any two branches.

use super::state::FlowState;
use super::window::FlowWindow;
use super::work::{Evaluate, Mend, Multiply};
use crate::formula::Register;
use crate::geometry::Geometry;
use crate::number::vector::{Level, Nodes};

/// Room for certificates.
pub(super) struct Certificate<'g, const P: usize> {
    geometry: &'g Geometry,
    /// Of the program of the momenta.
    registers: Vec<Nodes<P>>,
    outputs: Vec<Register>,
    /// p_a at the start of the run.
    momenta: Vec<f64>,
    rows: Vec<Nodes<P>>,
    slopes: Vec<Nodes<P>>,
}

impl<'g, const P: usize> Certificate<'g, P> {
    pub(super) fn new(geometry: &'g Geometry, momenta: &[f64]) -> Self {
        let program = &geometry.lagrangian().momenta;
        let (n, m) = (geometry.dimension(), geometry.active().len());
        Self {
            geometry,
            registers: program.registers(|constant| Nodes([constant; P])),
            outputs: (0..n + m).map(|output| program.output(output)).collect(),
            momenta: momenta.to_vec(),
            rows: vec![Nodes::ZERO; n + m],
            slopes: vec![Nodes::ZERO; n],
        }
    }

    /// The largest entry of the gradient of the action of the window of length `h` from `start`.
    pub(super) fn of(&mut self, window: &FlowWindow<'_, P>, start: &FlowState, h: f64) -> f64 {
        let (n, points) = (self.geometry.dimension(), window.rule.rule.points());
        for (place, &a) in self.geometry.active().iter().enumerate() {
            self.registers[a].0 = window.fields[place].0;
            let from = start.q[a];
            let row = window.fields[place].0.iter().map(|q| (q - from.hi) - from.lo);
            self.rows[a].0.iter_mut().zip(row).for_each(|(to, value)| *to = value);
        }
        let unit = window.rule.unit;
        let columns = unit.tables.columns;
        for (&a, velocity) in window.ignorable.iter().zip(window.unknowns.ignorable()) {
            let (matrix, rows) = (&unit.a[..columns], std::slice::from_ref(velocity));
            Level::Best.dispatch(Multiply { matrix, rows, out: &mut self.rows[a..=a] });
        }
        let matrix = &unit.derivative[..columns];
        Level::Best.dispatch(Multiply { matrix, rows: &self.rows[..n], out: &mut self.slopes });
        let per_length = 1.0 / h;
        for (a, slope) in self.slopes.iter().enumerate() {
            let row = slope.0.iter().map(|slope| per_length * slope);
            self.registers[n + a].0.iter_mut().zip(row).for_each(|(to, value)| *to = value);
        }
        let (program, outputs) = (&self.geometry.lagrangian().momenta, self.outputs.len());
        Level::Best.dispatch(Evaluate {
            steps: program.steps_to(outputs),
            mend: Some(Mend { program, outputs, points }),
            registers: &mut self.registers,
            factor: 1.0,
            from: &self.outputs,
            to: &mut self.rows,
        });
        for (a, row) in self.rows[..n].iter_mut().enumerate() {
            let place = window.place_of(a);
            let start = place.map_or(self.momenta[a], |place| start.p[place].hi);
            row.0.iter_mut().for_each(|p| *p -= start);
        }
        Level::Best.dispatch(Multiply { matrix, rows: &self.rows[..n], out: &mut self.slopes });
        // The maximum may lose a NaN, the sum does not.
        let (mut most, mut sum) = ([0.0_f64; P], [0.0; P]);
        for (a, slope) in self.slopes.iter().enumerate() {
            let force = window.place_of(a).map_or(&Nodes::ZERO, |place| &self.rows[n + place]);
            // Beyond the nodes velocities are 0, and forces need not be finite.
            for k in 0..points {
                let entry = unit.tables.weights[k] * (slope.0[k] - h * force.0[k]);
                most[k] = most[k].max(entry.abs());
                sum[k] += entry;
            }
        }
        if sum.iter().sum::<f64>().is_finite() { most.into_iter().fold(0.0, f64::max) } else { f64::INFINITY }
    }
}
