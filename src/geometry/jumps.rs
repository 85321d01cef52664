//! Places where the metric or the one-form jumps. The derivative of a step is 0 on both sides of it, so that the motion
//! would pass a wall and not know of it.
//!
//! A step is harmless where it is multiplied by what is 0 there, as in those of min and max. So what it adds is
//! evaluated where its argument is 0: along lines from a point, at all distances.

use super::parts::Parts;
use super::text::GeometryText;
use crate::formula::{Function, Graph, NodeId, Program};
use crate::number::root::root;

/// A place where a metric or a one-form jumps.
#[derive(Debug, Clone, PartialEq)]
pub struct Jump {
    /// The name of the function that jumps: step or sign.
    pub function: &'static str,
    /// The coordinates there.
    pub at: Vec<f64>,
    /// The coordinates at points on both sides of it, not near it.
    pub beside: [Vec<f64>; 2],
}

/// Lines are looked at from a point on at distances of 10^−4 … 10^4 times the size of the point, so many for each power
/// of ten. A surface is met if a line passes it alone between two of these.
const DECADES: [i32; 2] = [-4, 4];
const EACH: i32 = 40;

/// So many lines go in directions of no axis.
const OBLIQUE: usize = 8;

/// What a step adds where its argument is 0 is rounding if it is below the first part of the values, or below the
/// second of what it adds elsewhere: its zero is known to some 1e-16 of the distance on the line.
const ROUNDING: [f64; 2] = [1e-12, 1e-6];

/// Right beside a place, as parts of the way to the next one.
const BESIDE: [f64; 2] = [1e-9, 1e-10];

