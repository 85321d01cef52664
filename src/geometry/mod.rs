//! The geometry of a scene: n coordinates, any metric, one-form and force. This module knows no grid.
//!
//! ```text
//! L = ½ g_ab(q) q̇^a q̇^b + A_a(q) q̇^a,    p_a = g_ab q̇^b + A_a,    K = g_ab q̇^a q̇^b,    ˙ = d/dγ
//! q̇^a = g^ab (p_b − A_b),    ṗ_a = f_a + F_a,    f_a = ½ ∂_a g_bc q̇^b q̇^c + ∂_a A_b q̇^b
//! ```
//!
//! A coordinate is *ignorable* if nothing depends on it and no force acts on it; its momentum is a Noether charge. The
//! other coordinates are *active*. Which is which is found from the formulas, as is every derivative.
//!
//! ```
//! use geodesic_ivp::geometry::{Geometry, GeometryText, MetricText};
//!
//! let text = MetricText {
//!     coordinates: ["t", "r", "phi"].map(str::to_owned).to_vec(),
//!     components: vec![([0, 0], "f".into()), ([1, 1], "-1/f".into()), ([2, 2], "-r^2".into())],
//!     definitions: vec![("f".into(), "1 - 2/r".into())],
//!     ..MetricText::default()
//! };
//! let geometry: Geometry = Geometry::new(&GeometryText::Metric(text))?;
//! assert_eq!(geometry.active(), [1]);
//! let p = geometry.momenta(&[0.0, 10.0, 0.0], &[1.2, -0.05, 0.03]);
//! assert!((p[0] - 0.96).abs() < 1e-15 && (p[1] - 0.0625).abs() < 1e-15 && (p[2] + 3.0).abs() < 1e-15);
//! # Ok::<(), geodesic_ivp::geometry::GeometryError>(())
//! ```

mod conserved;
mod contraction;
mod direction;
mod field;
pub mod geodesic;
mod inverse;
mod linearised;
pub mod metric;
mod motion;
mod observable;
mod outside;
mod parts;
mod points;
pub mod potential;
mod presets;
mod rows;
mod structure;
mod text;
mod value;

pub use conserved::ConservedSum;
pub use contraction::Contraction;
pub(crate) use contraction::single;
pub use direction::Direction;
pub use field::{Field, Rates};
pub use inverse::MOST_COUPLED;
pub(crate) use linearised::Equations as LinearisedEquations;
pub use motion::{Motion, MotionRoom};
pub use observable::{Observable, observed};
pub use outside::OutsideGeometry;
pub use presets::{PRESETS, Preset};
pub(crate) use rows::RowPrograms;
pub(crate) use structure::other;
pub use structure::{Dynamics, ForceTerm, Samples, Source, Start, Structure, Term};
pub use text::{GeometryError, GeometryText, Law, MetricText, Place, PotentialText, Tau};
pub use value::value_of;

use self::inverse::Inverse;
use self::parts::Parts;
use crate::formula::{Graph, NodeId, Program};
use crate::number::Real;

/// The metric, the one-form and the force of a scene, with their derivatives, as programs.
#[derive(Debug, Clone)]
pub struct Geometry<S = f64> {
    names: Vec<String>,
    structure: Structure<S>,
    /// Rows of the metric and the one-form in the order of [`Structure`], then the determinants of the blocks.
    lagrangian: Program<S>,
    /// Rows of the force, in 2n variables.
    force: Program<S>,
    field: Field<S>,
    active: Vec<usize>,
    /// The active part of g^ab, row by row, if it is constant and coupled to nothing else.
    separable: Option<Vec<S>>,
    /// The coordinates of every block, and the sign that its determinant has.
    blocks: Vec<Vec<usize>>,
    signs: Vec<S>,
}

