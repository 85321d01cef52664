//! The first guess for the doubled action, made only of small doubled actions.
//!
//! Newton's method from a straight line finds the critical point of a short world-line, not of a long one. So the
//! world-line is cut into windows of a few nodes. Each is the critical point of its own action, found from the
//! straight line along its initial tangent; the next window starts where this one ends. Its end tangent is corrected
//! by the multipliers of the end constraints, q̇^a = (Dq^a)_N + g^ab κ_b/H_N, because the last node takes up the
//! action's compatibility defect. That correction also measures the window's error: a window that
//! fails or needs a large correction is halved, one that does neither is followed by a longer one. O(N).
//!
//! Windows are of the strong form whatever the form of the whole: both approximate the same world-line, this guess is
//! of the coordinates on the nodes only, and it need not be more exact than [`LARGEST_DEFECT`].

use std::collections::HashMap;

use super::critical_point::CriticalPointSolver;
use super::newton::{Failure, Root};
use crate::action::{DoubledAction, Form, Layout};
use crate::geometry::{Dynamics, Start};
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
/// The rate of any other coordinate counts as this share of its largest one at least.
const LEAST_RATE: f64 = 1e-3;
/// A window whose correction is below this share of its limit is followed by one twice as long.
const LENGTHENING: f64 = 0.1;

/// A window failed even at the smallest step.
pub(super) struct WindowFailure<O> {
    pub(super) failure: Box<Failure<O>>,
    /// Where the window started.
    pub(super) start: Start,
    /// γ at the window's first node, from the start of the whole, and its spacing.
    pub(super) gamma: f64,
    pub(super) spacing: f64,
}

/// A solved window, with what the next one starts from.
struct Window {
    root: Root,
    end: Start,
    /// |end correction| of q̇ relative to the size of q̇: the largest over the coordinates.
    defect: f64,
}

/// The whole that a guess is wanted for.
struct Whole<'a, L> {
    action: &'a DoubledAction<'a, f64, L>,
    lagrangian: &'a L,
}

/// The operator and the factorisation pattern of windows of one spacing.
struct WindowGrid {
    sbp: SbpOperator,
    solver: CriticalPointSolver,
}

impl WindowGrid {
    fn new<L: Dynamics<f64>>(whole: &Whole<'_, L>, spacing: f64) -> Self {
        // A guess needs no high order, and the closures of high orders do not fit into a window.
        let name = if whole.action.sbp().is_two_step() { SbpName::Sbp21 } else { SbpName::Sbp42 };
        let sbp = name.operator(WINDOW_STEPS + 1, spacing).expect("a window has enough points");
        let start = whole.action.initial().clone();
        let solver = CriticalPointSolver::new(&DoubledAction::new(&sbp, whole.lagrangian, start));
        Self { sbp, solver }
    }

    fn solve<L: Dynamics<f64>>(
        &self,
        whole: &Whole<'_, L>,
        start: &Start,
        largest_q_dot: &mut [f64],
    ) -> Result<Window, Failure<L::Outside>> {
        let action = DoubledAction::new(&self.sbp, whole.lagrangian, start.clone());
        let root = self.solver.solve(&action, straight_line(&action), WINDOW_ITERATIONS)?;
        let (layout, last) = (action.layout(), WINDOW_STEPS);
        let coordinates = 0..layout.dimension();
        let multipliers = layout.multipliers(&root.unknowns);
        let kappa: Vec<f64> = coordinates.clone().map(|a| multipliers[layout.kappa(a)]).collect();
        let forward = layout.branch(&root.unknowns, 0);
        let q: Vec<f64> = forward.iter().map(|row| row[last]).collect();
        let corrections = whole.lagrangian.raise(&q, &kappa, self.sbp.weights()[last]);
        let slopes = forward.iter().map(|row| self.sbp.derivative_at(row, last));
        let q_dot: Vec<f64> = slopes.zip(&corrections).map(|(slope, correction)| slope + correction).collect();
        let (mut defect, structure) = (0.0_f64, whole.lagrangian.structure());
        for a in coordinates {
            let (correction, here) = (corrections[a], q_dot[a].abs());
            largest_q_dot[a] = largest_q_dot[a].max(start.q_dot[a].abs()).max(here);
            // A coordinate that the Lagrangian depends on turns somewhere: there this window's q̇ alone vanishes.
            let turns = structure.first.iter().any(|term| term.by == [a]);
            let size = if turns { largest_q_dot[a] } else { here.max(LEAST_RATE * largest_q_dot[a]) };
            defect = defect.max(if correction == 0.0 { 0.0 } else { (correction / size).abs() });
        }
        // The strong form needs no momenta of the start.
        Ok(Window { root, end: Start { q, q_dot, p: start.p.clone() }, defect })
    }
}

