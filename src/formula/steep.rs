//! Which operations of a program can make something steep of what changes little.
//!
//! Sums and products of what a polynomial follows are followed by a polynomial of a higher degree. Only functions and
//! quotients have scales of their own, and those show in what they are *applied to*: between two points at which the
//! argument of exp differs by one, exp changes by a factor of e and hides nothing. So a smaller program is made, of
//! arguments and divisors alone.

use std::collections::HashMap;

use super::Function;
use super::graph::Fused;
use super::program::{Operation, Program, Register, Step};
use super::staged::Staged;

/// What must not change much.
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
    /// The argument of abs: by its sign.
    Sign,
    /// The argument of asin and acos: by the ratio of its distances from ±1.
    Edge,
}

/// The smaller program.
#[derive(Debug, Clone)]
pub(crate) struct Steep {
    /// Its outputs are what is looked at.
    pub(crate) program: Staged<f64>,
    /// Of every output.
    pub(crate) kinds: Vec<Kind>,
    /// Whether a variable matters.
    pub(crate) reads: Vec<bool>,
    /// All that drives the motion by simpler operations, with a register for every value.
    pub(crate) whole: Program<f64>,
}

impl Steep {
    /// Of what the first `outputs` outputs of `program` need, where some of its variables vary; `None` if there is
    /// nothing to look at.
    pub(crate) fn new(program: &Program<f64>, outputs: usize, varies: impl Fn(usize) -> bool) -> Option<Self> {
        let whole = plain(program, outputs);
        let depends = whole.dependent(&varies);
        let mut watched: Vec<(Register, Kind)> = Vec::new();
        for &Step { operation, .. } in &whole.steps {
            let look = match operation {
                Operation::Divide(_, b) => (b, Kind::Ratio),
                Operation::Call(function, a) => (a, kind(function)),
                _ => continue,
            };
            if depends[look.0] && !watched.contains(&look) {
                watched.push(look);
            }
        }
        // A root varies less than what it is taken of.
        let is_watched_root = |register: Register| {
            let step = whole.steps.iter().find(|step| step.to == register);
            step.is_some_and(|step| matches!(step.operation, Operation::Call(Function::Sqrt, _)))
        };
        watched.retain(|&(register, kind)| kind != Kind::Ratio || !is_watched_root(register));
        if watched.is_empty() {
            return None;
        }
        let registers: Vec<Register> = watched.iter().map(|look| look.0).collect();
        let arguments = whole.only(&registers);
        let reads = (0..program.variables()).map(|variable| arguments.reads(variable)).collect();
        let program = Staged::new(arguments, varies, 0, |_| false);
        Some(Self { program, kinds: watched.iter().map(|look| look.1).collect(), reads, whole })
    }
}

/// What must not change much of the argument of a function.
pub(crate) fn kind(function: Function) -> Kind {
    match function {
        Function::Sqrt | Function::Ln | Function::Log10 => Kind::Ratio,
        Function::Sin | Function::Cos | Function::Tan => Kind::Angle,
        Function::Abs | Function::Sign => Kind::Sign,
        Function::Asin | Function::Acos => Kind::Edge,
        Function::Exp => Kind::Exponent,
        Function::Sinh | Function::Cosh | Function::Tanh | Function::Atan => Kind::Step,
    }
}

/// The first `outputs` outputs by simpler operations, with a register for every value: tan is sin/cos, x^y is
/// exp(y ln x), log10 a multiple of ln, and a product with a sum is both.
pub(crate) fn plain(program: &Program<f64>, outputs: usize) -> Program<f64> {
    let mut constants = Vec::new();
    program.each_constant(|_, constant| constants.push(constant));
    let per_ten = program.variables() + constants.len();
    constants.push(std::f64::consts::LOG10_E);
    let mut made = Made { first: per_ten + 1, steps: Vec::new(), known: HashMap::new() };
    let mut value_of: Vec<Register> = (0..program.registers()).collect();
    for &Step { to, operation } in program.steps_to(outputs) {
        value_of[to] = match operation.map(|operand| value_of[operand]) {
            Operation::Call(Function::Tan, a) => {
                let sin = made.step(Operation::Call(Function::Sin, a));
                let cos = made.step(Operation::Call(Function::Cos, a));
                made.step(Operation::Divide(sin, cos))
            }
            Operation::Call(Function::Log10, a) => {
                let ln = made.step(Operation::Call(Function::Ln, a));
                made.step(Operation::Multiply(ln, per_ten))
            }
            Operation::Power(a, b) => {
                let ln = made.step(Operation::Call(Function::Ln, a));
                let exponent = made.step(Operation::Multiply(b, ln));
                made.step(Operation::Call(Function::Exp, exponent))
            }
            Operation::Fused(fused, [a, b, c]) => {
                let product = made.step(Operation::Multiply(a, b));
                made.step(match fused {
                    Fused::Add => Operation::Add(product, c),
                    Fused::Subtract => Operation::Subtract(product, c),
                    Fused::SubtractFrom => Operation::Subtract(c, product),
                })
            }
            operation => made.step(operation),
        };
    }
    let outputs: Vec<Register> = (0..outputs).map(|output| value_of[program.output(output)]).collect();
    Program::of_steps(program.variables(), constants, made.steps, &outputs)
}

/// Steps, every one of which writes a register of its own.
struct Made {
    first: Register,
    steps: Vec<Step>,
    known: HashMap<Operation, Register>,
}

impl Made {
    fn step(&mut self, operation: Operation) -> Register {
        let Self { first, steps, known } = self;
        *known.entry(operation).or_insert_with(|| {
            let to = *first + steps.len();
            steps.push(Step { to, operation });
            to
        })
    }
}