impl<S: Real> Geometry<S> {
    /// Compiles the formulas of `text`.
    ///
    /// # Errors
    /// [`GeometryError`] with the place of the mistake.
    pub fn new(text: &GeometryText) -> Result<Self, GeometryError> {
        let mut parts: Parts<S> = Parts::new(text)?;
        let inverse = Inverse::new(&mut parts)?;
        let n = parts.dimension();
        // The field needs no second derivatives, and finds its way faster in a small graph.
        let graph = parts.graph.clone();
        let (structure, mut rows) = structure_of(&mut parts);
        rows.extend(inverse.blocks.iter().map(|block| block.determinant));
        let lagrangian = Program::new(&mut parts.graph, n, &rows);
        let (mut structure, force) = force_structure_of(&mut parts, structure);
        structure.inertias = inertias(&parts, text);
        let force = Program::new(&mut parts.graph, 2 * n, &force);
        let active = active_of(&mut parts);
        parts.graph = graph;
        let separable = separable(&parts, &inverse, &active);
        let field = Field::new(&mut parts, &inverse, &active, separable.as_deref());
        let blocks: Vec<_> = inverse.blocks.iter().map(|block| block.coordinates.clone()).collect();
        let signs = vec![S::ZERO; blocks.len()];
        Ok(Self { names: parts.names, structure, lagrangian, force, field, active, separable, blocks, signs })
    }

    /// The same geometry, with the signs that the determinants have at `q` as the ones that they must have.
    ///
    /// # Errors
    /// [`OutsideGeometry`] if a determinant is zero or not finite there.
    pub fn around(mut self, q: &[S]) -> Result<Self, OutsideGeometry> {
        self.signs.fill(S::ZERO);
        let rows: Vec<&[S]> = q.iter().map(std::slice::from_ref).collect();
        let mut samples = self.room(1);
        self.fill(&rows, &mut samples)?;
        for (block, sign) in self.signs.iter_mut().enumerate() {
            *sign = samples.row(self.structure.rows + block)[0].signum();
        }
        self.field.set_signs(&self.signs);
        Ok(self)
    }

    /// Number of coordinates n.
    pub fn dimension(&self) -> usize {
        self.names.len()
    }

    /// The names of the coordinates.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The coordinates that are not ignorable, in order.
    pub fn active(&self) -> &[usize] {
        &self.active
    }

    /// The ignorable coordinates, in order.
    pub fn ignorable(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.dimension()).filter(|a| !self.active.contains(a))
    }

    /// Whether the equations of motion are q̈ = a(q): the active part of g^ab is constant and coupled to nothing else,
    /// the one-form has no active part, and no force acts.
    pub fn is_separable(&self) -> bool {
        self.separable.is_some()
    }

    /// The active part of g^ab, row by row, if the equations of motion are q̈ = a(q).
    pub(crate) fn separable(&self) -> Option<&[S]> {
        self.separable.as_deref()
    }

    /// Whether a component, the one-form or the force depends on the position in this coordinate.
    pub fn depends_on(&self, a: usize) -> bool {
        self.structure.first.iter().any(|term| term.by == [a])
            || self.structure.force_first.iter().any(|term| term.by == [a])
    }

    /// The coordinates that off-diagonal components couple, block by block.
    pub fn blocks(&self) -> &[Vec<usize>] {
        &self.blocks
    }

    /// Hamilton's equations.
    pub fn field(&self) -> &Field<S> {
        &self.field
    }

    /// Whether a force acts.
    pub fn has_force(&self) -> bool {
        !self.structure.force.is_empty()
    }

    /// The determinants of the blocks at a point.
    pub(crate) fn determinants(&self, q: &[S]) -> Vec<S> {
        let samples = self.at(q);
        (0..self.blocks.len()).map(|block| samples.row(self.structure.rows + block)[0]).collect()
    }

    /// g_aa at a point.
    pub(crate) fn diagonal(&self, q: &[S]) -> Vec<S> {
        let samples = self.at(q);
        let mut diagonal = vec![S::ZERO; self.dimension()];
        for term in self.structure.values.iter().filter(|term| term.ab[0] == term.ab[1]) {
            diagonal[term.ab[0]] = samples.at(term.value, 0);
        }
        diagonal
    }

    /// For each coordinate the first with the same g_aa at a point. They have one unit, so that sizes are shared: of x
    /// and y one may be zero but for rounding.
    pub(crate) fn alike(&self, q: &[S]) -> Vec<usize> {
        let diagonal = self.diagonal(q);
        (0..diagonal.len()).map(|a| diagonal.iter().position(|g| *g == diagonal[a]).unwrap_or(a)).collect()
    }

    /// The largest of the sizes of all coordinates that are alike, for every coordinate; see [`Self::alike`].
    pub(crate) fn shared<T: Real>(&self, q: &[S], sizes: &[T]) -> Vec<T> {
        let alike = self.alike(q);
        let largest = |kind: usize| {
            let of_kind = alike.iter().zip(sizes).filter(|(other, _)| **other == kind);
            of_kind.fold(T::ZERO, |largest, (_, &size)| largest.max(size))
        };
        alike.iter().map(|&kind| largest(kind)).collect()
    }

    fn compute(&self, q: &[&[S]], samples: &mut Samples<S>) {
        let mut rows: Vec<&mut [S]> = samples.rows_mut().collect();
        self.lagrangian.sample(q, &mut rows);
    }
}

