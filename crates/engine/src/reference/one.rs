//! The geodesic equations of one coordinate: the state is x, t − t_i and w = dx/dγ.

use super::equations::{Equations, Series};
use super::polynomials::{increment, slope};
use super::series::SeriesMachine;
use super::size::gap;
use crate::expr::Program;
use crate::geodesic::{InitialData, acceleration};
use crate::metric::Metric;
use crate::scalar::{Real, sum};

/// Places of the components.
pub(super) const X: usize = 0;
pub(super) const T: usize = 1;
const W: usize = 2;
/// x and t are kept; w is the derivative of x.
pub(super) const KEPT: usize = 2;
/// If steps shrink while g00 is below this share of its first value, the trajectory approaches a horizon.
const HORIZON: f64 = 1e-3;

/// dx/dγ = w, dw/dγ = −½ g00′ (Q_t/g00)², dt/dγ = Q_t/g00.
pub(super) struct OneCoordinate<'m, S> {
    metric: &'m Metric<S>,
    q_t: S,
    /// g00 at the start.
    g00_start: S,
    machine: SeriesMachine<'m, S>,
}

/// The state at the start. Time is counted from there.
pub(super) fn start_of<S: Real>(initial: InitialData<S>) -> [S; 3] {
    [initial.x, S::ZERO, initial.x_dot]
}

impl<'m, S: Real> OneCoordinate<'m, S> {
    /// `program` is that of the potential.
    pub(super) fn new(metric: &'m Metric<S>, program: &'m Program<S>, initial: InitialData<S>, order: usize) -> Self {
        Self {
            metric,
            q_t: initial.invariants(metric).q_t,
            g00_start: metric.g00(initial.x),
            machine: SeriesMachine::new(program, 2, order),
        }
    }
}

impl<S: Real> Equations<S> for OneCoordinate<'_, S> {
    fn kept(&self) -> usize {
        KEPT
    }

    fn first_of_scale(&self, component: usize) -> usize {
        usize::from(component == T)
    }

    fn expand(&mut self, state: &[S], order: usize) -> Series<S> {
        let [mut x, mut t, mut w] = [X, T, W].map(|component| vec![state[component]]);
        let (mut g00, mut t_dot, mut t_dot_squared, mut slope) = (vec![], vec![], vec![], vec![]);
        let convolve = |a: &[S], b: &[S], k: usize| sum((0..=k).map(|j| a[j] * b[k - j]));
        self.machine.restart();
        for k in 0..order {
            self.machine.extend(k, [(0, x[k])].into_iter());
            let [v, first] = [0, 1].map(|output| self.machine.output(output)[k]);
            g00.push(self.metric.two_over_mass() * v + if k == 0 { self.metric.c_squared() } else { S::ZERO });
            slope.push(self.metric.two_over_mass() * first);
            // g00 · ṫ = Q_t, coefficient by coefficient.
            let known = sum((1..=k).map(|j| g00[j] * t_dot[k - j]));
            t_dot.push((if k == 0 { self.q_t } else { S::ZERO } - known) / g00[0]);
            t_dot_squared.push(convolve(&t_dot, &t_dot, k));
            let next = S::from((k + 1) as f64);
            x.push(w[k] / next);
            w.push(-convolve(&slope, &t_dot_squared, k).half() / next);
            t.push(t_dot[k] / next);
        }
        vec![x, t, w]
    }

    fn kink_arguments(&self) -> impl Iterator<Item = &[S]> {
        self.machine.kink_arguments()
    }

    /// The difference of dw/dγ.
    fn missed(&mut self, series: &Series<S>, h: S, s: S, _: S) -> S {
        let [x, w] = [X, W].map(|component| &series[component]);
        let size = w[1].abs().max((w[2] * h).abs()).max(w[0].abs() / h).max(x[0].abs() / (h * h)).max(S::MIN_POSITIVE);
        let g = self.metric.at(x[0] + increment(x, s));
        gap(slope(w, s), acceleration(self.q_t, g.g00, g.first)) / size
    }

    fn is_inside(&mut self, state: &[S]) -> bool {
        self.metric.at(state[X]).is_inside()
    }

    fn is_near_the_edge(&mut self, state: &[S]) -> bool {
        self.metric.g00(state[X]) < S::from(HORIZON) * self.g00_start
    }
}
