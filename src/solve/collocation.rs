//! The collocation system of the physical limit as a banded Newton iteration in (x, w*), then one banded solve for t.

use super::march;
use super::newton::{self, Failure, LinearFailure, NewtonSystem};
use super::physical_limit::PhysicalLimit;
use super::problem::Problem;
use super::status::InitialGuess;
use crate::action::max_abs;
use crate::banded::{BandedLu, BandedMatrix};
use crate::geodesic::{acceleration, acceleration_slope};
use crate::metric::{MetricSamples, OutsideDomain};

/// Rounding units of hDu: the absolute coefficients of a boundary row of hD sum to less than 4.
const ROW_SUM: f64 = 4.0;

pub(super) fn solve(problem: &Problem, max_iterations: usize) -> Result<PhysicalLimit, Failure> {
    let (x, w) = march::nystrom(problem).map_err(march::outside)?;
    let mut system = Collocation::new(problem, &x, &w);
    let guess: Vec<f64> = x[1..].iter().zip(&w[1..]).flat_map(|(&x, &w)| [x, w]).collect();
    drop((x, w));
    let root = newton::solve(&mut system, guess, max_iterations)?;
    let (x, x_dot) = system.nodes(&root.unknowns);
    let metric = problem.metric.sample(&x).expect("an accepted iterate lies inside the domain");
    let elapsed = integrate(problem, &metric);
    Ok(PhysicalLimit { elapsed, x, x_dot, history: root.history, initial_guess: InitialGuess::Nystrom4 })
}

/// t − t_i from (Dt)_k = Q_t/g00(x_k) at the first N − 1 nodes, with one step of iterative refinement.
fn integrate(problem: &Problem, metric: &MetricSamples) -> Vec<f64> {
    let h = problem.sbp.spacing();
    let q_t = problem.invariants().q_t;
    let unknowns = problem.sbp.points() - 1;
    let lu = shifted(problem, 1, |matrix, k, column, d| matrix.add(k, column, h * d))
        .factor()
        .expect("D without its first column and last row is invertible");
    let mut right: Vec<f64> = metric.g00[..unknowns].iter().map(|g00| h * q_t / g00).collect();
    let mut elapsed = vec![0.0; unknowns + 1];
    let target = right.clone();
    for _ in 0..2 {
        lu.solve_in_place(&mut right);
        for (t, correction) in elapsed[1..].iter_mut().zip(&right) {
            *t += correction;
        }
        let slope = problem.sbp.derivative(&elapsed);
        for ((r, goal), slope) in right.iter_mut().zip(&target).zip(&slope) {
            *r = goal - h * slope;
        }
    }
    elapsed
}

/// A banded matrix with room for the first N − 1 rows of D without the first column, `fields` unknowns a node
/// interleaved and coupled within a row; `fill` is called for each of D's entries with (row, column) counted that way.
fn shifted(
    problem: &Problem,
    fields: usize,
    mut fill: impl FnMut(&mut BandedMatrix, usize, usize, f64),
) -> BandedMatrix {
    let unknowns = problem.sbp.points() - 1;
    let entries =
        |k: usize| problem.sbp.row(k).filter(|&(column, _)| column > 0).map(move |(column, d)| (k, column - 1, d));
    // The rows of the closures and one between them show every offset that occurs.
    let closure = problem.sbp.closure_rows();
    let (lower, upper) =
        (0..=closure).chain(unknowns - closure..unknowns).flat_map(entries).fold((1, 0), |(l, u), (row, column, _)| {
            (row.saturating_sub(column).max(l), column.saturating_sub(row).max(u))
        });
    // The coupling between two fields of neighbouring nodes reaches 2·fields − 1 below the diagonal.
    let mut matrix = BandedMatrix::zeros(fields * unknowns, (fields * lower).max(2 * fields - 1), fields * upper);
    for (row, column, d) in (0..unknowns).flat_map(entries) {
        fill(&mut matrix, row, column, d);
    }
    matrix
}

