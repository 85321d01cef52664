//! Functions of two arguments, written by those of one.

use super::Function;
use super::graph::{Graph, NodeId};
use crate::number::Real;

/// Writes a function of two arguments.
pub(super) type Pair<S> = fn(&mut Graph<S>, NodeId, NodeId) -> NodeId;

impl<S: Real> Graph<S> {
    /// The functions of two arguments by name.
    pub(super) const PAIRS: [(&'static str, Pair<S>); 4] =
        [("min", Self::min), ("max", Self::max), ("atan2", Self::angle), ("hypot", Self::hypot)];

    fn min(&mut self, a: NodeId, b: NodeId) -> NodeId {
        let difference = self.subtract(a, b);
        self.choose(difference, [b, a])
    }

    fn max(&mut self, a: NodeId, b: NodeId) -> NodeId {
        let difference = self.subtract(a, b);
        self.choose(difference, [a, b])
    }

    fn hypot(&mut self, a: NodeId, b: NodeId) -> NodeId {
        let [square, other] = [a, b].map(|side| self.power_integer(side, 2));
        let sum = self.add(square, other);
        self.call(Function::Sqrt, sum)
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
        let (side, length) = (self.choose(x, [one, minus_one]), self.hypot(y, x));
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

#[cfg(test)]
mod tests {
    use super::super::{Names, Program, parse};
    use super::Graph;

    /// The value of a formula of x and y, and its derivatives by these.
    fn values(formula: &str, at: [f64; 2]) -> [f64; 3] {
        let mut graph = Graph::default();
        let value = parse(formula, &["x", "y"], &Names::new(), &mut graph).unwrap();
        let [by_x, by_y] = [0, 1].map(|variable| graph.derivative(value, variable));
        Program::new(&mut graph, 2, &[value, by_x, by_y]).values(&at)
    }

    #[test]
    fn functions_of_two_arguments_are_what_they_are_called() {
        for (x, y) in [(0.3, -1.2), (-0.7, -1e-9), (-0.7, 1e-9), (2.0, 2.0), (-3.0, 0.0), (1e200, 1.0), (0.0, -2.0)] {
            let square: f64 = x * x + y * y;
            let less = f64::from(x < y);
            for (formula, expected) in [
                ("min(x, y)", [x.min(y), less, 1.0 - less]),
                ("max(y, x)", [x.max(y), 1.0 - f64::from(x <= y), f64::from(x <= y)]),
                ("hypot(x, y)", [x.hypot(y), x / x.hypot(y), y / x.hypot(y)]),
                ("atan2(y, x)", [y.atan2(x), -y / square, x / square]),
                ("sign(x)*step(y)", [if y >= 0.0 && x != 0.0 { x.signum() } else { 0.0 }, 0.0, 0.0]),
            ] {
                for (found, expected) in values(formula, [x, y]).into_iter().zip(expected) {
                    let is_near = (found - expected).abs() <= 4e-15 * expected.abs().max(1e-300);
                    assert!(is_near || square.is_infinite(), "{formula} at {x}, {y}: {found} is not {expected}");
                }
            }
        }
        assert_eq!(
            [values("min(x, 2)", [f64::NAN, 0.0])[0].is_nan(), values("step(x)", [-0.0, 0.0])[0] == 1.0],
            [true; 2]
        );
    }

    #[test]
    fn a_missing_argument_is_missed() {
        let mistake =
            |formula| parse(formula, &["x"], &Names::<f64>::new(), &mut Graph::default()).unwrap_err().message;
        assert_eq!(mistake("min(x)"), "the function 'min' has two arguments: expected a comma, found ')'");
        assert_eq!(mistake("atan2"), "the function 'atan2' needs its two arguments in parentheses");
        assert!(mistake("sin(x, x)").starts_with("expected an operator or the ')'"), "{}", mistake("sin(x, x)"));
    }
}
