//! The first guess for the doubled action, made only of small doubled actions.
//!
//! Newton's method from a straight line finds the critical point of a short world-line, not of a long one. So the
//! world-line is cut into windows of a few nodes. Each is the critical point of its own action, found from the
//! straight line along its initial tangent; the next window starts where this one ends. Its end tangent is corrected
//! by the multipliers of the end constraints, ṫ = (Dt)_N + λ7/(H_N g00) and ẋ = (Dx)_N − λ8/H_N, because the last
//! node takes up the action's compatibility defect. That correction also measures the window's error: a window that
//! fails or needs a large correction is halved, one that does neither is followed by a longer one. O(N).
//!
//! Windows are of the strong form whatever the form of the whole: both approximate the same world-line, this guess is
//! of t and x on the nodes only, and it need not be more exact than [`LARGEST_DEFECT`].

use std::collections::HashMap;

use super::critical_point::CriticalPointSolver;
use super::newton::{Failure, Root};
use super::problem::Problem;
use crate::action::Form;
use crate::action::{DoubledAction, Layout};
use crate::geodesic::InitialData;
use crate::sbp::{SbpName, SbpOperator};

/// Steps of a window; it has one node more, which every operator with banded closures accepts.
const WINDOW_STEPS: usize = 8;
/// Steps of the equidistant grid for each of a spectral element.
const FINER: usize = 4;
/// Positions are counted in this fraction of the grid spacing; it bounds how far a failing window is halved.
const UNITS_PER_STEP: usize = 64;
/// A window that needs more iterations than this is too long.
const WINDOW_ITERATIONS: usize = 12;
/// A window is accepted if its end correction is at most this share of the tangent (or it cannot be halved) …
const LARGEST_DEFECT: f64 = 1e-4;
/// … and all windows together may correct it by at most this share: on a long run small errors of the tangent add up to
/// a phase that Newton's method does not recover from.
const DEFECT_OF_RUN: f64 = 1e-2;
/// A window whose correction is below this share of its limit is followed by one twice as long.
const LENGTHENING: f64 = 0.1;

/// A window failed even at the smallest step.
pub(super) struct WindowFailure {
    pub(super) failure: Box<Failure>,
    /// Where the window started.
    pub(super) start: InitialData,
    /// γ at the window's first node, and its spacing.
    pub(super) gamma: f64,
    pub(super) spacing: f64,
}

/// A solved window, with what the next one starts from.
struct Window {
    root: Root,
    end: InitialData,
    /// |end correction| of (ṫ, ẋ) over the largest |ṫ|, |ẋ| met so far.
    defect: f64,
}

/// The operator and the factorisation pattern of windows of one spacing.
struct WindowGrid {
    sbp: SbpOperator,
    solver: CriticalPointSolver,
}

impl WindowGrid {
    fn new(problem: &Problem, spacing: f64) -> Self {
        // A guess needs no high order, and the closures of high orders do not fit into a window.
        let name = if problem.sbp.is_two_step() { SbpName::Sbp21 } else { SbpName::Sbp42 };
        let sbp = name.operator(WINDOW_STEPS + 1, spacing).expect("a window has enough points");
        let solver = CriticalPointSolver::new(&DoubledAction::new(
            &sbp,
            &*problem.metric,
            problem.initial.start(&problem.metric),
        ));
        Self { sbp, solver }
    }

    fn solve(&self, problem: &Problem, start: InitialData, largest_x_dot: &mut f64) -> Result<Window, Failure> {
        let action = DoubledAction::new(&self.sbp, &*problem.metric, start.start(&problem.metric));
        let root = self.solver.solve(&action, straight_line(&action), WINDOW_ITERATIONS)?;
        let layout = action.layout();
        let [t, x] = [0, 1].map(|a| layout.values(&root.unknowns, 0, a));
        let lambda = layout.multipliers(&root.unknowns);
        let last = WINDOW_STEPS;
        let weight = self.sbp.weights()[last];
        let slope = |u: &[f64]| self.sbp.derivative_at(u, last);
        let g00 = problem.metric.at(x[last]).g00;
        let (t_correction, x_correction) = (lambda[6] / (weight * g00), -lambda[7] / weight);
        let end =
            InitialData { t: t[last], x: x[last], t_dot: slope(t) + t_correction, x_dot: slope(x) + x_correction };
        // Not relative to this window's ẋ alone, which vanishes at a turning point.
        *largest_x_dot = largest_x_dot.max(start.x_dot.abs()).max(end.x_dot.abs());
        let share = |correction: f64, size: f64| if correction == 0.0 { 0.0 } else { (correction / size).abs() };
        let defect = share(t_correction, end.t_dot).max(share(x_correction, *largest_x_dot));
        Ok(Window { root, end, defect })
    }
}

