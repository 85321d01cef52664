//! The order of the unknowns of the doubled action: (t₁ | x₁ | t₂ | x₂ | λ1 … λ8), each block contiguous. The weak form
//! has no λ.

use std::ops::Range;

use super::Form;

/// Number of Lagrange multipliers of the strong form.
pub const MULTIPLIERS: usize = 8;

/// Where each unknown of the doubled action is, on a grid of N nodes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Layout {
    points: usize,
    multipliers: usize,
}

/// One branch, to read.
#[derive(Debug, Clone, Copy)]
pub struct Branch<'u, S = f64> {
    /// t on the nodes.
    pub t: &'u [S],
    /// x on the nodes.
    pub x: &'u [S],
}

/// One branch, to write.
#[derive(Debug)]
pub struct BranchMut<'u, S = f64> {
    /// t on the nodes.
    pub t: &'u mut [S],
    /// x on the nodes.
    pub x: &'u mut [S],
}

impl Layout {
    /// The layout for `points` = N nodes.
    pub fn new(points: usize, form: Form) -> Self {
        let multipliers = match form {
            Form::Strong => MULTIPLIERS,
            Form::Weak => 0,
        };
        Self { points, multipliers }
    }

    /// Number of unknowns: 4N + 8, or 4N in the weak form.
    pub fn unknowns(&self) -> usize {
        4 * self.points + self.multipliers
    }

    /// First index of t on the branch (0 forward, 1 backward).
    pub fn t(&self, branch: usize) -> usize {
        2 * branch * self.points
    }

    /// First index of x on the branch (0 forward, 1 backward).
    pub fn x(&self, branch: usize) -> usize {
        (2 * branch + 1) * self.points
    }

    /// Indices of λ1 … λ8 (none in the weak form).
    pub fn multiplier_range(&self) -> Range<usize> {
        4 * self.points..self.unknowns()
    }

    /// The node that an unknown belongs to. Multipliers that fix the start belong to the first node, and those that tie
    /// the ends to the last.
    pub fn node(&self, unknown: usize) -> usize {
        match unknown.checked_sub(4 * self.points) {
            None => unknown % self.points,
            Some(multiplier) if multiplier < 4 => 0,
            Some(_) => self.points - 1,
        }
    }

    /// Forward and backward branch of `u`.
    pub fn branches<'u, S>(&self, u: &'u [S]) -> [Branch<'u, S>; 2] {
        let n = self.points;
        [Branch { t: &u[..n], x: &u[n..2 * n] }, Branch { t: &u[2 * n..3 * n], x: &u[3 * n..4 * n] }]
    }

    /// Forward and backward branch of `u`, to write.
    pub fn branches_mut<'u, S>(&self, u: &'u mut [S]) -> [BranchMut<'u, S>; 2] {
        let n = self.points;
        let (t1, rest) = u.split_at_mut(n);
        let (x1, rest) = rest.split_at_mut(n);
        let (t2, rest) = rest.split_at_mut(n);
        let x2 = &mut rest[..n];
        [BranchMut { t: t1, x: x1 }, BranchMut { t: t2, x: x2 }]
    }

    /// λ1 … λ8 of `u`.
    pub fn multipliers<'u, S>(&self, u: &'u [S]) -> &'u [S] {
        &u[self.multiplier_range()]
    }

    /// λ1 … λ8 of `u`, to write.
    pub fn multipliers_mut<'u, S>(&self, u: &'u mut [S]) -> &'u mut [S] {
        &mut u[self.multiplier_range()]
    }

    /// The vector of unknowns in the physical limit, where both branches are equal to (t, x). In the weak form
    /// `multipliers` is empty.
    pub fn physical_limit<S: Copy>(&self, t: &[S], x: &[S], multipliers: &[S]) -> Vec<S> {
        debug_assert_eq!(multipliers.len(), self.multipliers);
        [t, x, t, x, multipliers].concat()
    }
}
