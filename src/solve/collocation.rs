//! The collocation system of the physical limit as a banded Newton iteration in (x, w*), then one banded solve for t.

use super::march;
use super::newton::{self, Failure, LinearFailure, NewtonSystem, Root, RoundingLevels};
use super::physical_limit::PhysicalLimit;
use super::problem::Problem;
use super::refinement::{self, Refined};
use super::status::InitialGuess;
use crate::banded::solve_banded;
use crate::case::Case;
use crate::geodesic::{acceleration, acceleration_slope};
use crate::metric::{MetricSamples, OutsideDomain};
use crate::norm::max_abs;
use crate::scalar::{Real, convert};

pub(super) fn solve<S: Real>(problem: &Problem<S>, case: &Case) -> Result<PhysicalLimit<S>, Failure> {
    let max_iterations = case.solver.max_iterations;
    let rough = problem.in_f64(case);
    let (x, w) = march::nystrom(&rough).map_err(march::outside)?;
    let guess: Vec<f64> = x[1..].iter().zip(&w[1..]).flat_map(|(&x, &w)| [x, w]).collect();
    let scales = Scales::new(&rough, &x, &w);
    let mut system = Collocation::new(&*rough, scales, x, w);
    let root = newton::solve(&mut system, guess, max_iterations)?;
    // The system was evaluated last at its root.
    let (history, x, w, g00, spare): (_, Vec<S>, Vec<S>, Vec<S>, Vec<S>);
    if S::IS_EXTENDED {
        let zeros = || vec![S::ZERO; problem.sbp.points()];
        let residual = Collocation::new(problem, scales, zeros(), zeros());
        let mut refined = RefinedCollocation { residual, linearised: system };
        let fine = refinement::refine(&mut refined, root, problem.digits, max_iterations)?;
        let mut system = refined.residual;
        system.evaluate(&fine.unknowns).map_err(march::outside)?;
        (history, x, w, g00, spare) = (fine.history, system.x, system.w, system.metric.g00, system.slope_x);
    } else {
        (history, x, w) = (root.history, convert(system.x), convert(system.w));
        (g00, spare) = (convert(system.metric.g00), convert(system.slope_x));
    }
    let elapsed = integrate(problem, &rough, &g00, spare, max_iterations)?;
    Ok(PhysicalLimit { elapsed, x, x_dot: w, history, initial_guess: InitialGuess::Nystrom4 })
}

/// t − t_i from (Dt)_k = Q_t/g00(x_k) at the first N − 1 nodes, with iterative refinement: one round for `f64`, as many
/// as the digits take for more. `spare` is room for N numbers.
fn integrate<S: Real>(
    problem: &Problem<S>,
    rough: &Problem,
    g00: &[S],
    spare: Vec<S>,
    max_iterations: usize,
) -> Result<Vec<S>, Failure> {
    let unknowns = problem.sbp.points() - 1;
    let (h_q, elapsed) = (problem.sbp.spacing() * problem.invariants().q_t, vec![S::ZERO; unknowns + 1]);
    let mut system = TimeIntegration { problem, rough, h_q, g00, elapsed, slope: spare };
    if S::IS_EXTENDED {
        let start = Root { unknowns: vec![0.0; unknowns], history: Vec::new() };
        let root = refinement::refine(&mut system, start, problem.digits, max_iterations)?;
        system.elapsed[1..].copy_from_slice(&root.unknowns);
        return Ok(system.elapsed);
    }
    let mut right: Vec<f64> = g00[..unknowns].iter().map(|&g00| (h_q / g00).to_f64()).collect();
    for round in 0..2 {
        system.solve_linearised(&mut right).expect("D without its first column and last row is invertible");
        for (t, &correction) in system.elapsed[1..].iter_mut().zip(&right) {
            *t += S::from(correction);
        }
        if round == 0 {
            system.evaluate();
            for (k, r) in right.iter_mut().enumerate() {
                *r = -system.row(k).to_f64();
            }
        }
    }
    Ok(system.elapsed)
}

