//! Straight-line programs: the nodes of an expression graph that its outputs need, with one instruction per value.

use super::graph::{Function, Graph, Node, NodeId};
use crate::scalar::Real;

/// Number of points that are evaluated together: enough to vectorise, and so few that all values of a formula stay in
/// the cache.
const BLOCK: usize = 64;

/// Programs of at most this length keep the values of a single point on the stack.
const STACK_VALUES: usize = 64;

/// Index of an instruction, and of the value that it computes.
pub(crate) type Register = usize;

/// One instruction. Its operands are the results of earlier ones.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Instruction<S> {
    X,
    Constant(S),
    Add(Register, Register),
    Subtract(Register, Register),
    Multiply(Register, Register),
    Divide(Register, Register),
    Negate(Register),
    Power(Register, Register),
    Call(Function, Register),
}

impl<S: Real> Instruction<S> {
    /// The registers that it reads.
    pub(crate) fn operands(self) -> impl Iterator<Item = Register> {
        let (a, b) = match self {
            Self::X | Self::Constant(_) => (None, None),
            Self::Negate(a) | Self::Call(_, a) => (Some(a), None),
            Self::Add(a, b) | Self::Subtract(a, b) | Self::Multiply(a, b) | Self::Divide(a, b) | Self::Power(a, b) => {
                (Some(a), Some(b))
            }
        };
        a.into_iter().chain(b)
    }

    /// Its value at `x` with the registers `r`.
    #[inline(always)]
    pub(crate) fn apply(self, r: &[S], x: S) -> S {
        match self {
            Self::X => x,
            Self::Constant(c) => c,
            Self::Add(a, b) => r[a] + r[b],
            Self::Subtract(a, b) => r[a] - r[b],
            Self::Multiply(a, b) => r[a] * r[b],
            Self::Divide(a, b) => r[a] / r[b],
            Self::Negate(a) => -r[a],
            Self::Power(a, b) => r[a].powf(r[b]),
            Self::Call(function, a) => function.apply(r[a]),
        }
    }
}

/// A straight-line program that computes V, V′ and V″.
#[derive(Debug, Clone)]
pub(crate) struct Program<S> {
    instructions: Vec<Instruction<S>>,
    outputs: [Register; 3],
}

fn operands(node: Node) -> impl Iterator<Item = NodeId> {
    let (a, b) = match node {
        Node::X | Node::Constant(_) => (None, None),
        Node::Negate(a) | Node::PowerInteger(a, _) | Node::Call(_, a) => (Some(a), None),
        Node::Add(a, b) | Node::Subtract(a, b) | Node::Multiply(a, b) | Node::Divide(a, b) | Node::Power(a, b) => {
            (Some(a), Some(b))
        }
    };
    a.into_iter().chain(b)
}

impl<S: Real> Program<S> {
    /// The program for V at node `value`, with its derivatives formed on the graph.
    pub(super) fn with_derivatives(graph: &mut Graph<S>, value: NodeId) -> Self {
        let first = graph.derivative(value);
        let second = graph.derivative(first);
        Self::compile(graph, [value, first, second])
    }

    /// The program for Σ_k c_k x^k by Horner's rule.
    pub(crate) fn polynomial(coefficients: &[S]) -> Self {
        let mut graph = Graph::default();
        let x = graph.x();
        let mut value = graph.constant(S::ZERO);
        for &c in coefficients.iter().rev() {
            let product = graph.multiply(value, x);
            let c = graph.constant(c);
            value = graph.add(product, c);
        }
        Self::with_derivatives(&mut graph, value)
    }

    /// Compiles the nodes that `outputs` need. Integer powers become multiplications.
    fn compile(graph: &Graph<S>, outputs: [NodeId; 3]) -> Self {
        let nodes = graph.nodes();
        let mut needed = vec![false; nodes.len()];
        for output in outputs {
            needed[output] = true;
        }
        for id in (0..nodes.len()).rev() {
            if needed[id] {
                operands(nodes[id]).for_each(|operand| needed[operand] = true);
            }
        }
        let mut register_of = vec![Register::MAX; nodes.len()];
        let mut instructions = Vec::new();
        for (id, &node) in nodes.iter().enumerate().filter(|(id, _)| needed[*id]) {
            if let Node::PowerInteger(a, n) = node {
                register_of[id] = integer_power(&mut instructions, register_of[a], n);
                continue;
            }
            let at = |id: NodeId| register_of[id];
            let instruction = match node {
                Node::X => Instruction::X,
                Node::Constant(constant) => Instruction::Constant(graph.number(constant)),
                Node::Add(a, b) => Instruction::Add(at(a), at(b)),
                Node::Subtract(a, b) => Instruction::Subtract(at(a), at(b)),
                Node::Multiply(a, b) => Instruction::Multiply(at(a), at(b)),
                Node::Divide(a, b) => Instruction::Divide(at(a), at(b)),
                Node::Negate(a) => Instruction::Negate(at(a)),
                Node::PowerInteger(..) => unreachable!("integer powers were expanded above"),
                Node::Power(a, b) => Instruction::Power(at(a), at(b)),
                Node::Call(function, a) => Instruction::Call(function, at(a)),
            };
            register_of[id] = instructions.len();
            instructions.push(instruction);
        }
        Self { instructions, outputs: outputs.map(|id| register_of[id]) }
    }

