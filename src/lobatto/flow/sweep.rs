//! Evaluations of the rates on all nodes of a window, and their integrals.

use super::state::FlowState;
use super::window::FlowWindow;
use super::work::{Evaluate, Integrate, Pass, Sweep};
use crate::lobatto::simd::Level;
use crate::lobatto::tables::Nodes;

impl<const P: usize> FlowWindow<'_, P> {
    /// Computes what does not change in a run, from the momenta of ignorable coordinates.
    pub(super) fn evaluate_fixed(&mut self) {
        let steps = self.programs.rates().fixed();
        Level::Best.dispatch(Evaluate { steps, registers: &mut self.registers, factor: 1.0, from: &[], to: &mut [] });
    }

    /// Sets what does not change in the sweeps: the start, and the line of the free motion.
    pub(super) fn prepare(&mut self, start: &FlowState, h: f64) {
        let m = self.m;
        for (place, &a) in self.q_at.iter().enumerate() {
            (self.starts[place], self.starts[m + place]) = (start.q[a].hi, start.p[place].hi);
            self.low[place].0 = [start.q[a].lo; P];
            self.low[m + place].0 = [start.p[place].lo; P];
        }
        let Some(inverse) = self.geometry.separable() else { return };
        for place in 0..m {
            let row = &inverse[place * m..][..m];
            let velocity: f64 =
                (row.iter().enumerate()).map(|(b, g)| g * (self.starts[m + b] + self.low[m + b].0[0])).sum();
            let c = &self.rule.tables.nodes.0;
            self.low[place].0.iter_mut().zip(c).for_each(|(low, c)| *low += h * velocity * c);
        }
    }

    /// Integrates rates of positions or of momenta.
    pub(super) fn integrate(&mut self, matrix: &[[f64; P]], rates: &[Nodes<P>], is_position: bool) {
        let (range, to) = if is_position { (0..self.m, &self.q_at) } else { (self.m..2 * self.m, &self.p_at) };
        Level::Best.dispatch(Integrate {
            matrix: &matrix[..self.rule.unit.tables.columns],
            rates,
            start: &self.starts[range.clone()],
            low: &self.low[range.clone()],
            registers: &mut self.registers,
            to,
            change: &mut self.change[range],
        });
    }

    /// Evaluates K and the velocities of ignorable coordinates at the fields as they are: so charges are exact to
    /// rounding on the nodes, whatever the tolerance, unless the metric couples their coordinate to an active one.
    pub(super) fn evaluate_last(&mut self, h: f64) {
        Level::Best.dispatch(Evaluate {
            steps: self.programs.rates().varying(self.programs.all()),
            registers: &mut self.registers,
            factor: h,
            from: &self.ignorable_from,
            to: &mut self.rows.rates[2 * self.m..],
        });
        self.norm = self.registers[self.programs.norm_register()].0[self.points() - 1];
    }

    /// One sweep.
    pub(super) fn sweep(&mut self, h: f64) {
        self.sweeps += 1;
        let tables = self.rule.tables;
        let columns = self.rule.unit.tables.columns;
        let (a, a_squared) = (&tables.a[..columns], &tables.a_squared[..columns]);
        let program = self.programs.rates();
        let momenta = Pass {
            steps: program.varying(self.programs.sweep()),
            from: &self.forces_from,
            is_position: false,
            inverse: None,
            matrix: a,
            to: &self.p_at,
        };
        let (from, to) = (&self.velocities_from[..], &self.q_at[..]);
        let passes = match self.geometry.separable() {
            Some(inverse) => {
                &[Pass { is_position: true, inverse: Some(inverse), matrix: a_squared, to, ..momenta }][..]
            }
            None => &[momenta, Pass { steps: program.again(), from, is_position: true, to, ..momenta }],
        };
        Level::Best.dispatch(Sweep {
            registers: &mut self.registers,
            h,
            rates: &mut self.rows.rates[..2 * self.m],
            start: &self.starts,
            low: &self.low,
            change: &mut self.change,
            kicks: &mut self.kicks,
            weights: &self.rule.unit.tables.weights,
            passes,
        });
    }

    /// Integrates the forces as they are.
    pub(super) fn integrate_forces(&mut self) {
        let rates = std::mem::take(&mut self.rows.rates);
        self.integrate(&self.rule.tables.a[..], &rates[self.m..2 * self.m], false);
        self.rows.rates = rates;
    }
}
