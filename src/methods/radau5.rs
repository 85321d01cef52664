//! Radau IIA of order 5, the implicit method for stiff problems.

use super::driver::{AdaptiveSteps, Control, Counted, Walker, adaptive_steps};
use super::force::Force;
use super::{About, Failure, Output, Peer, Problem, Setting, State, Step, Trajectory};
use crate::geodesic::acceleration_slope;
use crate::metric::Metric;

/// √6.
const ROOT: f64 = 2.449_489_742_783_178;
const C: [f64; 3] = [(4.0 - ROOT) / 10.0, (4.0 + ROOT) / 10.0, 1.0];
const A: [[f64; 3]; 3] = [
    [(88.0 - 7.0 * ROOT) / 360.0, (296.0 - 169.0 * ROOT) / 1800.0, (-2.0 + 3.0 * ROOT) / 225.0],
    [(296.0 + 169.0 * ROOT) / 1800.0, (88.0 + 7.0 * ROOT) / 360.0, (-2.0 - 3.0 * ROOT) / 225.0],
    [(16.0 - ROOT) / 36.0, (16.0 + ROOT) / 36.0, 1.0 / 9.0],
];
/// The reciprocal of the real eigenvalue of A.
const U1: f64 = 3.637_834_252_744_496;
/// The error estimate of Hairer and Wanner, "Solving Ordinary Differential Equations II", IV.8.
const E: [f64; 3] = [-(13.0 + 7.0 * ROOT) / 3.0, (-13.0 + 7.0 * ROOT) / 3.0, -1.0 / 3.0];

/// Newton iterations for a step, and what they leave in units of the tolerance.
const MOST_ITERATIONS: usize = 10;
const NEWTON: f64 = 1e-2;

/// Relative and absolute tolerance for x and w; t is a quadrature outside the error norm.
///
/// As for Gauss, x″ = a(x) leaves three unknowns a step, X = x + h c w + h² A² a(X), which a simplified Newton
/// iteration solves with the exact slope of a at the start of the step. Steps end on the points of output.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Radau5;

impl Peer for Radau5 {
    fn about(&self) -> About {
        About {
            name: "Radau5".to_owned(),
            curve: "Radau IIA 5",
            order: Some(5),
            step: Step::Adaptive,
            has_dense_output: false,
            coarsest: 1.0,
            source: "Hairer, Wanner, Solving Ordinary Differential Equations II, IV.8",
        }
    }

    fn run(&self, problem: &Problem, output: &Output, setting: Setting) -> Result<Trajectory, Failure> {
        let (q_t, metric, tolerance) = (problem.q_t(), &problem.metric, setting.tolerance);
        let here = Start { state: problem.start(), a: 0.0, slope: 0.0 };
        let tried = (Stages { end: here.state, a: [0.0; 3] }, 0.0);
        let walk = Walk { metric, q_t, tolerance, square: square(), here, tried, before: None };
        adaptive_steps(problem, output, tolerance, walk)
    }
}

