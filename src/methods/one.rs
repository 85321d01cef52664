//! The equations of the paper's metric: one quadrature, one position, one velocity.

use super::equations::{Equations, Parts};
use super::force::Force;
use super::{Failure, Problem, States};
use crate::geometry::{Point, Source};

/// t′ = u(x), x′ = w, w′ = a(x).
pub(super) struct One<'p, F> {
    problem: &'p Problem,
    /// Where g00, g00′ and g00″ stand.
    g00: [Source<f64>; 3],
    point: Point,
    force: F,
    /// a′ where it was asked for last.
    slope: f64,
    /// (1 − s m)⁻¹ for the s and m that were given last.
    inverse: [[f64; 3]; 3],
}

impl<'p, F: Force> One<'p, F> {
    pub(super) fn new(problem: &'p Problem, force: F) -> Self {
        let Problem { space, .. } = problem;
        let (g00, point) = (space.sources_of_g00(), space.point());
        Self { problem, g00, point, force, slope: 0.0, inverse: [[0.0; 3]; 3] }
    }
}

impl<F: Force> Equations for One<'_, F> {
    type Rows<T: Copy> = [T; 3];
    #[inline(always)]
    fn rows<T: Copy>(&self, value: T) -> [T; 3] {
        [value; 3]
    }

    #[inline(always)]
    fn vacant<T: Copy>(value: T) -> [T; 3] {
        [value; 3]
    }

    #[inline(always)]
    fn parts(&self) -> Parts {
        Parts { quadratures: 1, positions: 1, is_second_order: true }
    }

    #[inline(always)]
    fn start(&self) -> [f64; 3] {
        [0.0, self.problem.start.q[1], self.problem.start.q_dot[1]]
    }

    #[inline(always)]
    fn rates(&mut self, &[_, x, w]: &[f64; 3], rates: &mut [f64; 3]) {
        let (u, a) = self.force.at(x);
        *rates = [u, w, a];
    }

    fn point(&mut self, &[elapsed, x, w]: &[f64; 3], out: &mut States) -> Result<(), Failure> {
        if !(elapsed.is_finite() && x.is_finite() && w.is_finite()) {
            return Err(Failure::Diverged);
        }
        let (q, p) = ([self.problem.start.q[0] + elapsed, x], [self.problem.start.p[0], -w]);
        self.point.evaluate(&q, &p).map_err(|_| Failure::OutsideDomain)?;
        out.push(&q, &p);
        Ok(())
    }

    /// a′ = −½ g00″ u² + g00′² u²/g00.
    fn linearise(&mut self, &[_, x, _]: &[f64; 3]) {
        let samples = self.problem.space.at(&[0.0, x]);
        let [g00, first, second] = self.g00.map(|source| samples.at(source, 0));
        let u = self.problem.start.p[0] / g00;
        self.slope = u * u * (first * first / g00 - 0.5 * second);
    }

    #[inline(always)]
    fn factor(&mut self, matrix: &[[f64; 3]; 3], scale: f64) {
        self.inverse = resolvent(matrix, scale * self.slope);
    }

    #[inline(always)]
    fn correct(&mut self, right: &mut [[f64; 3]; 3]) {
        let r = right[1];
        right[1] = self.inverse.map(|row| row[0] * r[0] + row[1] * r[1] + row[2] * r[2]);
    }

    #[inline(always)]
    fn smooth(&mut self, diagonal: f64, right: &mut [f64; 3]) {
        // J = ((0, 1), (a′, 0)).
        let [_, x, w] = *right;
        let determinant = diagonal * diagonal - self.slope;
        (right[1], right[2]) = ((diagonal * x + w) / determinant, (self.slope * x + diagonal * w) / determinant);
    }
}

/// (1 − s m)⁻¹ by cofactors.
fn resolvent(m: &[[f64; 3]; 3], s: f64) -> [[f64; 3]; 3] {
    let r: [[f64; 3]; 3] = std::array::from_fn(|i| std::array::from_fn(|j| f64::from(u8::from(i == j)) - s * m[i][j]));
    let minor = |i: usize, j: usize| {
        let ([a, b], [c, d]) = ([(i + 1) % 3, (i + 2) % 3], [(j + 1) % 3, (j + 2) % 3]);
        r[a][c] * r[b][d] - r[a][d] * r[b][c]
    };
    let determinant: f64 = (0..3).map(|j| r[0][j] * minor(0, j)).sum();
    std::array::from_fn(|i| std::array::from_fn(|j| minor(j, i) / determinant))
}
