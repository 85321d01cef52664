//! Formulas of the states at both ends of a motion with all of their first derivatives, in balls.

use std::collections::BTreeMap;

use super::expressions::Expressions;
use super::inverse::Inverse;
use super::parts::{Parts, Scope, variables};
use super::{GeometryError, GeometryText, Place, active_of};
use crate::formula::{self, Known, NodeId, Program, run_on_balls};
use crate::number::Extended;
use crate::number::ball::{Ball, OFF};

/// A formula of the end of a motion, in which names stand for formulas of its start.
#[derive(Debug, Clone, Copy)]
pub(crate) struct OfEnds<'t> {
    pub(crate) end: &'t str,
    /// The names that stand for something of the start, each with its formula.
    pub(crate) starts: &'t [(String, String)],
}

/// Some such formulas g(q, p; q₀, p₀), where velocities are functions of positions and momenta.
#[derive(Debug)]
pub(crate) struct Jets {
    program: Program<Extended>,
    /// The number of coordinates n.
    dimension: usize,
    /// The number of unknown parameters.
    unknown: usize,
    /// For each formula the numbers of both ends, and unknown parameters, that it depends on.
    depends: Vec<Vec<bool>>,
}

/// A value, and the derivatives by q^a and p_a of the end, then of the start, and then by unknown parameters.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Jet {
    pub(crate) value: Ball,
    pub(crate) gradient: Vec<Ball>,
}

/// The states at both ends of a motion as a user's formulas see them, by nodes.
pub(super) struct Ends {
    pub(super) scope: Scope<Extended>,
    /// g_ab of the end.
    pub(super) metric: BTreeMap<[usize; 2], NodeId>,
    /// A_a of the end.
    pub(super) one_form: BTreeMap<usize, NodeId>,
    /// Everything of which the motion follows, in positions and velocities.
    pub(super) roots: Vec<NodeId>,
    /// Those of them that are no force.
    pub(super) fields: Vec<NodeId>,
    /// q, q̇ and p of the end, and the same of the start.
    pub(super) end: Vec<NodeId>,
    start: Vec<NodeId>,
    /// q̇ of the end as the geometry has it.
    pub(super) velocities: Vec<NodeId>,
    pub(super) names: Vec<String>,
}

impl Ends {
    /// Those of the scene `text`, where `norm` is K at the start.
    ///
    /// # Errors
    /// [`GeometryError`] with a mistake in a formula of the scene.
    pub(super) fn new(text: &GeometryText, norm: Extended, is_backward: bool) -> Result<Self, GeometryError> {
        let parts = Parts::new(text)?;
        let parts = if is_backward { parts.reversed() } else { parts };
        let mut parts = parts.of_two_ends(text.unknown.len());
        let (fields, roots) = (parts.fields(), parts.roots().into_iter().map(|node| *node).collect());
        let (n, inverse) = (parts.dimension(), Inverse::new(&mut parts)?);
        let active = active_of(&mut parts, &[]);
        let Expressions { velocities, .. } = Expressions::new(&mut parts, &inverse, &active);
        let mut scope = Scope::in_graph(std::mem::take(&mut parts.graph), text, 6 * n)?;
        scope.names.insert("norm".to_owned(), Known::Number(norm));
        scope.define(&text.definitions)?;
        // The end has the first 3n variables, of which velocities stand in none, and the start has as many behind them.
        // Unknown parameters are the last ones.
        let state = |first: usize, scope: &mut Scope<Extended>| -> Vec<NodeId> {
            let own: Vec<NodeId> = (first..first + 3 * n).map(|variable| scope.graph.variable(variable)).collect();
            let velocities = scope.graph.substitute(&velocities, &own);
            let mut state = [&own[..n], &velocities, &own[2 * n..]].concat();
            // Formulas see velocities and momenta as a user does.
            let rates = if is_backward { n..3 * n } else { 0..0 };
            for variable in rates.chain(text.mirrored().map(|a| 2 * n + a)) {
                state[variable] = scope.graph.negate(state[variable]);
            }
            state
        };
        let [end, start] = [0, 3 * n].map(|first| state(first, &mut scope));
        let own: Vec<NodeId> = (0..3 * n).map(|variable| scope.graph.variable(variable)).collect();
        let velocities = scope.graph.substitute(&velocities, &own);
        Ok(Self {
            metric: parts.metric,
            one_form: parts.one_form,
            roots,
            fields,
            velocities,
            names: variables(&text.names(), n, 3),
            scope,
            end,
            start,
        })
    }

