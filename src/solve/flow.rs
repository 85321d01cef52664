//! Runge–Kutta steps on Hamilton's equations: the first guess of Newton's method, and a look ahead.

use super::window::Window;
use crate::geometry::{Geometry, OutsideGeometry, Point, Start};
use crate::number::norm::max_abs;
use crate::number::runge_kutta::{Stages, runge_kutta};

/// q^a of all coordinates and p_a of all, on the way.
pub(super) struct Flow {
    point: Point,
    state: Vec<f64>,
    stages: Stages,
}

impl Flow {
    pub(super) fn new(geometry: &Geometry, start: &Start) -> Self {
        let state = [&start.q[..], &start.p].concat();
        Self { point: geometry.point(), stages: Stages::new(state.len()), state }
    }

    /// Goes on by h.
    ///
    /// # Errors
    /// [`OutsideGeometry`] if the state is outside the domain before or within the step.
    #[inline]
    pub(super) fn step(&mut self, h: f64) -> Result<(), OutsideGeometry> {
        let Self { point, state, stages } = self;
        runge_kutta(state, h, stages, |state, rates| point.slopes(state, rates))
    }

    /// q^a and p_a.
    pub(super) fn place(&self) -> (&[f64], &[f64]) {
        self.state.split_at(self.state.len() / 2)
    }

    /// dq^a/dγ and dp_a/dγ, one after the other, into `rates`.
    ///
    /// # Errors
    /// [`OutsideGeometry`] if the state is outside the domain.
    pub(super) fn rates(&mut self, rates: &mut [f64]) -> Result<(), OutsideGeometry> {
        self.point.slopes(&self.state, rates)
    }
}

/// Most sub-steps a node interval is divided into.
const MOST_SUBSTEPS: usize = 64;
/// Halving the step may change a position by this share of its size; Newton's method does the rest.
const GUESS_TOLERANCE: f64 = 1e-4;

/// Where a world-line leaves the domain.
pub(super) struct Edge {
    /// γ from the start of the window.
    pub(super) gamma: f64,
    /// A point outside, with the index of the node behind it.
    pub(super) point: OutsideGeometry,
}

/// A world-line on the nodes.
pub(super) struct Guess {
    /// q^a, a row for each coordinate.
    pub(super) q: Vec<Vec<f64>>,
    /// p_a, a row for each active coordinate.
    pub(super) p: Vec<Vec<f64>>,
}

/// A first guess of order four.
///
/// The step, at first two node intervals, is halved until that changes no position that matters, so the guess is close
/// to the geodesic however coarse the grid is. It also tells a geodesic that leaves the domain from a coarse step that
/// jumps out of it: only what happens with ever finer steps is believed.
///
/// # Errors
/// [`Edge`] if the world-line leaves the domain.
pub(super) fn guess(window: &Window<'_, f64>) -> Result<Guess, Edge> {
    // Every second node; the last interval is left out if their number is odd.
    let (mut coarse, mut stride, mut substeps) = (integrate(window, 2, 1), 2, 1);
    loop {
        let fine = integrate(window, 1, substeps);
        let settled = match (&coarse, &fine) {
            (Ok(before), Ok(after)) => has_settled(window.geometry.active(), before, after, stride),
            _ => false,
        };
        if settled || substeps == MOST_SUBSTEPS {
            return fine;
        }
        (coarse, stride) = (fine, 1);
        substeps *= 2;
    }
}

/// Whether no active coordinate changed by more than the tolerance times its size. `before` has every `stride`-th node.
fn has_settled(active: &[usize], before: &Guess, after: &Guess, stride: usize) -> bool {
    active.iter().all(|&a| {
        let (before, after) = (&before.q[a], &after.q[a]);
        let pairs = before.iter().zip(after.iter().step_by(stride));
        let change = pairs.fold(0.0_f64, |most, (before, after)| most.max((before - after).abs()));
        change <= GUESS_TOLERANCE * max_abs(after)
    })
}

/// Every `stride`-th node, with `substeps` steps from one to the next.
fn integrate(window: &Window<'_, f64>, stride: usize, substeps: usize) -> Result<Guess, Edge> {
    let (geometry, n) = (window.geometry, window.start.q.len());
    let intervals = (window.points() - 1) / stride;
    let rows = |count: usize| vec![Vec::with_capacity(intervals + 1); count];
    let mut guess = Guess { q: rows(n), p: rows(geometry.active().len()) };
    let mut flow = Flow::new(geometry, window.start);
    for k in 0..=intervals {
        let node = k * stride;
        let at = |gamma: f64| move |point| Edge { gamma, point: OutsideGeometry { index: node, ..point } };
        if k > 0 {
            let from = (k - 1) * stride;
            let length = (from..from + stride).fold(0.0, |length, k| length + window.sbp.interval(k));
            let h = length / substeps as f64;
            let place = |step: usize| window.sbp.node(from) + h * (step + 1) as f64;
            (0..substeps).try_for_each(|step| flow.step(h).map_err(at(place(step))))?;
        }
        if k == intervals {
            flow.rates(&mut vec![0.0; 2 * n]).map_err(at(window.sbp.node(node)))?;
        }
        let (q, p) = flow.place();
        guess.q.iter_mut().zip(q).for_each(|(row, &q)| row.push(q));
        guess.p.iter_mut().zip(geometry.active()).for_each(|(row, &a)| row.push(p[a]));
    }
    Ok(guess)
}
