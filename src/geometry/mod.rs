//! The geometry of a scene: n coordinates, any metric, one-form and force. This module knows no grid.
//!
//! ```text
//! L = ½ g_ab(q) q̇^a q̇^b + A_a(q) q̇^a,    p_a = g_ab q̇^b + A_a,    K = g_ab q̇^a q̇^b,    ˙ = d/dγ
//! q̇^a = g^ab (p_b − A_b),    ṗ_a = f_a + F_a,    f_a = ½ ∂_a g_bc q̇^b q̇^c + ∂_a A_b q̇^b
//! ```
//!
//! From the formulas come a `Lagrangian` for the action and a `Hamiltonian` for everything that moves.
//!
//! A coordinate is *ignorable* if nothing depends on it and no force acts on it; its momentum is a Noether charge. The
//! other coordinates are *active*. Which is which is found from the formulas, as is every derivative.
//!
//! ```
//! use geodesic_ivp::geometry::{Geometry, GeometryText};
//!
//! let text = GeometryText {
//!     coordinates: ["t", "r", "phi"].map(str::to_owned).to_vec(),
//!     components: vec![([0, 0], "f".into()), ([1, 1], "-1/f".into()), ([2, 2], "-r^2".into())],
//!     definitions: vec![("f".into(), "1 - 2/r".into())],
//!     ..GeometryText::default()
//! };
//! let geometry: Geometry = Geometry::new(&text)?;
//! assert_eq!(geometry.active(), [1]);
//! let p = geometry.momenta(&[0.0, 10.0, 0.0], &[1.2, -0.05, 0.03]);
//! assert!((p[0] - 0.96).abs() < 1e-15 && (p[1] - 0.0625).abs() < 1e-15 && (p[2] + 3.0).abs() < 1e-15);
//! # Ok::<(), geodesic_ivp::geometry::GeometryError>(())
//! ```

mod conserved;
mod contraction;
mod expressions;
mod hamiltonian;
mod inverse;
mod jets;
mod jumps;
mod kinks;
mod known;
mod lagrangian;
mod linear;
mod linearised;
mod motion;
mod observable;
mod parts;
mod points;
mod presets;
mod rates;
mod resets;
mod saltation;
mod structure;
mod text;
mod watched;
mod written;

pub use crate::formula::FormulaError;
pub use conserved::ConservedSum;
pub use contraction::Contraction;
pub(crate) use contraction::single;
pub(crate) use hamiltonian::Hamiltonian;
pub use hamiltonian::Point;
pub use inverse::MOST_COUPLED;
pub(crate) use jets::{Jet, Jets, OfEnds};
pub use jumps::{Jump, Steps};
pub use kinks::Side;
pub(crate) use kinks::{Arguments, arguments, may_jump};
pub(crate) use linear::{Degrees, StartTexts};
pub use motion::{Motion, OnNodes};
pub(crate) use observable::Shown;
pub use observable::{Direction, Observable, observed};
pub use parts::value_of;
pub(crate) use points::shared;
pub use presets::{PRESETS, Preset};
pub use rates::Rates;
pub(crate) use resets::{NewValue, Reset, Setting};
pub(crate) use saltation::Saltation;
pub(crate) use structure::other;
pub use structure::{ForceTerm, Samples, Source, Start, Structure, Term};
pub use text::{GeometryError, GeometryText, Law, Place, Potential, Tau};
pub(crate) use text::{uses, with_dependent};
pub use watched::Beside;
pub use written::{WrittenFormulas, WrittenRates};

use std::ops::Range;
use std::sync::Arc;

use self::inverse::Inverse;
use self::lagrangian::Lagrangian;
use self::parts::Parts;
use crate::formula::Names;
use crate::number::Real;
use crate::number::spline::Table;

/// The metric, the one-form and the force of a scene, with their derivatives, as programs.
#[derive(Debug, Clone)]
pub struct Geometry<S = f64> {
    names: Vec<String>,
    /// The coordinates that off-diagonal components couple, block by block.
    pub blocks: Vec<Vec<usize>>,
    /// The coordinates whose momenta have the other sign than in mechanics.
    mirrored: Range<usize>,
    tables: Vec<(String, Table)>,
    /// The signs that the determinants of the blocks must have, ±1, or 0 for either.
    pub(crate) signs: Vec<S>,
    /// c² of the paper's space-time diag(g00(x), −1) of t and x, in which a particle is where g00 > 0, wherever it
    /// starts.
    pub c_squared: Option<S>,
    pub(crate) lagrangian: Arc<Lagrangian<S>>,
    pub(crate) hamiltonian: Arc<Hamiltonian<S>>,
}

