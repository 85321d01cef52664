//! Interpolation of the world-line in one window.

use std::sync::Arc;

use super::cursor::Reached;
use super::curved::Curved;
use super::hermite::{Jet, hermite};
use super::legendre::Tables;
use super::partition;
use super::spectral::Polynomials;
use crate::action::Form;
use crate::geometry::geodesic::{acceleration, acceleration_slope};
use crate::geometry::metric::Metric;
use crate::number::{Real, sum};
use crate::solve::{Solution, WindowNodes};

/// The world-line of one coordinate at one value of γ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample<S = f64> {
    /// γ.
    pub gamma: S,
    /// t.
    pub t: S,
    /// x.
    pub x: S,
    /// dt/dγ.
    pub t_dot: S,
    /// dx/dγ.
    pub x_dot: S,
}

#[expect(private_interfaces, reason = "only this module interpolates")]
impl<S: Real> Curved<S> for Metric<S> {
    type Sample = Sample<S>;
    type Curve = Interpolant<S>;
    type Rates = ();

    fn rates_room(&self) {}

    fn curve(solution: &Solution<S>, window: usize, tables: &mut Tables<S>, (): &mut ()) -> Interpolant<S> {
        Interpolant::new(solution, solution.view(window), tables)
    }

    fn sample(_: &Solution<S>, _: usize, curve: &Interpolant<S>, place: S, (): &mut ()) -> Sample<S> {
        curve.at(place)
    }

    /// The sign of dt/dγ is that of Q_t everywhere, so that t is monotonic.
    fn sample_at_value(
        solution: &Solution<S>,
        (a, reached): (usize, &Reached<S>),
        curve: &Interpolant<S>,
        (): &mut (),
    ) -> Sample<S> {
        assert_eq!(a, 0, "in one coordinate t alone grows all the way");
        let elapsed = reached.value - solution.joint(reached.window).q[0];
        curve.at_elapsed(elapsed, reached.falls)
    }

    fn as_asked(sample: Sample<S>, gamma: Option<S>, value: Option<(usize, S)>) -> Sample<S> {
        Sample { gamma: gamma.unwrap_or(sample.gamma), t: value.map_or(sample.t, |(_, t)| t), ..sample }
    }
}

/// The world-line in a window, as a function of γ. γ and t are counted from the start of the window.
#[derive(Debug)]
pub struct Interpolant<S> {
    kind: Kind<S>,
    /// γ and t of the case at the start of the window.
    gamma: S,
    t: S,
    length: S,
    q_t: S,
    metric: Arc<Metric<S>>,
}

#[derive(Debug)]
enum Kind<S> {
    /// Positions of the nodes, and t, x and w* there, with their first two derivatives.
    Hermite { nodes: Vec<S>, jets: [Vec<Jet<S>>; 3] },
    /// Positions of the nodes, weights of barycentric interpolation, and t, x and w* on the nodes.
    Lagrange { nodes: Vec<S>, weights: Vec<S>, values: [Vec<S>; 3] },
    /// Integrals of dt/dγ and d²x/dγ².
    Polynomials(Polynomials<S>),
}

impl<S: Real> Interpolant<S> {
    pub(super) fn new(solution: &Solution<S>, view: WindowNodes<'_, S>, tables: &mut Tables<S>) -> Self {
        let (q_t, metric, window) = (solution.invariants().q_t, &solution.place.geometry, view.window);
        let nodes = || (0..view.grid.points()).map(|k| view.grid.sbp().node(k)).collect::<Vec<_>>();
        let kind = if view.grid.is_equidistant() {
            Kind::Hermite { nodes: nodes(), jets: jets(view, q_t, metric) }
        } else if solution.form == Form::Weak {
            Kind::Polynomials(Polynomials::new(&view, q_t, metric, (tables, solution.accuracy.is_some())))
        } else {
            let nodes = nodes();
            let others = |j: usize| nodes.iter().enumerate().filter(move |(k, _)| *k != j);
            let weight = |j: usize| {
                others(j).fold(S::ONE, |product, (_, &node)| product * (window.length() / (nodes[j] - node)))
            };
            let weights = (0..nodes.len()).map(weight).collect();
            Kind::Lagrange { values: [view.row(0).to_vec(), view.row(1).to_vec(), velocities(view)], weights, nodes }
        };
        Self {
            kind,
            gamma: solution.gamma_i + window.gamma[0],
            t: solution.t_i() + view.start.q[0],
            length: window.length(),
            q_t,
            metric: Arc::clone(metric),
        }
    }