    /// The number of coordinates n.
    pub(super) fn dimension(&self) -> usize {
        self.velocities.len()
    }

    /// A formula of the end, as a node.
    pub(super) fn of_end(&mut self, formula: &str) -> Result<NodeId, GeometryError> {
        let node = self.as_written(formula)?;
        Ok(self.scope.graph.substitute(&[node], &self.end)[0])
    }

    /// A formula in positions, velocities and momenta.
    pub(super) fn as_written(&mut self, formula: &str) -> Result<NodeId, GeometryError> {
        parsed(formula, &self.names, &mut self.scope)
    }
}

impl Jets {
    /// Compiles formulas of the scene `text`, where `norm` is K at the start.
    ///
    /// # Errors
    /// [`GeometryError`] with a mistake in a formula.
    pub(crate) fn new(
        text: &GeometryText,
        formulas: &[OfEnds<'_>],
        norm: Extended,
        is_backward: bool,
    ) -> Result<Self, GeometryError> {
        let ends = Ends::new(text, norm, is_backward)?;
        let n = ends.dimension();
        let Ends { mut scope, end, start, names, .. } = ends;
        let mut nodes = Vec::new();
        for of in formulas {
            let inner = of.starts.iter().map(|(_, inner)| parsed(inner, &names, &mut scope));
            let inner = inner.collect::<Result<Vec<_>, _>>()?;
            let inner = scope.graph.substitute(&inner, &start);
            let all: Vec<String> = names.iter().chain(of.starts.iter().map(|(name, _)| name)).cloned().collect();
            let node = parsed(of.end, &all, &mut scope)?;
            nodes.push(scope.graph.substitute(&[node], &[&end[..], &inner].concat())[0]);
        }
        Ok(Self::of_nodes(scope, [n, text.unknown.len()], &nodes))
    }

    /// Compiles nodes of a scene with so many coordinates and unknown parameters.
    pub(super) fn of_nodes(mut scope: Scope<Extended>, [n, unknown]: [usize; 2], nodes: &[NodeId]) -> Self {
        let (mut outputs, mut depends) = (Vec::new(), Vec::new());
        let all = 6 * n + unknown;
        for &node in nodes {
            let of = scope.graph.variables_of(node, all);
            depends.push(places(n, unknown).map(|variable| of[variable]).collect());
            outputs.push(node);
            outputs.extend(places(n, unknown).map(|variable| scope.graph.derivative(node, variable)));
        }
        let program = Program::new(&mut scope.graph, all, &outputs);
        Self { program, dimension: n, unknown, depends }
    }

    /// For each formula whether it depends on each q^a and p_a of the end, and then of the start.
    pub(crate) fn depends(&self) -> impl ExactSizeIterator<Item = &[bool]> {
        self.depends.iter().map(Vec::as_slice)
    }

    /// For each formula the positions of the end that it depends on, and behind them the unknown parameters, if it
    /// depends on nothing else.
    pub(crate) fn places(&self) -> impl Iterator<Item = Option<Vec<usize>>> {
        let (n, unknown) = (self.dimension, 4 * self.dimension);
        self.depends.iter().map(move |depends| {
            let places = (0..n).chain(unknown..depends.len()).filter(|&k| depends[k]);
            let places = places.map(|k| if k < n { k } else { k - unknown + n });
            (!depends[n..unknown].contains(&true)).then(|| places.collect())
        })
    }

    /// The number of coordinates n.
    pub(crate) fn dimension(&self) -> usize {
        self.dimension
    }

    /// Returns true if a formula depends on the momentum p_a of the end.
    pub(crate) fn look_at_momentum(&self, a: usize) -> bool {
        self.depends.iter().any(|depends| depends[self.dimension + a])
    }

    /// The formulas over sets of q^a and p_a of the end, then of the start, and of unknown parameters.
    pub(crate) fn at(&self, states: &[Ball]) -> Vec<Jet> {
        // A constant of the case is a decimal, or a formula of few of them.
        let mut registers = self.program.registers(|constant| Ball::of(constant, OFF));
        let places = places(self.dimension, self.unknown);
        places.zip(states).for_each(|(register, &value)| registers[register] = value);
        let each = 1 + 4 * self.dimension + self.unknown;
        run_on_balls(self.program.steps_to(each * self.depends.len()), &mut registers);
        let output = |k: usize| registers[self.program.output(k)];
        let jet = |k: usize| Jet {
            value: output(k * each),
            // A constant that is 0 has a radius, for underflow.
            gradient: (self.depends[k].iter().enumerate())
                .map(|(place, depends)| if *depends { output(k * each + 1 + place) } else { Ball::exact(0.0) })
                .collect(),
        };
        (0..self.depends.len()).map(jet).collect()
    }
}

/// The variables of positions and momenta, of the end and then of the start, and of unknown parameters.
fn places(n: usize, unknown: usize) -> impl Iterator<Item = usize> {
    let of_ends = [0, 3 * n].into_iter().flat_map(move |first| (first..first + n).chain(first + 2 * n..first + 3 * n));
    of_ends.chain(6 * n..6 * n + unknown)
}

fn parsed(text: &str, names: &[String], scope: &mut Scope<Extended>) -> Result<NodeId, GeometryError> {
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let node = formula::parse(text, &names, &scope.names, &mut scope.graph);
    node.map_err(|error| GeometryError::Formula(Place::Potential, error))
}

#[cfg(test)]
mod tests {
    use super::{Jets, OfEnds};
    use crate::geometry::GeometryText;
    use crate::number::Extended;
    use crate::number::ball::Ball;