/// Rows hDt − h Q_t/g00 at the first N − 1 nodes in the unknowns t_k − t_i, k = 2 … N.
struct TimeIntegration<'a, S> {
    problem: &'a Problem<S>,
    rough: &'a Problem,
    h_q: S,
    g00: &'a [S],
    // What was evaluated last.
    elapsed: Vec<S>,
    slope: Vec<S>,
}

impl<S: Real> TimeIntegration<'_, S> {
    fn evaluate(&mut self) {
        self.problem.sbp.apply(&self.elapsed, &mut self.slope);
    }

    fn row(&self, k: usize) -> S {
        self.problem.sbp.spacing() * self.slope[k] - self.h_q / self.g00[k]
    }
}

impl<S: Real> Refined<S> for TimeIntegration<'_, S> {
    fn residual(&mut self, u: &[S], out: &mut [S]) -> Result<(), OutsideDomain> {
        self.elapsed[1..].copy_from_slice(u);
        self.evaluate();
        for (k, row) in out.iter_mut().enumerate() {
            *row = self.row(k);
        }
        Ok(())
    }

    fn solve_linearised(&mut self, right: &mut [f64]) -> Result<(), LinearFailure> {
        let (lower, upper) = reach(self.rough);
        let h = self.rough.sbp.spacing();
        solve_banded(lower, upper, right, |k, row| {
            row.fill(0.0);
            shifted_row(self.rough, k).for_each(|(column, d)| row[column + lower - k] = h * d);
        })
        .map_err(|_| LinearFailure)
    }

    fn rounding(&self, u: &[S]) -> Option<RoundingLevels> {
        Some(vec![(0..u.len(), self.problem.sbp.row_sum() * S::EPSILON.to_f64() * max_abs(u).to_f64())])
    }

    fn sizes(&self, u: &[S]) -> [S; 2] {
        [max_abs(u), S::ZERO]
    }
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

/// What the two kinds of row are divided by, so that one rounding level holds for both.
#[derive(Debug, Clone, Copy)]
struct Scales {
    x: f64,
    w: f64,
}

impl Scales {
    /// From a first guess on the nodes.
    fn new(problem: &Problem, x: &[f64], w: &[f64]) -> Self {
        let h = problem.sbp.spacing();
        let (size_x, size_w) = (max_abs(x), max_abs(w));
        let q_t = problem.invariants().q_t;
        let force = x.iter().fold(0.0_f64, |largest, &x| {
            let g = problem.metric.at(x);
            largest.max(acceleration(q_t, g.g00, g.first).abs())
        });
        // At rest in an equilibrium every scale would vanish; the smallest normal number keeps 0/s at 0.
        let scale = |size: f64, change: f64| (size + h * change).max(f64::MIN_POSITIVE);
        Self { x: scale(size_x, size_w), w: scale(size_w, force) }
    }
}

/// Rows (hDx − h w)/s_x and (hDw − h a(x))/s_w at nodes 1 … N−1 in the unknowns (x_k, w_k), k = 2 … N, interleaved.
struct Collocation<'a, S> {
    problem: &'a Problem<S>,
    q_t: S,
    scales: Scales,
    // What was evaluated last: x and w on all N nodes, the metric and the slopes. Kept, because at a million nodes
    // fresh memory costs more than the arithmetic.
    x: Vec<S>,
    w: Vec<S>,
    metric: MetricSamples<S>,
    slope_x: Vec<S>,
    slope_w: Vec<S>,
}

impl<'a, S: Real> Collocation<'a, S> {
    /// The system, with `x` and `w` as room for N numbers each.
    fn new(problem: &'a Problem<S>, scales: Scales, mut x: Vec<S>, mut w: Vec<S>) -> Self {
        (x[0], w[0]) = (problem.initial.x, problem.initial.x_dot);
        let points = x.len();
        Self {
            problem,
            q_t: problem.invariants().q_t,
            scales,
            x,
            w,
            metric: MetricSamples::zeros(points),
            slope_x: vec![S::ZERO; points],
            slope_w: vec![S::ZERO; points],
        }
    }