impl<S: Real> Dynamics<S> for Geometry<S> {
    type Outside = OutsideGeometry;

    fn structure(&self) -> &Structure<S> {
        &self.structure
    }

    fn room(&self, points: usize) -> Samples<S> {
        Samples::zeros(self.structure.rows + self.blocks.len(), points)
    }

    fn fill(&self, q: &[&[S]], samples: &mut Samples<S>) -> Result<(), OutsideGeometry> {
        self.compute(q, samples);
        let rows = self.structure.rows;
        let determinants = (0..self.blocks.len()).map(|block| samples.row(rows + block));
        for (block, (row, &sign)) in determinants.zip(&self.signs).enumerate() {
            if let Some(index) = row.iter().position(|&determinant| is_outside(determinant, sign)) {
                let determinant = row[index].to_f64();
                return Err(OutsideGeometry { index, block: Some(block), determinant });
            }
        }
        for row in 0..rows {
            if let Some(index) = samples.row(row).iter().position(|value| !value.is_finite()) {
                return Err(OutsideGeometry { index, block: None, determinant: f64::NAN });
            }
        }
        Ok(())
    }

    fn raise(&self, q: &[S], v: &[S], weight: S) -> Vec<S> {
        let n = self.dimension();
        let at_rest = self.momenta(q, &vec![S::ZERO; n]);
        let p: Vec<S> = v.iter().zip(&at_rest).map(|(&v, &one_form)| v / weight + one_form).collect();
        let mut rates = self.field.room();
        // Outside the domain the numbers are of no use, and whoever asks finds that out from the position.
        let _ = self.field.evaluate(q, &p, &mut rates);
        (0..n).map(|a| self.field.q_dot(&rates, a)).collect()
    }

    fn fill_force(&self, q: &[&[S]], q_dot: &[&[S]], samples: &mut Samples<S>) {
        let variables: Vec<&[S]> = q.iter().chain(q_dot).copied().collect();
        let mut rows: Vec<&mut [S]> = samples.rows_mut().collect();
        self.force.sample(&variables, &mut rows);
    }
}

/// Whether a determinant that should have the given sign (0: any) says that a point is outside.
fn is_outside<S: Real>(determinant: S, sign: S) -> bool {
    !determinant.is_finite() || determinant == S::ZERO || determinant * sign < S::ZERO
}

/// Appends the expression to the rows, or takes it as the constant that it is; `None` if it is zero.
fn source<S: Real>(graph: &Graph<S>, node: NodeId, rows: &mut Vec<NodeId>) -> Option<Source<S>> {
    match graph.as_constant(node) {
        Some(value) if value == S::ZERO => None,
        Some(value) => Some(Source::Constant(value)),
        None => {
            rows.push(node);
            Some(Source::Row(rows.len() - 1))
        }
    }
}

