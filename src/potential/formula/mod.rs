//! Potentials given as a formula: text → expression graph → V, V′, V″ → flat program.
//!
//! The grammar is that of a case file: numbers (also `1e-3`), `x`, parameters, `pi`, `+ - * / ^` (right-associative,
//! binding tighter than unary minus), parentheses and the functions of [`Function`]. The derivatives are formed
//! symbolically on the graph, so they are exact and share every common sub-expression with V.

mod grammar;
mod graph;
mod hint;
mod program;

use std::collections::BTreeMap;

pub use graph::Function;

use self::graph::Graph;

pub(crate) use program::{Instruction, Program};

use super::PotentialJet;
use crate::scalar::Real;

/// A mistake in a formula.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{message} at character {} of \"{expression}\"", self.character())]
pub struct FormulaError {
    /// What is wrong.
    pub message: String,
    /// Byte offset inside the expression.
    pub offset: usize,
    /// The expression.
    pub expression: String,
    /// What was probably meant.
    pub hint: Option<String>,
}

impl FormulaError {
    /// The position of the mistake in characters, counted from 1.
    pub fn character(&self) -> usize {
        self.expression[..self.offset].chars().count() + 1
    }
}

/// V(x) compiled from an expression, with V′ and V″.
#[derive(Debug, Clone)]
pub struct Formula<S = f64> {
    program: Program<S>,
}

impl<S: Real> Formula<S> {
    /// Parses and compiles `expression` with the given parameter values.
    ///
    /// # Errors
    /// [`FormulaError`] with the position of the mistake: syntax, an unknown name, a function without its parentheses.
    pub fn new(expression: &str, parameters: &BTreeMap<String, S>) -> Result<Self, FormulaError> {
        let mut graph = Graph::default();
        let value = grammar::parse(expression, parameters, &mut graph)?;
        Ok(Self { program: Program::with_derivatives(&mut graph, value) })
    }

    /// The compiled program, for arithmetic on something other than numbers, such as series.
    pub(crate) fn program(&self) -> &Program<S> {
        &self.program
    }

    /// V, V′, V″ at `x`.
    pub fn at(&self, x: S) -> PotentialJet<S> {
        let [value, first, second] = self.program.at(x);
        PotentialJet { value, first, second }
    }

    /// Writes V, V′ and V″ at every entry of `x` into `out`, three arrays as long as `x`.
    pub fn sample(&self, x: &[S], out: [&mut [S]; 3]) {
        self.program.sample(x, out);
    }
}

/// Whether the grammar already gives `name` a meaning, so that it cannot be the name of a parameter.
pub fn is_reserved(name: &str) -> bool {
    name == "x" || name == "pi" || Function::from_name(name).is_some()
}

/// Whether `name` can be written in a formula: a letter or underscore, and then letters, digits and underscores.
pub fn is_identifier(name: &str) -> bool {
    let mut characters = name.chars();
    characters.next().is_some_and(|c| c.is_ascii_alphabetic() || c == '_')
        && characters.all(|c| c.is_ascii_alphanumeric() || c == '_')
}
