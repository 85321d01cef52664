//! Potentials given as a formula in x.

use std::collections::BTreeMap;

use super::PotentialJet;
use crate::formula::{self, FormulaError, Graph, Names, NodeId, Program};
use crate::number::Real;

/// The one variable.
const X: usize = 0;

/// V(x) compiled from an expression, with V′ and V″.
#[derive(Debug, Clone)]
pub struct Formula<S = f64> {
    /// V, V′ and V″.
    program: Program<S>,
}

impl<S: Real> Formula<S> {
    /// Parses and compiles `expression` with the given parameter values.
    ///
    /// # Errors
    /// [`FormulaError`] with the position of the mistake: syntax, an unknown name, a function without its parentheses.
    pub fn new(expression: &str, parameters: &BTreeMap<String, S>) -> Result<Self, FormulaError> {
        let mut graph = Graph::default();
        let value = formula::parse(
            expression,
            Names { variables: &["x"], parameters, definitions: &BTreeMap::new() },
            &mut graph,
        )?;
        Ok(Self { program: with_derivatives(&mut graph, value) })
    }
}

impl<S: Real> Formula<S> {
    /// The program of V, V′ and V″, for arithmetic on vectors and on series.
    pub(crate) fn program(&self) -> &Program<S> {
        &self.program
    }

    /// V, V′, V″ at `x`.
    pub fn at(&self, x: S) -> PotentialJet<S> {
        let [value, first, second] = self.program.values(&[x]);
        PotentialJet { value, first, second }
    }

    /// V at `x`, by the part of the program that V needs.
    pub fn value(&self, x: S) -> S {
        let [value] = self.program.values(&[x]);
        value
    }

    /// V and V′ at `x`.
    pub fn value_and_slope(&self, x: S) -> [S; 2] {
        self.program.values(&[x])
    }

    /// Writes V, V′ and V″ at every entry of `x` into `out`, three arrays as long as `x`.
    pub fn sample(&self, x: &[S], mut out: [&mut [S]; 3]) {
        self.program.sample(&[x], &mut out);
    }
}

/// The program for V at node `value`, V′ and V″.
fn with_derivatives<S: Real>(graph: &mut Graph<S>, value: NodeId) -> Program<S> {
    let first = graph.derivative(value, X);
    let second = graph.derivative(first, X);
    Program::new(graph, 1, &[value, first, second])
}

/// The program for Σ_k c_k x^k by Horner's rule, and its derivatives.
pub(super) fn polynomial<S: Real>(coefficients: &[S]) -> Program<S> {
    let mut graph = Graph::default();
    let x = graph.variable(X);
    let mut value = graph.constant(S::ZERO);
    for &c in coefficients.iter().rev() {
        let product = graph.multiply(value, x);
        let c = graph.constant(c);
        value = graph.add(product, c);
    }
    with_derivatives(&mut graph, value)
}

/// Whether the grammar of a potential already gives `name` a meaning, so that it cannot be the name of a parameter.
pub fn is_reserved(name: &str) -> bool {
    name == "x" || formula::is_reserved(name)
}