    /// The instructions in order.
    pub(crate) fn instructions(&self) -> &[Instruction<S>] {
        &self.instructions
    }

    /// The registers of V, V′ and V″.
    pub(crate) fn outputs(&self) -> [Register; 3] {
        self.outputs
    }

    /// The three outputs at `x`.
    pub(super) fn at(&self, x: S) -> [S; 3] {
        if self.instructions.len() <= STACK_VALUES {
            self.at_with(x, &mut [S::ZERO; STACK_VALUES])
        } else {
            self.at_with(x, &mut vec![S::ZERO; self.instructions.len()])
        }
    }

    fn at_with(&self, x: S, r: &mut [S]) -> [S; 3] {
        for (to, &instruction) in self.instructions.iter().enumerate() {
            r[to] = instruction.apply(r, x);
        }
        self.outputs.map(|o| r[o])
    }

    /// Writes the three outputs at every entry of `x`. Each instruction is executed on a block of points at a time.
    pub(super) fn sample(&self, x: &[S], out: [&mut [S]; 3]) {
        let [out_0, out_1, out_2] = out;
        let mut registers = vec![[S::ZERO; BLOCK]; self.instructions.len()];
        for (block, x) in x.chunks(BLOCK).enumerate() {
            for (to, &instruction) in self.instructions.iter().enumerate() {
                let (earlier, rest) = registers.split_at_mut(to);
                execute(earlier, &mut rest[0], instruction, x);
            }
            let start = block * BLOCK;
            for (out, register) in [&mut *out_0, &mut *out_1, &mut *out_2].into_iter().zip(self.outputs) {
                out[start..start + x.len()].copy_from_slice(&registers[register][..x.len()]);
            }
        }
    }
}

/// Emits u^n by repeated squaring.
fn integer_power<S: Real>(instructions: &mut Vec<Instruction<S>>, base: Register, exponent: i32) -> Register {
    let mut push = |instruction| {
        instructions.push(instruction);
        instructions.len() - 1
    };
    let (mut square, mut remaining) = (base, exponent.unsigned_abs());
    let mut product: Option<Register> = None;
    loop {
        if remaining & 1 == 1 {
            product = Some(product.map_or(square, |product| push(Instruction::Multiply(product, square))));
        }
        remaining >>= 1;
        if remaining == 0 {
            break;
        }
        square = push(Instruction::Multiply(square, square));
    }
    let one = Instruction::Constant(S::ONE);
    match product {
        Some(product) if exponent > 0 => product,
        Some(product) => {
            let one = push(one);
            push(Instruction::Divide(one, product))
        }
        None => push(one),
    }
}

/// Executes one instruction on a block. Beyond the end of `x` it works on old numbers, and the results are not used.
fn execute<S: Real>(r: &[[S; BLOCK]], out: &mut [S; BLOCK], instruction: Instruction<S>, x: &[S]) {
    match instruction {
        Instruction::X => out[..x.len()].copy_from_slice(x),
        Instruction::Constant(c) => *out = [c; BLOCK],
        Instruction::Add(a, b) => binary(out, &r[a], &r[b], |u, v| u + v),
        Instruction::Subtract(a, b) => binary(out, &r[a], &r[b], |u, v| u - v),
        Instruction::Multiply(a, b) => binary(out, &r[a], &r[b], |u, v| u * v),
        Instruction::Divide(a, b) => binary(out, &r[a], &r[b], |u, v| u / v),
        Instruction::Power(a, b) => binary(out, &r[a], &r[b], S::powf),
        Instruction::Negate(a) => unary(out, &r[a], |u| -u),
        Instruction::Call(function, a) => unary(out, &r[a], |u| function.apply(u)),
    }
}

#[inline]
fn unary<S: Real>(out: &mut [S; BLOCK], u: &[S; BLOCK], f: impl Fn(S) -> S) {
    for (out, u) in out.iter_mut().zip(u) {
        *out = f(*u);
    }
}

#[inline]
fn binary<S: Real>(out: &mut [S; BLOCK], u: &[S; BLOCK], v: &[S; BLOCK], f: impl Fn(S, S) -> S) {
    for ((out, u), v) in out.iter_mut().zip(u).zip(v) {
        *out = f(*u, *v);
    }
}