impl<S: Real> Geometry<S> {
    /// Compiles the formulas of `text`.
    ///
    /// # Errors
    /// [`GeometryError`] with the place of the mistake.
    pub fn new(text: &GeometryText) -> Result<Self, GeometryError> {
        Self::of_text(text, false)
    }

    /// The paper's space-time diag(g00(x), −1) of t and x. x is active without a force, too.
    ///
    /// # Errors
    /// [`GeometryError`] with the place of the mistake.
    ///
    /// # Panics
    /// Without a potential.
    pub fn of_x(text: &GeometryText) -> Result<Self, GeometryError> {
        let c = &text.potential.as_ref().expect("there is a potential").c;
        let c: S = parts::constant(c, &Names::new(), Place::SpeedOfLight)?;
        let geometry = Self::of_parts(Parts::new(text)?, &[1])?.seen_as(text);
        Ok(Self { signs: vec![S::ONE, -S::ONE], c_squared: Some(c * c), ..geometry })
    }

    /// The scene in which a world-line goes the way back: its velocities and momenta have the other sign.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn backward(text: &GeometryText) -> Result<Self, GeometryError> {
        Self::of_text(text, true)
    }

    /// The scene of `text`, on its way back if `is_backward`.
    fn of_text(text: &GeometryText, is_backward: bool) -> Result<Self, GeometryError> {
        let parts = Parts::new(text)?;
        let parts = if is_backward { parts.reversed() } else { parts };
        Self::of_parts(parts, &[]).map(|geometry| geometry.seen_as(text))
    }

    /// The coordinates that are active in any case are `kept`.
    fn of_parts(mut parts: Parts<S>, kept: &[usize]) -> Result<Self, GeometryError> {
        let inverse = Inverse::new(&mut parts)?;
        let (names, graph) = (parts.names.clone(), parts.graph.clone());
        let active = active_of(&mut parts, kept);
        let lagrangian = Arc::new(Lagrangian::new(&mut parts, &inverse, &active));
        // Hamilton's equations need no second derivatives, and find their way faster in a small graph.
        parts.graph = graph;
        let hamiltonian = Arc::new(Hamiltonian::new(parts, &inverse, active));
        let blocks: Vec<_> = inverse.blocks.into_iter().map(|block| block.coordinates).collect();
        let signs = vec![S::ZERO; blocks.len()];
        Ok(Self { names, signs, c_squared: None, blocks, mirrored: 0..0, tables: Vec::new(), lagrangian, hamiltonian })
    }

    /// The same geometry, whose momenta and tables are seen as those of this text.
    fn seen_as(self, text: &GeometryText) -> Self {
        Self { mirrored: text.mirrored(), tables: text.tables.clone(), ..self }
    }

    /// The table that has no value at `q`, if there is one. Arguments that depend on velocities are not looked at.
    pub fn off_table(&self, q: &[S]) -> Option<OffTable> {
        let mut point = self.point();
        let _ = point.evaluate(q, &vec![S::from(f64::NAN); q.len()]);
        self.hamiltonian.program.arguments_of_tables().find_map(|(register, table)| {
            let argument = point.registers[register][0];
            let is_off = !argument.is_nan() && table.piece(argument).is_none();
            let (name, _) = self.tables.iter().find(|(_, other)| is_off && table.is_of(*other))?;
            Some(OffTable { name: name.clone(), ends: table.ends(), argument: argument.to_f64() })
        })
    }

    /// The number of coordinates that are results: s, which Newton's law adds to have a geodesic, comes last and is
    /// none.
    pub fn results(&self) -> usize {
        self.dimension() - usize::from(!self.mirrored.is_empty())
    }

    /// The momentum of a coordinate as a user sees it, from that of the geometry, or back. With Newton's law it is that
    /// of mechanics, m dx/dγ + A; the geometry has g_aa = −m. All that a user reads or writes passes here.
    pub fn seen(&self, a: usize, p: S) -> S {
        if self.mirrored.contains(&a) { -p } else { p }
    }

    /// The same geometry, with the signs that the determinants have at `q` as the ones that they must have.
    ///
    /// # Errors
    /// [`OutsideGeometry`] if a determinant is zero or not finite there.
    pub fn with_domain_of(mut self, q: &[S]) -> Result<Self, OutsideGeometry> {
        if self.c_squared.is_none() {
            self.signs.fill(S::ZERO);
        }
        let mut samples = self.room(1);
        self.fill(&points::rows(q), &mut samples)?;
        self.signs = self.lagrangian.determinants(&samples).map(|row| row[0].signum()).collect();
        Ok(self)
    }

    /// Hamilton's equations at one point.
    pub fn point(&self) -> Point<S> {
        Point::new(&self.hamiltonian, &self.signs)
    }

    /// g00 at a point, if this is the paper's space-time diag(g00(x), −1) of t and x.
    pub fn g00(&self, q: &[S]) -> Option<S> {
        self.c_squared.map(|_| self.diagonal(q)[0])
    }

    /// Where g00, g00′ and g00″ of that space-time stand among the rows of [`Self::fill`].
    pub(crate) fn sources_of_g00(&self) -> [Source<S>; 3] {
        fn of_t<S: Real, const ORDER: usize>(terms: &[Term<S, ORDER>]) -> Source<S> {
            terms.iter().find(|term| term.ab == [0, 0]).map_or(Source::Constant(S::ZERO), |term| term.value)
        }
        let Structure { values, first, second, .. } = self.structure();
        [of_t(values), of_t(first), of_t(second)]
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
        &self.hamiltonian.active
    }

    /// The ignorable coordinates, in order.
    pub fn ignorable(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.dimension()).filter(|a| !self.active().contains(a))
    }

    /// Returns true if the equations of motion are q̈ = a(q): the active part of g^ab is constant and coupled to
    /// nothing else, the one-form has no active part, and no force acts.
    pub fn is_separable(&self) -> bool {
        self.separable().is_some()
    }

    /// The active part of g^ab, row by row, if the equations of motion are q̈ = a(q).
    pub(crate) fn separable(&self) -> Option<&[S]> {
        self.hamiltonian.inverse.as_deref()
    }

    /// Returns true if an active coordinate goes as it does in every motion, as t does under Newton's law.
    pub(crate) fn is_clock(&self, place: usize) -> bool {
        !self.is_separable() && self.hamiltonian.linearised().entries.iter().all(|entry| entry.row != place)
    }

    /// Returns true if a coordinate moves at a velocity that no active coordinate or momentum changes.
    pub(crate) fn is_steady(&self, a: usize) -> bool {
        self.hamiltonian.is_steady(a)
    }

    /// The function by which the equations of motion jump where motions pass that differ in more than time, if there is
    /// one. Linearised equations see nothing of it.
    pub fn jump(&self) -> Option<&'static str> {
        self.hamiltonian.jump(|place| self.is_clock(place))
    }

    /// Returns true if the equations of motion jump somewhere, be it at a time.
    pub(crate) fn has_jumps(&self) -> bool {
        self.hamiltonian.jump(|_| false).is_some()
    }

    /// Returns true if a force may grow like a power below 1, see [`Self::jump`] for what jumps.
    pub(crate) fn may_grow_like_a_root(&self) -> bool {
        self.hamiltonian.may_grow_like_a_root()
    }

    /// Returns true if a component, the one-form or the force depends on the position in this coordinate.
    pub fn depends_on(&self, a: usize) -> bool {
        let Structure { first, force_first, .. } = self.structure();
        first.iter().any(|term| term.by == [a]) || force_first.iter().any(|term| term.by == [a])
    }

    /// Returns true if K is kept: no force acts, or one in a potential, which brings its work as a force on t.
    pub fn keeps_norm(&self) -> bool {
        !self.has_force() || !self.structure().particles.is_empty()
    }

    /// Returns true if a force acts.
    pub fn has_force(&self) -> bool {
        !self.structure().force.is_empty()
    }

    /// The determinants of the blocks at a point.
    pub(crate) fn determinants(&self, q: &[S]) -> Vec<S> {
        self.lagrangian.determinants(&self.at(q)).map(|row| row[0]).collect()
    }

    /// For every coordinate the largest of the sizes of all with the same g_aa at a point. They have one unit, so that
    /// sizes are shared: of x and y one may be zero but for rounding.
    pub(crate) fn shared<T: Real>(&self, q: &[S], sizes: &[T]) -> Vec<T> {
        shared(&self.diagonal(q), sizes)
    }

    /// The structure lists what is not zero in the Lagrangian and the force.
    pub fn structure(&self) -> &Structure<S> {
        &self.lagrangian.structure
    }

    /// Room for [`Self::fill`] on so many nodes.
    pub fn room(&self, points: usize) -> Samples<S> {
        Samples::zeros(self.lagrangian.fields.outputs.len(), points)
    }

    /// Fills in the rows of the metric and the one-form at the positions `q`, one row of nodes for each coordinate.
    ///
    /// # Errors
    /// The first node that lies outside the domain.
    pub fn fill(&self, q: &[&[S]], samples: &mut Samples<S>) -> Result<(), OutsideGeometry> {
        self.lagrangian.fill(q, samples);
        let outside = |index: usize, block: Option<usize>, determinant: f64| {
            let position = self.active().first().map_or(f64::NAN, |&a| q[a][index].to_f64());
            Err(OutsideGeometry { index, block, determinant, position })
        };
        for (block, (row, &sign)) in self.lagrangian.determinants(samples).zip(&self.signs).enumerate() {
            if let Some(index) = row.iter().position(|&determinant| is_outside(determinant, sign)) {
                return outside(index, Some(block), row[index].to_f64());
            }
        }
        for row in 0..self.structure().rows {
            if let Some(index) = samples.row(row).iter().position(|value| !value.is_finite()) {
                return outside(index, None, f64::NAN);
            }
        }
        Ok(())
    }

    /// Fills in the rows of the force at positions and velocities.
    pub fn fill_force(&self, q: &[&[S]], q_dot: &[&[S]], samples: &mut Samples<S>) {
        self.lagrangian.force.sample(&[q, q_dot].concat(), &mut samples.rows_mut().collect::<Vec<_>>());
    }
}

