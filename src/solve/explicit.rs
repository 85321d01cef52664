//! Explicit recursions in γ: the two-step rule that SBP21's collocation system is, and the integrators of first
//! guesses.

use super::limit::Limit;
use super::newton::Failure;
use super::status::{InitialGuess, Status};
use super::window::Window;
use crate::geometry::Motion;
use crate::number::Real;
use crate::number::norm::max_abs;
use crate::number::runge_kutta::runge_kutta;

/// A recursion that ended at a point outside the domain.
pub(super) fn outside<O>(point: O) -> Failure<O> {
    Failure { outside: Some(point), ..Failure::without_iterate(Status::OutsideDomain) }
}

/// SBP21: one Euler step, then u_{k+1} = u_{k−1} + 2h u̇_k for every coordinate and every momentum. One evaluation a
/// node.
///
/// Exact charges say nothing about the rest here: the rule carries a computational (−1)^k mode, neutral only while
/// hω < 1.
pub(super) fn two_step<S: Real, G: Motion<S>>(window: &Window<'_, S, G>) -> Result<Limit<S>, Failure<G::Outside>> {
    let (points, h, geometry) = (window.points(), window.sbp.spacing(), window.geometry);
    let active = geometry.active();
    let mut q: Vec<Vec<S>> = window.start.q.iter().map(|&q| vec![q; points]).collect();
    let mut p: Vec<Vec<S>> = active.iter().map(|&a| vec![window.start.p[a]; points]).collect();
    let (mut here, mut momenta) = (window.start.q.clone(), window.start.p.clone());
    let mut room = geometry.motion_room();
    for k in 0..points {
        for (place, &a) in active.iter().enumerate() {
            (here[a], momenta[a]) = (q[a][k], p[place][k]);
        }
        geometry.rates_at(&here, &momenta, k, &mut room).map_err(outside)?;
        if k + 1 == points {
            break;
        }
        let (from, step) = if k == 0 { (0, h) } else { (k - 1, h + h) };
        for (a, q) in q.iter_mut().enumerate() {
            q[k + 1] = q[from] + step * geometry.q_dot(&room, a);
        }
        for (place, p) in p.iter_mut().enumerate() {
            p[k + 1] = p[from] + step * geometry.p_dot(&room, place);
        }
    }
    Ok(Limit { q, p, history: Vec::new(), initial_guess: InitialGuess::None })
}

/// Most sub-steps a node interval is divided into.
const MOST_SUBSTEPS: usize = 64;
/// Halving the step may change a position by this share of its size; Newton's method does the rest.
const GUESS_TOLERANCE: f64 = 1e-4;

/// The active coordinates on the nodes, node by node: (q_1 … q_m, p_1 … p_m) each.
pub(super) type States = Vec<f64>;

/// A first guess by an integrator of order four: Nyström's (E. J. Nyström, Acta Soc. Sci. Fenn. 50 (1925)) where the
/// accelerations depend on positions only, otherwise the classical one of Runge and Kutta.
///
/// The step, at first two node intervals, is halved until that changes no position that matters, so the guess is close
/// to the geodesic however coarse the grid is. It also tells a geodesic that leaves the domain from a coarse step that
/// jumps out of it: only what happens with ever finer steps is believed.
pub(super) fn guess<G: Motion<f64>>(window: &Window<'_, f64, G>) -> Result<(States, InitialGuess), G::Outside> {
    let m = window.geometry.active().len();
    // Every second node; the last interval is left out if their number is odd.
    let mut coarse = integrate(window, 2, 1);
    let mut coarse_stride = 2;
    let mut substeps = 1;
    loop {
        let fine = integrate(window, 1, substeps);
        let settled = match (&coarse, &fine) {
            (Ok((before, _)), Ok((after, _))) => has_settled(before, after, coarse_stride, m),
            _ => false,
        };
        if settled || substeps == MOST_SUBSTEPS {
            return fine;
        }
        (coarse, coarse_stride) = (fine, 1);
        substeps *= 2;
    }
}

/// Whether no position changed by more than the tolerance times its size. `before` has every `stride`-th node.
fn has_settled(before: &[f64], after: &[f64], stride: usize, m: usize) -> bool {
    let fields = 2 * m;
    (0..m).all(|field| {
        let of = |states: &[f64], stride: usize| -> Vec<f64> {
            states.iter().skip(field).step_by(fields * stride).copied().collect()
        };
        let change = of(before, 1).iter().zip(of(after, stride)).fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
        change <= GUESS_TOLERANCE * max_abs(&of(after, 1))
    })
}

/// Every `stride`-th node, with `substeps` steps from one to the next.
fn integrate<G: Motion<f64>>(
    window: &Window<'_, f64, G>,
    stride: usize,
    substeps: usize,
) -> Result<(States, InitialGuess), G::Outside> {
    let intervals = (window.points() - 1) / stride;
    let mut flow = Flow::new(window);
    let mut states = Vec::with_capacity(flow.state.len() * (intervals + 1));
    flow.append(&mut states);
    // What the equations are is known after a first evaluation.
    flow.rates(0)?;
    let is_separable = window.geometry.acceleration(&flow.room, 0).is_some();
    for k in 1..=intervals {
        let from = (k - 1) * stride;
        let length = (from..from + stride).fold(0.0, |length, k| length + window.sbp.interval(k));
        let h = length / substeps as f64;
        for _ in 0..substeps {
            match is_separable {
                true => flow.nystrom(h, [from, from + stride])?,
                false => flow.runge_kutta(h, [from, from + stride])?,
            }
        }
        flow.append(&mut states);
    }
    flow.rates(intervals * stride)?;
    let guess = if is_separable { InitialGuess::Nystrom4 } else { InitialGuess::RungeKutta4 };
    Ok((states, guess))
}

