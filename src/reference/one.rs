//! The geodesic equations of one coordinate: the state is x, t − t_i and w = dx/dγ.

use super::EndReason;
use super::analytic::{Analytic, Origin, Run, largest_relative};
use super::ends::{ReferenceEnds, Words};
use super::equations::{Equations, Series};
use super::polynomials::{Polynomial, increment, slope};
use super::series::ProgramSeries;
use super::size::gap;
use super::steps::{Goal, Steps};
use crate::formula::Program;
use crate::geometry::geodesic::{InitialData, acceleration};
use crate::geometry::metric::Metric;
use crate::number::{Real, sum};

/// Places of the components.
const X: usize = 0;
const T: usize = 1;
const W: usize = 2;
/// x and t are kept; w is the derivative of x.
const KEPT: usize = 2;
/// If steps shrink while g00 is below this share of its first value, the trajectory approaches a horizon.
const HORIZON: f64 = 1e-3;

/// A point of the trajectory of one coordinate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReferencePoint<S = f64> {
    /// t − t_i.
    pub elapsed: S,
    /// x.
    pub x: S,
    /// dt/dγ.
    pub t_dot: S,
    /// dx/dγ.
    pub x_dot: S,
}

/// Points count t from the start, and need to know nothing of it.
#[derive(Debug, Clone, Copy)]
pub struct Elapsed;

impl<S: Real> Origin<S> for Elapsed {
    type Point = ReferencePoint<S>;

    fn point(&self, components: &[Polynomial<S>], s: S, unit: S) -> ReferencePoint<S> {
        let (x, t) = (&components[X], &components[T]);
        let [t_dot, x_dot] = [t, x].map(|component| component.slope(s) / unit);
        ReferencePoint { elapsed: t.value(s), x: x.value(s), t_dot, x_dot }
    }
}

#[expect(private_interfaces, reason = "only this module integrates")]
impl<S: Real> Analytic<S> for Metric<S> {
    type Start = InitialData<S>;
    type Point = ReferencePoint<S>;
    type Origin = Elapsed;

    fn begin(&self, start: &InitialData<S>) -> Result<impl Run<S, Origin = Elapsed>, ReferenceEnds> {
        Ok(Begun { metric: self, program: self.potential().program(), start: *start })
    }
}

/// A potential with a start.
struct Begun<'m, S> {
    metric: &'m Metric<S>,
    program: Program<S>,
    start: InitialData<S>,
}

impl<S: Real> Begun<'_, S> {
    /// The start over γ/`unit`.
    fn stretched(&self, unit: S) -> InitialData<S> {
        let initial = self.start;
        InitialData { t_dot: initial.t_dot * unit, x_dot: initial.x_dot * unit, ..initial }
    }
}

impl<S: Real> Run<S> for Begun<'_, S> {
    type Origin = Elapsed;

    fn origin(&self) -> Elapsed {
        Elapsed
    }

    fn state(&self, unit: S) -> Vec<S> {
        let initial = self.stretched(unit);
        vec![initial.x, S::ZERO, initial.x_dot]
    }

    fn equations(&self, unit: S, order: usize) -> impl Equations<S> {
        let (metric, initial) = (self.metric, self.stretched(unit));
        OneCoordinate {
            metric,
            q_t: initial.invariants(metric).q_t,
            g00_start: metric.g00(initial.x),
            values: ProgramSeries::new(&self.program, vec![self.program.output(0), self.program.output(1)], order),
        }
    }

    /// Of t, which grows.
    fn goal(&self, a: usize, duration: S) -> Goal<S> {
        assert_eq!(a, 0, "in one coordinate t alone grows all the way");
        Goal::Value { component: T, value: duration, sign: S::ONE, length: duration / self.start.t_dot }
    }

    fn difference(&self, steps: &Steps<S>, check: &Steps<S>) -> f64 {
        largest_relative(steps.distances(check, KEPT))
    }

    fn ends(&self, reason: EndReason, gamma: f64, state: &[S]) -> ReferenceEnds {
        let numbers = [("x", state[X]), ("g00", self.metric.g00(state[X]))];
        let place = numbers.map(|(name, value)| (name.to_owned(), value.to_f64())).to_vec();
        let words = Words { formula: "the potential", value: "the physical time t_f" };
        ReferenceEnds { reason, gamma, place, words }
    }
}

/// dx/dγ = w, dw/dγ = −½ g00′ (Q_t/g00)², dt/dγ = Q_t/g00.
struct OneCoordinate<'m, S> {
    metric: &'m Metric<S>,
    q_t: S,
    /// g00 at the start.
    g00_start: S,
    values: ProgramSeries<S>,
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
        self.values.restart();
        for k in 0..order {
            self.values.extend(k, [(0, x[k])].into_iter());
            let [v, first] = [0, 1].map(|output| self.values.output(output)[k]);
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
        self.values.kink_arguments()
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
