//! A geometry at points: momenta, velocities, K.

use super::contraction::{Contraction, single};
use super::structure::Samples;
use super::{Geometry, OutsideGeometry};
use crate::number::Real;
use crate::number::norm::larger;

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
        single(|k| self.contraction(&self.values_at(&rows(q)), &rows(q_dot)).add_norm(k))
    }

    /// f_a + F_a = ½ ∂_a g_bc q̇^b q̇^c + ∂_a A_b q̇^b + F_a at a point, inside the domain or not.
    pub fn forces(&self, q: &[S], q_dot: &[S]) -> Vec<S> {
        self.rows_of_forces(&rows(q), &rows(q_dot)).concat()
    }

    /// The same at many points: rows of positions and of velocities, one for each coordinate.
    pub fn rows_of_forces(&self, q: &[&[S]], q_dot: &[&[S]]) -> Vec<Vec<S>> {
        let (structure, samples) = (self.structure(), self.first_at(q));
        let at = self.contraction(&samples, q_dot);
        let mut forces = vec![vec![S::ZERO; q[0].len()]; structure.dimension];
        forces.iter_mut().enumerate().for_each(|(a, row)| at.add_force(a, row));
        if !structure.force.is_empty() {
            let mut force = Samples::zeros(structure.force_rows, q[0].len());
            self.fill_force(q, q_dot, &mut force);
            for term in &structure.force {
                let row = forces[term.a].iter_mut().enumerate();
                row.for_each(|(k, sum)| *sum += force.at(term.value, k));
            }
        }
        forces
    }

    /// The contribution of motion to K at a point: the sizes of its terms without the largest of them.
    pub fn motion(&self, q: &[S], q_dot: &[S]) -> S {
        single(|motion| self.contraction(&self.values_at(&rows(q)), &rows(q_dot)).add_motion(motion))
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
        self.all_at(&rows(q))
    }

    /// K, and what motion contributes to it, at many points, given in the same way.
    pub fn norm_and_motion(&self, q: &[&[S]], q_dot: &[&[S]]) -> [Vec<S>; 2] {
        let samples = self.values_at(q);
        let contraction = self.contraction(&samples, q_dot);
        let [mut norm, mut motion] = [(); 2].map(|()| vec![S::ZERO; q[0].len()]);
        contraction.add_norm(&mut norm);
        contraction.add_motion(&mut motion);
        [norm, motion]
    }

    /// p_a at many points, given in the same way, a row for each coordinate.
    pub fn rows_of_momenta(&self, q: &[&[S]], q_dot: &[&[S]]) -> Vec<Vec<S>> {
        let samples = self.values_at(q);
        let contraction = self.contraction(&samples, q_dot);
        let mut momenta = vec![vec![S::ZERO; q[0].len()]; self.dimension()];
        momenta.iter_mut().enumerate().for_each(|(a, row)| contraction.add_momentum(a, row));
        momenta
    }

    /// g_aa at a point.
    pub(crate) fn diagonal(&self, q: &[S]) -> Vec<S> {
        self.diagonals(&rows(q)).into_iter().map(|row| row[0]).collect()
    }

    /// The same at many points, a row for each coordinate.
    pub(crate) fn diagonals(&self, q: &[&[S]]) -> Vec<Vec<S>> {
        let samples = self.values_at(q);
        let mut diagonals = vec![vec![S::ZERO; q[0].len()]; self.dimension()];
        for term in self.structure().values.iter().filter(|term| term.ab[0] == term.ab[1]) {
            diagonals[term.ab[0]].iter_mut().enumerate().for_each(|(k, g)| *g = samples.at(term.value, k));
        }
        diagonals
    }

    /// All rows at many points, inside the domain or not.
    pub(crate) fn all_at(&self, q: &[&[S]]) -> Samples<S> {
        self.at_rows(q, self.lagrangian.fields.outputs.len())
    }

    /// The rows of the metric and the one-form without derivatives at many points, inside the domain or not.
    pub(crate) fn values_at(&self, q: &[&[S]]) -> Samples<S> {
        self.at_rows(q, self.structure().rows_of_values)
    }

    /// The same with first derivatives.
    pub(crate) fn first_at(&self, q: &[&[S]]) -> Samples<S> {
        self.at_rows(q, self.structure().rows_of_first)
    }

    /// The first rows at many points.
    fn at_rows(&self, q: &[&[S]], rows: usize) -> Samples<S> {
        let mut samples = Samples::zeros(rows, q[0].len());
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

/// For every coordinate the largest of the sizes of all with the same g_aa, see [`Geometry::shared`].
pub(crate) fn shared<S: Real, T: Real>(diagonal: &[S], sizes: &[T]) -> Vec<T> {
    let largest = |g: &S| {
        let of_kind = diagonal.iter().zip(sizes).filter(|(other, _)| *other == g || std::ptr::eq(*other, g));
        of_kind.fold(T::ZERO, |most, (_, &size)| larger(most, size))
    };
    diagonal.iter().map(largest).collect()
}
