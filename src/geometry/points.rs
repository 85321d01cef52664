//! A geometry at points: momenta, velocities, K.

use super::Geometry;
use super::contraction::{Contraction, at_point, single};
use super::outside::OutsideGeometry;
use super::structure::{Dynamics, Samples};
use crate::number::Real;

impl<S: Real> Geometry<S> {
    /// p_a = g_ab q̇^b + A_a at a point.
    pub fn momenta(&self, q: &[S], q_dot: &[S]) -> Vec<S> {
        Dynamics::momenta(self, q, q_dot)
    }

    /// K = g_ab q̇^a q̇^b at a point.
    pub fn norm(&self, q: &[S], q_dot: &[S]) -> S {
        Dynamics::norm(self, q, q_dot)
    }

    /// What motion contributes to K at a point: the sizes of its terms without the largest of them.
    pub fn motion(&self, q: &[S], q_dot: &[S]) -> S {
        single(|motion| at_point(self.structure(), &self.at(q), q_dot).add_motion(motion))
    }

    /// q̇^a = g^ab (p_b − A_b) at a point.
    ///
    /// # Errors
    /// [`OutsideGeometry`] with `index` 0, where the point is outside the domain.
    pub fn velocities(&self, q: &[S], p: &[S]) -> Result<Vec<S>, OutsideGeometry> {
        let mut point = self.point();
        point.evaluate(q, p)?;
        Ok((0..self.dimension()).map(|a| point.q_dot(a)).collect())
    }

    /// All rows at one point, inside the domain or not.
    pub fn at(&self, q: &[S]) -> Samples<S> {
        self.sample_at(q)
    }

    /// K, and what motion contributes to it, at many points: rows of positions and of velocities, one for each
    /// coordinate.
    pub fn norm_and_motion(&self, q: &[&[S]], q_dot: &[&[S]]) -> [Vec<S>; 2] {
        let points = q[0].len();
        let mut samples = self.room(points);
        self.lagrangian.fill(q, &mut samples);
        let velocity = |b: usize| q_dot.get(b).copied();
        let contraction = Contraction { structure: self.structure(), samples: &samples, nodes: 0..points, velocity };
        let [mut norm, mut motion] = [(); 2].map(|()| vec![S::ZERO; points]);
        contraction.add_norm(&mut norm);
        contraction.add_motion(&mut motion);
        [norm, motion]
    }
}
