//! Evaluations of the rates on all nodes of a window, and their integrals.

use super::state::FlowState;
use super::tables::Matrices;
use super::window::FlowWindow;
use super::work::{Evaluate, Integrate};
use crate::lobatto::simd::Level;
use crate::lobatto::tables::Nodes;

impl<const P: usize> FlowWindow<'_, P> {
    /// Sets what does not change in the sweeps: the start, displaced by `delta`, and the line of the free motion.
    pub(super) fn prepare(&mut self, start: &FlowState, h: f64, delta: Option<&FlowState>) {
        let m = self.m;
        for (place, &a) in self.q_at.iter().enumerate() {
            let [dq, dp] = delta.map_or([0.0; 2], |delta| [delta.q[a].hi, delta.p[place].hi]);
            (self.starts[place], self.starts[m + place]) = (start.q[a].hi, start.p[place].hi);
            self.low[place].0 = [start.q[a].lo + dq; P];
            self.low[m + place].0 = [start.p[place].lo + dp; P];
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

    /// Evaluates what a sweep needs besides the velocities of active coordinates.
    pub(super) fn evaluate_sweep(&mut self, h: f64, is_companion: bool) {
        let rows = if is_companion { &mut self.companion_rows } else { &mut self.rows };
        let m = self.m;
        Level::Best.dispatch(Evaluate {
            program: self.programs.rates(),
            outputs: self.programs.sweep(),
            registers: &mut self.registers,
            factor: h,
            from: &self.sweep_from,
            to: &mut rows.rates[m..],
        });
        let Some(inverse) = self.geometry.separable() else { return };
        // h² q̈^a = h² g^ab ṗ_b
        let (accelerations, rest) = rows.rates.split_at_mut(m);
        for (place, acceleration) in accelerations.iter_mut().enumerate() {
            acceleration.0 = [0.0; P];
            for (&g, force) in inverse[place * m..].iter().zip(&rest[..m]) {
                if g != 0.0 {
                    acceleration.0.iter_mut().zip(&force.0).for_each(|(sum, force)| *sum += h * g * force);
                }
            }
        }
    }

    /// Evaluates K, and the velocities of ignorable coordinates at the fields as they are: so charges are exact to
    /// rounding on the nodes, whatever the tolerance, unless the metric couples their coordinate to an active one.
    pub(super) fn evaluate_last(&mut self, h: f64) {
        Level::Best.dispatch(Evaluate {
            program: self.programs.rates(),
            outputs: self.programs.all(),
            registers: &mut self.registers,
            factor: h,
            from: &self.sweep_from[self.m..],
            to: &mut self.rows.rates[2 * self.m..],
        });
        self.norm = self.registers[self.programs.norm_register()].0[self.points() - 1];
    }

    /// Evaluates the velocities of active coordinates, unless they are not unknowns.
    pub(super) fn evaluate_velocities(&mut self, h: f64, is_companion: bool) {
        if self.geometry.is_separable() {
            return;
        }
        let rows = if is_companion { &mut self.companion_rows } else { &mut self.rows };
        Level::Best.dispatch(Evaluate {
            program: self.programs.rates(),
            outputs: self.programs.first_velocities(),
            registers: &mut self.registers,
            factor: h,
            from: &self.velocities_from,
            to: &mut rows.rates[..self.m],
        });
    }

    /// One sweep.
    pub(super) fn sweep(&mut self, h: f64, matrices: &Matrices<P>, is_companion: bool) {
        self.sweeps += 1;
        self.evaluate_sweep(h, is_companion);
        if self.geometry.is_separable() {
            self.integrate_rows(&matrices.a_squared[..], 0, is_companion);
            return;
        }
        self.integrate_rows(&matrices.a[..], 1, is_companion);
        self.evaluate_velocities(h, is_companion);
        self.integrate_rows(&matrices.a[..], 0, is_companion);
    }

    /// Integrates the rates of positions (`half` 0) or momenta (1).
    pub(super) fn integrate_rows(&mut self, matrix: &[[f64; P]], half: usize, is_companion: bool) {
        let rows = if is_companion { &mut self.companion_rows } else { &mut self.rows };
        let rates = std::mem::take(&mut rows.rates);
        self.integrate(matrix, &rates[half * self.m..][..self.m], half == 0);
        let rows = if is_companion { &mut self.companion_rows } else { &mut self.rows };
        rows.rates = rates;
    }
}
