//! The collocation system of the physical limit as a banded Newton iteration in (x, w*), then one banded solve for t.

use std::ops::Range;

use super::march;
use super::newton::{self, Failure, LinearFailure, NewtonSystem};
use super::physical_limit::PhysicalLimit;
use super::problem::Problem;
use super::status::InitialGuess;
use crate::banded::solve_banded;
use crate::geodesic::{acceleration, acceleration_slope};
use crate::metric::{MetricSamples, OutsideDomain};
use crate::norm::max_abs;

/// Rounding units of hDu: the absolute coefficients of a boundary row of hD sum to less than 4.
const ROW_SUM: f64 = 4.0;

pub(super) fn solve(problem: &Problem, max_iterations: usize) -> Result<PhysicalLimit, Failure> {
    let (x, w) = march::nystrom(problem).map_err(march::outside)?;
    let guess: Vec<f64> = x[1..].iter().zip(&w[1..]).flat_map(|(&x, &w)| [x, w]).collect();
    let mut system = Collocation::new(problem, x, w);
    let root = newton::solve(&mut system, guess, max_iterations)?;
    // The system was evaluated last at its root.
    let Collocation { x, w, metric, slope_x, .. } = system;
    let elapsed = integrate(problem, &metric, slope_x);
    Ok(PhysicalLimit { elapsed, x, x_dot: w, history: root.history, initial_guess: InitialGuess::Nystrom4 })
}

/// t − t_i from (Dt)_k = Q_t/g00(x_k) at the first N − 1 nodes, with one step of iterative refinement. `slope` is room
/// for N numbers.
fn integrate(problem: &Problem, metric: &MetricSamples, mut slope: Vec<f64>) -> Vec<f64> {
    let h = problem.sbp.spacing();
    let q_t = problem.invariants().q_t;
    let unknowns = problem.sbp.points() - 1;
    let (lower, upper) = reach(problem);
    let goal = |k: usize| h * q_t / metric.g00[k];
    let mut right: Vec<f64> = (0..unknowns).map(goal).collect();
    let mut elapsed = vec![0.0; unknowns + 1];
    for _ in 0..2 {
        solve_banded(lower, upper, &mut right, |k, row| {
            row.fill(0.0);
            shifted_row(problem, k).for_each(|(column, d)| row[column + lower - k] = h * d);
        })
        .expect("D without its first column and last row is invertible");
        for (t, correction) in elapsed[1..].iter_mut().zip(&right) {
            *t += correction;
        }
        problem.sbp.apply(&elapsed, &mut slope);
        for (k, (r, slope)) in right.iter_mut().zip(&slope).enumerate() {
            *r = goal(k) - h * slope;
        }
    }
    elapsed
}

/// (column, entry) of row k of D without its first column: columns count the nodes from the second.
fn shifted_row(problem: &Problem, k: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
    problem.sbp.row(k).filter(|&(column, _)| column > 0).map(|(column, d)| (column - 1, d))
}

/// Sub- and super-diagonals of D without its first column and last row.
fn reach(problem: &Problem) -> (usize, usize) {
    let unknowns = problem.sbp.points() - 1;
    // The rows of the closures and one between them show every offset that occurs.
    let closure = problem.sbp.closure_rows();
    let rows = (0..=closure).chain(unknowns - closure..unknowns);
    rows.flat_map(|k| shifted_row(problem, k).map(move |(column, _)| (k, column)))
        .fold((1, 0), |(l, u), (k, column)| (k.saturating_sub(column).max(l), column.saturating_sub(k).max(u)))
}

/// Rows (hDx − h w)/s_x and (hDw − h a(x))/s_w at nodes 1 … N−1 in the unknowns (x_k, w_k), k = 2 … N, interleaved.
/// The scales s_x and s_w make one rounding level hold for both kinds of row.
struct Collocation<'a> {
    problem: &'a Problem,
    q_t: f64,
    scale_x: f64,
    scale_w: f64,
    // What was evaluated last: x and w on all N nodes, the metric and the slopes. Kept, because at a million nodes
    // fresh memory costs more than the arithmetic.
    x: Vec<f64>,
    w: Vec<f64>,
    metric: MetricSamples,
    slope_x: Vec<f64>,
    slope_w: Vec<f64>,
}

