//! The collocation system of the active coordinates as a banded Newton iteration in (q, p*).

use super::explicit;
use super::window::{Node, Window};
use crate::banded::solve_banded;
use crate::geometry::{OutsideGeometry, Rates};
use crate::scalar::Real;
use crate::solve::derivative::FormDerivative;
use crate::solve::newton::{self, Failure, LinearFailure, NewtonSystem, Root, RoundingLevels};
use crate::solve::refinement::{self, Refined};
use crate::solve::status::IterationRecord;

/// p* of the active coordinates, q of all, and the iterations.
type Solved<S> = (Vec<Vec<S>>, Vec<Vec<S>>, Vec<IterationRecord>);

/// p*_a of the active coordinates and q^a of all, where ignorable ones are still 0, with the iterations.
pub(super) fn solve<S: Real>(
    window: &Window<'_, S>,
    rough: &Window<'_>,
    max_iterations: usize,
) -> Result<Solved<S>, Failure<OutsideGeometry>> {
    let mut system = System::new(window, Vec::new());
    let mut history = Vec::new();
    if system.fields() > 0 {
        let states = explicit::runge_kutta(rough).map_err(explicit::outside)?;
        let scales = scales(rough, &states)?;
        let guess = states[rough.derivative().first_unknown() * system.fields()..].to_vec();
        let mut linearised = System::new(rough, scales.clone());
        let root = newton::solve(&mut linearised, guess, max_iterations)?;
        system = System::new(window, scales);
        let root = if S::IS_EXTENDED {
            let mut refined = RefinedSystem { residual: system, linearised };
            let root = refinement::refine(&mut refined, root, window.digits, max_iterations)?;
            system = refined.residual;
            root
        } else {
            Root { unknowns: root.unknowns.into_iter().map(S::from).collect(), history: root.history }
        };
        system.set(&root.unknowns);
        history = root.history;
    }
    Ok((system.p, system.q, history))
}

/// Entries of the Jacobian, divided by this, stay far from overflow.
const LEAST_SCALE: f64 = 1e-280;

/// The divisor of each kind of row, so that one rounding level holds for all: the size of the field plus its change in a
/// step.
fn scales(window: &Window<'_>, states: &[f64]) -> Result<Vec<f64>, Failure<OutsideGeometry>> {
    let (field, h) = (window.geometry.field(), window.sbp.spacing());
    let m = field.active().len();
    let (mut node, mut rates) = (Node::new(window.start), field.room());
    let (mut sizes, mut changes) = (vec![0.0_f64; 2 * m], vec![0.0_f64; 2 * m]);
    for (k, state) in states.chunks_exact(2 * m).enumerate() {
        for (place, &a) in field.active().iter().enumerate() {
            (node.q[a], node.p[a]) = (state[place], state[m + place]);
        }
        let evaluated = field.evaluate(&node.q, &node.p, &mut rates);
        evaluated.map_err(|point| explicit::outside(OutsideGeometry { index: k, ..point }))?;
        for (place, &a) in field.active().iter().enumerate() {
            sizes[place] = sizes[place].max(state[place].abs());
            sizes[m + place] = sizes[m + place].max(state[m + place].abs());
            changes[place] = changes[place].max(field.q_dot(&rates, a).abs());
            changes[m + place] = changes[m + place].max(field.p_dot(&rates, place).abs());
        }
    }
    // At rest in an equilibrium there is no scale.
    let scale = |(size, change): (f64, f64)| match size + h * change {
        0.0 => 1.0,
        scale => scale.max(LEAST_SCALE),
    };
    Ok(sizes.into_iter().zip(changes).map(scale).collect())
}

/// Rows (h du/dγ − h u̇)/s in the unknowns (q_1 … q_m, p_1 … p_m) of one node after the other: at nodes 1 … N−1 for
/// nodes 2 … N in the strong form, at all nodes for all in the weak one.
struct System<'w, S> {
    window: Window<'w, S>,
    scales: Vec<f64>,
    // What was evaluated last: the fields on all N nodes, their rates and their slopes.
    q: Vec<Vec<S>>,
    p: Vec<Vec<S>>,
    /// The rates of the 2m fields, node by node.
    rates: Vec<S>,
    slopes: Vec<Vec<S>>,
    node: Node<S>,
    room: Rates<S>,
}

impl<'w, S: Real> System<'w, S> {
    fn new(window: &Window<'w, S>, scales: Vec<f64>) -> Self {
        let (points, field) = (window.points(), window.geometry.field());
        let m = field.active().len();
        Self {
            window: *window,
            scales,
            q: window.start.q.iter().map(|&q| vec![q; points]).collect(),
            p: field.active().iter().map(|&a| vec![window.start.p[a]; points]).collect(),
            rates: vec![S::ZERO; 2 * m * points],
            slopes: vec![vec![S::ZERO; points]; 2 * m],
            node: Node::new(window.start),
            room: field.room(),
        }
    }

    /// Number of fields at a node, 2m.
    fn fields(&self) -> usize {
        self.slopes.len()
    }

