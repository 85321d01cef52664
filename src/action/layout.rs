//! The order of the unknowns of the doubled action: the rows of branch 1 by coordinate, those of branch 2, and the
//! multipliers. For t and x that is (t₁ | x₁ | t₂ | x₂ | λ1 … λ8). The weak form has no multipliers.

use std::ops::Range;

use super::Form;
use crate::number::Real;

/// Multipliers of the strong form for each coordinate: λ, μ, ν and κ.
pub const MULTIPLIERS_PER_COORDINATE: usize = 4;

/// Where each unknown of the doubled action is, for n coordinates on a grid of N nodes.
///
/// The multipliers are (λ_a, μ_a) for one coordinate a after the other, which fix the start, then all ν_a and then all
/// κ_a, which tie the ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Layout {
    /// Number of coordinates n.
    pub dimension: usize,
    points: usize,
    multipliers: usize,
}

impl Layout {
    /// The layout for `dimension` coordinates on `points` = N nodes.
    pub fn new(dimension: usize, points: usize, form: Form) -> Self {
        let multipliers = if form == Form::Strong { MULTIPLIERS_PER_COORDINATE * dimension } else { 0 };
        Self { dimension, points, multipliers }
    }

    /// Number of unknowns: 2nN + 4n, or 2nN in the weak form.
    pub fn unknowns(&self) -> usize {
        2 * self.dimension * self.points + self.multipliers
    }

    /// First index of coordinate `a` on the branch (0 forward, 1 backward).
    pub fn row(&self, branch: usize, a: usize) -> usize {
        (branch * self.dimension + a) * self.points
    }

    /// Indices of the multipliers (none in the weak form).
    pub fn multiplier_range(&self) -> Range<usize> {
        2 * self.dimension * self.points..self.unknowns()
    }

    /// Place of λ_a, which holds q^a at the start, among the multipliers.
    pub fn lambda(&self, a: usize) -> usize {
        2 * a
    }

    /// Place of μ_a, which holds dq^a/dγ at the start, among the multipliers.
    pub fn mu(&self, a: usize) -> usize {
        2 * a + 1
    }

    /// Place of ν_a, which ties the values at the end, among the multipliers.
    pub fn nu(&self, a: usize) -> usize {
        2 * self.dimension + a
    }

    /// Place of κ_a, which ties the derivatives at the end, among the multipliers.
    pub fn kappa(&self, a: usize) -> usize {
        3 * self.dimension + a
    }

    /// The node that an unknown belongs to. Multipliers that fix the start belong to the first node, and those that tie
    /// the ends to the last.
    pub fn node(&self, unknown: usize) -> usize {
        match unknown.checked_sub(self.multiplier_range().start) {
            None => unknown % self.points,
            Some(multiplier) if multiplier < 2 * self.dimension => 0,
            Some(_) => self.points - 1,
        }
    }

    /// Number of unknowns of Newton's system at equal branches: q^a on the nodes, by coordinate, and in the strong form
    /// ν and κ, nN + 2n in all. Its equations are those of q₁^a − q₂^a on the nodes, and those of λ and μ.
    pub fn equal_unknowns(&self) -> usize {
        self.unknowns() / 2
    }

    /// The entries of `gradient` that are equations of Newton's system at equal branches.
    pub fn equal_equations(&self, gradient: &[f64]) -> Vec<f64> {
        let (branch, border) = (self.row(1, 0), self.multiplier_range().start);
        let gaps = (0..branch).map(|i| 0.5 * (gradient[i] - gradient[branch + i]));
        gaps.chain(gradient[border..border + self.multipliers / 2].iter().copied()).collect()
    }

    /// Writes a step of the unknowns of Newton's system at equal branches as one of all unknowns.
    pub fn write_equal_step(&self, equal: &[f64], step: &mut [f64]) {
        let (branch, border) = (self.row(1, 0), self.multiplier_range().start);
        let (q, multipliers) = equal.split_at(branch);
        step[..branch].copy_from_slice(q);
        step[branch..border].copy_from_slice(q);
        step[border..].fill(0.0);
        step[border + self.multipliers / 2..].copy_from_slice(multipliers);
    }

    /// Coordinate `a` of a branch of `u` on the nodes.
    pub fn values<'u, S>(&self, u: &'u [S], branch: usize, a: usize) -> &'u [S] {
        &u[self.row(branch, a)..][..self.points]
    }

    /// Coordinate `a` of a branch of `u` on the nodes, to write.
    pub fn values_mut<'u, S>(&self, u: &'u mut [S], branch: usize, a: usize) -> &'u mut [S] {
        &mut u[self.row(branch, a)..][..self.points]
    }

    /// All coordinates of a branch of `u`.
    pub fn branch<'u, S>(&self, u: &'u [S], branch: usize) -> Vec<&'u [S]> {
        (0..self.dimension).map(|a| self.values(u, branch, a)).collect()
    }

    /// The multipliers of `u`.
    pub fn multipliers<'u, S>(&self, u: &'u [S]) -> &'u [S] {
        &u[self.multiplier_range()]
    }

    /// The multipliers of `u`, to write.
    pub fn multipliers_mut<'u, S>(&self, u: &'u mut [S]) -> &'u mut [S] {
        &mut u[self.multiplier_range()]
    }

    /// The signs with which the branches that `out` has room for enter the action.
    pub(super) fn signs<S: Real>(&self, out: &[S]) -> impl Iterator<Item = S> + use<S> {
        [S::ONE, -S::ONE].into_iter().take(out.len() / self.row(1, 0))
    }

    /// The parts of `u`.
    pub(super) fn split<'u, S>(&self, u: &'u [S]) -> Unknowns<'u, S> {
        Unknowns { branches: [0, 1].map(|branch| self.branch(u, branch)), multipliers: self.multipliers(u) }
    }

    /// The vector of unknowns in the physical limit, where both branches are equal to `q`, an array for each
    /// coordinate. In the weak form `multipliers` is empty.
    pub fn physical_limit<S: Copy>(&self, q: &[&[S]], multipliers: &[S]) -> Vec<S> {
        debug_assert_eq!((q.len(), multipliers.len()), (self.dimension, self.multipliers));
        let mut unknowns = Vec::with_capacity(self.unknowns());
        q.iter().chain(q).for_each(|row| unknowns.extend_from_slice(row));
        unknowns.extend_from_slice(multipliers);
        unknowns
    }
}

/// The unknowns, part by part.
pub(super) struct Unknowns<'u, S> {
    /// The rows of both branches, an array for each coordinate.
    pub(super) branches: [Vec<&'u [S]>; 2],
    /// Those of the strong form.
    pub(super) multipliers: &'u [S],
}
