//! The elementary functions, by their names in formulas.

use super::Real;
use super::spline::Table;

/// Makes a function of each variant with the method of [`Real`] that evaluates it, which has its name in formulas.
macro_rules! functions {
    ($($variant:ident $name:ident,)*) => {
        /// An elementary function. [`Self::apply`] evaluates it on one number, `vector::elementary` on many.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        #[allow(missing_docs)] // The variants are their own names.
        pub enum Function {
            $($variant,)*
            /// A spline, or a derivative of it.
            Table(Table),
        }

        impl Function {
            /// Every function of the grammar with its name.
            pub const NAMED: &'static [(&'static str, Function)] = &[$((stringify!($name), Function::$variant)),*];

            /// The value at `u`.
            #[inline]
            pub fn apply<S: Real>(self, u: S) -> S {
                match self {
                    $(Self::$variant => u.$name(),)*
                    Self::Table(table) => table.at(u),
                }
            }
        }
    };
}

functions! {
    Sin sin,
    Cos cos,
    Tan tan,
    Sinh sinh,
    Cosh cosh,
    Tanh tanh,
    Asin asin,
    Acos acos,
    Atan atan,
    Exp exp,
    Ln ln,
    Log10 log10,
    Sqrt sqrt,
    Abs abs,
    Sign sign,
    Step step,
}

impl Function {
    /// The function of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::NAMED.iter().find(|(n, _)| *n == name).map(|&(_, function)| function)
    }
}
