//! Straight-line programs: what the outputs of a graph need, one step a value.

use super::Function;
pub(crate) use super::graph::Operation;
use super::graph::{Fused, Graph, Node, NodeId};
use super::machine::Machine;
use crate::number::Real;

/// The place of a value while a program runs.
pub(crate) type Register = usize;

/// Computes one value from earlier ones.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Step {
    pub(crate) to: Register,
    pub(crate) operation: Operation,
}

/// One of the wanted values.
#[derive(Debug, Clone, Copy)]
pub(super) struct Output {
    pub(super) register: Register,
    /// So many steps compute this output and all before it.
    pub(super) steps: usize,
}

/// A straight-line program. The first registers are the variables, then come the constants, then the values of steps.
#[derive(Debug, Clone)]
pub(crate) struct Program<S> {
    pub(super) variables: usize,
    pub(super) constants: Vec<S>,
    pub(super) steps: Vec<Step>,
    pub(super) outputs: Vec<Output>,
    pub(super) registers: usize,
}

/// The nodes in the order of the outputs that need them, and how many of them each output needs; an output is computed
/// before work for the next one begins. A sine and the cosine of the same stand side by side, if both are wanted.
fn in_order<S: Real>(graph: &Graph<S>, outputs: &[NodeId], is_wanted: &[bool]) -> (Vec<NodeId>, Vec<usize>) {
    let mut order: Vec<NodeId> = Vec::new();
    let mut is_known = vec![false; graph.nodes.len()];
    let mut nodes_for = Vec::new();
    for &output in outputs {
        let mut is_needed = vec![false; output + 1];
        is_needed[output] = !is_known[output];
        for id in (0..=output).rev().filter(|&id| !is_known[id]) {
            if is_needed[id] {
                graph.nodes[id].operands().for_each(|operand| is_needed[operand] |= !is_known[operand]);
            }
        }
        for id in (0..=output).filter(|&id| is_needed[id]) {
            let group = graph.sine_and_cosine(id).filter(|pair| pair.iter().all(|&id| is_wanted[id]));
            for id in group.as_ref().map_or(&[id][..], |pair| pair) {
                if !std::mem::replace(&mut is_known[*id], true) {
                    order.push(*id);
                }
            }
        }
        nodes_for.push(order.len());
    }
    (order, nodes_for)
}

impl<S: Real> Program<S> {
    /// Compiles what `outputs` need, which are expressions in the first `variables` variables. Every value has a
    /// register of its own, see [`Self::packed`].
    pub(crate) fn new(graph: &mut Graph<S>, variables: usize, outputs: &[NodeId]) -> Self {
        let outputs = graph.expand_powers(outputs);
        let mut is_wanted = vec![false; graph.nodes.len()];
        outputs.iter().for_each(|&output| is_wanted[output] = true);
        for id in (0..graph.nodes.len()).rev() {
            if is_wanted[id] {
                graph.nodes[id].operands().for_each(|operand| is_wanted[operand] = true);
            }
        }
        let (order, nodes_for) = in_order(graph, &outputs, &is_wanted);
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
        let mut steps: Vec<Step> = Vec::new();
        let mut steps_for = vec![0; outputs.len()];
        for (place, &id) in order.iter().enumerate() {
            if let Node::Apply(operation) = graph.nodes[id] {
                register_of[id] = first + steps.len();
                steps.push(Step { to: register_of[id], operation: operation.map(|operand| register_of[operand]) });
            }
            for (count, &nodes) in steps_for.iter_mut().zip(&nodes_for) {
                if place < nodes {
                    *count = steps.len();
                }
            }
        }
        let output = |(&id, &steps): (&NodeId, &usize)| Output { register: register_of[id], steps };
        let outputs = outputs.iter().zip(&steps_for).map(output).collect();
        Self { variables, constants, registers: first + steps.len(), steps, outputs }
    }

