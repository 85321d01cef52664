//! Where a march is inside of its last window.

use super::Adaptive;
use crate::engine::POINTS;
use crate::engine::solved::WindowNodes;

/// The weights of values on the nodes at a place between them.
type Weights = [f64; POINTS];

impl Adaptive<'_> {
    /// γ at the end of the last window, 0 before the first.
    pub(in crate::engine) fn come_to(&self) -> f64 {
        if self.attempt.windows > 0 { self.gamma_at_end() } else { 0.0 }
    }

    /// True if that is the end of the run.
    pub(in crate::engine) fn is_over(&self) -> bool {
        self.attempt.windows > 0 && self.attempt.accepted.is_last
    }

    /// True if the run has come to the value of a coordinate at which it ends.
    pub(in crate::engine) fn has_landed(&self) -> bool {
        self.is_over() && self.target.is_some_and(|it| self.lent.solver.end.q[it.coordinate].high == it.value)
    }

    /// The part of the run that is behind.
    pub(in crate::engine) fn done(&self) -> f64 {
        let part = (self.gamma_at_end() / self.length).clamp(0.0, 1.0 - f64::EPSILON);
        if self.attempt.accepted.is_last { 1.0 } else { part }
    }

    /// 1/size of a coordinate for errors of the run, of which this part is done.
    pub(in crate::engine) fn inverse_for_sums(&self, a: usize, done: f64) -> f64 {
        let solver = &self.lent.solver;
        let size = solver.size(a);
        if solver.place(a).is_ok() { size.for_sums(done) } else { size.of_way(done) }
    }

    /// γ at a node.
    pub(in crate::engine) fn gamma_at(&self, node: usize) -> f64 {
        self.attempt.gamma.high + self.attempt.accepted.length * self.lent.solver.fractions()[node]
    }

    /// True for a clock: it goes as it does in every march, and what rounds its way is no error.
    fn is_clock(&self, a: usize) -> bool {
        let solver = &self.lent.solver;
        solver.place(a).is_ok_and(|place| solver.scales.clocks[place])
    }

    /// The way of a coordinate from the start of the run to the start of the window; 0 for a clock.
    fn way_before(&self, a: usize) -> f64 {
        let solver = &self.lent.solver;
        if self.is_clock(a) {
            return 0.0;
        }
        (solver.start.q[a].high - solver.initial.q[a]) + solver.start.q[a].low
    }

    /// Its way from there to a node.
    fn way_in(&self, a: usize, node: usize) -> f64 {
        let solver = &self.lent.solver;
        match solver.place(a) {
            Ok(_) if self.is_clock(a) => 0.0,
            Ok(place) => solver.system.position(place).0[node] - solver.start.q[a].high,
            Err(j) => solver.elapsed[j].0[node],
        }
    }

    /// The way of a coordinate from the start of the run to a node.
    pub(in crate::engine) fn way_at_node(&self, a: usize, node: usize) -> f64 {
        self.way_before(a) + self.way_in(a, node)
    }

    /// The same with these weights of the nodes.
    pub(in crate::engine) fn way_at(&self, a: usize, weights: &Weights) -> f64 {
        self.way_before(a) + weights.iter().enumerate().map(|(node, weight)| weight * self.way_in(a, node)).sum::<f64>()
    }

    /// The weights of the nodes at this γ, or at the end of the window if that is behind it, by Lagrange's formula
    /// (Wang, Huybrechs, Vandewalle, Math. Comp. 83, 2014).
    pub(in crate::engine) fn weights_at(&self, gamma: f64) -> Weights {
        let at = ((gamma - self.attempt.gamma.high) / self.attempt.accepted.length).min(1.0);
        let nodes = self.lent.solver.fractions();
        if let Some(node) = nodes.iter().position(|node| *node == at) {
            return std::array::from_fn(|k| f64::from(u8::from(k == node)));
        }
        // On Lobatto nodes barycentric weights are the roots of those of the rule, with signs in turn.
        let barycentric =
            |k: usize| self.lent.solver.rule.weights.0[k].sqrt() * if k.is_multiple_of(2) { 1.0 } else { -1.0 };
        let weights: Weights = std::array::from_fn(|k| barycentric(k) / (at - nodes[k]));
        let sum: f64 = weights.iter().sum();
        weights.map(|weight| weight / sum)
    }
}
