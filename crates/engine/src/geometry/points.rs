//! A geometry at points: momenta, velocities, K. What is long to compile has a door here.

use super::Geometry;
use super::contraction::{Contraction, at_point, single};
use super::observable::Observable;
use super::outside::OutsideGeometry;
use super::structure::{Lagrangian, Samples};
use super::text::{GeometryError, GeometryText, Place};
use crate::scalar::Real;

impl<S: Formulated> Geometry<S> {
    /// Compiles the formulas of `text`.
    ///
    /// # Errors
    /// [`GeometryError`] with the place of the mistake.
    pub fn new(text: &GeometryText) -> Result<Self, GeometryError> {
        S::geometry(text)
    }

    /// The same geometry, with the signs that the determinants have at `q` as the ones that they must have.
    ///
    /// # Errors
    /// [`OutsideGeometry`] if a determinant is zero or not finite there.
    pub fn around(self, q: &[S]) -> Result<Self, OutsideGeometry> {
        S::geometry_around(self, q)
    }

    /// p_a = g_ab q̇^b + A_a at a point.
    pub fn momenta(&self, q: &[S], q_dot: &[S]) -> Vec<S> {
        S::momenta(self, q, q_dot)
    }

    /// K = g_ab q̇^a q̇^b at a point.
    pub fn norm(&self, q: &[S], q_dot: &[S]) -> S {
        S::norm(self, q, q_dot)
    }

    /// What motion contributes to K at a point: the sizes of its terms without the largest of them.
    pub fn motion(&self, q: &[S], q_dot: &[S]) -> S {
        S::motion(self, q, q_dot)
    }

    /// q̇^a = g^ab (p_b − A_b) at a point.
    ///
    /// # Errors
    /// [`OutsideGeometry`] with `index` 0, where the point is outside the domain.
    pub fn velocities(&self, q: &[S], p: &[S]) -> Result<Vec<S>, OutsideGeometry> {
        S::velocities(self, q, p)
    }

    /// All rows at one point, inside the domain or not.
    pub fn at(&self, q: &[S]) -> Samples<S> {
        S::samples_at(self, q)
    }
}

impl<S: Real> Geometry<S> {
    /// [`Self::momenta`], for callers that are generic themselves.
    #[doc(hidden)]
    pub fn momenta_here(&self, q: &[S], q_dot: &[S]) -> Vec<S> {
        Lagrangian::momenta(self, q, q_dot)
    }

    /// [`Self::norm`], for callers that are generic themselves.
    #[doc(hidden)]
    pub fn norm_here(&self, q: &[S], q_dot: &[S]) -> S {
        Lagrangian::norm(self, q, q_dot)
    }

    fn motion_here(&self, q: &[S], q_dot: &[S]) -> S {
        single(|motion| at_point(&self.structure, &self.at_here(q), q_dot).add_motion(motion))
    }

    fn velocities_here(&self, q: &[S], p: &[S]) -> Result<Vec<S>, OutsideGeometry> {
        let mut rates = self.field.room();
        self.field.evaluate(q, p, &mut rates)?;
        Ok((0..self.dimension()).map(|a| self.field.q_dot(&rates, a)).collect())
    }

    /// [`Self::at`], for callers that are generic themselves.
    #[doc(hidden)]
    pub fn at_here(&self, q: &[S]) -> Samples<S> {
        let rows: Vec<&[S]> = q.iter().map(std::slice::from_ref).collect();
        let mut samples = self.room(1);
        self.compute(&rows, &mut samples);
        samples
    }

    /// K, and what motion contributes to it, at many points: rows of positions and of velocities, one for each
    /// coordinate.
    #[doc(hidden)]
    pub fn norm_and_motion_here(&self, q: &[&[S]], q_dot: &[&[S]]) -> [Vec<S>; 2] {
        let points = q[0].len();
        let mut samples = self.room(points);
        self.compute(q, &mut samples);
        let velocity = |b: usize| q_dot.get(b).copied();
        let contraction = Contraction { structure: &self.structure, samples: &samples, nodes: 0..points, velocity };
        let [mut norm, mut motion] = [(); 2].map(|()| vec![S::ZERO; points]);
        contraction.add_norm(&mut norm);
        contraction.add_motion(&mut motion);
        [norm, motion]
    }
}

crate::compiled! {
    /// Numbers in which scenes are formulated, and evaluated at points.
    pub trait Formulated {
        fn momenta(this: &Geometry<Self>, q: &[Self], q_dot: &[Self]) -> Vec<Self> = Geometry::momenta_here;
        fn norm(this: &Geometry<Self>, q: &[Self], q_dot: &[Self]) -> Self = Geometry::norm_here;
        fn motion(this: &Geometry<Self>, q: &[Self], q_dot: &[Self]) -> Self = Geometry::motion_here;
        fn velocities(
            this: &Geometry<Self>,
            q: &[Self],
            p: &[Self],
        ) -> Result<Vec<Self>, OutsideGeometry> = Geometry::velocities_here;
        fn samples_at(
            this: &Geometry<Self>,
            q: &[Self],
        ) -> Samples<Self> = Geometry::at_here;
        fn geometry(text: &GeometryText) -> Result<Geometry<Self>, GeometryError> = Geometry::new_here;
        fn geometry_around(
            this: Geometry<Self>,
            q: &[Self],
        ) -> Result<Geometry<Self>, OutsideGeometry> = Geometry::around_here;
        fn observable(
            text: &str,
            scene: &GeometryText,
            place: Place,
        ) -> Result<Observable<Self>, GeometryError> = Observable::new_here;
        fn value_of_observable(
            this: &mut Observable<Self>,
            q: &[Self],
            q_dot: &[Self],
            p: &[Self],
            norm: Self,
        ) -> Self = Observable::at_here;
    }
}
