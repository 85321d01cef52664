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
    evaluations: usize,
    /// a′ where it was asked for last.
    slope: f64,
    /// (1 − s m)⁻¹ for the s and m that were given last.
    inverse: Matrix3<f64>,
}

impl<'p, F: Force> PotentialEquations<'p, F> {
    pub(super) fn new(problem: &'p Problem, force: F) -> Self {
        let Problem { space, .. } = problem;
        let (g00, point) = (space.sources_of_g00(), space.point());
        Self { problem, g00, point, force, evaluations: 0, slope: 0.0, inverse: Matrix3::zeros() }
    }
}

impl<F: Force> Equations for PotentialEquations<'_, F> {
    type Rows<T: Copy> = [T; 3];
    #[inline(always)]
    fn rows<T: Copy>(&self, value: T) -> [T; 3] {
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

    fn evaluations(&self) -> usize {
        self.evaluations
    }

    #[inline(always)]
    fn rates(&mut self, &[_, x, w]: &[f64; 3], rates: &mut [f64; 3]) {
        self.evaluations += 1;
        let (u, a) = (self.force)(x);
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
        self.evaluations += 1;
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

/// u = dt/dγ and a = d²x/dγ² at x.
pub(super) trait Force: FnMut(f64) -> (f64, f64) {}

impl<F: FnMut(f64) -> (f64, f64)> Force for F {}

/// A force that methods are not compiled for.
pub(super) fn boxed<'f>(force: impl Force + 'f) -> Box<dyn Force + 'f> {
    Box::new(force)
}

/// g00 of degree four at most, by Estrin's scheme: half the latency of Horner's, which is what a step waits for.
pub(super) fn low_degree(coefficients: &[f64], q_t: f64) -> impl Force {
    let mut g = [0.0; 5];
    g[..coefficients.len()].copy_from_slice(coefficients);
    // −½ g00′.
    let d = [-0.5 * g[1], -g[2], -1.5 * g[3], -2.0 * g[4]];
    std::convert::identity(
        #[inline(always)]
        move |x: f64| {
            let x2 = x * x;
            let g00 = (g[0] + g[1] * x) + x2 * ((g[2] + g[3] * x) + x2 * g[4]);
            let u = q_t / g00;
            (u, ((d[0] + d[1] * x) + x2 * (d[2] + d[3] * x)) * (u * u))
        },
    )
}

/// g00 of any degree, by Horner's rule.
pub(super) fn any_degree(g: &[f64], q_t: f64) -> impl Force + '_ {
    move |x| {
        let (mut g00, mut slope) = (0.0, 0.0);
        for &c in g.iter().rev() {
            slope = slope * x + g00;
            g00 = g00 * x + c;
        }
        let u = q_t / g00;
        (u, -0.5 * slope * (u * u))
    }
}

/// The program of the equations.
pub(super) fn program(mut point: Point, q_t: f64) -> impl Force {
    move |x| match point.evaluate(&[0.0, x], &[q_t, 0.0]) {
        Ok(()) => (point.q_dot(0), point.acceleration(0).unwrap_or(f64::NAN)),
        Err(_) => (f64::NAN, f64::NAN),
    }
}