    /// The world-line at `gamma`, counted from the start of the window.
    pub(super) fn at(&self, gamma: S) -> Sample<S> {
        self.sample(gamma, self.values(gamma))
    }

    fn sample(&self, gamma: S, [t, x, x_dot]: [S; 3]) -> Sample<S> {
        let t_dot = self.q_t / self.metric.g00(x);
        Sample { gamma: self.gamma + gamma, t: self.t + t, x, t_dot, x_dot }
    }

    /// t (counted from the start of the window), x and w*.
    fn values(&self, gamma: S) -> [S; 3] {
        match &self.kind {
            Kind::Hermite { nodes, jets } => {
                let k = partition(nodes.len() - 1, |k| nodes[k] <= gamma);
                jets.each_ref().map(|f| hermite(f[k], f[k + 1], nodes[k + 1] - nodes[k], gamma - nodes[k]))
            }
            Kind::Lagrange { nodes, weights, values } => {
                if let Some(k) = nodes.iter().position(|&node| node == gamma) {
                    return values.each_ref().map(|f| f[k]);
                }
                let factor = |k: usize| weights[k] / (gamma - nodes[k]);
                let total = sum((0..nodes.len()).map(factor));
                values.each_ref().map(|f| sum((0..nodes.len()).map(|k| factor(k) * f[k])) / total)
            }
            Kind::Polynomials(polynomials) => polynomials.at(gamma),
        }
    }

    /// The world-line at the time `elapsed`, counted from the start of the window.
    pub(super) fn at_elapsed(&self, elapsed: S, backwards: bool) -> Sample<S> {
        let reached = |value: S| if backwards { value >= elapsed } else { value <= elapsed };
        let (mut low, mut high) = match &self.kind {
            Kind::Hermite { nodes, jets } => {
                let k = partition(nodes.len() - 1, |k| reached(jets[0][k][0]));
                (nodes[k], nodes[k + 1])
            }
            _ => (S::ZERO, self.length),
        };
        // Newton's method from the start of the interval. A step that leaves the interval is replaced by a bisection.
        let mut here = low;
        let mut values = self.values(here);
        for _ in 0..200 {
            let excess = values[0] - elapsed;
            if reached(values[0]) {
                low = here
            } else {
                high = here
            }
            let next = here - excess * self.metric.g00(values[1]) / self.q_t;
            let next = if next >= low && next <= high { next } else { (low + high).half() };
            let step = (next - here).abs();
            if excess == S::ZERO || step <= S::EPSILON * self.length {
                break;
            }
            here = next;
            values = self.values(here);
        }
        self.sample(here, values)
    }
}

/// w* at all nodes. In the strong form the last one is not Dx, and is taken from the end of the window.
fn velocities<S: Real>(view: WindowNodes<'_, S>) -> Vec<S> {
    let mut x_dot = vec![S::ZERO; view.grid.points()];
    view.grid.derivative(view.row(1), view.start.q[1], &mut x_dot);
    x_dot[view.grid.points() - 1] = -view.end.p[1];
    x_dot
}

/// t (counted from the start of the window), x and w* on the nodes, with their first two derivatives.
fn jets<S: Real>(view: WindowNodes<'_, S>, q_t: S, metric: &Metric<S>) -> [Vec<Jet<S>>; 3] {
    let mut jets = [0; 3].map(|_| Vec::with_capacity(view.grid.points()));
    for ((&x, w), &elapsed) in view.row(1).iter().zip(velocities(view)).zip(view.row(0)) {
        let g = metric.at(x);
        let (t_dot, force) = (q_t / g.g00, acceleration(q_t, g.g00, g.first));
        jets[0].push([elapsed, t_dot, -t_dot * g.first * w / g.g00]);
        jets[1].push([x, w, force]);
        jets[2].push([w, force, acceleration_slope(q_t, g.g00, g.first, g.second) * w]);
    }
    jets
}
