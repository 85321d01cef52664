//! The companion of a world-line: the same method on the same nodes, without the two highest modes of the rates.

use super::state::FlowState;
use super::window::{FlowWindow, MOST_SWEEPS, Task};
use crate::lobatto::tables::Nodes;

/// The last sweep of a companion changes its distance by this share at most. What is left is an error of the distance
/// that every window adds to, as interest.
const COMPANION: f64 = 0.01;

impl<const P: usize> FlowWindow<'_, P> {
    /// Carries the companion over the window that was solved: `delta` is what it is off by, at the start and then at the
    /// end. Whether its sweeps converge.
    pub(super) fn accompany(&mut self, task: Task<'_>, delta: &mut FlowState) -> bool {
        let Task { start, h, weights, .. } = task;
        self.prepare(start, h, Some(delta));
        let matrices = &self.rule.tables.companion;
        if self.geometry.is_separable() {
            self.integrate_rows(&matrices.a_squared[..], 0, false);
        } else {
            self.integrate_rows(&matrices.a[..], 1, false);
            self.integrate_rows(&matrices.a[..], 0, false);
        }
        let fields = if self.geometry.is_separable() { self.m } else { 2 * self.m };
        let last = self.points() - 1;
        let mut before = f64::INFINITY;
        for sweeps in 1..=MOST_SWEEPS {
            for (row, register) in self.q_at.iter().chain(&self.p_at).enumerate() {
                self.ends[row] = self.registers[*register].0[last];
            }
            self.sweep(h, matrices, true);
            let (mut change, mut distance) = (0.0_f64, 0.0_f64);
            for (row, register) in self.q_at.iter().chain(&self.p_at).enumerate().take(fields) {
                let weight = if row < self.m { weights.q[self.q_at[row]] } else { weights.p[row - self.m] };
                let end = self.registers[*register].0[last];
                change = change.max(weight * (end - self.ends[row]).abs());
                distance = distance.max(weight * (end - self.fields[row].0[last]).abs());
            }
            if !change.is_finite() {
                return false;
            }
            if sweeps > 1 && (change <= COMPANION * distance || change <= self.noise) {
                self.add_difference(h, delta);
                return true;
            }
            if sweeps > 4 && change > before {
                return false;
            }
            before = change;
        }
        false
    }

    /// Adds to `delta` what the companion's window moves more than the window, and the rounding of a window with random
    /// signs: the companion is computed on the same numbers, and does not show it.
    fn add_difference(&mut self, h: f64, delta: &mut FlowState) {
        let m = self.m;
        for (row, tail) in self.tails.iter().enumerate() {
            // A linear congruential generator (Knuth, MMIX).
            self.signs = self.signs.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let rounding = f64::EPSILON * tail.largest * if self.signs >> 63 == 0 { 1.0 } else { -1.0 };
            let field = match row {
                _ if row < m => &mut delta.q[self.q_at[row]],
                _ if row < 2 * m => &mut delta.p[row - m],
                _ => &mut delta.q[self.ignorable[row - 2 * m]],
            };
            *field = (field.hi + rounding).into();
        }
        let tables = &self.rule.unit.tables;
        let (n, companion) = (self.points(), &self.rule.tables.companion);
        let difference = |weights: &[f64; P], own: &Nodes<P>, other: &Nodes<P>| -> f64 {
            (0..n).map(|j| weights[j] * (other.0[j] - own.0[j])).sum()
        };
        let (own, other) = (&self.rows, &self.companion_rows);
        if let Some(inverse) = self.geometry.separable() {
            for (place, &a) in self.q_at.iter().enumerate() {
                let row = &inverse[place * m..][..m];
                let free: f64 = row.iter().zip(&delta.p).map(|(g, p)| g * h * p.hi).sum();
                let (own, other) = (&own.velocities()[place].0, &other.velocities()[place].0);
                let rest: f64 = (0..n)
                    .map(|j| companion.a_squared[j][n - 1] * other[j] - tables.position_weights[j] * own[j])
                    .sum();
                delta.q[a] = (delta.q[a].hi + (free + rest)).into();
            }
        } else {
            for (place, &a) in self.q_at.iter().enumerate() {
                let change = difference(&tables.weights, &own.velocities()[place], &other.velocities()[place]);
                delta.q[a] = (delta.q[a].hi + change).into();
            }
        }
        for place in 0..m {
            let change = difference(&tables.weights, &own.forces()[place], &other.forces()[place]);
            delta.p[place] = (delta.p[place].hi + change).into();
        }
        for ((&a, own), other) in self.ignorable.iter().zip(own.ignorable()).zip(other.ignorable()) {
            delta.q[a] = (delta.q[a].hi + difference(&tables.weights, own, other)).into();
        }
    }
}
