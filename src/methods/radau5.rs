//! Radau IIA of order 5, the implicit method for stiff problems.

use super::driver::{AdaptiveSteps, Control, Method, Task, Walker, adaptive_steps};
use super::equations::{Equations, Parts};
use super::{Failure, Trajectory};

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

/// As for Gauss, x″ = a(x) leaves three unknowns a step for each position, X = x + h c w + h² A² a(X), which a
/// simplified Newton iteration solves with the exact Jacobian at the start of the step. Equations of the first order
/// have Y = y + h A f(Y).
pub(super) struct Radau5;

impl Method for Radau5 {
    #[inline(always)]
    fn integrate<E: Equations>(&self, equations: E, task: &Task<'_>) -> Result<Trajectory, Failure> {
        const CONTROL: Control =
            Control { exponent: 0.25, change: [0.2, 8.0], after_failure: 0.5, ends_on_output: true };
        let (here, nodes) = (equations.start(), equations.rows([0.0; 3]));
        let walk = Walk {
            tolerance: task.setting.tolerance,
            square: square(),
            h: 0.0,
            rates: here.clone(),
            at: here.clone(),
            out: here.clone(),
            next: here.clone(),
            here,
            tried: nodes.clone(),
            z: nodes.clone(),
            change: nodes.clone(),
            known: nodes,
            before: None,
        };
        adaptive_steps(equations, task, CONTROL, walk)
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

/// The parabola through `a` on the nodes of a step, on those of the next, `ratio` times as long.
#[inline(always)]
fn extrapolate(a: [f64; 3], ratio: f64) -> [f64; 3] {
    C.map(|c| {
        let s = 1.0 + ratio * c;
        let basis = |i: usize, j: usize, k: usize| (s - C[j]) * (s - C[k]) / ((C[i] - C[j]) * (C[i] - C[k]));
        a[0] * basis(0, 1, 2) + a[1] * basis(1, 2, 0) + a[2] * basis(2, 0, 1)
    })
}

struct Walk<E: Equations> {
    tolerance: f64,
    square: [[f64; 3]; 3],
    /// The length of the step that was tried last, its start, where the method is or has just left, and its end.
    h: f64,
    here: E::Rows<f64>,
    next: E::Rows<f64>,
    /// The derivatives at the start.
    rates: E::Rows<f64>,
    /// The rates at the nodes.
    tried: E::Rows<[f64; 3]>,
    /// Room for what the unknowns at the nodes are away from the start of the step, and for their changes.
    z: E::Rows<[f64; 3]>,
    change: E::Rows<[f64; 3]>,
    /// Room for one of the nodes, and the derivatives there.
    at: E::Rows<f64>,
    out: E::Rows<f64>,
    /// The rates at the nodes of the step before, and its length.
    known: E::Rows<[f64; 3]>,
    before: Option<f64>,
}

impl<E: Equations> Walk<E> {
    /// The change of the unknown with index k from the start to the nodes, by the rates.
    #[inline(always)]
    fn image(&self, parts: Parts, k: usize) -> [f64; 3] {
        let (h, rates) = (self.h, self.tried.as_ref()[k + parts.behind()]);
        if parts.is_second_order {
            let (w, product) = (self.here.as_ref()[k + parts.behind()], multiply(&self.square, rates));
            return std::array::from_fn(|i| h * C[i] * w + h * h * product[i]);
        }
        multiply(&A, rates).map(|sum| h * sum)
    }

    /// The rates at the nodes.
    #[inline(always)]
    fn evaluate(&mut self, equations: &mut E) {
        let parts = equations.parts();
        let Self { here, z, at, out, tried, .. } = self;
        for i in 0..3 {
            for k in parts.unknowns() {
                at.as_mut()[k] = here.as_ref()[k] + z.as_ref()[k][i];
            }
            equations.rates(at, out);
            for k in 0..parts.quadratures {
                tried.as_mut()[k][i] = out.as_ref()[k];
            }
            for k in parts.driving() {
                tried.as_mut()[k][i] = out.as_ref()[k];
            }
        }
    }

    /// Solves from a guess of the rates at the nodes; whether Newton's method converges.
    #[inline(always)]
    fn solve(&mut self, equations: &mut E) -> bool {
        let (parts, h) = (equations.parts(), self.h);
        if parts.is_second_order {
            equations.factor(&self.square, h * h);
        } else {
            equations.factor(&A, h);
        }
        for k in parts.unknowns() {
            self.z.as_mut()[k] = self.image(parts, k);
        }
        for _ in 0..MOST_ITERATIONS {
            self.evaluate(equations);
            for k in parts.unknowns() {
                let (target, z) = (self.image(parts, k), self.z.as_ref()[k]);
                self.change.as_mut()[k] = std::array::from_fn(|i| target[i] - z[i]);
            }
            equations.correct(&mut self.change);
            let (mut is_done, mut is_finite) = (true, true);
            for k in parts.unknowns() {
                let (change, z, x) = (self.change.as_ref()[k], &mut self.z.as_mut()[k], self.here.as_ref()[k]);
                *z = std::array::from_fn(|i| z[i] + change[i]);
                let size = change.iter().fold(0.0, |size: f64, c| size.max(c.abs()));
                is_done &= size <= f64::max(NEWTON * (self.tolerance * (1.0 + x.abs())), f64::EPSILON * x.abs());
                is_finite &= size.is_finite();
            }
            if is_done || !is_finite {
                return is_done;
            }
        }
        false
    }

    /// The end of the step, and its error in units of the tolerance.
    #[inline(always)]
    fn finish(&mut self, equations: &mut E) -> f64 {
        self.evaluate(equations);
        let (parts, h) = (equations.parts(), self.h);
        let Self { tolerance, here, rates, tried, z, out: right, next, .. } = self;
        let (here, rates, tried, z) = (here.as_ref(), rates.as_ref(), tried.as_ref(), z.as_ref());
        let sum = |weights: [f64; 3], v: [f64; 3]| (0..3).map(|i| weights[i] * v[i]).sum::<f64>();
        for k in 0..parts.quadratures {
            next.as_mut()[k] = here[k] + h * sum(A[2], tried[k]);
        }
        // (u₁/h − J) e = f(y) + Σ E_i Z_i/h.
        for k in parts.unknowns() {
            next.as_mut()[k] = here[k] + z[k][2];
            right.as_mut()[k] = rates[k] + sum(E, z[k]) / h;
        }
        if parts.is_second_order {
            for k in parts.driving() {
                let z = multiply(&A, tried[k]).map(|sum| h * sum);
                next.as_mut()[k] = here[k] + z[2];
                right.as_mut()[k] = rates[k] + sum(E, z) / h;
            }
        }
        equations.smooth(U1 / h, right);
        let moving = parts.moving();
        let square = |k: usize| (right.as_ref()[k] / (*tolerance * (1.0 + here[k].abs()))).powi(2);
        (moving.clone().map(square).sum::<f64>() / moving.len() as f64).sqrt()
    }
}

impl<E: Equations> Walker<E> for Walk<E> {
    #[inline(always)]
    fn state(&self) -> &E::Rows<f64> {
        &self.here
    }
}

impl<E: Equations> AdaptiveSteps<E> for Walk<E> {
    #[inline(always)]
    fn begin(&mut self, equations: &mut E, rates: &E::Rows<f64>) {
        self.rates.clone_from(rates);
        equations.linearise(&self.here);
    }

    #[inline(always)]
    fn attempt(mut self, equations: &mut E, h: f64) -> (Self, Option<f64>) {
        self.h = h;
        for k in equations.parts().driving() {
            self.tried.as_mut()[k] = match self.before {
                Some(length) => extrapolate(self.known.as_ref()[k], h / length),
                None => [self.rates.as_ref()[k]; 3],
            };
        }
        let error = self.solve(equations).then(|| self.finish(equations)).filter(|error| error.is_finite());
        if error.is_none() {
            self.before = None;
        }
        (self, error)
    }

    #[inline(always)]
    fn accept(&mut self, equations: &mut E) {
        let parts = equations.parts();
        self.before = Some(self.h);
        self.known.as_mut().copy_from_slice(self.tried.as_ref());
        self.here.clone_from(&self.next);
        // The last node is the end of the step.
        for k in parts.driving() {
            self.rates.as_mut()[k] = self.tried.as_ref()[k][2];
        }
        if parts.is_second_order {
            for k in parts.unknowns() {
                self.rates.as_mut()[k] = self.here.as_ref()[k + parts.behind()];
            }
        }
        equations.linearise(&self.here);
    }
}
