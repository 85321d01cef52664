//! Scenes with more coordinates for a proof. Formulas that are watched are coordinates on which nothing depends, and
//! which move as they do. Unknown parameters are coordinates that stay where they are, and on which much may depend.
//!
//! Of a formula g(q, q̇, p) of the state, ġ = ∂g/∂q^a q̇^a + ∂g/∂p_a ṗ_a is a function of q and p, as velocities are.
//! Where g changes its sign the coordinate passes 0, so that whatever is known of coordinates is known of events, too:
//! what their errors have in common with those of the others, and how they bend.

use super::expressions::Expressions;
use super::inverse::Inverse;
use super::kinks::Side;
use super::parts::{Parts, Scope, variables};
use super::{Geometry, GeometryError, GeometryText, Place, active_of};
use crate::formula::{self, Known, NodeId};
use crate::number::Real;

/// What goes along beside a motion.
#[derive(Debug, Clone, Copy, Default)]
pub struct Beside<'t> {
    /// Formulas of the state.
    pub formulas: &'t [&'t str],
    /// Coordinates that are active in any case: their momenta are no constants of the equations, whose values cannot
    /// change.
    pub also: &'t [usize],
    /// The sides on which the arguments of abs, sign, step and tables are: the scene is that of this side everywhere,
    /// and what is 0 where it ends are formulas behind the others. Without sides it is what it is.
    pub sides: &'t [Side],
}

impl<S: Real> Geometry<S> {
    /// The scene of `text`, on its way back if `is_backward`, in which the last coordinates are the values of formulas
    /// of a state, where `norm` is K at the start. Their momenta are 0. What the rates of formulas depend on is active.
    /// Before them stand unknown parameters of `text`. A mistake is reported as one of the potential.
    ///
    /// # Errors
    /// [`GeometryError`] with the mistake.
    pub fn watching(
        text: &GeometryText,
        beside: Beside<'_>,
        norm: S,
        is_backward: bool,
    ) -> Result<Self, GeometryError> {
        let parts = Parts::new(text)?;
        let parts = if is_backward { parts.reversed() } else { parts };
        let parts = parts.watching(text, beside, norm, is_backward)?;
        let kept = parts.clone().places_of_rates()?;
        Self::of_parts(parts, &[&kept, beside.also].concat())
    }
}

impl<S: Real> Parts<S> {
    /// The same with a coordinate for each unknown parameter and each formula.
    fn watching(
        self,
        text: &GeometryText,
        Beside { formulas, sides, .. }: Beside<'_>,
        norm: S,
        is_backward: bool,
    ) -> Result<Self, GeometryError> {
        let n = self.dimension();
        let (mut this, arguments) = self.on_sides(sides);
        this.unknown = n..n + text.unknown.len();
        let all = this.unknown.end + formulas.len() + arguments.len();
        // Velocities and momenta stand behind so many more variables, and unknown parameters before them.
        let place = |k: usize| if k < 3 * n { k / n * all + k % n } else { k - 2 * n };
        let moved: Vec<NodeId> = (0..3 * n + text.unknown.len()).map(|k| this.graph.variable(place(k))).collect();
        let arguments = this.graph.substitute(&arguments, &moved);
        this.renamed(&moved);
        let one = this.graph.constant(S::ONE);
        for a in n..all {
            this.names.push(String::new());
            this.metric.insert([a, a], one);
        }
        let mut scope = Scope::in_graph(std::mem::take(&mut this.graph), text, n)?;
        scope.names.insert("norm".to_owned(), Known::Number(norm));
        scope.define(&text.definitions)?;
        let variables = variables(&text.names(), all, 3);
        let variables: Vec<&str> = variables.iter().map(String::as_str).collect();
        for formula in formulas {
            let node = formula::parse(formula, &variables, &scope.names, &mut scope.graph);
            this.watched.push(node.map_err(|error| GeometryError::Formula(Place::Potential, error))?);
        }
        // Formulas see velocities and momenta as a user does.
        let mut seen: Vec<NodeId> = (0..3 * all).map(|variable| scope.graph.variable(variable)).collect();
        let rates = if is_backward { all..3 * all } else { 0..0 };
        let mirrored = text.mirrored().map(|a| 2 * all + a);
        for variable in rates.chain(mirrored) {
            seen[variable] = scope.graph.negate(seen[variable]);
        }
        this.watched = scope.graph.substitute(&this.watched, &seen);
        this.watched.extend(arguments);
        this.graph = scope.graph;
        Ok(this)
    }

    /// The positions that rates of what is watched depend on.
    fn places_of_rates(mut self) -> Result<Vec<usize>, GeometryError> {
        let inverse = Inverse::new(&mut self)?;
        let active = active_of(&mut self, &[]);
        let Expressions { velocities, .. } = Expressions::new(&mut self, &inverse, &active);
        let n = self.dimension();
        let rates = &velocities[n - self.watched.len()..];
        let depend: Vec<Vec<bool>> = rates.iter().map(|&rate| self.graph.variables_of(rate, n)).collect();
        Ok((0..n).filter(|&a| depend.iter().any(|of| of[a])).collect())
    }
}
