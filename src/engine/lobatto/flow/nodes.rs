//! What observers read of a window that was solved.

use super::state::FlowState;
use super::window::FlowWindow;
use super::work::Multiply;
use crate::number::vector::{Level, Nodes};

impl<const P: usize> FlowWindow<'_, P> {
    /// The place of a coordinate among the active ones.
    pub(super) fn place_of(&self, a: usize) -> Option<usize> {
        self.geometry.active().iter().position(|&active| active == a)
    }

    /// q^a of an ignorable coordinate on the nodes, from the start of the window.
    pub(super) fn elapsed_row(&self, a: usize) -> Vec<f64> {
        let place = self.ignorable.iter().position(|&other| other == a).expect("an ignorable coordinate");
        let velocity = &self.unknowns.ignorable()[place].0;
        let rows = self.rule.rule.a().chunks(self.points());
        rows.map(|row| row.iter().zip(velocity).map(|(a, v)| a.hi * v).sum()).collect()
    }

    /// By how much every q^a, and every p_a by place, has changed after a fraction of the window.
    ///
    /// ∫_0^s P_k(2s − 1) = (P_{k+1} − P_{k−1})/(2(2k + 1)), with P_{−1} = −1.
    pub(super) fn changes_at(&self, fraction: f64, q: &mut [f64], p: &mut [f64]) {
        let unit = self.rule.unit;
        let z = 2.0 * fraction - 1.0;
        let mut integrals = Nodes::ZERO;
        let (mut before, mut here) = (-1.0, 1.0);
        for (k, [next, last]) in unit.recurrence[..self.points()].iter().enumerate() {
            let after = next * z * here - last * before;
            integrals.0[k] = (after - before) * unit.shares.0[k];
            (before, here) = (here, after);
        }
        // What a rate of 1 on each node adds.
        let mut weights = [Nodes::ZERO];
        let (matrix, rows) = (&self.rule.tables.from_modes[..unit.tables.columns], std::slice::from_ref(&integrals));
        Level::Best.dispatch(Multiply { matrix, rows, out: &mut weights });
        let weights = &weights[0].0;
        for (place, &a) in self.geometry.active().iter().enumerate() {
            p[place] = self.unknowns.forces()[place].dot(weights);
            q[a] = match self.geometry.separable() {
                None => self.unknowns.velocities()[place].dot(weights),
                Some(inverse) => {
                    let row = &inverse[place * self.m..][..self.m];
                    let momenta = self.fields[self.m..].iter();
                    self.length * row.iter().zip(momenta).map(|(g, p)| g * p.dot(weights)).sum::<f64>()
                }
            };
        }
        for (&a, rates) in self.ignorable.iter().zip(self.unknowns.ignorable()) {
            q[a] = rates.dot(weights);
        }
    }

    /// Σ |p_a q̇^a| at the end, the size of the terms of K.
    pub(super) fn norm_terms(&self) -> f64 {
        let (last, n) = (self.points() - 1, self.geometry.dimension());
        let active = (0..self.m).map(|place| self.rates_at_end(place)[0] * self.fields[self.m + place].0[last]);
        let ignorable = self.ignorable.iter().zip(self.unknowns.ignorable());
        let ignorable =
            ignorable.map(|(&a, row)| row.0[last] / self.length * self.unknowns.registers[2 * n + a].0[last]);
        active.chain(ignorable).map(f64::abs).sum()
    }

    /// dq^a/dγ and dp_a/dγ at the end, of an active coordinate by its place.
    pub(super) fn rates_at_end(&self, place: usize) -> [f64; 2] {
        let last = self.points() - 1;
        let velocity = match self.geometry.separable() {
            None => self.unknowns.velocities()[place].0[last] / self.length,
            Some(inverse) => {
                let row = &inverse[place * self.m..][..self.m];
                row.iter().enumerate().map(|(b, g)| g * self.fields[self.m + b].0[last]).sum()
            }
        };
        [velocity, self.unknowns.forces()[place].0[last] / self.length]
    }

    /// dq^a/dγ at the end.
    pub(super) fn velocity_at_end(&self, a: usize) -> f64 {
        match self.place_of(a) {
            Some(place) => self.rates_at_end(place)[0],
            None => {
                let place = self.ignorable.iter().position(|&other| other == a).expect("an ignorable coordinate");
                self.unknowns.ignorable()[place].0[self.points() - 1] / self.length
            }
        }
    }

    /// All positions, velocities and momenta at a node.
    pub(super) fn node(&self, start: &FlowState, h: f64, node: usize, [q, q_dot, p]: [&mut [f64]; 3]) {
        for (place, &a) in self.geometry.active().iter().enumerate() {
            (q[a], p[a]) = (self.fields[place].0[node], self.fields[self.m + place].0[node]);
        }
        for (place, &a) in self.geometry.active().iter().enumerate() {
            q_dot[a] = match self.geometry.separable() {
                None => self.unknowns.velocities()[place].0[node] / h,
                Some(inverse) => {
                    let row = &inverse[place * self.m..][..self.m];
                    row.iter().zip(self.geometry.active()).map(|(g, &b)| g * p[b]).sum()
                }
            };
        }
        let weights = &self.rule.rule.a()[node * self.points()..][..self.points()];
        for (&a, row) in self.ignorable.iter().zip(self.unknowns.ignorable()) {
            let elapsed: f64 = weights.iter().zip(&row.0).map(|(a, v)| a.hi * v).sum();
            q[a] = start.q[a].hi + (start.q[a].lo + elapsed);
            q_dot[a] = row.0[node] / h;
        }
    }
}