/// (t_i + ṫ_i γ, x_i + ẋ_i γ) on both branches, multipliers zero: the gradient is linear in them, so a first full
/// Newton step finds them from anywhere.
fn straight_line(action: &DoubledAction<'_>) -> Vec<f64> {
    let nodes = (0..action.sbp().points()).map(|k| k as f64 * action.sbp().spacing());
    let start = action.initial().q.iter().zip(&action.initial().q_dot);
    let lines: Vec<Vec<f64>> = start.map(|(q, q_dot)| nodes.clone().map(|gamma| q + q_dot * gamma).collect()).collect();
    let rows: Vec<&[f64]> = lines.iter().map(Vec::as_slice).collect();
    action.layout().physical_limit(&rows, &vec![0.0; action.layout().multiplier_range().len()])
}

/// A guess for all unknowns of the problem's action.
pub(super) fn windowed_action(problem: &Problem) -> Result<Vec<f64>, WindowFailure> {
    let nodes = problem.sbp.points();
    // Nodes that are not equidistant take their values from a finer grid that is.
    let points = if problem.sbp.is_equidistant() { nodes } else { FINER * (nodes - 1) + 1 };
    let spacing = problem.length / (points - 1) as f64;
    let end = (points - 1) * UNITS_PER_STEP;
    let mut t = vec![problem.initial.t; points];
    let mut x = vec![problem.initial.x; points];
    let mut start = problem.initial;
    let mut multipliers = [0.0; 8];
    let (mut position, mut units) = (0, UNITS_PER_STEP);
    let mut grids = HashMap::new();
    let mut largest_x_dot = 0.0;
    while position < end {
        // The window must not look beyond the end: there may be a horizon.
        while units * WINDOW_STEPS > end - position {
            units /= 2;
        }
        let grid = grids
            .entry(units)
            .or_insert_with(|| WindowGrid::new(problem, spacing * units as f64 / UNITS_PER_STEP as f64));
        let acceptable = LARGEST_DEFECT.min(DEFECT_OF_RUN * (WINDOW_STEPS * units) as f64 / end as f64);
        match grid.solve(problem, start, &mut largest_x_dot) {
            Ok(window) if window.defect > acceptable && units > 1 => units /= 2,
            Ok(window) => {
                let layout = Layout::new(2, WINDOW_STEPS + 1, Form::Strong);
                let [forward_t, forward_x] = [0, 1].map(|a| layout.values(&window.root.unknowns, 0, a));
                for step in 1..=WINDOW_STEPS {
                    let at = position + step * units;
                    if at % UNITS_PER_STEP == 0 {
                        t[at / UNITS_PER_STEP] = forward_t[step];
                        x[at / UNITS_PER_STEP] = forward_x[step];
                    }
                }
                multipliers.copy_from_slice(layout.multipliers(&window.root.unknowns));
                start = window.end;
                position += WINDOW_STEPS * units;
                let accurate = window.defect <= LENGTHENING * acceptable;
                // A longer window must still have its nodes on the grid.
                if accurate && units < UNITS_PER_STEP && position.is_multiple_of(2 * units) {
                    units *= 2;
                }
            }
            Err(_) if units > 1 => units /= 2,
            Err(failure) => {
                let per_unit = spacing / UNITS_PER_STEP as f64;
                return Err(WindowFailure {
                    failure: Box::new(failure),
                    start,
                    gamma: problem.gamma_i + position as f64 * per_unit,
                    spacing: units as f64 * per_unit,
                });
            }
        }
    }
    if !problem.sbp.is_equidistant() {
        let at = |values: &[f64], node: usize| {
            let place = problem.sbp.node(node) / spacing;
            let k = (place as usize).min(points - 2);
            values[k] + (place - k as f64) * (values[k + 1] - values[k])
        };
        (t, x) = (0..nodes).map(|node| (at(&t, node), at(&x, node))).unzip();
    }
    let multipliers = match problem.form {
        Form::Strong => multipliers.as_slice(),
        Form::Weak => &[],
    };
    Ok(problem.layout().physical_limit(&[&t, &x], multipliers))
}