    /// From steps that each write the next register after those of variables and constants.
    pub(super) fn of_steps(variables: usize, constants: Vec<S>, steps: Vec<Step>, outputs: &[Register]) -> Self {
        let first = variables + constants.len();
        let mut known = 0;
        let outputs = outputs.iter().map(|&register| {
            known = known.max((register + 1).saturating_sub(first));
            Output { register, steps: known }
        });
        let outputs = outputs.collect();
        Self { variables, constants, registers: first + steps.len(), steps, outputs }
    }

    /// What these registers need and nothing else, of a program in which every value has a register of its own.
    pub(super) fn only(&self, outputs: &[Register]) -> Self {
        let mut is_needed = vec![false; self.registers];
        outputs.iter().for_each(|&output| is_needed[output] = true);
        for step in self.steps.iter().rev() {
            if is_needed[step.to] {
                step.operation.operands().for_each(|operand| is_needed[operand] = true);
            }
        }
        let first = self.variables + self.constants.len();
        let mut place_of: Vec<Register> = (0..self.registers).collect();
        let mut steps = Vec::new();
        for step in self.steps.iter().filter(|step| is_needed[step.to]) {
            place_of[step.to] = first + steps.len();
            let operation = step.operation.map(|operand| place_of[operand]);
            steps.push(Step { to: place_of[step.to], operation });
        }
        let outputs: Vec<Register> = outputs.iter().map(|&output| place_of[output]).collect();
        Self::of_steps(self.variables, self.constants.clone(), steps, &outputs)
    }

    /// Whether a step or an output reads this register.
    pub(super) fn reads(&self, register: Register) -> bool {
        let is_operand = self.steps.iter().any(|step| step.operation.operands().any(|operand| operand == register));
        is_operand || self.outputs.iter().any(|output| output.register == register)
    }

    /// Which registers depend on these variables, where every value has a register of its own.
    pub(super) fn dependent(&self, is_variable: impl Fn(usize) -> bool) -> Vec<bool> {
        let is_among = |place: usize| place < self.variables && is_variable(place);
        let mut depends: Vec<bool> = (0..self.registers).map(is_among).collect();
        for step in &self.steps {
            depends[step.to] = step.operation.operands().any(|operand| depends[operand]);
        }
        depends
    }

    /// The same program in fewer registers: a value that is not needed any more leaves its place to another one.
    pub(crate) fn packed(&self) -> Self {
        self.packed_but(&vec![false; self.registers])
    }

    /// The same, but what is kept leaves its register to nothing, and takes it from nothing.
    pub(super) fn packed_but(&self, keeps: &[bool]) -> Self {
        let fixed = self.variables + self.constants.len();
        // The step after which a register is free.
        let mut last_use = vec![0; self.registers];
        for (place, step) in self.steps.iter().enumerate() {
            step.operation.operands().for_each(|operand| last_use[operand] = place);
        }
        for output in &self.outputs {
            last_use[output.register] = usize::MAX;
        }
        let mut place_of: Vec<Register> = (0..self.registers).collect();
        let (mut free, mut registers) = (Vec::new(), fixed);
        let mut steps = Vec::with_capacity(self.steps.len());
        for (place, step) in self.steps.iter().enumerate() {
            // Operands are freed afterwards: a step does not write where it reads.
            let known = if keeps[step.to] { None } else { free.pop() };
            let to = known.unwrap_or_else(|| {
                registers += 1;
                registers - 1
            });
            let mut ended: Vec<Register> = step.operation.operands().collect();
            ended.retain(|&operand| operand >= fixed && last_use[operand] == place && !keeps[operand]);
            ended.dedup();
            free.extend(ended.iter().map(|&operand| place_of[operand]));
            steps.push(Step { to, operation: step.operation.map(|operand| place_of[operand]) });
            place_of[step.to] = to;
        }
        let output = |output: &Output| Output { register: place_of[output.register], ..*output };
        let outputs = self.outputs.iter().map(output).collect();
        Self { variables: self.variables, constants: self.constants.clone(), steps, outputs, registers }
    }

    /// Number of variables.
    pub(crate) fn variables(&self) -> usize {
        self.variables
    }

