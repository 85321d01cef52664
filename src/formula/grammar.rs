//! The grammar of formulas: a recursive parser, which builds the expression graph directly.
//!
//! ```text
//! sum     = product (("+" | "-") product)*
//! product = signed (("*" | "/") signed)*
//! signed  = ("+" | "-")* power
//! power   = atom ("^" signed)?              right-associative, binds tighter than unary minus on its left
//! atom    = number | variable | "pi" | parameter | function "(" sum ("," sum)? ")" | "(" sum ")"
//! ```

use std::collections::BTreeMap;

use super::graph::{Graph, NodeId};
use super::{FormulaError, Function, PAIRS, hint};
use crate::number::Real;
use crate::number::spline::Table;

/// The longest expression that is accepted: the potential of two hundred bodies in space has a megabyte.
const MAX_BYTES: usize = 1 << 22;
/// The deepest nesting that is accepted. The parser is recursive, so that nesting costs stack.
const MAX_DEPTH: usize = 64;
/// The most powers that are exponents of each other, for the same reason.
const MAX_POWERS: usize = 512;

/// A message lists no more variables than this.
const MOST_NAMED: usize = 12;

/// The meaning of a name in formulas.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Known<S> {
    Number(S),
    /// An expression of the same graph.
    Node(NodeId),
    /// A function that is a table.
    Table(Table),
}

/// The names that a formula may use besides its variables and those of the grammar.
pub(crate) type Names<S> = BTreeMap<String, Known<S>>;

/// The result, or the place of a mistake and the mistake in words.
type Parsed<T = NodeId> = Result<T, (usize, String)>;

struct Parser<'p, S> {
    text: &'p str,
    /// The place of the next token.
    at: usize,
    variables: &'p [&'p str],
    known: &'p dyn Fn(&str) -> Option<Known<S>>,
    graph: &'p mut Graph<S>,
    depth: usize,
    powers: usize,
}

/// Parses `text` into `graph` and returns the root. Variable k of the graph has the k-th name of `variables`; one with
/// an empty name cannot be used.
///
/// # Errors
/// [`FormulaError`] with the position of the mistake: syntax, an unknown name, a function without its parentheses.
pub(crate) fn parse<S: Real>(
    text: &str,
    variables: &[&str],
    names: &Names<S>,
    graph: &mut Graph<S>,
) -> Result<NodeId, FormulaError> {
    let known = |name: &str| names.get(name).copied();
    let mut parser = Parser { text, at: 0, variables, known: &known, graph, depth: 0, powers: 0 };
    parser.formula().map_err(|(offset, message)| {
        let known = variables.iter().copied().chain(["pi"]).chain(names.keys().map(String::as_str));
        FormulaError { message, offset, expression: text.to_owned(), hint: hint::at(text, offset, known) }
    })
}

impl<S: Real> Graph<S> {
    /// The node of a formula of this program, in which other nodes have names.
    pub(crate) fn written(&mut self, text: &str, nodes: &[(&str, NodeId)]) -> NodeId {
        let known = |name: &str| nodes.iter().find(|(other, _)| *other == name).map(|&(_, node)| Known::Node(node));
        let mut parser = Parser { text, at: 0, variables: &[], known: &known, graph: self, depth: 0, powers: 0 };
        parser.formula().expect("the formulas of this program are correct")
    }
}

impl<'p, S: Real> Parser<'p, S> {
    fn formula(&mut self) -> Parsed {
        if self.text.len() > MAX_BYTES {
            return Err((0, format!("the expression is longer than {MAX_BYTES} bytes")));
        }
        self.pass(0);
        let root = self.sum()?;
        if self.at == self.text.len() { Ok(root) } else { self.missing("expected an operator") }
    }

