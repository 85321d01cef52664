//! From the text of a scene to expressions: components, one-form and force as nodes of one graph.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::ops::Range;

use super::presets::Preset;
use super::text::{GeometryError, GeometryText, Law, Place, Potential, uses, words};
use crate::formula::{self, Graph, Known, Names, NodeId};
use crate::number::Real;

/// The Lagrangian and the force as expressions. Variable a of the graph is q^a, variable n + a is dq^a/dγ.
#[derive(Debug, Clone)]
pub(super) struct Parts<S> {
    pub(super) graph: Graph<S>,
    pub(super) names: Vec<String>,
    /// g_ab for a ≤ b, where it is not zero.
    pub(super) metric: BTreeMap<[usize; 2], NodeId>,
    /// A_a, where it is not zero.
    pub(super) one_form: BTreeMap<usize, NodeId>,
    /// H(q, p) = ½ g^ab (p_a − A_a)(p_b − A_b), where it is known; variable 2n + a is p_a.
    pub(super) hamiltonian: Option<NodeId>,
    /// F_a, where it is not zero.
    pub(super) force: BTreeMap<usize, NodeId>,
    /// The coordinates of particles in a potential.
    pub(super) particles: Range<usize>,
    /// Formulas of q, q̇ and p, whose rates are the velocities of the last coordinates.
    pub(super) watched: Vec<NodeId>,
    /// Coordinates that stay where they are: unknown parameters.
    pub(super) unknown: Range<usize>,
}

/// The names that the formulas of a scene may refer to.
pub(super) struct Scope<S> {
    pub(super) graph: Graph<S>,
    /// Names of the coordinates that formulas may use; they are the first variables of the graph.
    coordinates: Vec<String>,
    /// Number of all coordinates.
    pub(super) all: usize,
    pub(super) names: Names<S>,
}

/// The names of variables: of positions, of velocities too, or of momenta too, by the number of `kinds`. Those of
/// coordinates beyond the given ones are empty, so that formulas cannot use them.
pub(super) fn variables(coordinates: &[String], all: usize, kinds: usize) -> Vec<String> {
    const KINDS: [fn(&String) -> String; 3] = [String::clone, |q| format!("{q}_dot"), |q| format!("p_{q}")];
    (0..kinds * all).map(|k| coordinates.get(k % all).map_or_else(String::new, KINDS[k / all])).collect()
}

impl<S: Real> Scope<S> {
    /// The names of a scene in a graph, without its definitions.
    pub(super) fn new(scene: &GeometryText) -> Result<Self, GeometryError> {
        Self::in_graph(Graph::default(), scene, 3 * scene.names().len())
    }

    /// The same in a graph that has nodes already, with unknown parameters in the place of its variables from `first`
    /// on.
    pub(super) fn in_graph(mut graph: Graph<S>, scene: &GeometryText, first: usize) -> Result<Self, GeometryError> {
        let mut names = parameters(&scene.parameters)?;
        let mut unknown = scene.unknown.clone();
        for (j, name) in unknown.iter().enumerate() {
            names.insert(name.clone(), Known::Node(graph.variable(first + j)));
        }
        for k in in_order(&scene.parameters)? {
            let (name, text) = &scene.parameters[k];
            if !unknown.contains(name) && unknown.iter().any(|other| uses(text, other)) {
                let node = formula::parse(text, &[], &names, &mut graph);
                let node = node.map_err(|error| GeometryError::Formula(Place::Parameter(name.clone()), error))?;
                names.insert(name.clone(), Known::Node(node));
                unknown.push(name.clone());
            }
        }
        for name in &scene.held {
            if let Some(Known::Number(value)) = names.get(name).copied() {
                names.insert(name.clone(), Known::Node(graph.held(value)));
            }
        }
        names.extend(scene.tables.iter().map(|(name, table)| (name.clone(), Known::Table(*table))));
        Ok(Self { graph, coordinates: scene.positions(), all: scene.names().len(), names })
    }

    /// A formula in so many [`variables`].
    pub(super) fn parse(&mut self, text: &str, place: Place, kinds: usize) -> Result<NodeId, GeometryError> {
        let variables = variables(&self.coordinates, self.all, kinds);
        let variables: Vec<&str> = variables.iter().map(String::as_str).collect();
        formula::parse(text, &variables, &self.names, &mut self.graph)
            .map_err(|error| GeometryError::Formula(place, error))
    }