/// The active coordinates and their momenta or, where the equations are separable, their velocities, on the way.
struct Flow<'w, G: Motion<f64>> {
    window: &'w Window<'w, f64, G>,
    q: Vec<f64>,
    p: Vec<f64>,
    room: G::Room,
    /// (q_1 … q_m, p_1 … p_m).
    state: Vec<f64>,
    slopes: [Vec<f64>; 4],
}

impl<'w, G: Motion<f64>> Flow<'w, G> {
    fn new(window: &'w Window<'w, f64, G>) -> Self {
        let (start, active) = (window.start, window.geometry.active());
        let state: Vec<f64> = active.iter().map(|&a| start.q[a]).chain(active.iter().map(|&a| start.p[a])).collect();
        let slopes = [(); 4].map(|()| vec![0.0; state.len()]);
        let room = window.geometry.motion_room();
        Self { window, q: start.q.clone(), p: start.p.clone(), room, state, slopes }
    }

    fn append(&self, states: &mut States) {
        states.extend_from_slice(&self.state);
    }

    /// Computes the rates at the present state.
    #[inline]
    fn rates(&mut self, index: usize) -> Result<(), G::Outside> {
        let m = self.state.len() / 2;
        for (place, &a) in self.window.geometry.active().iter().enumerate() {
            (self.q[a], self.p[a]) = (self.state[place], self.state[m + place]);
        }
        self.window.geometry.rates_at(&self.q, &self.p, index, &mut self.room)
    }

    /// A step of the classical method between two nodes.
    fn runge_kutta(&mut self, h: f64, [from, to]: [usize; 2]) -> Result<(), G::Outside> {
        let Self { window, q, p, room, state, slopes } = self;
        let (geometry, m) = (window.geometry, state.len() / 2);
        runge_kutta(state, h, slopes, |stage, trial, slope| {
            for (place, &a) in geometry.active().iter().enumerate() {
                (q[a], p[a]) = (trial[place], trial[m + place]);
            }
            geometry.rates_at(q, p, if stage == 0 { from } else { to }, room)?;
            for (place, &a) in geometry.active().iter().enumerate() {
                (slope[place], slope[m + place]) = (geometry.q_dot(room, a), geometry.p_dot(room, place));
            }
            Ok(())
        })
    }

    /// A step of Nyström's method between two nodes. Of the momenta only the rates matter: the velocities at the start
    /// of the step are those of the state.
    #[inline]
    fn nystrom(&mut self, h: f64, [from, to]: [usize; 2]) -> Result<(), G::Outside> {
        self.rates(from)?;
        let (m, geometry) = (self.state.len() / 2, self.window.geometry);
        let active = geometry.active();
        for (velocity, &a) in self.slopes[3].iter_mut().zip(active) {
            *velocity = geometry.q_dot(&self.room, a);
        }
        self.keep(0);
        let Self { q, slopes: [k1, _, _, velocities], state, .. } = self;
        for (((&a, x), w), k1) in active.iter().zip(&state[..m]).zip(&*velocities).zip(&*k1) {
            q[a] = x + h * (0.5 * w + 0.125 * h * k1);
        }
        geometry.rates_at(&self.q, &self.p, to, &mut self.room)?;
        self.keep(1);
        let Self { q, slopes: [_, k2, _, velocities], state, .. } = self;
        for (((&a, x), w), k2) in active.iter().zip(&state[..m]).zip(&*velocities).zip(&*k2) {
            q[a] = x + h * (w + 0.5 * h * k2);
        }
        geometry.rates_at(&self.q, &self.p, to, &mut self.room)?;
        self.keep(2);
        let [k1, k2, k3, velocities] = &self.slopes;
        let (x, p) = self.state.split_at_mut(m);
        for (((x, w), k1), k2) in x.iter_mut().zip(velocities).zip(k1).zip(k2) {
            *x += h * (w + h * (k1 + 2.0 * k2) / 6.0);
        }
        for (((p, k1), k2), k3) in p.iter_mut().zip(&k1[m..]).zip(&k2[m..]).zip(&k3[m..]) {
            *p += h * (k1 + 4.0 * k2 + k3) / 6.0;
        }
        Ok(())
    }

    /// Keeps the accelerations and the rates of the momenta as a slope.
    #[inline]
    fn keep(&mut self, slope: usize) {
        let m = self.state.len() / 2;
        for place in 0..m {
            let acceleration = self.window.geometry.acceleration(&self.room, place);
            self.slopes[slope][place] = acceleration.expect("the equations are separable");
            self.slopes[slope][m + place] = self.window.geometry.p_dot(&self.room, place);
        }
    }
}
