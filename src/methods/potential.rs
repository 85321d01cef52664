//! The equations in a potential of x alone: one quadrature, one position, one velocity. The rates that drive the
//! motion, u = Q_t/g00(x) and a = −½ g00′(x) u², are computed as fast as possible.

use nalgebra::{Matrix3, Vector3};

use super::equations::{Equations, Parts};
use super::{Failure, Problem, States};
use crate::geometry::{Point, Source};

/// t′ = u(x), x′ = w, w′ = a(x).
pub(super) struct PotentialEquations<'p, F> {
    problem: &'p Problem,
    /// Where g00, g00′ and g00″ stand.
    g00: [Source<f64>; 3],
    point: Point,
    force: F,
    /// a′ where it was asked for last.
    slope: f64,
    /// (1 − s m)⁻¹ for the s and m that were given last.
    inverse: Matrix3<f64>,
}

impl<'p, F: Force> PotentialEquations<'p, F> {
    pub(super) fn new(problem: &'p Problem, force: F) -> Self {
        let Problem { space, .. } = problem;
        let (g00, point) = (space.sources_of_g00(), space.point());
        Self { problem, g00, point, force, slope: 0.0, inverse: Matrix3::zeros() }
    }
}

impl<F: Force> Equations for PotentialEquations<'_, F> {
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
        let s = scale * self.slope;
        let system = Matrix3::from_fn(|i, j| f64::from(u8::from(i == j)) - s * matrix[i][j]);
        self.inverse = system.try_inverse().unwrap_or(Matrix3::repeat(f64::NAN));
    }

    #[inline(always)]
    fn correct(&mut self, right: &mut [[f64; 3]; 3]) {
        right[1] = (self.inverse * Vector3::from(right[1])).into();
    }

    #[inline(always)]
    fn smooth(&mut self, diagonal: f64, right: &mut [f64; 3]) {
        // J = ((0, 1), (a′, 0)).
        let [_, x, w] = *right;
        let determinant = diagonal * diagonal - self.slope;
        (right[1], right[2]) = ((diagonal * x + w) / determinant, (self.slope * x + diagonal * w) / determinant);
    }
}

/// u = dt/dγ and a = d²x/dγ².
pub(super) trait Force {
    /// (u, a) at `x`.
    fn at(&mut self, x: f64) -> (f64, f64);
}

impl Force for Box<dyn Force> {
    fn at(&mut self, x: f64) -> (f64, f64) {
        (**self).at(x)
    }
}

/// g00 of degree four at most, by Estrin's scheme: half the latency of Horner's, which is what a step waits for.
pub(super) struct LowDegree {
    g: [f64; 5],
    /// −½ g00′.
    d: [f64; 4],
    q_t: f64,
}

impl LowDegree {
    pub(super) fn new(coefficients: &[f64], q_t: f64) -> Self {
        let mut g = [0.0; 5];
        g[..coefficients.len()].copy_from_slice(coefficients);
        Self { g, d: [-0.5 * g[1], -g[2], -1.5 * g[3], -2.0 * g[4]], q_t }
    }
}

impl Force for LowDegree {
    #[inline(always)]
    fn at(&mut self, x: f64) -> (f64, f64) {
        let Self { g, d, q_t } = self;
        let x2 = x * x;
        let g00 = (g[0] + g[1] * x) + x2 * ((g[2] + g[3] * x) + x2 * g[4]);
        let u = *q_t / g00;
        (u, ((d[0] + d[1] * x) + x2 * (d[2] + d[3] * x)) * (u * u))
    }
}

/// g00 of any degree, by Horner's rule.
pub(super) struct AnyDegree {
    pub(super) g: Vec<f64>,
    pub(super) q_t: f64,
}

impl Force for AnyDegree {
    #[inline(always)]
    fn at(&mut self, x: f64) -> (f64, f64) {
        let (mut g00, mut slope) = (0.0, 0.0);
        for &c in self.g.iter().rev() {
            slope = slope * x + g00;
            g00 = g00 * x + c;
        }
        let u = self.q_t / g00;
        (u, -0.5 * slope * (u * u))
    }
}

/// The program of the equations.
pub(super) struct ProgramForce {
    pub(super) point: Point,
    pub(super) q_t: f64,
}

impl Force for ProgramForce {
    #[inline]
    fn at(&mut self, x: f64) -> (f64, f64) {
        match self.point.evaluate(&[0.0, x], &[self.q_t, 0.0]) {
            Ok(()) => (self.point.q_dot(0), self.point.acceleration(0).unwrap_or(f64::NAN)),
            Err(_) => (f64::NAN, f64::NAN),
        }
    }
}