    /// Brings x, w and the metric to the unknowns `u`.
    fn evaluate(&mut self, u: &[S]) -> Result<(), OutsideDomain> {
        for ((pair, x), w) in u.chunks_exact(2).zip(&mut self.x[1..]).zip(&mut self.w[1..]) {
            (*x, *w) = (pair[0], pair[1]);
        }
        self.problem.metric.sample_into(&self.x, &mut self.metric)
    }

    /// The rows are scaled for one level to hold for all.
    fn rounding(&self, u: &[S]) -> RoundingLevels {
        vec![(0..u.len(), self.problem.sbp.row_sum() * S::EPSILON.to_f64())]
    }

    /// `out` = F(u).
    fn residual(&mut self, u: &[S], out: &mut [S]) -> Result<(), OutsideDomain> {
        self.evaluate(u)?;
        let h = self.problem.sbp.spacing();
        let (scale_x, scale_w) = (S::from(self.scales.x), S::from(self.scales.w));
        self.problem.sbp.apply(&self.x, &mut self.slope_x);
        self.problem.sbp.apply(&self.w, &mut self.slope_w);
        for (k, rows) in out.chunks_exact_mut(2).enumerate() {
            let force = acceleration(self.q_t, self.metric.g00[k], self.metric.first[k]);
            rows[0] = h * (self.slope_x[k] - self.w[k]) / scale_x;
            rows[1] = h * (self.slope_w[k] - force) / scale_w;
        }
        Ok(())
    }
}

/// Largest |x| and |w| of interleaved unknowns.
fn sizes<S: Real>(u: &[S]) -> [S; 2] {
    u.chunks_exact(2).fold([S::ZERO; 2], |[x, w], pair| [x.max(pair[0].abs()), w.max(pair[1].abs())])
}

impl Collocation<'_, f64> {
    /// Overwrites `right` with J⁻¹ `right` for the Jacobian J at what was evaluated last.
    fn solve_linearised(&self, right: &mut [f64]) -> Result<(), LinearFailure> {
        let h = self.problem.sbp.spacing();
        let (lower, upper) = reach(self.problem);
        // Two fields a node; the coupling of w to x of the node before reaches three below the diagonal.
        let (lower, upper) = ((2 * lower).max(3), 2 * upper);
        solve_banded(lower, upper, right, |index, row| {
            row.fill(0.0);
            let (k, is_w) = (index / 2, index % 2);
            let scale = if is_w == 1 { self.scales.w } else { self.scales.x };
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

impl NewtonSystem for Collocation<'_, f64> {
    fn residual(&mut self, u: &[f64], out: &mut [f64]) -> Result<(), OutsideDomain> {
        Collocation::residual(self, u, out)
    }

    fn rounding(&self, u: &[f64]) -> Option<RoundingLevels> {
        Some(Collocation::rounding(self, u))
    }

    fn newton_step(&mut self, _: &[f64], residual: &[f64], step: &mut [f64]) -> Result<(), LinearFailure> {
        for (step, r) in step.iter_mut().zip(residual) {
            *step = -r;
        }
        self.solve_linearised(step)
    }

    fn sizes(&self, u: &[f64]) -> [f64; 2] {
        sizes(u)
    }
}

/// The residual with all digits, the Jacobian at the `f64` root.
///
/// The Jacobian is eliminated anew in every round: that is cheap beside an extended residual, and keeps the elimination
/// in one pass without a stored factor L.
struct RefinedCollocation<'a, S> {
    residual: Collocation<'a, S>,
    linearised: Collocation<'a, f64>,
}

impl<S: Real> Refined<S> for RefinedCollocation<'_, S> {
    fn residual(&mut self, u: &[S], out: &mut [S]) -> Result<(), OutsideDomain> {
        self.residual.residual(u, out)
    }

    fn solve_linearised(&mut self, right: &mut [f64]) -> Result<(), LinearFailure> {
        self.linearised.solve_linearised(right)
    }

    fn rounding(&self, u: &[S]) -> Option<RoundingLevels> {
        Some(self.residual.rounding(u))
    }

    fn sizes(&self, u: &[S]) -> [S; 2] {
        sizes(u)
    }
}
