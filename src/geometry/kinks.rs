//! Scenes that are smooth on both sides of surfaces: those where an argument of abs, sign or step changes its sign, or
//! that of a table passes a knot. On one side of it abs(a) is a or −a, sign and step are constants, and between two
//! knots a table is a polynomial.

use super::GeometryText;
use super::jets::{Ends, Jets};
use super::parts::Parts;
use crate::formula::{Function, Graph, NodeId};
use crate::number::spline::Table;
use crate::number::{Extended, Real};

/// Where an argument is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Side {
    /// Below 0.
    Negative,
    /// Above 0.
    Positive,
    /// On this piece of a table.
    Piece(usize),
}

/// An argument, and the calls that have it or its opposite.
struct Kink {
    argument: NodeId,
    table: Option<Table>,
    calls: Vec<(NodeId, Function, bool)>,
}

/// The arguments of a scene as functions of the state, with their derivatives, in balls.
pub(crate) struct Arguments {
    pub(crate) jets: Jets,
    /// The tables of those that have one.
    pub(crate) tables: Vec<Option<Table>>,
}

/// The arguments in these expressions, of which `fields` are those of the metric and the one-form. `None` if one stands
/// in the argument of another one, which may jump with it, or if it is not seen that no field jumps: the derivative of
/// a jump is 0 on both sides of it, and no force would show it.
fn kinks<S: Real>(graph: &mut Graph<S>, roots: &[NodeId], fields: &[NodeId]) -> Option<Vec<Kink>> {
    let table_of = |function: Function| match function {
        Function::Abs | Function::Sign | Function::Step => Some(None),
        Function::Table(table) => Some(Some(table)),
        _ => None,
    };
    let mut found: Vec<Kink> = Vec::new();
    for (call, function, argument) in graph.calls(roots) {
        let Some(table) = table_of(function) else { continue };
        if graph.calls(&[argument]).iter().any(|(_, inner, _)| table_of(*inner).is_some()) {
            return None;
        }
        let opposite = if table.is_none() { graph.negate(argument) } else { argument };
        let is_same =
            |kink: &&mut Kink| kink.table == table && (kink.argument == argument || kink.argument == opposite);
        match found.iter_mut().find(is_same) {
            Some(kink) => kink.calls.push((call, function, kink.argument != argument)),
            None => found.push(Kink { argument, table, calls: vec![(call, function, false)] }),
        }
    }
    found.iter().all(|kink| kink.table.is_some() || is_continuous(graph, fields, kink)).then_some(found)
}

/// True if both sides of all fields are one expression where the argument is 0: with 0 in its place or, if it is a
/// difference, with one of its terms in the place of the other.
fn is_continuous<S: Real>(graph: &mut Graph<S>, fields: &[NodeId], kink: &Kink) -> bool {
    let zero = graph.constant(S::ZERO);
    let opposite = graph.negate(kink.argument);
    let mut equal = vec![(kink.argument, zero), (opposite, zero)];
    for (one, other) in [kink.argument, opposite].into_iter().filter_map(|node| graph.terms_of_difference(node)) {
        equal.extend([(one, other), (other, one)]);
    }
    // A quotient by 0 may be anything, also where 0 times that is written as 0, or where it is cancelled. A divisor
    // that depends on nothing that the argument depends on is no more 0 at the surface than elsewhere.
    if singular(graph, fields).iter().any(|&divisor| graph.may_share(divisor, kink.argument)) {
        return false;
    }
    // The function abs has no jump.
    let calls = kink.calls.iter().copied().filter(|(_, function, _)| *function != Function::Abs).collect();
    let jumps = Kink { calls, ..*kink };
    let [below, above] = [Side::Negative, Side::Positive].map(|side| on_one_side(graph, fields, &jumps, side));
    let mut is_same = |below: NodeId, above: NodeId| {
        let mut is_zero_with = |&(place, by): &(NodeId, NodeId)| {
            let [below, above] = [below, above].map(|node| graph.replaced(&[node], place, by)[0]);
            let jump = graph.subtract(above, below);
            above == below || graph.is(jump, 0.0)
        };
        below == above || equal.iter().any(&mut is_zero_with)
    };
    below.into_iter().zip(above).all(|(below, above)| is_same(below, above))
}

/// The divisors in expressions, and the arguments of logarithms and tangents: these may have poles.
fn singular<S: Real>(graph: &Graph<S>, roots: &[NodeId]) -> Vec<NodeId> {
    let has_poles = |function: &Function| matches!(function, Function::Tan | Function::Ln | Function::Log10);
    let calls = graph.calls(roots).into_iter().filter(|(_, function, _)| has_poles(function));
    graph.divisors(roots).into_iter().chain(calls.map(|(_, _, argument)| argument)).collect()
}

