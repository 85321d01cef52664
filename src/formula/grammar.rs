//! The grammar of formulas: a parser with operator precedence, which builds the expression graph directly.
//!
//! ```text
//! sum     = product (("+" | "-") product)*
//! product = signed (("*" | "/") signed)*
//! signed  = ("+" | "-") signed | power
//! power   = atom ("^" signed)?              right-associative, binds tighter than unary minus on its left
//! atom    = number | variable | "pi" | parameter | function "(" sum ("," sum)? ")" | "(" sum ")"
//! ```

use std::collections::BTreeMap;

use winnow::ascii::multispace0;
use winnow::combinator::{
    Infix::{Left, Right},
    Prefix, dispatch, expression, fail, not, peek, preceded, terminated,
};
use winnow::error::{ContextError, ErrMode};
use winnow::prelude::*;
use winnow::stream::{LocatingSlice, Location, Stateful};
use winnow::token::{any, take_while};

use super::graph::{Graph, NodeId};
use super::{FormulaError, Function, hint, pairs};
use crate::number::Real;
use crate::number::spline::Table;

/// The longest expression that is accepted: the potential of nine bodies in space has two kilobytes.
const MAX_BYTES: usize = 65_536;
/// The deepest nesting that is accepted. The parser is recursive, so that nesting costs stack.
const MAX_DEPTH: usize = 64;
/// The most powers that are exponents of each other, for the same reason.
const MAX_POWERS: usize = 512;

/// A message lists no more variables than this.
const MOST_NAMED: usize = 12;

/// The names that a formula may use besides those of the grammar.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Names<'n, S> {
    /// Variable k of the graph has the k-th name. One with an empty name cannot be used.
    pub variables: &'n [&'n str],
    /// Numbers that have names.
    pub parameters: &'n BTreeMap<String, S>,
    /// Expressions of the same graph that have names.
    pub definitions: &'n BTreeMap<String, NodeId>,
    /// Functions that are tables.
    pub tables: &'n [(String, Table)],
}

#[derive(Debug)]
struct State<'s, S> {
    names: Names<'s, S>,
    graph: &'s mut Graph<S>,
    depth: usize,
    /// The mistake found furthest to the right.
    mistake: Option<(usize, String)>,
}

impl<S> State<'_, S> {
    fn report(&mut self, offset: usize, message: impl Into<String>) {
        if self.mistake.as_ref().is_none_or(|(furthest, _)| offset > *furthest) {
            self.mistake = Some((offset, message.into()));
        }
    }
}

type Input<'i, 's, S> = Stateful<LocatingSlice<&'i str>, State<'s, S>>;
type Failure = ErrMode<ContextError>;

/// Parses `text` into `graph` and returns the root.
///
/// # Errors
/// [`FormulaError`] with the position of the mistake: syntax, an unknown name, a function without its parentheses.
pub(crate) fn parse<S: Real>(text: &str, names: Names<'_, S>, graph: &mut Graph<S>) -> Result<NodeId, FormulaError> {
    let error = |offset: usize, message: String| {
        let given = names.parameters.keys().chain(names.definitions.keys());
        let given = given.chain(names.tables.iter().map(|(name, _)| name)).map(String::as_str);
        let hint = hint::at(text, offset, names.variables.iter().copied().chain(["pi"]).chain(given));
        FormulaError { message, offset, expression: text.to_owned(), hint }
    };
    if text.len() > MAX_BYTES {
        return Err(error(0, format!("the expression is longer than {MAX_BYTES} bytes")));
    }
    if let Some(offset) = deep_power(text) {
        return Err(error(offset, format!("more than {MAX_POWERS} powers of powers")));
    }
    let state = State { names, graph, depth: 0, mistake: None };
    let mut input = Stateful { input: LocatingSlice::new(text), state };
    let parsed = preceded(multispace0, sum).parse_next(&mut input);
    let end = input.current_token_start();
    match (parsed, input.state.mistake) {
        (Ok(root), _) if end == text.len() => Ok(root),
        // If the operand of an operator is missing, the parser stops before the operator, but the mistake is after it.
        (_, Some((offset, message))) if offset > end || end == text.len() => Err(error(offset, message)),
        (Ok(_), _) => Err(error(end, format!("expected an operator, found {}", found(&text[end..])))),
        (Err(_), Some((offset, message))) => Err(error(offset, message)),
        (Err(_), None) => Err(error(end, "not understood".to_owned())),
    }
}