    /// Number of registers.
    pub(crate) fn registers(&self) -> usize {
        self.registers
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

    /// Number of steps that compute the first `outputs` outputs.
    pub(crate) fn steps(&self, outputs: usize) -> usize {
        if outputs == 0 { 0 } else { self.outputs[outputs - 1].steps }
    }

    /// What these steps do, in order, with the registers that they write.
    pub(crate) fn operations(&self, outputs: usize) -> impl Iterator<Item = (Register, Operation)> + '_ {
        self.steps[..self.steps(outputs)].iter().map(|step| (step.to, step.operation))
    }

    /// Hands out the constants and their registers.
    #[inline]
    pub(crate) fn each_constant(&self, mut see: impl FnMut(Register, S)) {
        for (place, &constant) in self.constants.iter().enumerate() {
            see(self.variables + place, constant);
        }
    }

    /// The steps to the first `outputs` outputs.
    pub(crate) fn steps_to(&self, outputs: usize) -> &[Step] {
        &self.steps[..self.steps(outputs)]
    }

    /// Lets `machine` compute the first `outputs` outputs.
    #[inline(always)]
    pub(crate) fn walk(&self, outputs: usize, machine: &mut impl Machine) {
        walk(self.steps_to(outputs), machine);
    }
}

/// Lets `machine` carry out steps.
#[inline(always)]
pub(crate) fn walk(steps: &[Step], machine: &mut impl Machine) {
    let mut k = 0;
    while k < steps.len() {
        let Step { to: place, operation } = steps[k];
        k += 1;
        match operation {
            Operation::Add(a, b) => machine.add(place, a, b),
            Operation::Subtract(a, b) => machine.subtract(place, a, b),
            Operation::Multiply(a, b) => machine.multiply(place, a, b),
            Operation::Divide(a, b) => machine.divide(place, a, b),
            Operation::Negate(a) => machine.negate(place, a),
            Operation::Power(a, b) => machine.power(place, a, b),
            Operation::Fused(Fused::Add, operands) => machine.fused(place, Fused::Add, operands),
            Operation::Fused(Fused::Subtract, operands) => machine.fused(place, Fused::Subtract, operands),
            Operation::Fused(Fused::SubtractFrom, operands) => machine.fused(place, Fused::SubtractFrom, operands),
            Operation::Call(function, a) => match steps.get(k) {
                Some(&Step { to: cos, operation: Operation::Call(Function::Cos, b) })
                    if function == Function::Sin && a == b =>
                {
                    k += 1;
                    machine.sin_cos(place, cos, a);
                }
                _ => machine.call(place, function, a),
            },
        }
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
            Names { variables: &["x", "y"], parameters: &parameters, definitions: &BTreeMap::new() },
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
    fn packing_changes_no_number_and_takes_fewer_registers() {
        let long = "exp(-a*x^2)*cos(y)/(1 + x^2*y^2) + sqrt(x^4 + y^4 + 2) - tanh(x*y)^3";
        for expression in ["x", "x*y + a", "x^7*y^2 - 1/y", long] {
            let (own, packed) = (program(expression), program(expression).packed());
            assert!(packed.registers() <= own.registers());
            for point in [[0.3, -1.2], [2.0, 0.5], [-1.0, 3.0]] {
                let [a, b]: [[f64; 4]; 2] = [own.values(&point), packed.values(&point)];
                assert_eq!(a.map(f64::to_bits), b.map(f64::to_bits), "{expression}");
            }
        }
        let [own, packed] = [program(long).registers(), program(long).packed().registers()];
        assert!(2 * packed < own, "{packed} of {own}");
    }

    #[test]
    fn what_is_equal_is_computed_once() {
        // x^4 is the square of x^2, of which the derivatives in x need the product with x.
        assert_eq!(program("x^4 + x^2").steps(1), 3);
        assert_eq!(program("x*y + y*x").steps(1), 2);
        assert_eq!(program("x/8 + x*0.125").steps(1), 2);
        assert_eq!(program("0*exp(x) + y").steps(2), 0);
    }
}
