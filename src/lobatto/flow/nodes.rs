//! What observers read of a window that was solved.

use super::state::FlowState;
use super::window::FlowWindow;

impl<const P: usize> FlowWindow<'_, P> {
    /// The place of a coordinate among the active ones.
    pub(super) fn place_of(&self, a: usize) -> Option<usize> {
        self.q_at.iter().position(|&active| active == a)
    }

    /// h q̇^a on the nodes.
    pub(super) fn velocity_row(&self, a: usize) -> Vec<f64> {
        let n = self.points();
        let Some(place) = self.place_of(a) else {
            let place = self.ignorable.iter().position(|&other| other == a).expect("active or ignorable");
            return self.rows.ignorable()[place].0[..n].to_vec();
        };
        match self.geometry.separable() {
            None => self.rows.velocities()[place].0[..n].to_vec(),
            Some(inverse) => {
                let row = &inverse[place * self.m..][..self.m];
                let velocity = |node: usize| (0..self.m).map(|b| row[b] * self.fields[self.m + b].0[node]).sum::<f64>();
                (0..n).map(|node| self.length * velocity(node)).collect()
            }
        }
    }

    /// q^a of an ignorable coordinate on the nodes, from the start of the window.
    pub(super) fn elapsed_row(&self, a: usize) -> Vec<f64> {
        let velocity = self.velocity_row(a);
        let rows = self.rule.rule.a().chunks(self.points());
        rows.map(|row| row.iter().zip(&velocity).map(|(a, v)| a.hi * v).sum()).collect()
    }

    /// Σ |p_a q̇^a| at the end, the size of the terms of K.
    pub(super) fn norm_terms(&self) -> f64 {
        let (last, n) = (self.points() - 1, self.geometry.dimension());
        let active = (0..self.m).map(|place| self.rates_at_end(place)[0] * self.fields[self.m + place].0[last]);
        let ignorable = self.ignorable.iter().zip(self.rows.ignorable());
        let ignorable = ignorable.map(|(&a, row)| row.0[last] / self.length * self.registers[2 * n + a].0[last]);
        active.chain(ignorable).map(f64::abs).sum()
    }

    /// dq^a/dγ and dp_a/dγ at the end, of an active coordinate by its place.
    pub(super) fn rates_at_end(&self, place: usize) -> [f64; 2] {
        let last = self.points() - 1;
        let velocity = match self.geometry.separable() {
            None => self.rows.velocities()[place].0[last] / self.length,
            Some(inverse) => {
                let row = &inverse[place * self.m..][..self.m];
                row.iter().enumerate().map(|(b, g)| g * self.fields[self.m + b].0[last]).sum()
            }
        };
        [velocity, self.rows.forces()[place].0[last] / self.length]
    }

    /// All positions, velocities and momenta at a node.
    pub(super) fn node(&self, start: &FlowState, h: f64, node: usize, [q, q_dot, p]: [&mut [f64]; 3]) {
        for (place, &a) in self.q_at.iter().enumerate() {
            (q[a], p[a]) = (self.fields[place].0[node], self.fields[self.m + place].0[node]);
        }
        for (place, &a) in self.q_at.iter().enumerate() {
            q_dot[a] = match self.geometry.separable() {
                None => self.rows.velocities()[place].0[node] / h,
                Some(inverse) => {
                    let row = &inverse[place * self.m..][..self.m];
                    row.iter().zip(&self.q_at).map(|(g, &b)| g * p[b]).sum()
                }
            };
        }
        let weights = &self.rule.rule.a()[node * self.points()..][..self.points()];
        for (&a, row) in self.ignorable.iter().zip(self.rows.ignorable()) {
            let elapsed: f64 = weights.iter().zip(&row.0).map(|(a, v)| a.hi * v).sum();
            q[a] = start.q[a].hi + (start.q[a].lo + elapsed);
            q_dot[a] = row.0[node] / h;
        }
    }
}
