//! The values of formulas at points of a window, in which [`signs`](super::signs) looks for changes of sign.

use crate::geometry::Observable;
use crate::number::Real;
use crate::sbp::polynomial::Expansion;

/// The values of a formula and its [arguments](Observable::arguments) at the points of a part.
#[derive(Debug, Clone, Default)]
pub(crate) struct Seen<S> {
    pub(super) places: Vec<f64>,
    pub(super) values: Vec<S>,
    /// Those of the first argument at all points, then those of the second one, and so on.
    pub(super) arguments: Vec<f64>,
    pub(super) margins: Vec<f64>,
}

impl<S: Real> Seen<S> {
    /// Nothing is seen at the points of a rule.
    pub(crate) fn clear(&mut self, rule: &Expansion<S>) {
        self.places.clear();
        self.places.extend(rule.nodes.iter().map(|node| node.to_f64()));
        self.values.clear();
    }

    /// Sees the formula at all points of a rule, where q^a, dq^a/dγ and p_a are these rows, and K at the start is
    /// `norm`.
    pub(crate) fn see_all(
        &mut self,
        rule: &Expansion<S>,
        formula: &mut Observable<S>,
        [q, q_dot, p]: [&[&[S]]; 3],
        norm: S,
    ) {
        self.clear(rule);
        if formula.arguments().len() == 0 {
            self.values.resize(rule.nodes.len(), S::ZERO);
            return formula.along([q, q_dot, p], norm, &mut self.values);
        }
        let mut state = [q, q_dot, p].map(|rows| vec![S::ZERO; rows.len()]);
        for point in 0..rule.nodes.len() {
            for (values, rows) in state.iter_mut().zip([q, q_dot, p]) {
                values.iter_mut().zip(rows).for_each(|(value, row)| *value = row[point]);
            }
            let value = formula.at(&state[0], &state[1], &state[2], norm);
            self.see(formula, value);
        }
    }

    /// The value at the next point, where the formula was evaluated.
    pub(crate) fn see(&mut self, formula: &Observable<S>, value: S) {
        let (points, point) = (self.places.len(), self.values.len());
        let count = formula.arguments().len();
        self.arguments.resize(count * points, 0.0);
        for (k, argument) in formula.arguments().enumerate() {
            self.arguments[k * points + point] = argument;
        }
        self.values.push(value);
    }
}
