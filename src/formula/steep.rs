//! Which operations of a program can make something steep of what changes little.
//!
//! Sums and products of what a polynomial follows are followed by a polynomial of a higher degree. Only functions and
//! quotients have scales of their own, and those show in what they are *applied to*: between two points at which the
//! argument of exp differs by one, exp changes by a factor of e and hides nothing. So a smaller program is made, of
//! arguments and divisors alone.

use std::collections::HashMap;

use super::Function;
use super::operation::{Fused, Operation};
use super::program::{Program, Register, Step};
use crate::number::spline::Table;

/// The measure by which an argument must not change much.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Kind {
    /// A divisor, or what a root or a logarithm is taken of: by its ratio, and it must not contain 0.
    Ratio,
    /// The argument of exp: by its difference.
    Exponent,
    /// The argument of tanh and the like: by its difference.
    Step,
    /// An angle: by its difference.
    Angle,
    /// The argument of abs, sign and step: by its sign.
    Sign,
    /// The argument of asin and acos: by the ratio of its distances from ±1.
    Edge,
    /// The argument of a table: by the knots that it passes.
    Table(Table),
}

/// A program with what may become steep in it.
#[derive(Debug, Clone)]
pub(crate) struct Steep {
    /// All that drives the motion, by simpler operations.
    pub(crate) program: Program<f64>,
    /// The registers that are looked at.
    pub(crate) watched: Vec<(Register, Kind)>,
}

impl Steep {
    /// Looks at what the first `outputs` outputs of `program` need, where some of its variables vary; `None` if there
    /// is nothing to look at.
    pub(crate) fn new(program: &Program<f64>, outputs: usize, varies: impl Fn(usize) -> bool) -> Option<Self> {
        let program = plain(program, outputs);
        let watched = watched(&program.steps, &program.depends_on(varies));
        (!watched.is_empty()).then_some(Self { program, watched })
    }
}

/// Divisors and arguments of functions in these steps that depend on variables.
fn watched<'s>(steps: impl IntoIterator<Item = &'s Step>, depends: &[bool]) -> Vec<(Register, Kind)> {
    let mut watched: Vec<(Register, Kind)> = Vec::new();
    let mut is_root = vec![false; depends.len()];
    for step in steps {
        let look = match step.operation() {
            Operation::Divide(_, b) => (b, Kind::Ratio),
            Operation::Power(a, _) => (a, Kind::Ratio),
            Operation::Call(function, a) => (a, kind(function)),
            _ => continue,
        };
        is_root[step.to()] = matches!(step.operation(), Operation::Call(Function::Sqrt, _));
        if depends[look.0] && !watched.contains(&look) {
            watched.push(look);
        }
    }
    // A root varies less than what it is taken of.
    watched.retain(|&(register, kind)| kind != Kind::Ratio || !is_root[register]);
    watched
}

/// Returns what is to be looked at where these steps of a program were carried out, and whether that is all: the
/// divisor of a tangent and the exponent of a power have no registers.
pub(crate) fn watched_registers<'s>(
    steps: impl Iterator<Item = &'s Step> + Clone,
    depends: &[bool],
) -> (Vec<(Register, Kind)>, bool) {
    let is_plain = |step: &Step| !matches!(step.operation(), Operation::Call(Function::Tan, _) | Operation::Power(..));
    (watched(steps.clone(), depends), steps.clone().all(is_plain))
}

/// The measure by which the argument of a function must not change much.
pub(crate) fn kind(function: Function) -> Kind {
    match function {
        Function::Sqrt | Function::Ln | Function::Log10 => Kind::Ratio,
        Function::Sin | Function::Cos | Function::Tan => Kind::Angle,
        Function::Abs | Function::Sign | Function::Step => Kind::Sign,
        Function::Asin | Function::Acos => Kind::Edge,
        Function::Exp => Kind::Exponent,
        Function::Table(table) => Kind::Table(table),
        Function::Sinh | Function::Cosh | Function::Tanh | Function::Atan => Kind::Step,
    }
}

/// The first `outputs` outputs by simpler operations: tan is sin/cos, x^y is exp(y ln x), log10 a multiple of ln, and a
/// product with a sum is both.
pub(crate) fn plain(program: &Program<f64>, outputs: usize) -> Program<f64> {
    let mut constants = program.constants.clone();
    let per_ten = program.variables + constants.len();
    constants.push(std::f64::consts::LOG10_E);
    // Operations without repetitions, each with the register of what it gives.
    let (mut operations, mut known) = (Vec::new(), HashMap::new());
    let mut value = |operation: Operation| {
        *known.entry(operation).or_insert_with(|| {
            operations.push(operation);
            per_ten + operations.len()
        })
    };
    let mut value_of: Vec<Register> = (0..program.size()).collect();
    for step in program.steps_to(outputs) {
        value_of[step.to()] = match step.operation().map(|operand| value_of[operand]) {
            Operation::Call(Function::Tan, a) => {
                let [sin, cos] = [Function::Sin, Function::Cos].map(|function| value(Operation::Call(function, a)));
                value(Operation::Divide(sin, cos))
            }
            Operation::Call(Function::Log10, a) => {
                let ln = value(Operation::Call(Function::Ln, a));
                value(Operation::Multiply(ln, per_ten))
            }
            Operation::Power(a, b) => {
                let ln = value(Operation::Call(Function::Ln, a));
                let exponent = value(Operation::Multiply(b, ln));
                value(Operation::Call(Function::Exp, exponent))
            }
            Operation::Fused(fused, [a, b, c]) => {
                let product = value(Operation::Multiply(a, b));
                value(match fused {
                    Fused::Add => Operation::Add(product, c),
                    Fused::Subtract => Operation::Subtract(product, c),
                    Fused::SubtractFrom => Operation::Subtract(c, product),
                })
            }
            operation => value(operation),
        };
    }
    let outputs = (0..outputs).map(|output| value_of[program.output(output)]);
    Program::of_operations(program.variables, constants, operations, outputs)
}