    /// Ω, if there is a formula of it.
    fn omega(&mut self, conformal: Option<&String>) -> Result<Option<NodeId>, GeometryError> {
        conformal.map(|omega| self.parse(omega, Place::Conformal, 1)).transpose()
    }

    /// Newton's force F(x, dx/dt) as a force of the lift, Ω ṫ² F(x, ẋ/ṫ): with p_x = −Ω m ẋ and the constant
    /// p_s = Ωṫ, the rate dp_x/dγ is −Ωṫ² m d²x/dt². The path does not depend on the rate of t.
    fn by_time(&mut self, force: NodeId, omega: Option<NodeId>) -> NodeId {
        let n = self.all;
        let t_dot = self.graph.variable(n);
        let mut replacement: Vec<NodeId> = (0..2 * n).map(|variable| self.graph.variable(variable)).collect();
        for velocity in &mut replacement[n..] {
            *velocity = self.graph.divide(*velocity, t_dot);
        }
        let force = self.graph.substitute(&[force], &replacement)[0];
        let force = omega.map_or(force, |omega| self.graph.multiply(omega, force));
        let square = self.graph.power_integer(t_dot, 2);
        self.graph.multiply(square, force)
    }

    /// Adds F_t = −F·ẋ/ṫ: a force does not change K, and Q_t changes by its work.
    fn add_work(&mut self, force: &mut BTreeMap<usize, NodeId>) {
        if force.is_empty() {
            return;
        }
        let mut power = self.graph.constant(S::ZERO);
        for (&a, &node) in force.iter() {
            let velocity = self.graph.variable(self.all + a);
            power = plus(&mut self.graph, power, [node, velocity]);
        }
        let t_dot = self.graph.variable(self.all);
        let rate = self.graph.divide(power, t_dot);
        force.insert(0, self.graph.negate(rate));
    }

    /// Adds the definitions, each after those that it uses.
    pub(super) fn define(&mut self, definitions: &[(String, String)]) -> Result<(), GeometryError> {
        for k in in_order(definitions)? {
            let (name, text) = &definitions[k];
            let node = self.parse(text, Place::Definition(name.clone()), 1)?;
            self.names.insert(name.clone(), Known::Node(node));
        }
        Ok(())
    }
}

/// The places of named formulas, each after those that it uses.
fn in_order(named: &[(String, String)]) -> Result<Vec<usize>, GeometryError> {
    let places: HashMap<&str, usize> = named.iter().enumerate().map(|(k, (name, _))| (name.as_str(), k)).collect();
    let used = |(_, text): &(String, String)| {
        let found: BTreeSet<usize> = words(text).filter_map(|word| places.get(word).copied()).collect();
        found.into_iter().collect()
    };
    let used: Vec<Vec<usize>> = named.iter().map(used).collect();
    let (mut order, mut is_done) = (Vec::new(), vec![false; named.len()]);
    for k in 0..named.len() {
        append(k, (named, &used), (&mut order, &mut is_done), &mut Vec::new())?;
    }
    Ok(order)
}

/// Appends what formula `k` uses, and itself; those on the `path` wait for it.
fn append(
    k: usize,
    (named, used): (&[(String, String)], &[Vec<usize>]),
    (order, is_done): (&mut Vec<usize>, &mut [bool]),
    path: &mut Vec<usize>,
) -> Result<(), GeometryError> {
    if is_done[k] {
        return Ok(());
    }
    if let Some(start) = path.iter().position(|&other| other == k) {
        let circle = path[start..].iter().chain([&k]).map(|&k| named[k].0.clone());
        return Err(GeometryError::Circular(circle.collect()));
    }
    path.push(k);
    for &other in &used[k] {
        append(other, (named, used), (order, is_done), path)?;
    }
    path.pop();
    order.push(k);
    is_done[k] = true;
    Ok(())
}

/// The value of a formula without variables, in which parameters may occur.
pub(super) fn constant<S: Real>(text: &str, parameters: &Names<S>, place: Place) -> Result<S, GeometryError> {
    let mut graph = Graph::default();
    let node = formula::parse(text, &[], parameters, &mut graph)
        .map_err(|error| GeometryError::Formula(place.clone(), error))?;
    let value = graph.as_constant(node).expect("an expression without variables is folded to a constant");
    if value.is_finite() { Ok(value) } else { Err(GeometryError::NotFinite(place)) }
}