fn found(rest: &str) -> String {
    rest.chars().next().map_or_else(|| "the end".to_owned(), |c| format!("'{c}'"))
}

/// Applies `parser` and skips the white space after it.
fn token<'i, 's: 'i, S: Real, O>(
    parser: impl Parser<Input<'i, 's, S>, O, Failure>,
) -> impl Parser<Input<'i, 's, S>, O, Failure> {
    terminated(parser, multispace0)
}

fn sum<'i, 's: 'i, S: Real>(input: &mut Input<'i, 's, S>) -> Result<NodeId, Failure> {
    let offset = input.current_token_start();
    input.state.depth += 1;
    if input.state.depth > MAX_DEPTH {
        input.state.report(offset, format!("nested more than {MAX_DEPTH} deep"));
        return Err(cut());
    }
    let result = expression(atom)
        .prefix(dispatch! { signs;
            true => Prefix(14, |i: &mut Input<'i, 's, S>, a| Ok(i.state.graph.negate(a))),
            false => Prefix(14, |_: &mut Input<'i, 's, S>, a| Ok(a)),
        })
        .infix(dispatch! { token(any);
            '+' => Left(10, |i: &mut Input<'i, 's, S>, a, b| Ok(i.state.graph.add(a, b))),
            '-' => Left(10, |i: &mut Input<'i, 's, S>, a, b| Ok(i.state.graph.subtract(a, b))),
            '*' => Left(12, |i: &mut Input<'i, 's, S>, a, b| Ok(i.state.graph.multiply(a, b))),
            '/' => Left(12, |i: &mut Input<'i, 's, S>, a, b| Ok(i.state.graph.divide(a, b))),
            '^' => Right(16, |i: &mut Input<'i, 's, S>, a, b| Ok(i.state.graph.power(a, b))),
            _ => fail,
        })
        .parse_next(input);
    input.state.depth -= 1;
    result
}

/// Returns true if a row of signs negates. It is read at once, since every operator in front of an operand costs stack.
fn signs<'i, 's: 'i, S: Real>(input: &mut Input<'i, 's, S>) -> Result<bool, Failure> {
    let signs = take_while(1.., |c: char| matches!(c, '+' | '-') || c.is_ascii_whitespace()).parse_next(input)?;
    Ok(signs.matches('-').count() % 2 == 1)
}

/// Where more than [`MAX_POWERS`] powers are exponents of each other, as in 2^2^2^…: they cost stack as parentheses do.
fn deep_power(text: &str) -> Option<usize> {
    // Those of every open parenthesis, and all of them.
    let (mut powers, mut all, mut before) = (vec![0], 0, ' ');
    for (offset, c) in text.char_indices().filter(|(_, c)| !c.is_ascii_whitespace()) {
        match (c, before) {
            ('(', _) => powers.push(0),
            (')', _) => all -= powers.pop().unwrap_or(0),
            ('^', _) => {
                powers.last_mut().map(|count| *count += 1)?;
                all += 1;
                if all > MAX_POWERS {
                    return Some(offset);
                }
            }
            // After another operator it is a sign.
            ('+' | '-', '^' | '+' | '-') => {}
            ('+' | '-' | '*' | '/', _) => all -= powers.last_mut().map_or(0, std::mem::take),
            _ => {}
        }
        before = c;
    }
    None
}

fn cut() -> Failure {
    ErrMode::Cut(ContextError::new())
}

fn atom<'i, 's: 'i, S: Real>(input: &mut Input<'i, 's, S>) -> Result<NodeId, Failure> {
    let offset = input.current_token_start();
    match peek_char(input) {
        Some('(') => {
            token('(').parse_next(input)?;
            closed(input, offset)
        }
        Some(c) if c.is_ascii_digit() || c == '.' => number(input),
        Some(c) if c.is_ascii_alphabetic() || c == '_' => name(input),
        other => {
            let found = other.map_or_else(|| "the end".to_owned(), |c| format!("'{c}'"));
            let named: Vec<&str> =
                input.state.names.variables.iter().copied().filter(|name| !name.is_empty()).collect();
            let variables = if named.len() > MOST_NAMED { "a name".to_owned() } else { named.join(", ") };
            input.state.report(
                offset,
                format!("expected a number, {variables}, a parameter, a function or a parenthesis, found {found}"),
            );
            Err(ErrMode::Backtrack(ContextError::new()))
        }
    }
}

