//! Programs that are run many times while only some of their variables change.

use super::program::{Program, Step};
use crate::number::Real;

/// A program in stages, see [`Self::new`].
#[derive(Debug, Clone)]
pub(crate) struct Staged<S> {
    program: Program<S>,
    /// So many steps at the beginning depend on nothing that varies.
    fixed: usize,
    again: Vec<Step>,
}

impl<S: Real> Staged<S> {
    /// From a program in which every value has a register of its own.
    ///
    /// What depends on none of the variables that vary comes first, and keeps its registers. So do the first `outputs`
    /// outputs, and what is needed to compute them once more after only the variables `moved` have changed.
    pub(crate) fn new(
        mut program: Program<S>,
        varies: impl Fn(usize) -> bool,
        outputs: usize,
        moved: impl Fn(usize) -> bool,
    ) -> Self {
        let depends = program.dependent(varies);
        let steps = std::mem::take(&mut program.steps);
        let is_fixed = |step: &&Step| !depends[step.to];
        let fixed = steps.iter().filter(is_fixed).count();
        for output in &mut program.outputs {
            output.steps = fixed + steps[..output.steps].iter().filter(|step| depends[step.to]).count();
        }
        let varying = steps.iter().filter(|step| depends[step.to]);
        program.steps = steps.iter().filter(is_fixed).chain(varying).copied().collect();
        let moves = program.dependent(moved);
        let range = fixed..program.steps(outputs).max(fixed);
        let mut keeps = vec![false; program.registers()];
        program.steps[..fixed].iter().for_each(|step| keeps[step.to] = true);
        (0..outputs).for_each(|output| keeps[program.output(output)] = true);
        for Step { operation, .. } in program.steps[range.clone()].iter().filter(|step| moves[step.to]) {
            operation.operands().filter(|&operand| !moves[operand]).for_each(|operand| keeps[operand] = true);
        }
        let packed = program.packed_but(&keeps);
        let again = range.filter(|&place| moves[program.steps[place].to]).map(|place| packed.steps[place]).collect();
        Self { program: packed, fixed, again }
    }

    /// All of a program as what varies.
    pub(crate) fn whole(program: Program<S>) -> Self {
        Self { program, fixed: 0, again: Vec::new() }
    }

    /// The program as a whole.
    pub(crate) fn program(&self) -> &Program<S> {
        &self.program
    }

    /// The steps that do not depend on what varies.
    pub(crate) fn fixed(&self) -> &[Step] {
        &self.program.steps[..self.fixed]
    }

    /// The steps to the first `outputs` outputs, without those.
    pub(crate) fn varying(&self, outputs: usize) -> &[Step] {
        &self.program.steps[self.fixed..self.program.steps(outputs).max(self.fixed)]
    }

    /// The steps that are to be run again where only the variables `moved` have changed.
    pub(crate) fn again(&self) -> &[Step] {
        &self.again
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use proptest::prelude::*;

    use super::super::machine::Numbers;
    use super::super::program::walk;
    use super::super::{Graph, Names, Program, parse};
    use super::Staged;

    /// Expressions in a (which stays), q and p.
    fn expression() -> impl Strategy<Value = String> {
        let leaf = prop::sample::select(vec!["a", "q", "p", "0.7", "3"]).prop_map(String::from);
        leaf.prop_recursive(5, 40, 2, |inner| {
            (inner.clone(), prop::sample::select(vec!["+", "-", "*", "/"]), inner.clone())
                .prop_map(|(one, operation, other)| format!("({one} {operation} {other})"))
                .boxed()
                .prop_union(inner.prop_map(|one| format!("sin({one})")).boxed())
        })
    }

    proptest! {
        /// Stage by stage the outputs are what the program gives from anew, to the last bit.
        #[test]
        fn stages_are_the_program(formulas in prop::collection::vec(expression(), 4)) {
            let mut graph = Graph::default();
            let (parameters, definitions) = (BTreeMap::new(), BTreeMap::new());
            let names = Names { variables: &["a", "q", "p"], parameters: &parameters, definitions: &definitions };
            let nodes: Vec<_> = formulas.iter().map(|formula| parse(formula, names, &mut graph).unwrap()).collect();
            let plain = Program::new(&mut graph, 3, &nodes);
            let staged = Staged::new(plain.clone(), |variable| variable > 0, 2, |variable| variable == 2);
            let room = |program: &Program<f64>| {
                let mut registers = vec![0.0; program.registers()];
                program.each_constant(|register, constant| registers[register] = constant);
                registers
            };
            let (mut expected, mut registers) = (room(&plain), room(staged.program()));
            registers[0] = 1.3;
            walk(staged.fixed(), &mut Numbers(&mut registers));
            for (q, [p, moved]) in [(0.4, [-0.6, 0.9]), (2.5, [0.1, -3.0])] {
                (registers[1], registers[2]) = (q, p);
                let mut agree = |p: f64, outputs: usize, registers: &[f64]| {
                    (expected[0], expected[1], expected[2]) = (1.3, q, p);
                    walk(plain.steps_to(4), &mut Numbers(&mut expected));
                    (0..outputs).all(|output| {
                        let [one, other] = [expected[plain.output(output)], registers[staged.program().output(output)]];
                        one.to_bits() == other.to_bits() || one.is_nan() && other.is_nan()
                    })
                };
                walk(staged.varying(4), &mut Numbers(&mut registers));
                prop_assert!(agree(p, 4, &registers));
                registers[2] = moved;
                walk(staged.again(), &mut Numbers(&mut registers));
                prop_assert!(agree(moved, 2, &registers));
            }
        }
    }
}
