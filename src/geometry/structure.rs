//! Which components and derivatives of a Lagrangian are not zero, and their values on the nodes of a grid.

use std::ops::Range;

use crate::number::Real;
use crate::number::norm::max_abs;

/// Where a value comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Source<S> {
    /// It is the same everywhere.
    Constant(S),
    /// It stands in a row of [`Samples`].
    Row(usize),
}

/// A derivative of g_ab (a ≤ b) with respect to coordinates, or g_ab itself.
///
/// One rule serves metric and one-form: with n coordinates and q̇^n = 1, A_a is the component g_an.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Term<S, const ORDER: usize> {
    /// The pair a ≤ b; b = n for the one-form.
    pub ab: [usize; 2],
    /// With respect to which coordinates, in ascending order.
    pub by: [usize; ORDER],
    /// Its value.
    pub value: Source<S>,
}

/// A derivative of F_a with respect to positions (0 … n−1) and velocities (n … 2n−1), or F_a itself.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ForceTerm<S, const ORDER: usize> {
    /// The coordinate.
    pub a: usize,
    /// With respect to which variables, in ascending order.
    pub by: [usize; ORDER],
    /// Its value.
    pub value: Source<S>,
}

/// The entries that are not zero in a Lagrangian L = ½ g_ab(q) q̇^a q̇^b + A_a(q) q̇^a and a force F_a(q, q̇).
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Structure<S> {
    /// Number of coordinates n.
    pub dimension: usize,
    /// True if there is a one-form.
    pub has_one_form: bool,
    /// g_ab and A_a.
    pub values: Vec<Term<S, 0>>,
    /// Their first derivatives.
    pub first: Vec<Term<S, 1>>,
    /// Their second derivatives.
    pub second: Vec<Term<S, 2>>,
    /// F_a.
    pub force: Vec<ForceTerm<S, 0>>,
    /// Its first derivatives.
    pub force_first: Vec<ForceTerm<S, 1>>,
    /// Number of rows for the metric and the one-form with their derivatives: first come values, then first
    /// derivatives, then second ones.
    pub rows: usize,
    /// Number of rows for values alone.
    pub rows_of_values: usize,
    /// Number of rows for values and first derivatives.
    pub rows_of_first: usize,
    /// Number of rows for the force with its derivatives.
    pub force_rows: usize,
    /// The coordinates of particles in a potential.
    pub particles: Range<usize>,
}

impl<S: Real> Structure<S> {
    /// The constant g_aa of a coordinate of a potential.
    pub fn inertia(&self, a: usize) -> Option<S> {
        let term = self.values.iter().find(|term| term.ab == [a; 2] && self.particles.contains(&a))?;
        if let Source::Constant(inertia) = term.value { Some(inertia) } else { None }
    }

    /// Velocities that the Lagrangian multiplies: n, and the constant 1 if there is a one-form.
    pub fn velocities(&self) -> usize {
        self.dimension + usize::from(self.has_one_form)
    }
}

/// Values on nodes, one contiguous row for each quantity.
#[derive(Debug, Clone)]
pub struct Samples<S> {
    points: usize,
    data: Vec<S>,
}

impl<S: Real> Samples<S> {
    /// All zero.
    pub fn zeros(rows: usize, points: usize) -> Self {
        Self { points, data: vec![S::ZERO; rows * points] }
    }

    /// A row.
    pub fn row(&self, row: usize) -> &[S] {
        &self.data[row * self.points..][..self.points]
    }

    /// A row, to write.
    pub fn row_mut(&mut self, row: usize) -> &mut [S] {
        &mut self.data[row * self.points..][..self.points]
    }

    /// All rows, to write.
    pub fn rows_mut(&mut self) -> impl Iterator<Item = &mut [S]> {
        self.data.chunks_exact_mut(self.points)
    }

    /// A value at node k.
    #[inline]
    pub fn at(&self, source: Source<S>, k: usize) -> S {
        match source {
            Source::Constant(value) => value,
            Source::Row(row) => self.data[row * self.points + k],
        }
    }

    /// The largest absolute value on the nodes.
    pub(crate) fn size(&self, source: Source<S>) -> f64 {
        match source {
            Source::Constant(value) => value.abs().to_f64(),
            Source::Row(row) => max_abs(self.row(row)).to_f64(),
        }
    }
}

/// Where a world-line starts: a position with its velocities and momenta.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Start<S = f64> {
    /// q^a.
    pub q: Vec<S>,
    /// dq^a/dγ.
    pub q_dot: Vec<S>,
    /// p_a.
    pub p: Vec<S>,
}

impl<S: Real> Start<S> {
    /// The same place on the way back.
    pub fn reversed(mut self) -> Self {
        self.q_dot.iter_mut().chain(&mut self.p).for_each(|rate| *rate = -*rate);
        self
    }

    /// The same in `f64`.
    pub(crate) fn in_f64(&self) -> Start {
        let of = |row: &[S]| row.iter().map(|value| value.to_f64()).collect();
        Start { q: of(&self.q), q_dot: of(&self.q_dot), p: of(&self.p) }
    }
}

/// The other index of a pair that contains `a`.
pub(crate) fn other([first, second]: [usize; 2], a: usize) -> Option<usize> {
    match (first == a, second == a) {
        (true, _) => Some(second),
        (_, true) => Some(first),
        _ => None,
    }
}
