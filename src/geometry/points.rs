//! A geometry at points: momenta, velocities, K.

use super::contraction::{Contraction, single};
use super::structure::Samples;
use super::{Geometry, OutsideGeometry};
use crate::number::Real;

/// A point as rows of one node.
pub(super) fn rows<S>(values: &[S]) -> Vec<&[S]> {
    values.iter().map(std::slice::from_ref).collect()
}

impl<S: Real> Geometry<S> {
    /// p_a = g_ab q̇^b + A_a at a point, inside the domain or not.
    pub fn momenta(&self, q: &[S], q_dot: &[S]) -> Vec<S> {
        self.rows_of_momenta(&rows(q), &rows(q_dot)).concat()
    }

    /// K = g_ab q̇^a q̇^b at a point, inside the domain or not.
    pub fn norm(&self, q: &[S], q_dot: &[S]) -> S {
        single(|k| self.contraction(&self.at(q), &rows(q_dot)).add_norm(k))
    }

    /// f_a + F_a = ½ ∂_a g_bc q̇^b q̇^c + ∂_a A_b q̇^b + F_a at a point, inside the domain or not.
    pub fn forces(&self, q: &[S], q_dot: &[S]) -> Vec<S> {
        let (structure, samples, q_dot) = (self.structure(), self.at(q), rows(q_dot));
        let at = self.contraction(&samples, &q_dot);
        let mut forces: Vec<S> = (0..structure.dimension).map(|a| single(|f| at.add_force(a, f))).collect();
        if !structure.force.is_empty() {
            let mut force = Samples::zeros(structure.force_rows, 1);
            self.fill_force(&rows(q), &q_dot, &mut force);
            for term in &structure.force {
                forces[term.a] += force.at(term.value, 0);
            }
        }
        forces
    }

    /// The contribution of motion to K at a point: the sizes of its terms without the largest of them.
    pub fn motion(&self, q: &[S], q_dot: &[S]) -> S {
        single(|motion| self.contraction(&self.at(q), &rows(q_dot)).add_motion(motion))
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
        self.at_rows(&rows(q))
    }

    /// K, and what motion contributes to it, at many points: rows of positions and of velocities, one for each
    /// coordinate.
    pub fn norm_and_motion(&self, q: &[&[S]], q_dot: &[&[S]]) -> [Vec<S>; 2] {
        let samples = self.at_rows(q);
        let contraction = self.contraction(&samples, q_dot);
        let [mut norm, mut motion] = [(); 2].map(|()| vec![S::ZERO; q[0].len()]);
        contraction.add_norm(&mut norm);
        contraction.add_motion(&mut motion);
        [norm, motion]
    }

    /// p_a at many points, given in the same way, a row for each coordinate.
    pub fn rows_of_momenta(&self, q: &[&[S]], q_dot: &[&[S]]) -> Vec<Vec<S>> {
        let samples = self.at_rows(q);
        let contraction = self.contraction(&samples, q_dot);
        let mut momenta = vec![vec![S::ZERO; q[0].len()]; self.dimension()];
        momenta.iter_mut().enumerate().for_each(|(a, row)| contraction.add_momentum(a, row));
        momenta
    }

    fn at_rows(&self, q: &[&[S]]) -> Samples<S> {
        let mut samples = self.room(q[0].len());
        self.lagrangian.fill(q, &mut samples);
        samples
    }

    fn contraction<'c>(
        &'c self,
        samples: &'c Samples<S>,
        q_dot: &'c [&'c [S]],
    ) -> Contraction<'c, S, impl Fn(usize) -> Option<&'c [S]>> {
        let velocity = |b: usize| q_dot.get(b).copied();
        Contraction { structure: self.structure(), samples, nodes: 0..q_dot[0].len(), velocity }
    }
}
