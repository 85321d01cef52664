//! Programs whose products and sums are one step, for machines that have an instruction for both.

use super::graph::{Fused, Operation};
use super::program::{Output, Program, Register, Step};
use crate::number::Real;

impl<S: Real> Program<S> {
    /// The same program with a product and the sum that alone needs it as one step. Every value must have a register of
    /// its own.
    pub(crate) fn fused(&self) -> Self {
        let mut uses = vec![0_usize; self.registers];
        self.steps.iter().flat_map(|step| step.operation.operands()).for_each(|operand| uses[operand] += 1);
        self.outputs.iter().for_each(|output| uses[output.register] += 2);
        let mut products: Vec<Option<[Register; 2]>> = vec![None; self.registers];
        for step in &self.steps {
            if let Operation::Multiply(a, b) = step.operation {
                products[step.to] = (uses[step.to] == 1).then_some([a, b]);
            }
        }
        let mut is_fused = vec![false; self.registers];
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
        let steps: Vec<Step> =
            self.steps.iter().map(|step| Step { operation: fuse(step.operation), ..*step }).collect();
        let left = |count: usize| self.steps[..count].iter().filter(|step| !is_fused[step.to]).count();
        let outputs = self.outputs.iter().map(|output| Output { steps: left(output.steps), ..*output }).collect();
        let steps = steps.into_iter().filter(|step| !is_fused[step.to]).collect();
        Self { constants: self.constants.clone(), steps, outputs, ..*self }
    }
}
