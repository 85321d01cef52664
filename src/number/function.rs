//! The elementary functions, by their names in formulas.

use super::Real;
use super::spline::Table;

/// An elementary function. [`Self::apply`] evaluates it on one number, `vector::elementary` on many.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[allow(missing_docs)] // The variants are their own names.
pub enum Function {
    Sin,
    Cos,
    Tan,
    Sinh,
    Cosh,
    Tanh,
    Asin,
    Acos,
    Atan,
    Exp,
    Ln,
    Log10,
    Sqrt,
    Abs,
    /// 1, −1 or 0: the derivative of `abs`.
    Sign,
    /// 0 below 0, and 1 from 0 on.
    Step,
    /// A spline, or a derivative of it.
    Table(Table),
}

impl Function {
    /// Every function of the grammar with its name.
    pub const NAMED: [(&'static str, Function); 16] = [
        ("sin", Function::Sin),
        ("cos", Function::Cos),
        ("tan", Function::Tan),
        ("sinh", Function::Sinh),
        ("cosh", Function::Cosh),
        ("tanh", Function::Tanh),
        ("asin", Function::Asin),
        ("acos", Function::Acos),
        ("atan", Function::Atan),
        ("exp", Function::Exp),
        ("ln", Function::Ln),
        ("log10", Function::Log10),
        ("sqrt", Function::Sqrt),
        ("abs", Function::Abs),
        ("sign", Function::Sign),
        ("step", Function::Step),
    ];

    /// The function of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::NAMED.iter().find(|(n, _)| *n == name).map(|&(_, function)| function)
    }

    /// The value at `u`.
    #[inline]
    pub fn apply<S: Real>(self, u: S) -> S {
        match self {
            Self::Sin => u.sin(),
            Self::Cos => u.cos(),
            Self::Tan => u.tan(),
            Self::Sinh => u.sinh(),
            Self::Cosh => u.cosh(),
            Self::Tanh => u.tanh(),
            Self::Asin => u.asin(),
            Self::Acos => u.acos(),
            Self::Atan => u.atan(),
            Self::Exp => u.exp(),
            Self::Ln => u.ln(),
            Self::Log10 => u.log10(),
            Self::Sqrt => u.sqrt(),
            Self::Abs => u.abs(),
            Self::Sign if u == S::ZERO => S::ZERO,
            Self::Sign => u.signum(),
            Self::Step if u >= S::ZERO => S::ONE,
            Self::Step if u < S::ZERO => S::ZERO,
            Self::Step => u,
            Self::Table(table) => table.at(u),
        }
    }
}
