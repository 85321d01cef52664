//! Formulas: text → expression graph → derivatives → straight-line program.
//!
//! ```text
//! grammar     parses text into a graph
//! graph       holds every distinct sub-expression once, in tables of quick keys
//! derivative  adds symbolic derivatives to a graph, so they are exact and share sub-expressions with the rest
//! reduce      writes expressions with fewer operations
//! program     compiles what the wanted outputs need to a list of steps on registers, one for a product and a sum
//! algebra     carries out the steps: on numbers and blocks of them (here), vectors of nodes, Taylor series (elsewhere)
//! one_ball    does so with a ball of 32 digits in each register
//! mend        computes once more what is not finite, in numbers of wide exponents (`wide`)
//! steep       finds what functions and quotients of a program are applied to, and high powers (`powers`)
//! ```
//!
//! The grammar is that of a case file: numbers (also `1e-3`), variables, parameters, `pi`, `+ - * / ^`
//! (right-associative, binding tighter than unary minus), parentheses, the functions of [`Function`], and min, max,
//! atan2 and hypot of two arguments. A formula may have any number of variables.

mod algebra;
mod derivative;
mod grammar;
mod graph;
mod hint;
mod mend;
mod one_ball;
mod operation;
mod powers;
mod program;
mod reduce;
pub mod similar;
mod steep;
#[cfg(test)]
mod tests;
mod variables;
mod wide;

pub use crate::number::Function;
pub(crate) use algebra::{Algebra, BLOCK, MOST_LOST, run, run_at};
pub(crate) use grammar::{Known, Names, parse};
pub(crate) use graph::{Graph, NodeId};
pub(crate) use one_ball::run_on_balls;
pub(crate) use operation::{Fused, Operation};
pub(crate) use program::{Program, Register, Step};
pub(crate) use reduce::Level;
#[cfg(test)]
pub(crate) use steep::plain;
pub(crate) use steep::{BENT, Kind, Steep, Watched, kind, turn, watched_registers};

/// A mistake in a formula.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{message} at character {} of \"{expression}\"", self.character())]
pub struct FormulaError {
    /// The mistake in words.
    pub message: String,
    /// Byte offset inside the expression.
    pub offset: usize,
    /// The expression.
    pub expression: String,
    /// The word that was probably meant.
    pub hint: Option<String>,
}

impl FormulaError {
    /// The position of the mistake in characters, counted from 1.
    pub fn character(&self) -> usize {
        self.expression[..self.offset].chars().count() + 1
    }
}

/// The sign of b, and that of 0 is 1.
macro_rules! side {
    () => {
        "(step(b) + (1 - step(b))*(-1))"
    };
}

/// Functions of two arguments, written by those of one. The angle of (b, a) is twice that of the point that halves it:
/// that is accurate where |b| stands, and on the left side the angle to the negative axis is found so.
const PAIRS: [(&str, &str); 4] = [
    ("min", "step(a - b)*b + (1 - step(a - b))*a"),
    ("max", "step(a - b)*a + (1 - step(a - b))*b"),
    (
        "atan2",
        concat!(
            side!(),
            "*(2*atan(a/(hypot(a, b) + ",
            side!(),
            "*b)))",
            " + (1 - step(b))*(pi*(step(a) + (1 - step(a))*(-1)))"
        ),
    ),
    ("hypot", "sqrt(a^2 + b^2)"),
];

/// The names of all functions.
pub(crate) fn functions() -> impl Iterator<Item = &'static str> {
    Function::NAMED.iter().map(|(name, _)| *name).chain(PAIRS.iter().map(|(name, _)| *name))
}

/// Returns true if the grammar already gives `name` a meaning in formulas of any variables.
pub(crate) fn is_reserved(name: &str) -> bool {
    name == "pi" || functions().any(|function| function == name)
}

/// Returns true if `name` can be written in a formula: a letter or underscore, and then letters, digits and
/// underscores.
pub(crate) fn is_identifier(name: &str) -> bool {
    let mut characters = name.chars();
    characters.next().is_some_and(|c| c.is_ascii_alphabetic() || c == '_')
        && characters.all(|c| c.is_ascii_alphanumeric() || c == '_')
}