/// Expressions with what functions of an argument are on a side in their places.
fn on_one_side<S: Real>(graph: &mut Graph<S>, roots: &[NodeId], kink: &Kink, side: Side) -> Vec<NodeId> {
    let mut roots = roots.to_vec();
    for &(call, function, is_opposite) in &kink.calls {
        let (own, side) = match (is_opposite, side) {
            (true, Side::Positive) => (graph.negate(kink.argument), Side::Negative),
            (true, Side::Negative) => (graph.negate(kink.argument), Side::Positive),
            _ => (kink.argument, side),
        };
        let by = on_side(graph, function, own, side);
        roots = graph.replaced(&roots, call, by);
    }
    roots
}

/// The expression that a function of an argument is on a side.
fn on_side<S: Real>(graph: &mut Graph<S>, function: Function, own: NodeId, side: Side) -> NodeId {
    match (function, side) {
        (Function::Table(table), Side::Piece(piece)) => {
            let Some((ends, coefficients)) = table.polynomial::<S>(piece) else { return graph.call(function, own) };
            let knot = graph.constant(ends[0]);
            let distance = graph.subtract(own, knot);
            let mut sum = graph.constant(S::ZERO);
            for &coefficient in coefficients.iter().rev() {
                let product = graph.multiply(sum, distance);
                let coefficient = graph.constant(coefficient);
                sum = graph.add(product, coefficient);
            }
            sum
        }
        (Function::Abs, Side::Positive) => own,
        (Function::Abs, _) => graph.negate(own),
        (Function::Sign, Side::Positive) | (Function::Step, Side::Positive) => graph.constant(S::ONE),
        (Function::Sign, _) => graph.constant(-S::ONE),
        _ => graph.constant(S::ZERO),
    }
}

impl<S: Real> Parts<S> {
    /// Everything of which the motion follows.
    pub(super) fn roots(&mut self) -> Vec<&mut NodeId> {
        let fields = self.metric.values_mut().chain(self.one_form.values_mut()).chain(self.force.values_mut());
        fields.chain(&mut self.hamiltonian).collect()
    }

    /// The metric, the one-form and the Hamiltonian.
    pub(super) fn fields(&self) -> Vec<NodeId> {
        self.metric.values().chain(self.one_form.values()).chain(&self.hamiltonian).copied().collect()
    }

    /// The scene on these sides of its surfaces, and what is 0 where a side ends: the argument, or its distances from
    /// both knots of a piece. Without sides it is what it was.
    pub(super) fn on_sides(mut self, sides: &[Side]) -> (Self, Vec<NodeId>) {
        let mut roots: Vec<NodeId> = self.roots().into_iter().map(|node| *node).collect();
        let fields = self.fields();
        let found = if sides.is_empty() { None } else { kinks(&mut self.graph, &roots, &fields) };
        let (graph, mut ends) = (&mut self.graph, Vec::new());
        for (kink, &side) in found.iter().flatten().zip(sides) {
            roots = on_one_side(graph, &roots, kink, side);
            let Kink { argument, table, .. } = kink;
            let piece = table.zip(if let Side::Piece(piece) = side { Some(piece) } else { None });
            match piece.and_then(|(table, piece)| table.polynomial::<S>(piece)) {
                None => ends.push(*argument),
                Some((knots, _)) => ends.extend(knots.map(|knot| {
                    let knot = graph.constant(knot);
                    graph.subtract(*argument, knot)
                })),
            }
        }
        self.roots().into_iter().zip(roots).for_each(|(node, new)| *node = new);
        (self, ends)
    }
}

/// True if it is not seen that a formula of the state is continuous. Of what jumps only its values tell, as the
/// derivative of a jump is 0 on both sides of it.
pub(crate) fn may_jump(text: &GeometryText, formula: &str) -> bool {
    let Ok(mut ends) = Ends::new(text, Extended::ZERO, false) else { return true };
    let Ok(node) = ends.as_written(formula) else { return true };
    let graph = &mut ends.scope.graph;
    // The derivatives of atan(1/x) and atan(tan(x)) may be written without a divisor.
    let is_divided = |&(_, _, argument): &(NodeId, Function, NodeId)| {
        singular(graph, &[argument]).into_iter().any(|divisor| graph.as_constant(divisor).is_none())
    };
    graph.calls(&[node]).iter().any(is_divided) || kinks(graph, &[node], &[node]).is_none()
}

/// The arguments of a scene, on its way back if `is_backward`. `None` if the sides of one may depend on those of
/// another one.
pub(crate) fn arguments(text: &GeometryText, is_backward: bool) -> Option<Arguments> {
    let mut ends = Ends::new(text, Extended::ZERO, is_backward).ok()?;
    let n = ends.dimension();
    let found = kinks(&mut ends.scope.graph, &ends.roots, &ends.fields)?;
    let tables = found.iter().map(|kink| kink.table).collect();
    let nodes: Vec<NodeId> = found.into_iter().map(|kink| kink.argument).collect();
    let own: Vec<NodeId> = (0..3 * n).map(|variable| ends.scope.graph.variable(variable)).collect();
    let state = [&own[..n], &ends.velocities, &own[2 * n..]].concat();
    let nodes = ends.scope.graph.substitute(&nodes, &state);
    Some(Arguments { jets: Jets::of_nodes(ends.scope, [n, text.unknown.len()], &nodes), tables })
}
