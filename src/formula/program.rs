//! Straight-line programs: what the outputs of a graph need, one step a value.

use super::graph::{Graph, Node, NodeId};
use super::operation::Operation;
use crate::number::Real;

/// The place of a value in a register file.
pub(crate) type Register = usize;

/// Computes one value from earlier ones. Programs are read from memory step by step, so that a step is kept small.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Step {
    pub(super) to: u32,
    pub(super) operation: Operation<u32>,
}

impl Step {
    fn new(to: Register, operation: Operation) -> Self {
        let small = |register: Register| u32::try_from(register).expect("a program has far fewer values");
        Self { to: small(to), operation: operation.map(small) }
    }

    /// The register that it writes.
    pub(crate) fn to(&self) -> Register {
        self.to as Register
    }

    /// Its operation, and the registers of its operands.
    pub(crate) fn operation(&self) -> Operation {
        self.operation.map(|operand| operand as Register)
    }
}

/// One of the wanted values.
#[derive(Debug, Clone, Copy)]
pub(super) struct Output {
    register: Register,
    /// So many steps compute this output and all before it.
    steps: usize,
}

/// A straight-line program. Every value has a register of its own: the first are the variables, then come the
/// constants, then one for each step. So a step reads what lies below the register that it writes, and any number of
/// schedules work on one register file.
#[derive(Debug, Clone)]
pub(crate) struct Program<S> {
    pub(super) variables: usize,
    pub(super) constants: Vec<S>,
    pub(super) steps: Vec<Step>,
    pub(super) outputs: Vec<Output>,
}

/// The nodes in the order of the outputs that need them; an output is computed before work for the next one begins. A
/// sine and the cosine of the same stand side by side, if both are wanted.
fn in_order<S: Real>(graph: &Graph<S>, outputs: &[NodeId]) -> Vec<NodeId> {
    let is_wanted = graph.needed(outputs);
    let pair =
        |id: NodeId| graph.sine_and_cosine(id).filter(|pair| pair.iter().all(|&id| is_wanted.get(id) == Some(&true)));
    let mut order: Vec<NodeId> = Vec::with_capacity(is_wanted.iter().filter(|&&is_wanted| is_wanted).count());
    let mut is_known = vec![false; is_wanted.len()];
    let mut waiting = Vec::new();
    for &output in outputs {
        let first = order.len();
        waiting.push(output);
        while let Some(id) = waiting.pop() {
            if !std::mem::replace(&mut is_known[id], true) {
                order.push(id);
                waiting.extend(graph.nodes[id].operands());
                // The other one of a pair needs nothing else.
                waiting.extend(pair(id).into_iter().flatten());
            }
        }
        // Operands have smaller indices.
        order[first..].sort_unstable_by_key(|&id| {
            pair(id).map_or((id, 0), |[sin, cos]| (sin.min(cos), usize::from(id == cos) + 1))
        });
    }
    order
}

impl<S: Real> Program<S> {
    /// Compiles what `outputs` need, which are expressions in the first `variables` variables.
    pub(crate) fn new(graph: &mut Graph<S>, variables: usize, outputs: &[NodeId]) -> Self {
        let outputs = graph.expand_powers(outputs);
        let order = in_order(graph, &outputs);
        let mut register_of = vec![Register::MAX; graph.nodes.len()];
        let mut constants = Vec::new();
        for &id in &order {
            match graph.nodes[id] {
                Node::Variable(index) => register_of[id] = index,
                Node::Constant(constant) => {
                    register_of[id] = variables + constants.len();
                    constants.push(graph.number(constant));
                }
                Node::PowerInteger(..) | Node::Apply(_) => {}
            }
        }
        let first = variables + constants.len();
        let mut operations = Vec::new();
        for &id in &order {
            if let Node::Apply(operation) = graph.nodes[id] {
                register_of[id] = first + operations.len();
                operations.push(operation.map(|operand| register_of[operand]));
            }
        }
        Self::of_operations(variables, constants, operations, outputs.iter().map(|&output| register_of[output]))
    }

    /// From operations on earlier values, each of which makes the next value after variables and constants.
    pub(super) fn of_operations(
        variables: usize,
        constants: Vec<S>,
        operations: Vec<Operation>,
        outputs: impl Iterator<Item = Register>,
    ) -> Self {
        let first = variables + constants.len();
        let steps = operations.into_iter().enumerate().map(|(place, operation)| Step::new(first + place, operation));
        let mut known = 0;
        let outputs = outputs.map(|register| {
            known = known.max((register + 1).saturating_sub(first));
            Output { register, steps: known }
        });
        Self { variables, constants, steps: steps.collect(), outputs: outputs.collect() }
    }

