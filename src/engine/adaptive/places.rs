//! Where a march is inside of its last window.

use super::Adaptive;
use crate::engine::POINTS;
use crate::engine::rule::Rule;
use crate::engine::solved::WindowNodes;

/// The weights of values on the nodes at a place between them.
pub(super) type Weights = [f64; POINTS];

/// The barycentric weights of the nodes: on those of Lobatto the roots of the weights of the rule, with signs in turn.
pub(super) fn barycentric(rule: &Rule<POINTS>) -> Weights {
    std::array::from_fn(|k| rule.weights.0[k].sqrt() * if k.is_multiple_of(2) { 1.0 } else { -1.0 })
}

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

    /// Its values on the nodes of the window, and what they count from; `None` for a clock.
    fn row(&self, a: usize) -> Option<(&Weights, f64)> {
        let solver = &self.lent.solver;
        match solver.place(a) {
            Ok(_) if self.is_clock(a) => None,
            Ok(place) => Some((&solver.system.position(place).0, solver.start.q[a].high)),
            Err(j) => Some((&solver.elapsed[j].0, 0.0)),
        }
    }

    /// The way of a coordinate from the start of the run to a node.
    pub(in crate::engine) fn way_at_node(&self, a: usize, node: usize) -> f64 {
        self.way_before(a) + self.row(a).map_or(0.0, |(row, from)| row[node] - from)
    }

    /// The same with these weights of the nodes.
    pub(in crate::engine) fn way_at(&self, a: usize, weights: &Weights) -> f64 {
        let Some((row, from)) = self.row(a) else { return self.way_before(a) };
        self.way_before(a) + sum(&std::array::from_fn(|k| weights[k] * (row[k] - from)))
    }

    /// The weights of the nodes at this γ, or at the end of the window if that is behind it, by Lagrange's formula
    /// (Wang, Huybrechs, Vandewalle, Math. Comp. 83, 2014).
    pub(in crate::engine) fn weights_at(&self, gamma: f64) -> Weights {
        let at = ((gamma - self.attempt.gamma.high) / self.attempt.accepted.length).min(1.0);
        let nodes = &self.lent.solver.rule.nodes[0].0;
        let weights: Weights = std::array::from_fn(|k| self.barycentric[k] / (at - nodes[k]));
        let all = 1.0 / sum(&weights);
        // On a node its weight is infinite.
        if all == 0.0 { nodes.map(|node| f64::from(u8::from(node == at))) } else { weights.map(|weight| weight * all) }
    }
}

/// The sum of all, of which four parts go side by side.
#[inline(always)]
fn sum(terms: &Weights) -> f64 {
    let mut sums = [0.0; 4];
    for terms in terms.as_chunks::<4>().0 {
        sums.iter_mut().zip(terms).for_each(|(sum, term)| *sum += term);
    }
    (sums[0] + sums[2]) + (sums[1] + sums[3])
}
