//! The collocation system of the physical limit as a banded Newton iteration in (x, w*), then one banded solve for t.
//!
//! Both forms of the action have one; they differ in which nodes are unknown and in how the initial values enter, which
//! [`FormDerivative`] knows.

use super::arithmetic::Arithmetic;
use super::derivative::FormDerivative;
use super::march;
use super::newton::{self, Failure, LinearFailure, NewtonSystem, Root, RoundingLevels};
use super::physical_limit::PhysicalLimit;
use super::problem::Problem;
use super::quadrature::Integral;
use super::refinement::{self, Refined};
use super::setup::Setup;
use super::status::{InitialGuess, IterationRecord};
use crate::banded::solve_banded;
use crate::geodesic::{acceleration, acceleration_slope};
use crate::metric::{MetricSamples, OutsideDomain};
use crate::norm::max_abs;
use crate::scalar::Real;

pub(super) fn solve<S: Arithmetic>(problem: &Problem<S>, setup: &Setup<S>) -> Result<PhysicalLimit<S>, Failure> {
    let max_iterations = setup.max_iterations;
    let rough = S::rough_problem(problem, setup);
    let (x, w) = march::nystrom(&rough).map_err(march::outside)?;
    let first = rough.derivative().first_unknown();
    let guess: Vec<f64> = x[first..].iter().zip(&w[first..]).flat_map(|(&x, &w)| [x, w]).collect();
    let scales = Scales::new(&rough, &x, &w);
    let mut system = Collocation::new(&*rough, scales, x, w);
    let root = newton::solve(&mut system, guess, max_iterations)?;
    // The system was evaluated last at its root.
    let (system, history) = S::collocated(system, root, problem, setup)?;
    let (h_q, g00) = (problem.sbp.spacing() * problem.invariants().q_t, &system.metric.g00);
    let integral = Integral { derivative: problem.derivative(), rough: rough.derivative(), digits: problem.digits };
    let elapsed = integral.of(|k| h_q / g00[k], system.slope_x, max_iterations)?;
    Ok(PhysicalLimit { elapsed, x: system.x, x_dot: system.w, history, initial_guess: InitialGuess::Nystrom4 })
}

/// The system of `problem` at its root, by refinement of the `root` of the system `linearised` there.
pub(super) fn refined<'a, S: Real>(
    linearised: Collocation<'a, f64>,
    root: Root,
    problem: &'a Problem<S>,
    max_iterations: usize,
) -> Result<(Collocation<'a, S>, Vec<IterationRecord>), Failure> {
    let zeros = || vec![S::ZERO; problem.sbp.points()];
    let residual = Collocation::new(problem, linearised.scales, zeros(), zeros());
    let mut refined = RefinedCollocation { residual, linearised };
    let fine = refinement::refine(&mut refined, root, problem.digits, max_iterations)?;
    let mut system = refined.residual;
    system.evaluate(&fine.unknowns).map_err(march::outside)?;
    Ok((system, fine.history))
}

/// Entries of the Jacobian, divided by this, stay far from overflow.
const LEAST_SCALE: f64 = 1e-280;

/// The divisors of the two kinds of row, so that one rounding level holds for both.
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
        // At rest in an equilibrium there is no scale.
        let scale = |size: f64, change: f64| match size + h * change {
            0.0 => 1.0,
            scale => scale.max(LEAST_SCALE),
        };
        Self { x: scale(size_x, size_w), w: scale(size_w, force) }
    }
}

