//! The formulas of a scene as they are written, and Hamilton's equations as they follow from them, in any precision:
//! what rounding takes from them is the difference of two precisions.

use super::expressions::Expressions;
use super::inverse::Inverse;
use super::parts::{Parts, Scope};
use super::text::{GeometryError, GeometryText, Law, Place};
use crate::formula::{Graph, Known, NodeId, Program, run_on_balls};
use crate::number::ball::Ball;
use crate::number::{Extended, Real};

/// A program with its registers, which is run at one point after another.
#[derive(Debug, Clone)]
struct AtPoints<S> {
    program: Program<S>,
    registers: Vec<[S; 1]>,
}

impl<S: Real> AtPoints<S> {
    fn new(graph: &mut Graph<S>, variables: usize, outputs: &[NodeId]) -> Self {
        let program = Program::new(graph, variables, outputs);
        Self { registers: program.registers(|constant| [constant]), program }
    }

    /// The outputs where variables have these values.
    fn at(&mut self, variables: impl Iterator<Item = S>) -> Vec<S> {
        let Self { program, registers } = self;
        registers.iter_mut().zip(variables).for_each(|(register, value)| *register = [value]);
        let outputs = program.outputs.len();
        program.run(outputs, 1, registers, &mut 1);
        (0..outputs).map(|output| registers[program.output(output)][0]).collect()
    }
}

/// Hamilton's equations of *all* coordinates as they follow from the formulas. A coordinate that is ignorable in one
/// precision may be active in another, where a number that rounds to 0 is none.
#[derive(Debug, Clone)]
pub struct WrittenRates<S> {
    at_points: AtPoints<S>,
    /// Registers of balls, if there were any yet.
    balls: Vec<Ball>,
}

impl<S: Real> WrittenRates<S> {
    /// Compiles the equations, of the motion on its way back if `is_backward`.
    ///
    /// # Errors
    /// [`GeometryError`] with the place of the mistake.
    pub fn new(text: &GeometryText, is_backward: bool) -> Result<Self, GeometryError> {
        let parts = Parts::new(text)?;
        let mut parts = if is_backward { parts.reversed() } else { parts };
        let inverse = Inverse::new(&mut parts)?;
        let n = parts.dimension();
        let Expressions { velocities, forces, .. } =
            Expressions::new(&mut parts, &inverse, &(0..n).collect::<Vec<_>>());
        let at_points = AtPoints::new(&mut parts.graph, 3 * n, &[velocities, forces].concat());
        Ok(Self { at_points, balls: Vec::new() })
    }

    /// q̇^a of all coordinates, and then ṗ_a of all, inside the domain or not.
    pub fn at(&mut self, q: &[S], p: &[S]) -> Vec<S> {
        let unused = std::iter::repeat_n(S::ZERO, q.len());
        self.at_points.at(q.iter().copied().chain(unused).chain(p.iter().copied()))
    }
}

impl WrittenRates<Extended> {
    /// The same in balls, with 32 digits and at a small part of the costs; unknown where something is not analytic.
    pub(crate) fn in_balls(&mut self, q: &[f64], p: &[f64]) -> impl Iterator<Item = Ball> {
        let Self { at_points: AtPoints { program, .. }, balls } = self;
        if balls.is_empty() {
            *balls = program.registers(|constant| Ball::of(constant, 0.0));
        }
        q.iter().enumerate().for_each(|(a, &q)| balls[a] = Ball::exact(q));
        p.iter().enumerate().for_each(|(a, &p)| balls[2 * q.len() + a] = Ball::exact(p));
        let outputs = program.outputs.len();
        run_on_balls(program.steps_to(outputs), balls);
        (0..outputs).map(|output| balls[program.output(output)])
    }
}

/// The formulas of a scene in positions and velocities: their values and derivatives, as far as motion depends on them.
#[derive(Debug)]
pub struct WrittenFormulas<S> {
    /// The places of the formulas, each with the number of its outputs. Definitions come before those that use them.
    places: Vec<(Place, usize)>,
    at_points: AtPoints<S>,
}

impl<S: Real> WrittenFormulas<S> {
    /// Compiles the formulas.
    ///
    /// # Errors
    /// [`GeometryError`] with the place of the mistake.
    pub fn new(text: &GeometryText) -> Result<Self, GeometryError> {
        let mut scope = Scope::new(text)?;
        scope.define(&text.definitions)?;
        let mut found: Vec<(Place, NodeId)> = Vec::new();
        for (name, _) in &text.definitions {
            if let Some(Known::Node(node)) = scope.names.get(name) {
                found.push((Place::Definition(name.clone()), *node));
            }
        }
        let potential = text.potential.iter();
        let of_potential = potential.clone().map(|potential| (Place::Potential, &potential.expression));
        let masses = potential.flat_map(|potential| potential.masses.iter().enumerate());
        let masses = masses.map(|(a, mass)| (Place::Mass(Some(a)), mass));
        let components = text.components.iter().map(|(ab, component)| (Place::Component(*ab), component));
        let one_form = text.one_form.iter().map(|(a, component)| (Place::OneForm(*a), component));
        let force = text.force.iter().map(|(a, component)| (Place::Force(*a), component));
        let conformal = text.conformal.iter().map(|omega| (Place::Conformal, omega));
        for (place, formula) in
            of_potential.chain(masses).chain(components).chain(one_form).chain(force).chain(conformal)
        {
            let node = scope.parse(formula, place.clone(), 2)?;
            found.push((place, node));
        }
        let (mut places, mut outputs) = (Vec::new(), Vec::new());
        for (place, node) in found {
            let before = outputs.len();
            // Newton's potential acts by its slopes alone.
            let has_value = !(place == Place::Potential && text.law() == Some(Law::Newtonian));
            outputs.extend(has_value.then_some(node));
            for variable in 0..scope.all {
                outputs.push(scope.graph.derivative(node, variable));
            }
            places.push((place, outputs.len() - before));
        }
        let at_points = AtPoints::new(&mut scope.graph, 2 * scope.all, &outputs);
        Ok(Self { places, at_points })
    }

    /// The places of the formulas with their values and derivatives at a point.
    pub fn at(&mut self, q: &[S], q_dot: &[S]) -> Vec<(Place, Vec<S>)> {
        let mut values = self.at_points.at(q.iter().chain(q_dot).copied()).into_iter();
        self.places.iter().map(|(place, count)| (place.clone(), values.by_ref().take(*count).collect())).collect()
    }
}
