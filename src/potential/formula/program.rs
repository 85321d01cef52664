//! Flat programs: the part of an expression graph that its outputs need, on as few registers as it can be done.

use super::graph::{Function, Graph, Node, NodeId};

/// Points evaluated together: long enough to vectorise, short enough that all registers stay in the first-level cache.
const BLOCK: usize = 64;

/// Programs with at most this many registers evaluate a single point on the stack.
const STACK_REGISTERS: usize = 32;

type Register = usize;

#[derive(Debug, Clone, Copy)]
enum Operation {
    X,
    Constant(f64),
    Add(Register, Register),
    Subtract(Register, Register),
    Multiply(Register, Register),
    Divide(Register, Register),
    Negate(Register),
    PowerInteger(Register, i32),
    Power(Register, Register),
    Call(Function, Register),
}

/// A straight-line program with three outputs.
#[derive(Debug, Clone)]
pub(super) struct Program {
    /// Each instruction writes the register given with it.
    instructions: Vec<(Register, Operation)>,
    outputs: [Register; 3],
    registers: usize,
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

impl Program {
    /// Keeps the nodes that `outputs` need and gives each a register that is free again after its last use.
    pub(super) fn compile(graph: &Graph, outputs: [NodeId; 3]) -> Self {
        let nodes = graph.nodes();
        let mut last_use: Vec<Option<NodeId>> = vec![None; nodes.len()];
        for output in outputs {
            last_use[output] = Some(NodeId::MAX);
        }
        for id in (0..nodes.len()).rev() {
            if last_use[id].is_some() {
                for operand in operands(nodes[id]) {
                    last_use[operand] = last_use[operand].max(Some(id));
                }
            }
        }
        let mut register_of = vec![Register::MAX; nodes.len()];
        let (mut free, mut registers) = (Vec::new(), 0);
        let mut instructions = Vec::new();
        for (id, &node) in nodes.iter().enumerate() {
            if last_use[id].is_none() {
                continue;
            }
            let at = |id: NodeId| register_of[id];
            let operation = match node {
                Node::X => Operation::X,
                Node::Constant(bits) => Operation::Constant(f64::from_bits(bits)),
                Node::Add(a, b) => Operation::Add(at(a), at(b)),
                Node::Subtract(a, b) => Operation::Subtract(at(a), at(b)),
                Node::Multiply(a, b) => Operation::Multiply(at(a), at(b)),
                Node::Divide(a, b) => Operation::Divide(at(a), at(b)),
                Node::Negate(a) => Operation::Negate(at(a)),
                Node::PowerInteger(a, n) => Operation::PowerInteger(at(a), n),
                Node::Power(a, b) => Operation::Power(at(a), at(b)),
                Node::Call(function, a) => Operation::Call(function, at(a)),
            };
            // The result gets a register of its own before its operands are freed: no instruction overwrites its input.
            let register = free.pop().unwrap_or_else(|| {
                registers += 1;
                registers - 1
            });
            register_of[id] = register;
            instructions.push((register, operation));
            let mut dying: Vec<NodeId> = operands(node).filter(|&o| last_use[o] == Some(id)).collect();
            dying.dedup();
            free.extend(dying.into_iter().map(|o| register_of[o]));
        }
        Self { instructions, outputs: outputs.map(|id| register_of[id]), registers }
    }

    /// The three outputs at `x`.
    pub(super) fn at(&self, x: f64) -> [f64; 3] {
        if self.registers <= STACK_REGISTERS {
            self.at_with(x, &mut [0.0; STACK_REGISTERS])
        } else {
            self.at_with(x, &mut vec![0.0; self.registers])
        }
    }

    fn at_with(&self, x: f64, r: &mut [f64]) -> [f64; 3] {
        for &(to, operation) in &self.instructions {
            r[to] = match operation {
                Operation::X => x,
                Operation::Constant(c) => c,
                Operation::Add(a, b) => r[a] + r[b],
                Operation::Subtract(a, b) => r[a] - r[b],
                Operation::Multiply(a, b) => r[a] * r[b],
                Operation::Divide(a, b) => r[a] / r[b],
                Operation::Negate(a) => -r[a],
                Operation::PowerInteger(a, n) => r[a].powi(n),
                Operation::Power(a, b) => r[a].powf(r[b]),
                Operation::Call(function, a) => function.apply(r[a]),
            };
        }
        self.outputs.map(|o| r[o])
    }

    /// The three outputs at every entry of `x`, a block of points an instruction.
    pub(super) fn sample(&self, x: &[f64], out: [&mut [f64]; 3]) {
        let [out_0, out_1, out_2] = out;
        let mut registers = vec![[0.0; BLOCK]; self.registers];
        for (block, x) in x.chunks(BLOCK).enumerate() {
            for &(to, operation) in &self.instructions {
                execute(&mut registers, to, operation, x);
            }
            let start = block * BLOCK;
            for (out, register) in [&mut *out_0, &mut *out_1, &mut *out_2].into_iter().zip(self.outputs) {
                out[start..start + x.len()].copy_from_slice(&registers[register][..x.len()]);
            }
        }
    }
}

/// One instruction on a block. Lanes beyond the end of `x` compute on stale numbers that nobody reads.
fn execute(r: &mut [[f64; BLOCK]], to: Register, operation: Operation, x: &[f64]) {
    match operation {
        Operation::X => r[to][..x.len()].copy_from_slice(x),
        Operation::Constant(c) => r[to] = [c; BLOCK],
        Operation::Add(a, b) => binary(r, to, a, b, |u, v| u + v),
        Operation::Subtract(a, b) => binary(r, to, a, b, |u, v| u - v),
        Operation::Multiply(a, b) => binary(r, to, a, b, |u, v| u * v),
        Operation::Divide(a, b) => binary(r, to, a, b, |u, v| u / v),
        Operation::Power(a, b) => binary(r, to, a, b, f64::powf),
        Operation::Negate(a) => unary(r, to, a, |u| -u),
        Operation::PowerInteger(a, 2) => unary(r, to, a, |u| u * u),
        Operation::PowerInteger(a, n) => unary(r, to, a, |u| u.powi(n)),
        Operation::Call(function, a) => unary(r, to, a, |u| function.apply(u)),
    }
}

#[inline]
fn unary(r: &mut [[f64; BLOCK]], to: Register, a: Register, f: impl Fn(f64) -> f64) {
    let u = r[a];
    for (out, u) in r[to].iter_mut().zip(u) {
        *out = f(u);
    }
}

#[inline]
fn binary(r: &mut [[f64; BLOCK]], to: Register, a: Register, b: Register, f: impl Fn(f64, f64) -> f64) {
    let (u, v) = (r[a], r[b]);
    for ((out, u), v) in r[to].iter_mut().zip(u).zip(v) {
        *out = f(u, v);
    }
}