/// `m` v.
#[inline(always)]
fn multiply(m: &[[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
    m.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

/// A².
fn square() -> [[f64; 3]; 3] {
    let entry = |i: usize, j: usize| (0..3).map(|k| A[i][k] * A[k][j]).sum();
    std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j)))
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

/// A step: its end, and a at its nodes.
#[derive(Clone, Copy)]
struct Stages {
    end: State,
    a: [f64; 3],
}

/// Where a step starts.
#[derive(Clone, Copy)]
struct Start {
    state: State,
    /// a and its slope there.
    a: f64,
    slope: f64,
}

impl Start {
    /// One step from a guess of a at its nodes, and its error in units of the tolerance; no step if Newton's method
    /// fails.
    #[inline(always)]
    fn step(
        &self,
        force: &mut Counted<impl Force>,
        square: &[[f64; 3]; 3],
        h: f64,
        guess: [f64; 3],
        tolerance: f64,
    ) -> Option<(Stages, f64)> {
        let State { elapsed, x, w } = self.state;
        let inverse = resolvent(square, h * h * self.slope);
        let scales = [tolerance * (1.0 + x.abs()), tolerance * (1.0 + w.abs())];
        let (mut a, mut u) = (guess, [0.0; 3]);
        // X − x on the nodes.
        let image = |a: [f64; 3]| {
            let product = multiply(square, a);
            std::array::from_fn::<f64, 3, _>(|i| h * C[i] * w + h * h * product[i])
        };
        let mut z = image(a);
        let mut converged = false;
        for _ in 0..MOST_ITERATIONS {
            for i in 0..3 {
                (u[i], a[i]) = force.at(x + z[i]);
            }
            let target = image(a);
            let change = multiply(&inverse, std::array::from_fn(|i| target[i] - z[i]));
            z = std::array::from_fn(|i| z[i] + change[i]);
            let size = change.iter().fold(0.0, |size: f64, c| size.max(c.abs()));
            if size <= f64::max(NEWTON * scales[0], f64::EPSILON * x.abs()) {
                converged = true;
                break;
            }
            if !size.is_finite() {
                break;
            }
        }
        if !converged {
            return None;
        }
        for i in 0..3 {
            (u[i], a[i]) = force.at(x + z[i]);
        }
        let zw = multiply(&A, a).map(|sum| h * sum);
        let sum = |weights: [f64; 3], v: [f64; 3]| (0..3).map(|i| weights[i] * v[i]).sum::<f64>();
        let end = State { elapsed: elapsed + h * sum(A[2], u), x: x + z[2], w: w + zw[2] };
        // (u₁/h − J) e = f(y) + Σ E_i Z_i/h with J = ((0, 1), (a′, 0)).
        let (diagonal, right) = (U1 / h, [w + sum(E, z) / h, self.a + sum(E, zw) / h]);
        let determinant = diagonal * diagonal - self.slope;
        let e = [
            (diagonal * right[0] + right[1]) / determinant,
            (self.slope * right[0] + diagonal * right[1]) / determinant,
        ];
        let error = (0.5 * ((e[0] / scales[0]).powi(2) + (e[1] / scales[1]).powi(2))).sqrt();
        Some((Stages { end, a }, error))
    }
}

/// The parabola through `a` on the nodes of a step, on those of the next, `ratio` times as long.
#[inline(always)]
fn extrapolate(a: [f64; 3], ratio: f64) -> [f64; 3] {
    C.map(|c| {
        let s = 1.0 + ratio * c;
        let basis = |i: usize, j: usize, k: usize| (s - C[j]) * (s - C[k]) / ((C[i] - C[j]) * (C[i] - C[k]));
        a[0] * basis(0, 1, 2) + a[1] * basis(1, 2, 0) + a[2] * basis(2, 0, 1)
    })
}

struct Walk<'a> {
    metric: &'a Metric,
    q_t: f64,
    tolerance: f64,
    square: [[f64; 3]; 3],
    here: Start,
    /// The step that was tried last, and its length.
    tried: (Stages, f64),
    /// a at the nodes of the step before, and its length.
    before: Option<([f64; 3], f64)>,
}

impl Walk<'_> {
    /// Goes on from this state, where a is known. The slope of a takes an evaluation.
    #[inline(always)]
    fn start(&mut self, force: &mut Counted<impl Force>, state: State, a: f64) {
        let g = self.metric.at(state.x);
        force.evaluations += 1;
        self.here = Start { state, a, slope: acceleration_slope(self.q_t, g.g00, g.first, g.second) };
    }
}

impl Walker for Walk<'_> {
    #[inline(always)]
    fn state(&self) -> State {
        self.here.state
    }
}

impl AdaptiveSteps for Walk<'_> {
    const CONTROL: Control = Control { exponent: 0.25, change: [0.2, 8.0], after_failure: 0.5, ends_on_output: true };

    #[inline(always)]
    fn begin<F: Force>(&mut self, force: &mut Counted<F>, (_, a): (f64, f64)) {
        self.start(force, self.here.state, a);
    }

    #[inline(always)]
    fn attempt<F: Force>(&mut self, force: &mut Counted<F>, h: f64) -> Option<f64> {
        let guess = self.before.map_or([self.here.a; 3], |(a, length)| extrapolate(a, h / length));
        let tried = self.here.step(force, &self.square, h, guess, self.tolerance);
        let Some((stages, error)) = tried.filter(|(_, error)| error.is_finite()) else {
            self.before = None;
            return None;
        };
        self.tried = (stages, h);
        Some(error)
    }

    #[inline(always)]
    fn accept<F: Force>(&mut self, force: &mut Counted<F>) {
        let (Stages { end, a }, h) = self.tried;
        self.before = Some((a, h));
        // The last node is the end of the step.
        self.start(force, end, a[2]);
    }
}