/// The steps in a metric and a one-form, each with the name of its function.
#[derive(Debug, Clone)]
pub struct Steps(Vec<(&'static str, Sides)>);

impl Steps {
    /// Those of a scene.
    pub fn new(text: &GeometryText) -> Self {
        let Ok(Parts { mut graph, metric, one_form, names, .. }) = Parts::<f64>::new(text) else {
            return Self(Vec::new());
        };
        let roots: Vec<NodeId> = metric.into_values().chain(one_form.into_values()).collect();
        let mut found = Vec::new();
        for (call, function, argument) in graph.calls(&roots) {
            let (name, values) = match function {
                Function::Step => ("step", [0.0, 1.0].map(|value| graph.constant(value))),
                Function::Sign => ("sign", [-1.0, 1.0].map(|value| graph.constant(value))),
                // A number that is divided by it may jump.
                Function::Abs => ("abs", [graph.negate(argument), argument]),
                _ => continue,
            };
            let sides = Sides::new(&mut graph, names.len(), &roots, (call, argument), values);
            found.push((name, Sides { is_kink: function == Function::Abs, ..sides }));
        }
        Self(found)
    }

    /// The jumps that are met on lines from `from`.
    pub fn jumps(&mut self, from: &[f64]) -> Vec<Jump> {
        let mut found = Vec::new();
        for (name, sides) in &mut self.0 {
            let met = directions(from.len()).into_iter().filter_map(|direction| sides.jump_on(from, &direction));
            found.extend(met.map(|(at, beside)| Jump { function: name, at, beside }));
        }
        found
    }
}

/// The directions of all axes, and some others.
fn directions(n: usize) -> Vec<Vec<f64>> {
    let axis = |a: usize, sign: f64| (0..n).map(|b| if a == b { sign } else { 0.0 }).collect();
    let axes = (0..n).flat_map(|a| [axis(a, 1.0), axis(a, -1.0)]);
    // Angles that are no fractions of a turn.
    let oblique = (1..=OBLIQUE).map(|k| (0..n).map(|a| ((k * n + a) as f64 * 2.4).sin()).collect());
    axes.chain(oblique).collect()
}

/// The argument of a function with two values, and everything that may jump with each of them.
#[derive(Debug, Clone)]
struct Sides {
    program: Program<f64>,
    registers: Vec<[f64; 1]>,
    variables: usize,
    /// Number of what may jump.
    count: usize,
    /// True if the function itself has a kink there, and no jump.
    is_kink: bool,
}

impl Sides {
    fn new(
        graph: &mut Graph<f64>,
        variables: usize,
        roots: &[NodeId],
        (call, argument): (NodeId, NodeId),
        values: [NodeId; 2],
    ) -> Self {
        let sides = values.map(|value| graph.replaced(roots, call, value));
        let outputs = [&[argument][..], &sides[0], &sides[1]].concat();
        let program = Program::new(graph, variables, &outputs);
        Self {
            registers: program.registers(|constant| [constant]),
            program,
            variables,
            count: roots.len(),
            is_kink: false,
        }
    }

    fn evaluate(&mut self, q: &[f64]) -> f64 {
        self.registers.as_flattened_mut()[..self.variables].copy_from_slice(q);
        self.program.run(2 * self.count + 1, 1, &mut self.registers, &mut 1);
        self.value(0)
    }

    fn value(&self, output: usize) -> f64 {
        self.registers[self.program.output(output)][0]
    }

    /// By how much everything jumps at the point that was evaluated, and its size there.
    fn jumps(&self) -> Vec<[f64; 2]> {
        let sides = (1..=self.count).map(|root| [self.value(root), self.value(self.count + root)]);
        sides.map(|[low, high]| [(high - low).abs(), low.abs() + high.abs()]).collect()
    }

    /// The same right beside a point where values are 0/0; of a pole, which is no jump, nothing.
    fn beside(&mut self, [one, nearer]: [Vec<f64>; 2]) -> Vec<[f64; 2]> {
        self.evaluate(&one);
        let before = self.jumps();
        self.evaluate(&nearer);
        let is_alike = |one: f64, other: f64| (one - other).abs() <= 0.5 * other;
        let jumps = before.into_iter().zip(self.jumps());
        jumps.map(|(one, other)| if is_alike(one[0], other[0]) { other } else { [0.0; 2] }).collect()
    }

    /// The first place on a line where the argument changes its sign and something jumps, with places beside it.
    fn jump_on(&mut self, from: &[f64], direction: &[f64]) -> Option<(Vec<f64>, [Vec<f64>; 2])> {
        let size = from.iter().fold(1.0_f64, |most, q| most.max(q.abs()));
        let on_line = |s: f64| from.iter().zip(direction).map(|(q, u)| q + s * u).collect::<Vec<f64>>();
        let distances =
            (DECADES[0] * EACH..=DECADES[1] * EACH).map(|k| size * 10.0_f64.powf(f64::from(k) / f64::from(EACH)));
        let (mut before, mut at_before) = (0.0, self.evaluate(from));
        for after in distances {
            let at_after = self.evaluate(&on_line(after));
            if (at_before < 0.0) != (at_after < 0.0) && at_before.is_finite() && at_after.is_finite() {
                let ends = [[before, at_before], [after, at_after]];
                let zero = ends.iter().find(|[_, value]| *value == 0.0).map(|[at, _]| *at);
                let root = zero.unwrap_or_else(|| root(ends[0], ends[1], 0.0, |s| self.evaluate(&on_line(s))));
                let mut near = vec![0.0_f64; self.count];
                for s in [before, after] {
                    self.evaluate(&on_line(s));
                    near.iter_mut().zip(self.jumps()).for_each(|(near, jump)| *near = near.max(jump[0]));
                }
                self.evaluate(&on_line(root));
                let mut there = self.jumps();
                if self.is_kink || there.iter().any(|[jump, _]| !jump.is_finite()) {
                    let far = if after == root { before } else { after };
                    there = self.beside(BESIDE.map(|part| on_line(root + part * (far - root))));
                }
                let jumps = there.into_iter().zip(near);
                let is_jump = |([jump, size], near): ([f64; 2], f64)| jump > ROUNDING[0] * size + ROUNDING[1] * near;
                if jumps.into_iter().any(is_jump) {
                    return Some((on_line(root), [on_line(before), on_line(after)]));
                }
            }
            (before, at_before) = (after, at_after);
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The functions that jump in V(x, y).
    fn found(formula: &str) -> Vec<&'static str> {
        let text = GeometryText {
            coordinates: ["t", "x", "y"].map(str::to_owned).to_vec(),
            components: vec![([0, 0], format!("2 + {formula}")), ([1, 1], "-1".into()), ([2, 2], "-1".into())],
            ..GeometryText::default()
        };
        let mut names: Vec<_> =
            Steps::new(&text).jumps(&[0.0, 0.3, 0.2]).into_iter().map(|jump| jump.function).collect();
        names.dedup();
        names
    }

    /// A function that jumps is found unless it is multiplied by what is 0 where it does.
    #[test]
    fn what_jumps_is_told_from_what_has_a_kink() {
        assert_eq!(found("5*step(x - 1)"), ["step"]);
        assert_eq!(found("y*step(x - 1)"), ["step"]);
        assert_eq!(found("sign(x + y - 2)"), ["sign"]);
        assert_eq!(found("exp(step(t - 7))"), ["step"]);
        // Factors of both sides cancel.
        assert_eq!(found("abs(x - 1)/(x - 1)"), ["abs"]);
        assert_eq!(found("(y - 1)/abs(y - 1)"), ["abs"]);
        assert_eq!(found("max(x - 1, 2*x - 2)/(x - 1)").len(), 1);
        // The place of a kink may be looked at itself.
        let smooth = [
            "max(0, t - 1)",
            "max(1 - t, 0)",
            "max(x^2/2, 0)",
            "min(x, y)",
            "abs(x - 1)",
            "step(x - 1)*(x - 1)^2",
            "x*sign(x)",
            "x^2 + y",
            "-1/abs(x)",
            "abs(x - 1)*(x - 1)/(y^2 + 1)",
            "sqrt(abs(x - 1))",
            "ln(abs(x - 1))",
            "abs(x - 1)^3/(x - 1)",
        ];
        for formula in smooth {
            assert!(found(formula).is_empty(), "{formula}");
        }
        // An angle jumps by a whole turn, which its sine does not see.
        assert!(found("sin(atan2(y, x))").is_empty());
    }
}
