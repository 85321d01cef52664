//! Radau IIA of order 5, the implicit method for stiff problems.

use super::force::{Force, WithForce, dispatch};
use super::{Failure, MOST_STEPS, Output, Problem, State, Trajectory, check};
use crate::geodesic::acceleration_slope;

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
const SAFETY: f64 = 0.9;
const LEAST_CHANGE: f64 = 0.2;
const MOST_CHANGE: f64 = 8.0;
/// Steps shorter than this share of the whole length are rejected.
const LEAST_STEP: f64 = 1e-13;

/// The world-line with relative and absolute `tolerance` for x and w; t is a quadrature outside the error norm.
///
/// As for Gauss, x″ = a(x) leaves three unknowns a step, X = x + h c w + h² A² a(X), which a simplified Newton
/// iteration solves with the exact slope of a at the start of the step. Steps end on the points of `output`.
///
/// # Errors
/// [`Failure`].
pub fn radau5(problem: &Problem, output: &Output, tolerance: f64) -> Result<Trajectory, Failure> {
    dispatch(&problem.metric, problem.q_t(), March { problem, output, tolerance })
}

struct March<'a> {
    problem: &'a Problem,
    output: &'a Output,
    tolerance: f64,
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

/// A step that was tried.
struct Step {
    end: State,
    a: [f64; 3],
    /// In units of the tolerance.
    error: f64,
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
    /// One step from a guess of a at its nodes, and how many evaluations it took; no step if Newton's method fails.
    #[inline(always)]
    fn step(
        &self,
        force: &mut impl Force,
        square: &[[f64; 3]; 3],
        h: f64,
        guess: [f64; 3],
        tolerance: f64,
    ) -> (Option<Step>, usize) {
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
        let mut evaluations = 0;
        for _ in 0..MOST_ITERATIONS {
            for i in 0..3 {
                (u[i], a[i]) = force.at(x + z[i]);
            }
            evaluations += 3;
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
            return (None, evaluations);
        }
        for i in 0..3 {
            (u[i], a[i]) = force.at(x + z[i]);
        }
        evaluations += 3;
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
        (Some(Step { end, a, error }), evaluations)
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

impl WithForce for March<'_> {
    type Output = Result<Trajectory, Failure>;

    #[inline(always)]
    fn with(self, mut force: impl Force) -> Self::Output {
        let Self { problem, output, tolerance } = self;
        let (metric, q_t) = (&problem.metric, problem.q_t());
        let square = square();
        let start = |state: State, a: f64| {
            let g = metric.at(state.x);
            Start { state, a, slope: acceleration_slope(q_t, g.g00, g.first, g.second) }
        };
        let first = problem.start();
        let mut from = start(first, force.at(first.x).1);
        let pace = from.a.abs().sqrt().max(first.w.abs()).max(1.0 / problem.length);
        let mut h = (0.5 * tolerance.powf(0.25) / pace).min(problem.length);
        // The stages of the step before, and its length.
        let mut before: Option<([f64; 3], f64)> = None;
        let (mut evaluations, mut accepted, mut attempts, mut gamma) = (2, 0, 0, 0.0);
        let mut states = Vec::with_capacity(output.marks.len());
        for target in output.gamma(problem.length) {
            loop {
                let remaining = target - gamma;
                let parts = (remaining / h * (1.0 - 1e-12)).ceil().max(1.0);
                let step = if parts <= 2.0 { remaining / parts } else { h };
                attempts += 1;
                if attempts > MOST_STEPS || step < LEAST_STEP * problem.length {
                    return Err(Failure::TooManySteps);
                }
                let guess = before.map_or([from.a; 3], |(a, length)| extrapolate(a, step / length));
                let (tried, cost) = from.step(&mut force, &square, step, guess, tolerance);
                evaluations += cost;
                let change = |error: f64| (SAFETY * error.powf(-0.25)).clamp(LEAST_CHANGE, MOST_CHANGE);
                let done = match tried {
                    Some(done) if done.error <= 1.0 => done,
                    Some(Step { error, .. }) if error.is_finite() => {
                        h = step * change(error).min(1.0);
                        continue;
                    }
                    _ => {
                        h = 0.5 * step;
                        before = None;
                        continue;
                    }
                };
                // A step that was cut is no argument against longer ones.
                let longer = step * change(done.error);
                h = if step < h { longer.max(h) } else { longer };
                before = Some((done.a, step));
                // The last node is the end of the step.
                from = start(done.end, done.a[2]);
                evaluations += 1;
                accepted += 1;
                gamma += step;
                if parts == 1.0 {
                    gamma = target;
                    break;
                }
            }
            check(metric, from.state)?;
            states.push(from.state);
        }
        Ok(Trajectory { states, evaluations, steps: accepted })
    }
}
