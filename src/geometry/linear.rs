//! What a start depends on: the degrees of its numbers as polynomials in unknown parameters.

use std::collections::BTreeMap;

use super::parts::{Parts, Scope};
use super::{GeometryError, GeometryText, Place};
use crate::formula::{self, Graph, NodeId};
use crate::number::Extended;

/// A start as text: of every coordinate its position, and its velocity or its momentum if that is given.
#[derive(Debug, Clone)]
pub(crate) struct StartTexts {
    pub(crate) q: Vec<String>,
    pub(crate) velocities: Vec<Option<String>>,
    pub(crate) momenta: Vec<Option<String>>,
    /// Other numbers.
    pub(crate) others: Vec<String>,
}

/// The degrees of these numbers, `None` of what is no polynomial or is not known to be one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Degrees {
    pub(crate) q: Vec<Option<u32>>,
    pub(crate) q_dot: Vec<Option<u32>>,
    pub(crate) p: Vec<Option<u32>>,
    pub(crate) others: Vec<Option<u32>>,
}

impl Degrees {
    /// Those of a start in the scene `text`, in its unknown parameters.
    ///
    /// # Errors
    /// [`GeometryError`] with a mistake in a formula.
    pub(crate) fn new(text: &GeometryText, start: &StartTexts) -> Result<Self, GeometryError> {
        let mut parts = Parts::<Extended>::new(text)?;
        let n = parts.dimension();
        let mut scope = Scope::in_graph(std::mem::take(&mut parts.graph), text, 3 * n)?;
        let mut node = |text: &str| {
            let node = formula::parse(text, &[], &scope.names, &mut scope.graph);
            node.map_err(|error| GeometryError::Formula(Place::Potential, error))
        };
        let q = start.q.iter().map(|text| node(text)).collect::<Result<Vec<_>, _>>()?;
        let mut given = |texts: &[Option<String>]| -> Result<Vec<Option<NodeId>>, GeometryError> {
            texts.iter().map(|text| text.as_deref().map(&mut node).transpose()).collect()
        };
        let (velocities, momenta) = (given(&start.velocities)?, given(&start.momenta)?);
        let others = start.others.iter().map(|text| node(text)).collect::<Result<Vec<_>, _>>()?;
        let graph = &mut scope.graph;
        // Positions that are not given, as that of tau, stay variables, and no polynomials follow from them.
        let mut there = |nodes: Vec<NodeId>| graph.substitute(&nodes, &q);
        let metric: BTreeMap<[usize; 2], NodeId> =
            parts.metric.keys().copied().zip(there(parts.metric.values().copied().collect())).collect();
        let one_form: BTreeMap<usize, NodeId> =
            parts.one_form.keys().copied().zip(there(parts.one_form.values().copied().collect())).collect();
        let [q_dot, p] = followed(graph, [&velocities, &momenta], (n, &metric, &one_form));
        let degree = |node: NodeId| graph.degree(node);
        let all = |nodes: &[Option<NodeId>]| nodes.iter().map(|node| node.and_then(degree)).collect::<Vec<_>>();
        // If nothing depends on them, neither does what follows from all of it.
        let known = q.iter().chain(velocities.iter().flatten()).chain(momenta.iter().flatten());
        let mut fields = known.chain(metric.values()).chain(one_form.values());
        let is_constant = fields.all(|&node| degree(node) == Some(0));
        let follows = |degrees: Vec<Option<u32>>| {
            degrees.into_iter().map(|degree| degree.or(is_constant.then_some(0))).collect::<Vec<_>>()
        };
        Ok(Self {
            q: q.iter().map(|&node| degree(node)).collect(),
            q_dot: follows(all(&q_dot)),
            p: follows(all(&p)),
            others: others.iter().map(|&node| degree(node)).collect(),
        })
    }
}

/// Velocities and momenta, of which each is given or follows from the others.
fn followed(
    graph: &mut Graph<Extended>,
    [velocities, momenta]: [&[Option<NodeId>]; 2],
    (n, metric, one_form): (usize, &BTreeMap<[usize; 2], NodeId>, &BTreeMap<usize, NodeId>),
) -> [Vec<Option<NodeId>>; 2] {
    let row =
        |a: usize| -> Vec<(usize, NodeId)> { (0..n).filter_map(|b| Some((b, metric_at(metric, a, b)?))).collect() };
    let mut q_dot = Vec::new();
    for a in 0..n {
        let (velocity, momentum) = (velocities.get(a).copied().flatten(), momenta.get(a).copied().flatten());
        // Where a coordinate is coupled to no other one its velocity follows from its momentum alone.
        let follows = momentum.zip(metric_at(metric, a, a)).filter(|_| row(a).len() == 1);
        let follows = follows.map(|(momentum, own)| {
            let kinetic = one_form.get(&a).map_or(momentum, |&one_form| graph.subtract(momentum, one_form));
            graph.divide(kinetic, own)
        });
        q_dot.push(velocity.or(follows));
    }
    let mut p = Vec::new();
    for a in 0..n {
        let zero = graph.constant(Extended::ZERO);
        let of_one_form = one_form.get(&a).copied().unwrap_or(zero);
        let sum = row(a).into_iter().try_fold(of_one_form, |sum, (b, component)| {
            let term = graph.multiply(component, q_dot[b]?);
            Some(graph.add(sum, term))
        });
        p.push(momenta.get(a).copied().flatten().or(sum));
    }
    [q_dot, p]
}

/// g_ab, in either order of the indices.
fn metric_at(metric: &BTreeMap<[usize; 2], NodeId>, a: usize, b: usize) -> Option<NodeId> {
    metric.get(&[a.min(b), a.max(b)]).copied()
}