/// The values of the parameters.
fn parameters<S: Real>(texts: &[(String, String)]) -> Result<Names<S>, GeometryError> {
    let mut values = Names::new();
    for k in in_order(texts)? {
        let (name, text) = &texts[k];
        let value = constant(text, &values, Place::Parameter(name.clone()))?;
        values.insert(name.clone(), Known::Number(value));
    }
    Ok(values)
}

/// The value of a formula in the `parameters` of a scene and no variables, such as `pi/3`.
///
/// # Errors
/// [`GeometryError::Formula`] if there is a mistake in it, or [`GeometryError::NotFinite`].
pub fn value_of<S: Real>(text: &str, parameters: &[(String, String)]) -> Result<S, GeometryError> {
    constant(text, &self::parameters(parameters)?, Place::Parameter(String::new()))
}

/// sum + a b.
pub(super) fn plus<S: Real>(graph: &mut Graph<S>, sum: NodeId, [a, b]: [NodeId; 2]) -> NodeId {
    let product = graph.multiply(a, b);
    graph.add(sum, product)
}

impl<S: Real> Parts<S> {
    pub(super) fn new(text: &GeometryText) -> Result<Self, GeometryError> {
        let scope = Scope::new(text)?;
        let parts = match &text.potential {
            None => Self::of_metric(text, scope),
            Some(potential) => Self::of_potential(text, potential, scope),
        };
        parts.map(Self::without_zeros)
    }

    fn of_metric(text: &GeometryText, mut scope: Scope<S>) -> Result<Self, GeometryError> {
        let (names, n) = (text.names(), scope.all);
        scope.define(&text.definitions)?;
        let omega = scope.omega(text.conformal.as_ref())?;
        let (mut metric, mut one_form, mut force) = (BTreeMap::new(), BTreeMap::new(), BTreeMap::new());
        for ([a, b], component) in &text.components {
            let node = scope.parse(component, Place::Component([*a, *b]), 1)?;
            let node = omega.map_or(node, |omega| scope.graph.multiply(omega, node));
            metric.insert([*a.min(b), *a.max(b)], node);
        }
        if let Some(tau) = text.tau {
            let flat = scope.graph.constant(tau.component());
            metric.insert([n - 1, n - 1], omega.map_or(flat, |omega| scope.graph.multiply(omega, flat)));
        }
        for (a, component) in &text.one_form {
            one_form.insert(*a, scope.parse(component, Place::OneForm(*a), 1)?);
        }
        for (a, component) in &text.force {
            force.insert(*a, scope.parse(component, Place::Force(*a), 2)?);
        }
        let hamiltonian = Preset::hamiltonian(text).map(|alone| scope.hamiltonian(alone, &one_form, text.tau, omega));
        Ok(Self {
            graph: scope.graph,
            names,
            metric,
            one_form,
            hamiltonian,
            force,
            particles: 0..0,
            watched: Vec::new(),
            unknown: 0..0,
        })
    }