/// A table whose argument lies outside of what it knows.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("the table '{name}' goes from {} to {}, and its argument is {argument}", .ends[0], .ends[1])]
pub struct OffTable {
    /// Its name.
    pub name: String,
    /// Its first argument and its last one.
    pub ends: [f64; 2],
    /// The argument.
    pub argument: f64,
}

/// A block of the metric has a determinant of the wrong sign, or a number is not finite.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("the point lies outside the domain of the metric")]
pub struct OutsideGeometry {
    /// Index of the node.
    pub index: usize,
    /// The block of the metric, see [`Geometry::blocks`]; `None` where another number is not finite.
    pub block: Option<usize>,
    /// Its determinant there.
    pub determinant: f64,
    /// The first active coordinate there.
    pub position: f64,
}

/// Returns true if a determinant that should have the given sign (0: any) says that a point is outside.
fn is_outside<S: Real>(determinant: S, sign: S) -> bool {
    !determinant.is_finite() || determinant == S::ZERO || determinant * sign < S::ZERO
}

/// The coordinates that a component, the one-form or the force depends on, or that a force acts on, and those that are
/// `kept`.
fn active_of<S: Real>(parts: &mut Parts<S>, kept: &[usize]) -> Vec<usize> {
    let n = parts.dimension();
    let mut is_active = vec![false; n];
    parts.force.keys().chain(kept).for_each(|&a| is_active[a] = true);
    let components = parts.components();
    for (a, is_active) in is_active.iter_mut().enumerate() {
        *is_active |= components.iter().any(|&(_, node)| {
            let derivative = parts.graph.derivative(node, a);
            !parts.graph.is(derivative, 0.0)
        });
        *is_active |= parts.force.values().any(|&node| parts.graph.variables_of(node, n)[a]);
    }
    (0..n).filter(|&a| is_active[a]).collect()
}
