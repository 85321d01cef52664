//! Explicit recursions in γ: the two-step rule that SBP21's collocation system is, and Nyström's method for first
//! guesses.

use super::newton::Failure;
use super::physical_limit::PhysicalLimit;
use super::problem::Problem;
use super::status::{InitialGuess, Status};
use crate::geodesic::acceleration;
use crate::metric::OutsideDomain;
use crate::norm::max_abs;
use crate::scalar::Real;

/// SBP21: one Euler step, then x_{k+1} = x_{k−1} + 2h w_k, likewise w and t. One evaluation of the potential a node.
///
/// Exact Q_t says nothing about x here: the rule carries a computational (−1)^k mode, neutral only while hω < 1.
pub(super) fn two_step<S: Real>(problem: &Problem<S>) -> Result<PhysicalLimit<S>, Failure> {
    let points = problem.sbp.points();
    let h = problem.sbp.spacing();
    let q_t = problem.invariants().q_t;
    let mut elapsed = vec![S::ZERO; points];
    let two_h = h + h;
    let mut x = vec![problem.initial.x; points];
    let mut w = vec![problem.initial.x_dot; points];
    for k in 0..points - 1 {
        let g = problem.metric.at(x[k]);
        if !(g.is_inside() && x[k].is_finite()) {
            return Err(outside(OutsideDomain { index: k, x: x[k].to_f64(), g00: g.g00.to_f64() }));
        }
        let (from, step) = if k == 0 { (0, h) } else { (k - 1, two_h) };
        elapsed[k + 1] = elapsed[from] + step * (q_t / g.g00);
        x[k + 1] = x[from] + step * w[k];
        w[k + 1] = w[from] + step * acceleration(q_t, g.g00, g.first);
    }
    let g = problem.metric.at(x[points - 1]);
    if !g.is_inside() {
        return Err(outside(OutsideDomain { index: points - 1, x: x[points - 1].to_f64(), g00: g.g00.to_f64() }));
    }
    Ok(PhysicalLimit { elapsed, x, x_dot: w, history: Vec::new(), initial_guess: InitialGuess::None })
}

/// A recursion that ended at a point outside the domain.
pub(super) fn outside(point: OutsideDomain) -> Failure {
    Failure { outside: Some(point), ..Failure::without_iterate(Status::OutsideDomain) }
}

/// Most sub-steps a node interval is divided into.
const MOST_SUBSTEPS: usize = 64;
/// Halving the step may change x by this share of its size; Newton's method does the rest.
const GUESS_TOLERANCE: f64 = 1e-4;

/// x and dx/dγ on the nodes by Nyström's classical method of order four (E. J. Nyström, Acta Soc. Sci. Fenn. 50
/// (1925)).
///
/// The step, at first two node intervals, is halved until that changes nothing that matters, so the guess is close to
/// the geodesic however coarse the grid is. It also tells a geodesic that leaves the domain from a coarse step that
/// jumps out of it: only what happens with ever finer steps is believed.
pub(super) fn nystrom(problem: &Problem) -> Result<(Vec<f64>, Vec<f64>), OutsideDomain> {
    // Every second node; the last interval is left out if their number is odd.
    let mut coarse = nystrom_with(problem, 2, 1);
    let mut coarse_stride = 2;
    let mut substeps = 1;
    loop {
        let fine = nystrom_with(problem, 1, substeps);
        let settled = match (&coarse, &fine) {
            (Ok((before, _)), Ok((after, _))) => {
                let change = before
                    .iter()
                    .zip(after.iter().step_by(coarse_stride))
                    .fold(0.0_f64, |change, (a, b)| change.max((a - b).abs()));
                change <= GUESS_TOLERANCE * max_abs(after)
            }
            _ => false,
        };
        if settled || substeps == MOST_SUBSTEPS {
            return fine;
        }
        (coarse, coarse_stride) = (fine, 1);
        substeps *= 2;
    }
}

/// Every `stride`-th node, with `substeps` steps from one to the next.
fn nystrom_with(problem: &Problem, stride: usize, substeps: usize) -> Result<(Vec<f64>, Vec<f64>), OutsideDomain> {
    let intervals = (problem.sbp.points() - 1) / stride;
    let q_t = problem.invariants().q_t;
    let force = |interval: usize, x: f64| {
        let g = problem.metric.at(x);
        let outside = OutsideDomain { index: interval * stride, x, g00: g.g00 };
        if g.is_inside() { Ok(acceleration(q_t, g.g00, g.first)) } else { Err(outside) }
    };
    let (mut xs, mut ws) = (Vec::with_capacity(intervals + 1), Vec::with_capacity(intervals + 1));
    let (mut x, mut w) = (problem.initial.x, problem.initial.x_dot);
    xs.push(x);
    ws.push(w);
    for k in 1..=intervals {
        let from = (k - 1) * stride;
        let length = (from..from + stride).fold(0.0, |length, k| length + problem.sbp.interval(k));
        let h = length / substeps as f64;
        for _ in 0..substeps {
            let k1 = force(k - 1, x)?;
            let k2 = force(k, x + h * (0.5 * w + 0.125 * h * k1))?;
            let k3 = force(k, x + h * (w + 0.5 * h * k2))?;
            x += h * (w + h * (k1 + 2.0 * k2) / 6.0);
            w += h * (k1 + 4.0 * k2 + k3) / 6.0;
        }
        xs.push(x);
        ws.push(w);
    }
    force(intervals, x)?;
    Ok((xs, ws))
}
