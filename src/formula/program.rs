//! Straight-line programs: what the outputs of a graph need, one step a value.

use super::Function;
use super::graph::{Graph, Node, NodeId};
use super::operation::{Fused, Operation};
use crate::number::Real;
use crate::number::spline::Table;

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
pub(crate) struct Output {
    register: Register,
    /// So many steps compute this output and all before it.
    steps: usize,
}

/// A straight-line program. Every value has a register of its own: the first are the variables, then come the
/// constants, then one for each step. So a step reads what lies below the register that it writes, and any number of
/// schedules work on one register file.
#[derive(Debug, Clone)]
pub(crate) struct Program<S> {
    /// Number of variables.
    pub(crate) variables: usize,
    pub(super) constants: Vec<S>,
    pub(super) steps: Vec<Step>,
    pub(crate) outputs: Vec<Output>,
}

/// The nodes in the order of the outputs that need them; an output is computed before work for the next one begins. A
/// sine and the cosine of the same stand side by side, if both are wanted.
fn in_order<S: Real>(graph: &Graph<S>, outputs: &[NodeId]) -> Vec<NodeId> {
    let is_wanted: Vec<bool> = graph.uses(outputs).into_iter().map(|uses| uses > 0).collect();
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

    /// The same program with a product and a sum as one step, where nothing but sums needs the product.
    pub(crate) fn fused(&self) -> Self {
        let operations: Vec<Operation> = self.steps.iter().map(|step| step.operation()).collect();
        let terms = |operation: &Operation| match *operation {
            Operation::Add(a, b) | Operation::Subtract(a, b) => Some([a, b]),
            _ => None,
        };
        let (mut uses, mut sums) = (vec![0_usize; self.size()], vec![0_usize; self.size()]);
        operations.iter().flat_map(|operation| operation.operands()).for_each(|operand| uses[operand] += 1);
        (0..self.outputs.len()).for_each(|output| uses[self.output(output)] += 1);
        operations.iter().filter_map(terms).flatten().for_each(|term| sums[term] += 1);
        let mut products: Vec<Option<[Register; 2]>> = vec![None; self.size()];
        for step in self.steps.iter().filter(|step| uses[step.to()] == sums[step.to()]) {
            if let Operation::Multiply(a, b) = step.operation() {
                products[step.to()] = Some([a, b]);
            }
        }
        for [a, b] in operations.iter().filter_map(terms) {
            // The first one of two products stays, wherever it is needed.
            if products[b].is_some() {
                products[a] = None;
            }
        }
        let fuse = |operation: Operation| {
            let (a, b, [of_first, of_second]) = match operation {
                Operation::Add(a, b) => (a, b, [Fused::Add, Fused::Add]),
                Operation::Subtract(a, b) => (a, b, [Fused::Subtract, Fused::SubtractFrom]),
                _ => return operation,
            };
            match (products[a], products[b]) {
                (_, Some([c, d])) => Operation::Fused(of_second, [c, d, a]),
                (Some([c, d]), None) => Operation::Fused(of_first, [c, d, b]),
                (None, None) => operation,
            }
        };
        let fused: Vec<Operation> = operations.iter().map(|&operation| fuse(operation)).collect();
        let first = self.size() - self.steps.len();
        let mut place_of: Vec<Register> = (0..self.size()).collect();
        let mut operations = Vec::new();
        for (register, operation) in (first..).zip(fused).filter(|&(register, _)| products[register].is_none()) {
            place_of[register] = first + operations.len();
            operations.push(operation.map(|operand| place_of[operand]));
        }
        let outputs = (0..self.outputs.len()).map(|output| place_of[self.output(output)]);
        Self::of_operations(self.variables, self.constants.clone(), operations, outputs)
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

    /// True for the registers that the `wanted` ones need, themselves among them, but for what is known already.
    pub(crate) fn needed(
        &self,
        wanted: impl IntoIterator<Item = Register>,
        is_known: impl Fn(Register) -> bool,
    ) -> Vec<bool> {
        let mut is_needed = vec![false; self.size()];
        wanted.into_iter().for_each(|register| is_needed[register] = true);
        for step in self.steps.iter().rev() {
            is_needed[step.to()] &= !is_known(step.to());
            if is_needed[step.to()] {
                step.operation().operands().for_each(|operand| is_needed[operand] = true);
            }
        }
        is_needed
    }

    /// The steps that compute the `wanted` registers with all that they need, but for what is known already.
    pub(crate) fn schedule(
        &self,
        wanted: impl IntoIterator<Item = Register>,
        is_known: impl Fn(Register) -> bool,
    ) -> Box<[Step]> {
        let is_needed = self.needed(wanted, is_known);
        self.steps.iter().filter(|step| is_needed[step.to()]).copied().collect()
    }

    /// The tables that the program reads, each with the register of its argument: knots lie at values of that.
    pub(crate) fn arguments_of_tables(&self) -> impl Iterator<Item = (Register, Table)> {
        self.steps.iter().filter_map(|step| match step.operation() {
            Operation::Call(Function::Table(table), argument) => Some((argument, table)),
            _ => None,
        })
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

    /// The constants, with their registers.
    pub(crate) fn constants(&self) -> impl Iterator<Item = (Register, S)> {
        self.constants.iter().enumerate().map(|(k, &constant)| (self.variables + k, constant))
    }

    /// Number of registers.
    pub(crate) fn size(&self) -> usize {
        self.variables + self.constants.len() + self.steps.len()
    }

    /// The register of an output.
    #[inline]
    pub(crate) fn output(&self, index: usize) -> Register {
        self.outputs[index].register
    }
}