    fn rest(&self) -> &'p str {
        &self.text[self.at..]
    }

    /// Goes on after so many bytes and the white space behind them.
    fn pass(&mut self, bytes: usize) {
        self.at = self.text.len() - self.rest()[bytes..].trim_start_matches([' ', '\t', '\r', '\n']).len();
    }

    /// Passes the next character if it is one of these.
    fn accept(&mut self, characters: &[char]) -> Option<char> {
        let next = self.rest().chars().next().filter(|next| characters.contains(next))?;
        self.pass(next.len_utf8());
        Some(next)
    }

    /// A mistake at the next character.
    fn missing<T>(&self, message: &str) -> Parsed<T> {
        let found = self.rest().chars().next().map_or_else(|| "the end".to_owned(), |c| format!("'{c}'"));
        Err((self.at, format!("{message}, found {found}")))
    }

    fn sum(&mut self) -> Parsed {
        self.depth += 1;
        if self.depth > MAX_DEPTH {
            return Err((self.at, format!("nested more than {MAX_DEPTH} deep")));
        }
        let mut sum = self.product()?;
        while let Some(sign) = self.accept(&['+', '-']) {
            let term = self.product()?;
            sum = if sign == '+' { self.graph.add(sum, term) } else { self.graph.subtract(sum, term) };
        }
        self.depth -= 1;
        Ok(sum)
    }

    fn product(&mut self) -> Parsed {
        let mut product = self.signed()?;
        while let Some(operator) = self.accept(&['*', '/']) {
            let factor = self.signed()?;
            product =
                if operator == '*' { self.graph.multiply(product, factor) } else { self.graph.divide(product, factor) };
        }
        Ok(product)
    }

    fn signed(&mut self) -> Parsed {
        let mut is_negative = false;
        while let Some(sign) = self.accept(&['+', '-']) {
            is_negative ^= sign == '-';
        }
        let power = self.power()?;
        Ok(if is_negative { self.graph.negate(power) } else { power })
    }

    fn power(&mut self) -> Parsed {
        let (base, offset) = (self.atom()?, self.at);
        if self.accept(&['^']).is_none() {
            return Ok(base);
        }
        self.powers += 1;
        if self.powers > MAX_POWERS {
            return Err((offset, format!("more than {MAX_POWERS} powers of powers")));
        }
        let exponent = self.signed()?;
        self.powers -= 1;
        Ok(self.graph.power(base, exponent))
    }

    fn atom(&mut self) -> Parsed {
        let opened = self.at;
        if self.accept(&['(']).is_some() {
            let inner = self.sum()?;
            return self.close(opened).map(|()| inner);
        }
        match self.rest().chars().next() {
            Some(c) if c.is_ascii_digit() || c == '.' => self.number(),
            Some(c) if c.is_ascii_alphabetic() || c == '_' => self.name(),
            _ => {
                let named: Vec<&str> = self.variables.iter().copied().filter(|name| !name.is_empty()).collect();
                let variables = if named.len() > MOST_NAMED { "a name".to_owned() } else { named.join(", ") };
                self.missing(&format!("expected a number, {variables}, a parameter, a function or a parenthesis"))
            }
        }
    }

    /// Passes the end of a parenthesis.
    fn close(&mut self, opened: usize) -> Parsed<()> {
        match self.accept(&[')']) {
            Some(_) => Ok(()),
            None => self.missing(&format!("expected an operator or the ')' that closes character {}", opened + 1)),
        }
    }

    fn number(&mut self) -> Parsed {
        // "2x" and "1e" are mistakes, not products.
        let (rest, mut before) = (self.rest(), ' ');
        let is_beyond = |c: char| {
            let is_sign = matches!((before, c), ('e' | 'E', '+' | '-'));
            before = c;
            !(is_sign || c.is_alphanumeric() || c == '_' || c == '.')
        };
        let literal = &rest[..rest.find(is_beyond).unwrap_or(rest.len())];
        let Some(value) = S::from_decimal(literal).filter(|value| value.is_finite()) else {
            return Err((self.at, "not a finite number (a product is written with *)".to_owned()));
        };
        self.pass(literal.len());
        Ok(self.graph.constant(value))
    }

    fn name(&mut self) -> Parsed {
        let (offset, rest) = (self.at, self.rest());
        let length = rest.find(|c: char| !(c.is_ascii_alphanumeric() || c == '_')).unwrap_or(rest.len());
        let name = &rest[..length];
        self.pass(length);
        let known = (self.known)(name);
        let function = match known {
            Some(Known::Table(table)) => Some(Function::Table(table)),
            Some(_) => None,
            None => Function::from_name(name),
        };
        if let Some(function) = function {
            let [argument] = self.arguments(name, offset)?;
            return Ok(self.graph.call(function, argument));
        }
        if let Some((_, pair)) = PAIRS.iter().find(|(pair, _)| known.is_none() && *pair == name) {
            let [first, last] = self.arguments(name, offset)?;
            return Ok(self.graph.written(pair, &[("a", first), ("b", last)]));
        }
        let node = match (self.variables.iter().position(|variable| *variable == name), known) {
            (Some(variable), _) => Some(self.graph.variable(variable)),
            (None, Some(Known::Node(node))) => Some(node),
            (None, Some(Known::Number(value))) => Some(self.graph.constant(value)),
            (None, _) => (name == "pi").then(|| self.graph.constant(S::PI)),
        };
        let is_called = self.rest().starts_with('(');
        match node {
            Some(node) if !is_called => Ok(node),
            Some(_) => Err((offset, format!("'{name}' is not a function (a product is written with *)"))),
            None => Err((offset, format!("unknown {} '{name}'", if is_called { "function" } else { "name" }))),
        }
    }

    /// The arguments of a function whose name stands at `offset`: one, or two.
    fn arguments<const COUNT: usize>(&mut self, name: &str, offset: usize) -> Parsed<[NodeId; COUNT]> {
        let opened = self.at;
        if self.accept(&['(']).is_none() {
            let arguments = if COUNT == 1 { "its argument" } else { "its two arguments" };
            return Err((offset, format!("the function '{name}' needs {arguments} in parentheses")));
        }
        let mut arguments = [self.sum()?; COUNT];
        for argument in &mut arguments[1..] {
            if self.accept(&[',']).is_none() {
                return self.missing(&format!("the function '{name}' has two arguments: expected a comma"));
            }
            *argument = self.sum()?;
        }
        self.close(opened).map(|()| arguments)
    }
}
