//! Functions of two arguments, written by those of one.

use super::Function;
use super::graph::{Graph, NodeId};
use crate::number::Real;

/// A function of two arguments.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Pair {
    Min,
    Max,
    Atan2,
    Hypot,
}

impl Pair {
    /// Every one with its name.
    pub(crate) const NAMED: [(&'static str, Self); 4] =
        [("min", Self::Min), ("max", Self::Max), ("atan2", Self::Atan2), ("hypot", Self::Hypot)];
}

/// The function of that name.
pub(super) fn from_name(name: &str) -> Option<Pair> {
    Pair::NAMED.iter().find(|(other, _)| *other == name).map(|&(_, pair)| pair)
}

impl<S: Real> Graph<S> {
    /// The value of a function of two arguments.
    pub(super) fn pair(&mut self, pair: Pair, a: NodeId, b: NodeId) -> NodeId {
        match pair {
            Pair::Min | Pair::Max => {
                let difference = self.subtract(a, b);
                let larger = if matches!(pair, Pair::Max) { [a, b] } else { [b, a] };
                self.choose(difference, larger)
            }
            Pair::Hypot => {
                let [square, other] = [a, b].map(|side| self.power_integer(side, 2));
                let sum = self.add(square, other);
                self.call(Function::Sqrt, sum)
            }
            Pair::Atan2 => self.angle(a, b),
        }
    }

    /// The first value where `decides` is not negative, and elsewhere the second one.
    fn choose(&mut self, decides: NodeId, [first, second]: [NodeId; 2]) -> NodeId {
        let (step, one) = (self.call(Function::Step, decides), self.whole(1));
        let rest = self.subtract(one, step);
        let (first, second) = (self.multiply(step, first), self.multiply(rest, second));
        self.add(first, second)
    }

    /// The angle of (x, y), from twice that of the point that halves it: that is accurate where |x| stands, and on the
    /// left side the angle to the negative axis is found so.
    fn angle(&mut self, y: NodeId, x: NodeId) -> NodeId {
        let [one, minus_one, zero] = [1, -1, 0].map(|number| self.whole(number));
        let half_turn = self.constant(S::PI);
        let (side, length) = (self.choose(x, [one, minus_one]), self.pair(Pair::Hypot, y, x));
        let distance = self.multiply(side, x);
        let sum = self.add(length, distance);
        let tangent = self.divide(y, sum);
        let (half, two) = (self.call(Function::Atan, tangent), self.whole(2));
        let whole = self.multiply(two, half);
        let from_axis = self.multiply(side, whole);
        let above = self.choose(y, [one, minus_one]);
        let opposite = self.multiply(half_turn, above);
        let axis = self.choose(x, [zero, opposite]);
        self.add(axis, from_axis)
    }
}