    fn derivative(&self) -> FormDerivative<'w, S> {
        self.window.derivative()
    }

    fn active(&self) -> &'w [usize] {
        self.window.geometry.active()
    }

    fn set(&mut self, u: &[S]) {
        let (first, fields) = (self.derivative().first_unknown(), self.fields());
        for (k, state) in u.chunks_exact(fields).enumerate() {
            for (place, &a) in self.window.geometry.active().iter().enumerate() {
                self.q[a][first + k] = state[place];
                self.p[place][first + k] = state[fields / 2 + place];
            }
        }
    }

    fn set_node(&mut self, k: usize) {
        for (place, &a) in self.window.geometry.active().iter().enumerate() {
            (self.node.q[a], self.node.p[a]) = (self.q[a][k], self.p[place][k]);
        }
    }

    /// Updates the fields and their rates to the unknowns `u`.
    fn evaluate(&mut self, u: &[S]) -> Result<(), OutsideGeometry> {
        self.set(u);
        let (field, fields) = (self.window.geometry.field(), self.fields());
        for k in 0..self.window.points() {
            self.set_node(k);
            let evaluated = field.evaluate(&self.node.q, &self.node.p, &mut self.room);
            evaluated.map_err(|point| OutsideGeometry { index: k, ..point })?;
            let rates = &mut self.rates[k * fields..][..fields];
            for (place, &a) in field.active().iter().enumerate() {
                rates[place] = field.q_dot(&self.room, a);
                rates[fields / 2 + place] = field.p_dot(&self.room, place);
            }
        }
        Ok(())
    }

    /// `out` = F(u).
    fn residual(&mut self, u: &[S], out: &mut [S]) -> Result<(), OutsideGeometry> {
        self.evaluate(u)?;
        let (h, derivative, fields) = (self.window.sbp.spacing(), self.derivative(), self.fields());
        let start = self.window.start;
        for (place, &a) in self.active().iter().enumerate() {
            derivative.apply(&self.q[a], start.q[a], &mut self.slopes[place]);
            derivative.apply(&self.p[place], start.p[a], &mut self.slopes[fields / 2 + place]);
        }
        for (k, rows) in out.chunks_exact_mut(fields).enumerate() {
            for (field, row) in rows.iter_mut().enumerate() {
                let defect = self.slopes[field][k] - self.rates[k * fields + field];
                *row = h * defect / S::from(self.scales[field]);
            }
        }
        Ok(())
    }

    /// The rows are scaled so that one level holds for all.
    fn rounding(&self, u: &[S]) -> RoundingLevels {
        vec![(0..u.len(), self.window.sbp.row_sum() * S::EPSILON.to_f64())]
    }

    /// The largest absolute value of each field.
    fn sizes(&self, u: &[S]) -> Vec<S> {
        let mut sizes = vec![S::ZERO; self.fields()];
        for state in u.chunks_exact(self.fields()) {
            sizes.iter_mut().zip(state).for_each(|(size, value)| *size = size.max(value.abs()));
        }
        sizes
    }
}

impl System<'_, f64> {
    /// Overwrites `right` with J⁻¹ `right` for the Jacobian J at what was evaluated last.
    fn solve_linearised(&mut self, right: &mut [f64]) -> Result<(), LinearFailure> {
        let (h, derivative, fields) = (self.window.sbp.spacing(), self.derivative(), self.fields());
        let (first, (lower, upper)) = (derivative.first_unknown(), derivative.reach());
        // Rows of node k stand beside the unknowns of node k + first, so their coupling to the fields of node k reaches
        // (first + 1) nodes, less one field, below the diagonal, and above it only if first is 0.
        let lower = (fields * lower).max(fields * (first + 1) - 1);
        let upper = (fields * upper).max(if first == 0 { fields - 1 } else { 0 });
        let field = self.window.geometry.field();
        let mut room = field.jacobian_room();
        let mut jacobian = vec![0.0; fields * fields];
        solve_banded(lower, upper, right, |index, row| {
            row.fill(0.0);
            let (k, here) = (index / fields, index % fields);
            if here == 0 && k >= first {
                self.set_node(k);
                jacobian.fill(0.0);
                let see = |row: usize, column: usize, value| jacobian[row * fields + column] = value;
                field.jacobian(&self.node.q, &self.node.p, &mut room, see);
            }
            let scale = self.scales[here];
            derivative.row(k).for_each(|(column, d)| row[fields * column + here + lower - index] += h * d / scale);
            // In the strong form the first node is given: it has no unknowns to couple to.
            if k >= first {
                for (other, &coupling) in jacobian[here * fields..][..fields].iter().enumerate() {
                    if coupling != 0.0 {
                        row[fields * (k - first) + other + lower - index] -= h * coupling / scale;
                    }
                }
            }
        })
        .map_err(|_| LinearFailure)
    }
}

impl NewtonSystem for System<'_, f64> {
    type Outside = OutsideGeometry;

    fn residual(&mut self, u: &[f64], out: &mut [f64]) -> Result<(), OutsideGeometry> {
        System::residual(self, u, out)
    }

    fn rounding(&self, u: &[f64]) -> Option<RoundingLevels> {
        Some(System::rounding(self, u))
    }

    fn newton_step(&mut self, u: &[f64], residual: &[f64], step: &mut [f64]) -> Result<(), LinearFailure> {
        // A trial step may have been evaluated since.
        self.set(u);
        for (step, r) in step.iter_mut().zip(residual) {
            *step = -r;
        }
        self.solve_linearised(step)
    }

    fn sizes(&self, u: &[f64]) -> Vec<f64> {
        System::sizes(self, u)
    }
}

/// The residual with all digits, the Jacobian at the `f64` root, eliminated anew in every round.
struct RefinedSystem<'w, S> {
    residual: System<'w, S>,
    linearised: System<'w, f64>,
}

impl<S: Real> Refined<S> for RefinedSystem<'_, S> {
    type Outside = OutsideGeometry;

    fn residual(&mut self, u: &[S], out: &mut [S]) -> Result<(), OutsideGeometry> {
        self.residual.residual(u, out)
    }

    fn solve_linearised(&mut self, right: &mut [f64]) -> Result<(), LinearFailure> {
        self.linearised.solve_linearised(right)
    }

    fn rounding(&self, u: &[S]) -> Option<RoundingLevels> {
        Some(self.residual.rounding(u))
    }

    fn sizes(&self, u: &[S]) -> Vec<S> {
        self.residual.sizes(u)
    }
}
