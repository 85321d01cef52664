//! Explicit recursions in γ: the two-step rule that SBP21's collocation system is, and Runge–Kutta steps for guesses.

use super::limit::Limit;
use super::window::{Node, Window};
use crate::geometry::{OutsideGeometry, Rates};
use crate::scalar::Real;
use crate::solve::newton::Failure;
use crate::solve::status::{InitialGuess, Status};

/// A recursion that ended at a point outside the domain.
pub(super) fn outside(point: OutsideGeometry) -> Failure<OutsideGeometry> {
    Failure { outside: Some(point), ..Failure::without_iterate(Status::OutsideDomain) }
}

/// SBP21: one Euler step, then u_{k+1} = u_{k−1} + 2h u̇_k for every coordinate and every momentum. One evaluation a
/// node.
pub(super) fn two_step<S: Real>(window: &Window<'_, S>) -> Result<Limit<S>, Failure<OutsideGeometry>> {
    let (points, h, field) = (window.points(), window.sbp.spacing(), window.geometry.field());
    let active = field.active();
    let mut q: Vec<Vec<S>> = window.start.q.iter().map(|&q| vec![q; points]).collect();
    let mut p: Vec<Vec<S>> = active.iter().map(|&a| vec![window.start.p[a]; points]).collect();
    let (mut node, mut rates) = (Node::new(window.start), field.room());
    for k in 0..points {
        for (place, &a) in active.iter().enumerate() {
            (node.q[a], node.p[a]) = (q[a][k], p[place][k]);
        }
        let evaluated = field.evaluate(&node.q, &node.p, &mut rates);
        evaluated.map_err(|point| outside(OutsideGeometry { index: k, ..point }))?;
        if k + 1 == points {
            break;
        }
        let (from, step) = if k == 0 { (0, h) } else { (k - 1, h + h) };
        for (a, q) in q.iter_mut().enumerate() {
            q[k + 1] = q[from] + step * field.q_dot(&rates, a);
        }
        for (place, p) in p.iter_mut().enumerate() {
            p[k + 1] = p[from] + step * field.p_dot(&rates, place);
        }
    }
    Ok(Limit { q, p, history: Vec::new(), initial_guess: InitialGuess::None })
}

/// Most sub-steps a node interval is divided into.
const MOST_SUBSTEPS: usize = 64;
/// Halving the step may change a position by this share of its size; Newton's method does the rest.
const GUESS_TOLERANCE: f64 = 1e-4;

/// Rows of positions and momenta of the active coordinates, node by node: (q_1 … q_m, p_1 … p_m) each.
pub(super) type States = Vec<f64>;

/// The active coordinates and momenta on the nodes by the classical Runge–Kutta method of order four.
///
/// The number of steps between two nodes, at first one, is doubled until that changes nothing that matters. So the
/// guess is close to the geodesic however coarse the grid is, and only what happens with ever finer steps is believed.
pub(super) fn runge_kutta(window: &Window<'_>) -> Result<States, OutsideGeometry> {
    let mut coarse = runge_kutta_with(window, 1);
    let mut substeps = 2;
    loop {
        let fine = runge_kutta_with(window, substeps);
        let settled = match (&coarse, &fine) {
            (Ok(before), Ok(after)) => has_settled(before, after, 2 * window.geometry.active().len()),
            _ => false,
        };
        if settled || substeps == MOST_SUBSTEPS {
            return fine;
        }
        coarse = fine;
        substeps *= 2;
    }
}

/// Whether no field changed by more than the tolerance times its size.
fn has_settled(before: &[f64], after: &[f64], fields: usize) -> bool {
    (0..fields).all(|field| {
        let pairs = || before.iter().zip(after).skip(field).step_by(fields);
        let change = pairs().fold(0.0_f64, |change, (a, b)| change.max((a - b).abs()));
        let size = pairs().fold(0.0_f64, |size, (_, b)| size.max(b.abs()));
        change <= GUESS_TOLERANCE * size
    })
}

/// The right-hand side on active coordinates and momenta.
struct Motion<'w> {
    window: &'w Window<'w>,
    node: Node<f64>,
    rates: Rates<f64>,
}

impl Motion<'_> {
    fn slope(&mut self, state: &[f64], out: &mut [f64]) -> Result<(), OutsideGeometry> {
        let field = self.window.geometry.field();
        let m = field.active().len();
        for (place, &a) in field.active().iter().enumerate() {
            (self.node.q[a], self.node.p[a]) = (state[place], state[m + place]);
        }
        field.evaluate(&self.node.q, &self.node.p, &mut self.rates)?;
        for (place, &a) in field.active().iter().enumerate() {
            out[place] = field.q_dot(&self.rates, a);
            out[m + place] = field.p_dot(&self.rates, place);
        }
        Ok(())
    }
}

fn runge_kutta_with(window: &Window<'_>, substeps: usize) -> Result<States, OutsideGeometry> {
    let (start, field) = (window.start, window.geometry.field());
    let active = field.active();
    let fields = 2 * active.len();
    let mut motion = Motion { window, node: Node::new(start), rates: field.room() };
    let mut state: Vec<f64> = active.iter().map(|&a| start.q[a]).chain(active.iter().map(|&a| start.p[a])).collect();
    let mut states = Vec::with_capacity(fields * window.points());
    states.extend_from_slice(&state);
    let mut slopes = [(); 4].map(|()| vec![0.0; fields]);
    let mut trial = state.clone();
    for k in 1..window.points() {
        let h = window.sbp.interval(k - 1) / substeps as f64;
        let at = |index: usize| move |point: OutsideGeometry| OutsideGeometry { index, ..point };
        for _ in 0..substeps {
            let [k1, k2, k3, k4] = &mut slopes;
            motion.slope(&state, k1).map_err(at(k - 1))?;
            advance(&state, 0.5 * h, k1, &mut trial);
            motion.slope(&trial, k2).map_err(at(k))?;
            advance(&state, 0.5 * h, k2, &mut trial);
            motion.slope(&trial, k3).map_err(at(k))?;
            advance(&state, h, k3, &mut trial);
            motion.slope(&trial, k4).map_err(at(k))?;
            for (field, value) in state.iter_mut().enumerate() {
                *value += h / 6.0 * (k1[field] + 2.0 * (k2[field] + k3[field]) + k4[field]);
            }
        }
        states.extend_from_slice(&state);
    }
    motion.slope(&state, &mut trial).map_err(|point| OutsideGeometry { index: window.points() - 1, ..point })?;
    Ok(states)
}

fn advance(state: &[f64], h: f64, slope: &[f64], out: &mut [f64]) {
    for ((out, value), slope) in out.iter_mut().zip(state).zip(slope) {
        *out = value + h * slope;
    }
}