/// Rows (h dx/dγ − h w)/s_x and (h dw/dγ − h a(x))/s_w in the unknown (x_k, w_k), both interleaved: at nodes 1 … N−1
/// for k = 2 … N in the strong form, at all nodes for all k in the weak one.
pub(super) struct Collocation<'a, S> {
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

    /// Updates x, w and the metric to the unknowns `u`.
    fn evaluate(&mut self, u: &[S]) -> Result<(), OutsideDomain> {
        let first = self.problem.derivative().first_unknown();
        for ((pair, x), w) in u.chunks_exact(2).zip(&mut self.x[first..]).zip(&mut self.w[first..]) {
            (*x, *w) = (pair[0], pair[1]);
        }
        self.problem.metric.sample_into(&self.x, &mut self.metric)
    }

    /// The rows are scaled so that one level holds for all.
    fn rounding(&self, u: &[S]) -> RoundingLevels {
        vec![(0..u.len(), self.problem.sbp.row_sum() * S::EPSILON.to_f64())]
    }

    /// `out` = F(u).
    fn residual(&mut self, u: &[S], out: &mut [S]) -> Result<(), OutsideDomain> {
        self.evaluate(u)?;
        let h = self.problem.sbp.spacing();
        let (scale_x, scale_w) = (S::from(self.scales.x), S::from(self.scales.w));
        let (derivative, initial) = (self.problem.derivative(), self.problem.initial);
        derivative.apply(&self.x, initial.x, &mut self.slope_x);
        derivative.apply(&self.w, initial.x_dot, &mut self.slope_w);
        for (k, rows) in out.chunks_exact_mut(2).enumerate() {
            let force = acceleration(self.q_t, self.metric.g00[k], self.metric.first[k]);
            rows[0] = h * (self.slope_x[k] - self.w[k]) / scale_x;
            rows[1] = h * (self.slope_w[k] - force) / scale_w;
        }
        Ok(())
    }
}

/// Largest |x| and |w| of interleaved unknowns.
fn sizes<S: Real>(u: &[S]) -> Vec<S> {
    u.chunks_exact(2).fold([S::ZERO; 2], |[x, w], pair| [x.max(pair[0].abs()), w.max(pair[1].abs())]).to_vec()
}

impl Collocation<'_, f64> {
    /// Overwrites `right` with J⁻¹ `right` for the Jacobian J at what was evaluated last.
    fn solve_linearised(&self, right: &mut [f64]) -> Result<(), LinearFailure> {
        let h = self.problem.sbp.spacing();
        let derivative: FormDerivative<'_, f64> = self.problem.derivative();
        let (first, (lower, upper)) = (derivative.first_unknown(), derivative.reach());
        // Two fields a node. Rows of node k stand beside the unknowns of node k + first, so their coupling to w and x
        // of node k reaches 2 first + 1 below the diagonal, and 1 above it if first is 0.
        let (lower, upper) = ((2 * lower).max(2 * first + 1), (2 * upper).max(1 - first));
        solve_banded(lower, upper, right, |index, row| {
            row.fill(0.0);
            let (k, is_w) = (index / 2, index % 2);
            let scale = if is_w == 1 { self.scales.w } else { self.scales.x };
            derivative.row(k).for_each(|(column, d)| row[2 * column + is_w + lower - index] += h * d / scale);
            // In the strong form the first node is given: it has no unknowns to couple to.
            if k >= first {
                let coupling = match is_w {
                    0 => 1.0,
                    _ => acceleration_slope(self.q_t, self.metric.g00[k], self.metric.first[k], self.metric.second[k]),
                };
                row[2 * (k - first) + (1 - is_w) + lower - index] = -h * coupling / scale;
            }
        })
        .map_err(|_| LinearFailure)
    }
}

impl NewtonSystem for Collocation<'_, f64> {
    type Outside = OutsideDomain;

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

    fn sizes(&self, u: &[f64]) -> Vec<f64> {
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
    type Outside = OutsideDomain;

    fn residual(&mut self, u: &[S], out: &mut [S]) -> Result<(), OutsideDomain> {
        self.residual.residual(u, out)
    }

    fn solve_linearised(&mut self, right: &mut [f64]) -> Result<(), LinearFailure> {
        self.linearised.solve_linearised(right)
    }

    fn rounding(&self, u: &[S]) -> Option<RoundingLevels> {
        Some(self.residual.rounding(u))
    }

    fn sizes(&self, u: &[S]) -> Vec<S> {
        sizes(u)
    }
}