/// Rows (hDx − h w)/s_x and (hDw − h a(x))/s_w at nodes 1 … N−1 in the unknowns (x_k, w_k), k = 2 … N, interleaved.
/// The scales s_x and s_w make one rounding level hold for both kinds of row.
struct Collocation<'a> {
    problem: &'a Problem,
    q_t: f64,
    scale_x: f64,
    scale_w: f64,
}

impl<'a> Collocation<'a> {
    fn new(problem: &'a Problem, x: &[f64], w: &[f64]) -> Self {
        let h = problem.sbp.spacing();
        let (size_x, size_w) = (max_abs(x), max_abs(w));
        // At rest in an equilibrium every scale would vanish; the smallest normal number keeps 0/s at 0.
        let scale_x = (size_x + h * size_w).max(f64::MIN_POSITIVE);
        let q_t = problem.invariants().q_t;
        let force = x.iter().fold(0.0_f64, |largest, &x| {
            let g = problem.metric.at(x);
            largest.max(acceleration(q_t, g.g00, g.first).abs())
        });
        let scale_w = (size_w + h * force).max(f64::MIN_POSITIVE);
        Self { problem, q_t, scale_x, scale_w }
    }

    /// x and w on all N nodes.
    fn nodes(&self, u: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let initial = self.problem.initial;
        let x = std::iter::once(initial.x).chain(u.iter().step_by(2).copied()).collect();
        let w = std::iter::once(initial.x_dot).chain(u.iter().skip(1).step_by(2).copied()).collect();
        (x, w)
    }

    fn factor(&self, metric: &MetricSamples) -> Result<BandedLu, LinearFailure> {
        let h = self.problem.sbp.spacing();
        let mut jacobian = shifted(self.problem, 2, |matrix, row, column, d| {
            matrix.add(2 * row, 2 * column, h * d / self.scale_x);
            matrix.add(2 * row + 1, 2 * column + 1, h * d / self.scale_w);
        });
        for k in 1..self.problem.sbp.points() - 1 {
            let slope = acceleration_slope(self.q_t, metric.g00[k], metric.first[k], metric.second[k]);
            jacobian.add(2 * k, 2 * (k - 1) + 1, -h / self.scale_x);
            jacobian.add(2 * k + 1, 2 * (k - 1), -h * slope / self.scale_w);
        }
        jacobian.factor().map_err(|_| LinearFailure)
    }
}

impl NewtonSystem for Collocation<'_> {
    fn residual(&self, u: &[f64], out: &mut [f64]) -> Result<(), OutsideDomain> {
        let h = self.problem.sbp.spacing();
        let (x, w) = self.nodes(u);
        let metric = self.problem.metric.sample(&x)?;
        let slope_x = self.problem.sbp.derivative(&x);
        let slope_w = self.problem.sbp.derivative(&w);
        for (k, rows) in out.chunks_exact_mut(2).enumerate() {
            rows[0] = h * (slope_x[k] - w[k]) / self.scale_x;
            rows[1] = h * (slope_w[k] - acceleration(self.q_t, metric.g00[k], metric.first[k])) / self.scale_w;
        }
        Ok(())
    }

    fn rounding(&self, _: &[f64]) -> f64 {
        ROW_SUM * f64::EPSILON
    }

    fn newton_step(&mut self, u: &[f64], residual: &[f64], step: &mut [f64]) -> Result<(), LinearFailure> {
        let (x, _) = self.nodes(u);
        let metric = self.problem.metric.sample(&x).map_err(|_| LinearFailure)?;
        let lu = self.factor(&metric)?;
        for (step, r) in step.iter_mut().zip(residual) {
            *step = -r;
        }
        lu.solve_in_place(step);
        Ok(())
    }

    fn coordinates<'u>(&self, u: &'u [f64]) -> &'u [f64] {
        u
    }
}
