//! Programs whose products and sums are one step, for algebras that have an instruction for both.

use super::operation::{Fused, Operation};
use super::program::{Program, Register};
use crate::number::Real;

impl<S: Real> Program<S> {
    /// The same program with a product and a sum as one step, where nothing but sums needs the product.
    pub(crate) fn fused(&self) -> Self {
        let operations: Vec<Operation> = self.steps.iter().map(|step| step.operation()).collect();
        let terms = |operation: &Operation| match *operation {
            Operation::Add(a, b) | Operation::Subtract(a, b) => Some([a, b]),
            _ => None,
        };
        let (mut uses, mut sums) = (vec![0_usize; self.size()], vec![0_usize; self.size()]);
        operations.iter().flat_map(|operation| operation.operands()).for_each(|operand| uses[operand] += 1);
        (0..self.outputs()).for_each(|output| uses[self.output(output)] += 1);
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
        let outputs = (0..self.outputs()).map(|output| place_of[self.output(output)]);
        Self::of_operations(self.variables, self.constants.clone(), operations, outputs)
    }
}
