//! A geometry at points: momenta, velocities, K.

use super::Geometry;
use super::contraction::{Contraction, at_point, single};
use super::outside::OutsideGeometry;
use super::structure::Samples;
use crate::number::Real;

impl<S: Real> Geometry<S> {
    /// p_a = g_ab q̇^b + A_a at a point, inside the domain or not.
    pub fn momenta(&self, q: &[S], q_dot: &[S]) -> Vec<S> {
        let samples = self.at(q);
        let at = at_point(self.structure(), &samples, q_dot);
        (0..self.dimension()).map(|a| single(|p| at.add_momentum(a, p))).collect()
    }

    /// K = g_ab q̇^a q̇^b at a point, inside the domain or not.
    pub fn norm(&self, q: &[S], q_dot: &[S]) -> S {
        single(|k| at_point(self.structure(), &self.at(q), q_dot).add_norm(k))
    }

    /// f_a + F_a = ½ ∂_a g_bc q̇^b q̇^c + ∂_a A_b q̇^b + F_a at a point, inside the domain or not.
    pub fn forces(&self, q: &[S], q_dot: &[S]) -> Vec<S> {
        let (structure, samples) = (self.structure(), self.at(q));
        let at = at_point(structure, &samples, q_dot);
        let mut forces: Vec<S> = (0..structure.dimension).map(|a| single(|f| at.add_force(a, f))).collect();
        if !structure.force.is_empty() {
            let [q, q_dot] = [q, q_dot].map(|row| row.iter().map(std::slice::from_ref).collect::<Vec<_>>());
            let mut force = Samples::zeros(structure.force_rows, 1);
            self.fill_force(&q, &q_dot, &mut force);
            for term in &structure.force {
                forces[term.a] += force.at(term.value, 0);
            }
        }
        forces
    }

    /// The contribution of motion to K at a point: the sizes of its terms without the largest of them.
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
        let rows: Vec<&[S]> = q.iter().map(std::slice::from_ref).collect();
        let mut samples = self.room(1);
        // Outside the domain the rows are filled in as well.
        let _ = self.fill(&rows, &mut samples);
        samples
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
        let row = |a: usize| {
            let mut row = vec![S::ZERO; q[0].len()];
            contraction.add_momentum(a, &mut row);
            row
        };
        (0..self.dimension()).map(row).collect()
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