impl<'a> Collocation<'a> {
    /// The system with scales from a first guess on the nodes.
    fn new(problem: &'a Problem, x: Vec<f64>, w: Vec<f64>) -> Self {
        let h = problem.sbp.spacing();
        let (size_x, size_w) = (max_abs(&x), max_abs(&w));
        // At rest in an equilibrium every scale would vanish; the smallest normal number keeps 0/s at 0.
        let scale_x = (size_x + h * size_w).max(f64::MIN_POSITIVE);
        let q_t = problem.invariants().q_t;
        let force = x.iter().fold(0.0_f64, |largest, &x| {
            let g = problem.metric.at(x);
            largest.max(acceleration(q_t, g.g00, g.first).abs())
        });
        let scale_w = (size_w + h * force).max(f64::MIN_POSITIVE);
        let points = x.len();
        Self {
            problem,
            q_t,
            scale_x,
            scale_w,
            x,
            w,
            metric: MetricSamples::zeros(points),
            slope_x: vec![0.0; points],
            slope_w: vec![0.0; points],
        }
    }

    /// Brings x, w and the metric to the unknowns `u`.
    fn evaluate(&mut self, u: &[f64]) -> Result<(), OutsideDomain> {
        for ((pair, x), w) in u.chunks_exact(2).zip(&mut self.x[1..]).zip(&mut self.w[1..]) {
            (*x, *w) = (pair[0], pair[1]);
        }
        self.problem.metric.sample_into(&self.x, &mut self.metric)
    }

    /// Overwrites `right` with J⁻¹ `right` for the Jacobian J at what was evaluated last.
    fn solve_linearised(&self, right: &mut [f64]) -> Result<(), LinearFailure> {
        let h = self.problem.sbp.spacing();
        let (scale_x, scale_w) = (self.scale_x, self.scale_w);
        let (lower, upper) = reach(self.problem);
        // Two fields a node; the coupling of w to x of the node before reaches three below the diagonal.
        let (lower, upper) = ((2 * lower).max(3), 2 * upper);
        solve_banded(lower, upper, right, |index, row| {
            row.fill(0.0);
            let (k, is_w) = (index / 2, index % 2);
            let scale = if is_w == 1 { scale_w } else { scale_x };
            shifted_row(self.problem, k).for_each(|(column, d)| row[2 * column + is_w + lower - index] = h * d / scale);
            // The first node is given: it has no unknowns to couple to.
            if k > 0 {
                let coupling = match is_w {
                    0 => 1.0,
                    _ => acceleration_slope(self.q_t, self.metric.g00[k], self.metric.first[k], self.metric.second[k]),
                };
                row[2 * (k - 1) + (1 - is_w) + lower - index] = -h * coupling / scale;
            }
        })
        .map_err(|_| LinearFailure)
    }
}

impl NewtonSystem for Collocation<'_> {
    fn residual(&mut self, u: &[f64], out: &mut [f64]) -> Result<(), OutsideDomain> {
        self.evaluate(u)?;
        let h = self.problem.sbp.spacing();
        self.problem.sbp.apply(&self.x, &mut self.slope_x);
        self.problem.sbp.apply(&self.w, &mut self.slope_w);
        for (k, rows) in out.chunks_exact_mut(2).enumerate() {
            let force = acceleration(self.q_t, self.metric.g00[k], self.metric.first[k]);
            rows[0] = h * (self.slope_x[k] - self.w[k]) / self.scale_x;
            rows[1] = h * (self.slope_w[k] - force) / self.scale_w;
        }
        Ok(())
    }

    fn rounding(&mut self, u: &[f64]) -> Option<Vec<(Range<usize>, f64)>> {
        Some(vec![(0..u.len(), ROW_SUM * f64::EPSILON)])
    }

    fn newton_step(&mut self, _: &[f64], residual: &[f64], step: &mut [f64]) -> Result<(), LinearFailure> {
        for (step, r) in step.iter_mut().zip(residual) {
            *step = -r;
        }
        self.solve_linearised(step)
    }

    fn sizes(&self, u: &[f64]) -> [f64; 2] {
        u.chunks_exact(2).fold([0.0, 0.0], |[x, w]: [f64; 2], pair| [x.max(pair[0].abs()), w.max(pair[1].abs())])
    }
}