/// q_i + q̇_i γ on both branches, multipliers zero: the gradient is linear in them, so a first full Newton step finds
/// them from anywhere.
fn straight_line<L: Dynamics<f64>>(action: &DoubledAction<'_, f64, L>) -> Vec<f64> {
    let nodes = (0..action.sbp().points()).map(|k| k as f64 * action.sbp().spacing());
    let start = action.initial().q.iter().zip(&action.initial().q_dot);
    let lines: Vec<Vec<f64>> = start.map(|(q, q_dot)| nodes.clone().map(|gamma| q + q_dot * gamma).collect()).collect();
    let rows: Vec<&[f64]> = lines.iter().map(Vec::as_slice).collect();
    action.layout().physical_limit(&rows, &vec![0.0; action.layout().multiplier_range().len()])
}

/// A guess for all unknowns of `action`, over the given length of γ.
pub(super) fn windowed_action<L: Dynamics<f64>>(
    action: &DoubledAction<'_, f64, L>,
    lagrangian: &L,
    length: f64,
) -> Result<Vec<f64>, WindowFailure<L::Outside>> {
    let (sbp, whole) = (action.sbp(), Whole { action, lagrangian });
    let nodes = sbp.points();
    // Nodes that are not equidistant take their values from a finer grid that is.
    let points = if sbp.is_equidistant() { nodes } else { FINER * (nodes - 1) + 1 };
    let spacing = length / (points - 1) as f64;
    let end = (points - 1) * UNITS_PER_STEP;
    let mut start = action.initial().clone();
    let mut rows: Vec<Vec<f64>> = start.q.iter().map(|&q| vec![q; points]).collect();
    let mut multipliers = Vec::new();
    let (mut position, mut units) = (0, UNITS_PER_STEP);
    let mut grids = HashMap::new();
    let mut largest_q_dot = vec![0.0; rows.len()];
    while position < end {
        // The window must not look beyond the end: there may be a horizon.
        while units * WINDOW_STEPS > end - position {
            units /= 2;
        }
        let grid = grids
            .entry(units)
            .or_insert_with(|| WindowGrid::new(&whole, spacing * units as f64 / UNITS_PER_STEP as f64));
        let acceptable = LARGEST_DEFECT.min(DEFECT_OF_RUN * (WINDOW_STEPS * units) as f64 / end as f64);
        match grid.solve(&whole, &start, &mut largest_q_dot) {
            Ok(window) if window.defect > acceptable && units > 1 => units /= 2,
            Ok(window) => {
                let layout = Layout::new(rows.len(), WINDOW_STEPS + 1, Form::Strong);
                let forward = layout.branch(&window.root.unknowns, 0);
                let places = (1..=WINDOW_STEPS).map(|step| (step, position + step * units));
                for (step, at) in places.filter(|(_, at)| at % UNITS_PER_STEP == 0) {
                    rows.iter_mut().zip(&forward).for_each(|(row, forward)| row[at / UNITS_PER_STEP] = forward[step]);
                }
                multipliers = layout.multipliers(&window.root.unknowns).to_vec();
                start = window.end;
                position += WINDOW_STEPS * units;
                // A longer window must still have its nodes on the grid.
                let may_grow = units < UNITS_PER_STEP && position.is_multiple_of(2 * units);
                units *= if may_grow && window.defect <= LENGTHENING * acceptable { 2 } else { 1 };
            }
            Err(_) if units > 1 => units /= 2,
            Err(failure) => {
                let [gamma, spacing] = [position, units].map(|count| count as f64 * spacing / UNITS_PER_STEP as f64);
                return Err(WindowFailure { failure: Box::new(failure), start, gamma, spacing });
            }
        }
    }
    if !sbp.is_equidistant() {
        for row in &mut rows {
            *row = (0..nodes).map(|node| interpolated(row, sbp.node(node) / spacing)).collect();
        }
    }
    if action.form() == Form::Weak {
        multipliers.clear();
    }
    let rows: Vec<&[f64]> = rows.iter().map(Vec::as_slice).collect();
    Ok(action.layout().physical_limit(&rows, &multipliers))
}

/// The value at a `place` between the entries, by a straight line.
fn interpolated(values: &[f64], place: f64) -> f64 {
    let k = (place as usize).min(values.len() - 2);
    values[k] + (place - k as f64) * (values[k + 1] - values[k])
}