    /// Values and derivatives of a formula of both ends of a motion on the sphere, against those by hand:
    /// q̇ = p/cos² of the longitude.
    #[test]
    fn formulas_of_both_ends_have_their_derivatives() {
        let text = GeometryText {
            coordinates: vec!["b".into(), "l".into()],
            components: vec![([0, 0], "1".into()), ([1, 1], "cos(b)^2".into())],
            ..GeometryText::default()
        };
        let starts = vec![("s".to_owned(), "l_dot + b".to_owned())];
        let of = OfEnds { end: "l_dot*s - p_b", starts: &starts };
        let jets = Jets::new(&text, &[of], Extended::from(0.5), false).unwrap();
        let at = [0.5, 1.0, 0.3, 0.7, -0.2, 0.4, 0.1, 1.1];
        let jet = &jets.at(&at.map(Ball::exact))[0];
        let [b, _, p_b, p_l, b_0, _, _, l_0] = at;
        let (square, square_0) = (f64::cos(b).powi(2), f64::cos(b_0).powi(2));
        let (l_dot, s) = (p_l / square, l_0 / square_0 + b_0);
        let turned = |b: f64, p: f64| 2.0 * p * b.sin() / b.cos().powi(3);
        let wanted =
            [turned(b, p_l) * s, 0.0, -1.0, s / square, l_dot * (turned(b_0, l_0) + 1.0), 0.0, 0.0, l_dot / square_0];
        assert!((jet.value.hi - (l_dot * s - p_b)).abs() < 1e-14 && jet.value.rad < 1e-28);
        for (found, wanted) in jet.gradient.iter().zip(wanted) {
            assert!((found.hi - wanted).abs() < 1e-14, "{found:?} {wanted}");
        }
    }
}
