//! Programs whose products and sums are one step, for algebras that have an instruction for both.

use super::graph::{Fused, Operation};
use super::program::{Program, Register};
use crate::number::Real;

impl<S: Real> Program<S> {
    /// The same program with a product and the sum that alone needs it as one step.
    pub(crate) fn fused(&self) -> Self {
        let mut uses = vec![0_usize; self.size()];
        self.steps.iter().flat_map(|step| step.operation().operands()).for_each(|operand| uses[operand] += 1);
        (0..self.outputs()).for_each(|output| uses[self.output(output)] += 2);
        let mut products: Vec<Option<[Register; 2]>> = vec![None; self.size()];
        for step in &self.steps {
            if let Operation::Multiply(a, b) = step.operation() {
                products[step.to()] = (uses[step.to()] == 1).then_some([a, b]);
            }
        }
        let mut is_fused = vec![false; self.size()];
        let mut fuse = |operation: Operation| {
            let (a, b, [of_first, of_second]) = match operation {
                Operation::Add(a, b) => (a, b, [Fused::Add, Fused::Add]),
                Operation::Subtract(a, b) => (a, b, [Fused::Subtract, Fused::SubtractFrom]),
                _ => return operation,
            };
            // The later one of two products: the other one may be needed by a product before.
            match (products[a], products[b]) {
                (_, Some([c, d])) => {
                    is_fused[b] = true;
                    Operation::Fused(of_second, [c, d, a])
                }
                (Some([c, d]), None) => {
                    is_fused[a] = true;
                    Operation::Fused(of_first, [c, d, b])
                }
                (None, None) => operation,
            }
        };
        let fused: Vec<Operation> = self.steps.iter().map(|step| fuse(step.operation())).collect();
        let first = self.size() - self.steps.len();
        let mut place_of: Vec<Register> = (0..self.size()).collect();
        let mut operations = Vec::new();
        for (register, operation) in (first..).zip(fused).filter(|&(register, _)| !is_fused[register]) {
            place_of[register] = first + operations.len();
            operations.push(operation.map(|operand| place_of[operand]));
        }
        let outputs = (0..self.outputs()).map(|output| place_of[self.output(output)]);
        Self::of_operations(self.variables, self.constants.clone(), operations, outputs)
    }
}