    fn of_potential(text: &GeometryText, potential: &Potential, mut scope: Scope<S>) -> Result<Self, GeometryError> {
        let (parameters, names, n) = (parameters(&text.parameters)?, text.names(), scope.all);
        let number = |text: &str, place| constant(text, &parameters, place);
        let mass = number(&potential.mass, Place::Mass(None))?;
        let c = number(&potential.c, Place::SpeedOfLight)?;
        let is_newtonian = potential.law == Law::Newtonian;
        // With the paper's metric the Lagrangian is −1/m of Newton's, with the lift it is −1 of it.
        let scale = if is_newtonian { S::ONE } else { mass };
        let particles = 1..text.coordinates.len() + 1;
        let undefined = scope.names.clone();
        scope.define(&text.definitions)?;
        let v = scope.parse(&potential.expression, Place::Potential, 1)?;
        let mut metric = BTreeMap::new();
        let two_over_scale = scope.graph.constant(S::from(2.0) / scale);
        let mut g_tt = scope.graph.multiply(two_over_scale, v);
        if !is_newtonian {
            let c_squared = scope.graph.constant(c * c);
            g_tt = scope.graph.add(c_squared, g_tt);
        }
        metric.insert([0, 0], g_tt);
        let minus_one_over_scale = scope.graph.constant(-S::ONE / scale);
        // Masses depend on t alone, and not on definitions.
        let defined = std::mem::replace(&mut scope.names, undefined);
        let coordinates = std::mem::replace(&mut scope.coordinates, vec!["t".to_owned()]);
        for (a, mass) in potential.masses.iter().enumerate() {
            let mass = scope.parse(mass, Place::Mass(Some(a)), 1)?;
            let component = match scope.graph.as_constant(mass) {
                Some(mass) if !mass.is_finite() => return Err(GeometryError::NotFinite(Place::Mass(Some(a)))),
                Some(mass) => scope.graph.constant(-mass / scale),
                None => scope.graph.multiply(minus_one_over_scale, mass),
            };
            metric.insert([a + 1, a + 1], component);
        }
        (scope.coordinates, scope.names) = (coordinates, defined);
        if is_newtonian {
            metric.insert([0, n - 1], scope.graph.constant(S::ONE));
        }
        // −ṫ A·ẋ, so that the Lagrangian stays homogeneous: the path does not depend on the rate of t.
        for (a, component) in &text.one_form {
            let node = scope.parse(component, Place::OneForm(*a), 1)?;
            metric.insert([0, a + 1], scope.graph.multiply(minus_one_over_scale, node));
        }
        let omega = scope.omega(text.conformal.as_ref())?;
        let mut force = BTreeMap::new();
        for (a, component) in &text.force {
            let node = scope.parse(component, Place::Force(*a), 2)?;
            let node = if is_newtonian { scope.by_time(node, omega) } else { node };
            force.insert(a + 1, scope.graph.multiply(minus_one_over_scale, node));
        }
        scope.add_work(&mut force);
        let hamiltonian = is_newtonian.then(|| scope.lift(&metric, omega));
        if let Some(omega) = omega {
            for node in metric.values_mut() {
                *node = scope.graph.multiply(omega, *node);
            }
        }
        let (one_form, watched, unknown) = (BTreeMap::new(), Vec::new(), 0..0);
        Ok(Self { graph: scope.graph, names, metric, one_form, hamiltonian, force, particles, watched, unknown })
    }

    /// The same world-lines on their way back: velocities and momenta have the other sign.
    pub(super) fn reversed(mut self) -> Self {
        let (graph, n) = (&mut self.graph, self.names.len());
        let mut replacement: Vec<NodeId> = (0..3 * n).map(|variable| graph.variable(variable)).collect();
        replacement[n..].iter_mut().for_each(|rate| *rate = graph.negate(*rate));
        self.one_form.values_mut().for_each(|node| *node = graph.negate(*node));
        for node in self.force.values_mut().chain(&mut self.hamiltonian) {
            *node = graph.substitute(&[*node], &replacement)[0];
        }
        self
    }

    /// The same with unknown parameters behind the variables of two states, as many as there are.
    pub(super) fn of_two_ends(mut self, unknown: usize) -> Self {
        let n = self.dimension();
        let place = |k: usize| if k < 3 * n { k } else { k + 3 * n };
        let moved: Vec<NodeId> = (0..3 * n + unknown).map(|k| self.graph.variable(place(k))).collect();
        self.renamed(&moved);
        self
    }

    /// Puts other nodes in the place of variables of all fields.
    pub(super) fn renamed(&mut self, variables: &[NodeId]) {
        let roots: Vec<NodeId> = self.roots().into_iter().map(|node| *node).collect();
        let roots = self.graph.substitute(&roots, variables);
        self.roots().into_iter().zip(roots).for_each(|(node, new)| *node = new);
    }

    fn without_zeros(mut self) -> Self {
        let graph = &self.graph;
        self.metric.retain(|_, node| !graph.is(*node, 0.0));
        self.one_form.retain(|_, node| !graph.is(*node, 0.0));
        self.force.retain(|_, node| !graph.is(*node, 0.0));
        self
    }

    /// Number of coordinates.
    pub(super) fn dimension(&self) -> usize {
        self.names.len()
    }

    /// g_ab for a ≤ b, and then A_a as g_an: a Lagrangian has both, with the velocity q̇^n = 1.
    pub(super) fn components(&self) -> Vec<([usize; 2], NodeId)> {
        let one_form = self.one_form.iter().map(|(&a, &node)| ([a, self.dimension()], node));
        self.metric.iter().map(|(&ab, &node)| (ab, node)).chain(one_form).collect()
    }

    /// g_ab, in either order of the indices.
    pub(super) fn component(&self, a: usize, b: usize) -> Option<NodeId> {
        self.metric.get(&[a.min(b), a.max(b)]).copied()
    }
}