/// The structure of metric and one-form, with the expressions of its rows.
fn structure_of<S: Real>(parts: &mut Parts<S>) -> (Structure<S>, Vec<NodeId>) {
    let n = parts.dimension();
    let components: Vec<([usize; 2], NodeId)> = (parts.metric.iter().map(|(&ab, &node)| (ab, node)))
        .chain(parts.one_form.iter().map(|(&a, &node)| ([a, n], node)))
        .collect();
    let mut structure = Structure { dimension: n, has_one_form: !parts.one_form.is_empty(), ..Structure::default() };
    let mut rows = Vec::new();
    for &(ab, node) in &components {
        structure.values.extend(source(&parts.graph, node, &mut rows).map(|value| Term { ab, by: [], value }));
    }
    for &(ab, node) in &components {
        for c in 0..n {
            let node = parts.graph.derivative(node, c);
            structure.first.extend(source(&parts.graph, node, &mut rows).map(|value| Term { ab, by: [c], value }));
        }
    }
    for &(ab, node) in &components {
        for c in 0..n {
            for d in c..n {
                let first = parts.graph.derivative(node, c);
                let node = parts.graph.derivative(first, d);
                structure.second.extend(source(&parts.graph, node, &mut rows).map(|value| Term {
                    ab,
                    by: [c, d],
                    value,
                }));
            }
        }
    }
    structure.rows = rows.len();
    (structure, rows)
}

/// The structure with that of the force, and the expressions of its rows.
fn force_structure_of<S: Real>(parts: &mut Parts<S>, structure: Structure<S>) -> (Structure<S>, Vec<NodeId>) {
    let variables = 2 * parts.dimension();
    let components: Vec<(usize, NodeId)> = parts.force.iter().map(|(&a, &node)| (a, node)).collect();
    let (mut structure, mut rows) = (structure, Vec::new());
    for &(a, node) in &components {
        structure.force.extend(source(&parts.graph, node, &mut rows).map(|value| ForceTerm { a, by: [], value }));
        for v in 0..variables {
            let first = parts.graph.derivative(node, v);
            structure.force_first.extend(source(&parts.graph, first, &mut rows).map(|value| ForceTerm {
                a,
                by: [v],
                value,
            }));
        }
    }
    structure.force_rows = rows.len();
    (structure, rows)
}

/// The coordinates of a potential with their g_aa, where those are constant.
fn inertias<S: Real>(parts: &Parts<S>, text: &GeometryText) -> Vec<(usize, S)> {
    let GeometryText::Potential(PotentialText { coordinates, .. }) = text else { return Vec::new() };
    let inertia = |a: usize| Some((a, parts.graph.as_constant(*parts.metric.get(&[a, a])?)?));
    // The first coordinate is t.
    (1..=coordinates.len()).filter_map(inertia).collect()
}

/// The active part of g^ab, if the equations of motion are q̈ = a(q).
fn separable<S: Real>(parts: &Parts<S>, inverse: &Inverse, active: &[usize]) -> Option<Vec<S>> {
    let n = parts.dimension();
    let is_coupled = |a: usize| (0..n).any(|b| !active.contains(&b) && inverse.get(a, b).is_some());
    let has_one_form = |a: usize| parts.one_form.contains_key(&a);
    if !parts.force.is_empty() || active.iter().any(|&a| is_coupled(a) || has_one_form(a)) {
        return None;
    }
    let entry = |a: usize, b: usize| inverse.get(a, b).map_or(Some(S::ZERO), |node| parts.graph.as_constant(node));
    active.iter().flat_map(|&a| active.iter().map(move |&b| (a, b))).map(|(a, b)| entry(a, b)).collect()
}

/// The coordinates that a component, the one-form or the force depends on, or that a force acts on.
fn active_of<S: Real>(parts: &mut Parts<S>) -> Vec<usize> {
    let n = parts.dimension();
    let mut is_active = vec![false; n];
    parts.force.keys().for_each(|&a| is_active[a] = true);
    let nodes: Vec<NodeId> = parts.metric.values().chain(parts.one_form.values()).copied().collect();
    for (a, is_active) in is_active.iter_mut().enumerate() {
        *is_active |= nodes.iter().any(|&node| {
            let derivative = parts.graph.derivative(node, a);
            !parts.graph.is(derivative, 0.0)
        });
        *is_active |= parts.force.values().any(|&node| parts.graph.variables_of(node, n)[a]);
    }
    (0..n).filter(|&a| is_active[a]).collect()
}