fn peek_char<S>(input: &mut Input<'_, '_, S>) -> Option<char> {
    input.input.chars().next()
}

/// The rest of a parenthesised expression whose parenthesis was opened at `opened`.
fn closed<'i, 's: 'i, S: Real>(input: &mut Input<'i, 's, S>, opened: usize) -> Result<NodeId, Failure> {
    let inner = sum(input)?;
    let offset = input.current_token_start();
    if token(')').parse_next(input).is_err() {
        let rest = found(&input.input);
        input.state.report(
            offset,
            format!("expected an operator or the ')' that closes character {}, found {rest}", opened + 1),
        );
        return Err(cut());
    }
    Ok(inner)
}

/// The first argument of a function of two, with the comma after it.
fn first_of_two<'i, 's: 'i, S: Real>(input: &mut Input<'i, 's, S>, name: &str) -> Result<NodeId, Failure> {
    let first = sum(input)?;
    let offset = input.current_token_start();
    if token(',').parse_next(input).is_err() {
        let rest = found(&input.input);
        input.state.report(offset, format!("the function '{name}' has two arguments: expected a comma, found {rest}"));
        return Err(cut());
    }
    Ok(first)
}

fn number<'i, 's: 'i, S: Real>(input: &mut Input<'i, 's, S>) -> Result<NodeId, Failure> {
    let offset = input.current_token_start();
    let digits = |c: char| c.is_ascii_digit();
    let literal = (
        take_while(0.., digits),
        winnow::combinator::opt(('.', take_while(0.., digits))),
        winnow::combinator::opt((
            winnow::token::one_of(['e', 'E']),
            winnow::combinator::opt(winnow::token::one_of(['+', '-'])),
            take_while(1.., digits),
        )),
    );
    // "2x" and "1e" are mistakes, not products.
    let parsed: Result<&str, Failure> =
        terminated(literal.take(), not(peek(any.verify(|c: &char| c.is_alphanumeric() || *c == '_' || *c == '.'))))
            .parse_next(input);
    match parsed.ok().and_then(|literal| S::from_decimal(literal)).filter(|value| value.is_finite()) {
        Some(value) => {
            multispace0.parse_next(input)?;
            Ok(input.state.graph.constant(value))
        }
        None => {
            input.state.report(offset, "not a finite number (a product is written with *)");
            Err(cut())
        }
    }
}

fn name<'i, 's: 'i, S: Real>(input: &mut Input<'i, 's, S>) -> Result<NodeId, Failure> {
    let offset = input.current_token_start();
    let name: &str = token(take_while(1.., |c: char| c.is_ascii_alphanumeric() || c == '_')).parse_next(input)?;
    let called = peek_char(input) == Some('(');
    let tables = input.state.names.tables;
    let table = tables.iter().find(|(table, _)| table == name).map(|&(_, table)| Function::Table(table));
    let (function, pair) = (Function::from_name(name).or(table), pairs::from_name(name));
    if function.is_some() || pair.is_some() {
        let opened = input.current_token_start();
        if !called {
            let arguments = if pair.is_some() { "its two arguments" } else { "its argument" };
            input.state.report(offset, format!("the function '{name}' needs {arguments} in parentheses"));
            return Err(cut());
        }
        token('(').parse_next(input)?;
        let first = pair.map(|pair| Ok((pair, first_of_two(input, name)?))).transpose()?;
        let last = closed(input, opened)?;
        let graph = &mut input.state.graph;
        return Ok(match (function, first) {
            (Some(function), _) => graph.call(function, last),
            (None, Some((pair, first))) => graph.pair(pair, first, last),
            (None, None) => last,
        });
    }
    let Names { variables, parameters, definitions, .. } = input.state.names;
    let constant = || if name == "pi" { Some(S::PI) } else { parameters.get(name).copied() };
    // A parameter that is held is a definition, too.
    let node = match (variables.iter().position(|variable| *variable == name), definitions.get(name)) {
        (Some(variable), _) => Some(input.state.graph.variable(variable)),
        (None, Some(&node)) => Some(node),
        (None, None) => constant().map(|value| input.state.graph.constant(value)),
    };
    match node {
        Some(_) if called => {
            input.state.report(offset, format!("'{name}' is not a function (a product is written with *)"));
            Err(cut())
        }
        Some(node) => Ok(node),
        None => {
            let kind = if called { "function" } else { "name" };
            input.state.report(offset, format!("unknown {kind} '{name}'"));
            Err(cut())
        }
    }
}
