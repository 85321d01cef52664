//! The operations of graphs and programs.

use super::Function;

/// Index of a node in its [`Graph`](super::Graph).
pub(crate) type NodeId = usize;

/// An operation on earlier values, each given by the index of a node of a graph or of a register of a program.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Operation<I = NodeId> {
    Add(I, I),
    Subtract(I, I),
    Multiply(I, I),
    Divide(I, I),
    Negate(I),
    Power(I, I),
    Call(Function, I),
    /// A product with a sum at once. Programs have it ([`super::Program::fused`]), graphs do not.
    Fused(Fused, [I; 3]),
}

/// A product ab with a third value c.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Fused {
    /// ab + c.
    Add,
    /// ab − c.
    Subtract,
    /// c − ab.
    SubtractFrom,
}

impl<I: Copy> Operation<I> {
    /// The indices of its operands.
    pub(crate) fn operands(self) -> impl Iterator<Item = I> {
        let (operands, count) = self.listed();
        operands.into_iter().take(count)
    }

    /// Its operands, and how many of these there are.
    pub(super) fn listed(self) -> ([I; 3], usize) {
        match self {
            Self::Negate(a) | Self::Call(_, a) => ([a; 3], 1),
            Self::Add(a, b) | Self::Subtract(a, b) | Self::Multiply(a, b) | Self::Divide(a, b) | Self::Power(a, b) => {
                ([a, b, b], 2)
            }
            Self::Fused(_, operands) => (operands, 3),
        }
    }

    /// The same on other indices.
    pub(super) fn map<J>(self, at: impl Fn(I) -> J) -> Operation<J> {
        match self {
            Self::Add(a, b) => Operation::Add(at(a), at(b)),
            Self::Subtract(a, b) => Operation::Subtract(at(a), at(b)),
            Self::Multiply(a, b) => Operation::Multiply(at(a), at(b)),
            Self::Divide(a, b) => Operation::Divide(at(a), at(b)),
            Self::Negate(a) => Operation::Negate(at(a)),
            Self::Power(a, b) => Operation::Power(at(a), at(b)),
            Self::Call(function, a) => Operation::Call(function, at(a)),
            Self::Fused(fused, operands) => Operation::Fused(fused, operands.map(at)),
        }
    }
}

impl Operation {
    /// The same number for the same numbers, whichever operand comes first.
    pub(super) fn sorted(self) -> Self {
        match self {
            Self::Add(a, b) => Self::Add(a.min(b), a.max(b)),
            Self::Multiply(a, b) => Self::Multiply(a.min(b), a.max(b)),
            _ => self,
        }
    }
}