    /// Which registers depend on these variables.
    pub(crate) fn depends_on(&self, is_variable: impl Fn(usize) -> bool) -> Vec<bool> {
        let is_among = |register: Register| register < self.variables && is_variable(register);
        let mut depends: Vec<bool> = (0..self.size()).map(is_among).collect();
        for step in &self.steps {
            depends[step.to()] = step.operation().operands().any(|operand| depends[operand]);
        }
        depends
    }

    /// The steps that compute the `wanted` registers with all that they need, but for what is known already.
    pub(crate) fn schedule(
        &self,
        wanted: impl IntoIterator<Item = Register>,
        is_known: impl Fn(Register) -> bool,
    ) -> Box<[Step]> {
        let mut is_needed = vec![false; self.size()];
        wanted.into_iter().for_each(|register| is_needed[register] = true);
        for step in self.steps.iter().rev() {
            is_needed[step.to()] &= !is_known(step.to());
            if is_needed[step.to()] {
                step.operation().operands().for_each(|operand| is_needed[operand] = true);
            }
        }
        self.steps.iter().filter(|step| is_needed[step.to()]).copied().collect()
    }

    /// The steps to the first `outputs` outputs: the schedule of these that needs no room of its own.
    pub(crate) fn steps_to(&self, outputs: usize) -> &[Step] {
        &self.steps[..if outputs == 0 { 0 } else { self.outputs[outputs - 1].steps }]
    }

    /// A register file with the constants in place.
    pub(crate) fn registers<V: Clone>(&self, constant: impl Fn(S) -> V) -> Vec<V> {
        let mut registers = vec![constant(S::ZERO); self.size()];
        let constants = registers[self.variables..].iter_mut().zip(&self.constants);
        constants.for_each(|(register, &value)| *register = constant(value));
        registers
    }

    /// Number of registers.
    pub(crate) fn size(&self) -> usize {
        self.variables + self.constants.len() + self.steps.len()
    }

    /// Number of variables.
    pub(crate) fn variables(&self) -> usize {
        self.variables
    }

    /// Number of outputs.
    pub(crate) fn outputs(&self) -> usize {
        self.outputs.len()
    }

    /// The register of an output.
    #[inline]
    pub(crate) fn output(&self, index: usize) -> Register {
        self.outputs[index].register
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::super::{Graph, Names, parse};
    use super::Program;

    /// f with the first derivatives and the mixed second one, in x and y.
    fn program(expression: &str) -> Program<f64> {
        let mut graph = Graph::default();
        let parameters = BTreeMap::from([("a".to_owned(), 0.7)]);
        let f = parse(
            expression,
            Names { variables: &["x", "y"], parameters: &parameters, definitions: &BTreeMap::new(), tables: &[] },
            &mut graph,
        )
        .unwrap();
        let [f_x, f_y] = [0, 1].map(|variable| graph.derivative(f, variable));
        let f_xy = graph.derivative(f_x, 1);
        assert_eq!(graph.derivative(f_x, 1), f_xy, "memoised");
        Program::new(&mut graph, 2, &[f, f_x, f_y, f_xy])
    }

    #[test]
    fn several_variables() {
        let (x, y) = (0.3_f64, -1.2_f64);
        for (expression, expected) in [
            ("x*y + a", [x * y + 0.7, y, x, 1.0]),
            ("x^3*y^2", [x.powi(3) * y.powi(2), 3.0 * x * x * y * y, 2.0 * x.powi(3) * y, 6.0 * x * x * y]),
            ("sin(x*y)", {
                let (s, c) = (x * y).sin_cos();
                [s, y * c, x * c, c - x * y * s]
            }),
            ("1/(x - y)", {
                let r = 1.0 / (x - y);
                [r, -r * r, r * r, -2.0 * r * r * r]
            }),
            ("2", [2.0, 0.0, 0.0, 0.0]),
        ] {
            let values: [f64; 4] = program(expression).values(&[x, y]);
            for (value, expected) in values.iter().zip(expected) {
                assert!((value - expected).abs() < 1e-14, "{expression}: {values:?}");
            }
        }
    }

    #[test]
    fn what_is_equal_is_computed_once() {
        // x^4 is the square of x^2, of which the derivatives in x need the product with x.
        assert_eq!(program("x^4 + x^2").steps_to(1).len(), 3);
        assert_eq!(program("x*y + y*x").steps_to(1).len(), 2);
        assert_eq!(program("x/8 + x*0.125").steps_to(1).len(), 2);
        assert_eq!(program("0*exp(x) + y").steps_to(2).len(), 0);
    }
}
