//! Hamilton's equations of a scene of n coordinates: the state is q^a of all coordinates, and then p_a of the active
//! ones. The momenta of the ignorable ones are constants.
//!
//! ```text
//! q̇^a = g^ab (p_b − A_b),    ṗ_a = ½ ∂_a g_bc q̇^b q̇^c + ∂_a A_b q̇^b + F_a,    ˙ = d/dγ
//! ```

use super::EndReason;
use super::analytic::{Analytic, Origin, Run, largest_relative};
use super::ends::{ReferenceEnds, Words};
use super::equations::{Equations, Series};
use super::polynomials::{Polynomial, increment, slope};
use super::series::ProgramSeries;
use super::size::gap;
use super::steps::{Goal, Steps};
use crate::geometry::{Geometry, Hamiltonian, Point, Start};
use crate::number::Real;

/// If steps shrink while a determinant is below this share of its first value, or that many times above it, the
/// trajectory approaches the edge of the domain.
const EDGE: f64 = 1e-3;

/// By how much the state is shifted to see what rounding does to its derivatives: these multiples of ε, in turn.
const SHIFTS: [f64; 5] = [4.0, -8.0, 12.0, -4.0, 8.0];

/// A point of the trajectory of a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct ScenePoint<S = f64> {
    /// q^a.
    pub q: Vec<S>,
    /// dq^a/dγ.
    pub q_dot: Vec<S>,
    /// p_a.
    pub p: Vec<S>,
}

/// The start, with the active coordinates.
#[derive(Debug, Clone)]
pub struct Beginning<S> {
    start: Start<S>,
    active: Vec<usize>,
}

impl<S: Real> Origin<S> for Beginning<S> {
    type Point = ScenePoint<S>;

    fn point(&self, components: &[Polynomial<S>], s: S, unit: S) -> ScenePoint<S> {
        let n = self.start.q.len();
        let offset = |a: usize| if self.active.contains(&a) { S::ZERO } else { self.start.q[a] };
        let q = (0..n).map(|a| offset(a) + components[a].value(s)).collect();
        let q_dot = (0..n).map(|a| components[a].slope(s) / unit).collect();
        let mut p = self.start.p.clone();
        for (place, &a) in self.active.iter().enumerate() {
            p[a] = components[n + place].value(s);
        }
        ScenePoint { q, q_dot, p }
    }
}

#[expect(private_interfaces, reason = "only this module integrates")]
impl<S: Real> Analytic<S> for Geometry<S> {
    type Start = Start<S>;
    type Point = ScenePoint<S>;
    type Origin = Beginning<S>;

    /// With the domain that the start lies in.
    fn begin(&self, start: &Start<S>) -> Result<impl Run<S, Origin = Beginning<S>>, ReferenceEnds> {
        let geometry = self.clone().around(&start.q);
        let geometry = geometry.map_err(|_| ends(self, EndReason::OutsideDomain, 0.0, &start.q))?;
        Ok(Begun { geometry, start })
    }
}

/// The error that a trajectory ends where the coordinates are `q`.
fn ends<S: Real>(geometry: &Geometry<S>, reason: EndReason, gamma: f64, q: &[S]) -> ReferenceEnds {
    let place = geometry.names().iter().cloned().zip(q.iter().map(|q| q.to_f64())).collect();
    let words = Words { formula: "a formula", value: "the value of the coordinate" };
    ReferenceEnds { reason, gamma, place, words }
}

/// A scene with a start.
struct Begun<'g, S> {
    geometry: Geometry<S>,
    start: &'g Start<S>,
}

impl<S: Real> Run<S> for Begun<'_, S> {
    type Origin = Beginning<S>;

    fn origin(&self) -> Beginning<S> {
        Beginning { start: self.start.clone(), active: self.geometry.active().to_vec() }
    }

    /// Positions and momenta have no unit of γ.
    fn state(&self, _: S) -> Vec<S> {
        let mut state = self.start.q.clone();
        self.geometry.ignorable().for_each(|a| state[a] = S::ZERO);
        state.extend(self.geometry.active().iter().map(|&a| self.start.p[a]));
        state
    }

    fn equations(&self, unit: S, order: usize) -> impl Equations<S> {
        SceneEquations::new(&self.geometry, self.start, unit, order)
    }

    fn goal(&self, a: usize, value: S) -> Goal<S> {
        let distance = value - self.start.q[a];
        let length = (distance / self.start.q_dot[a]).abs();
        // From rest nothing tells how far it is.
        let length = if length.is_finite() { length } else { S::ONE };
        let value = if self.geometry.active().contains(&a) { value } else { distance };
        Goal::Value { component: a, value, sign: distance.signum(), length }
    }

    /// Coordinates with the same g_aa at the start have the same unit, and share the largest size: of x and y one may
    /// be zero but for rounding.
    fn difference(&self, steps: &Steps<S>, check: &Steps<S>) -> f64 {
        let n = self.geometry.dimension();
        let distances = steps.distances(check, n);
        let sizes: Vec<S> = distances.iter().map(|(_, size)| *size).collect();
        let sizes = self.geometry.shared(&self.start.q, &sizes);
        largest_relative((0..n).map(|a| (distances[a].0, sizes[a])))
    }

    fn ends(&self, reason: EndReason, gamma: f64, state: &[S]) -> ReferenceEnds {
        let mut q = state[..self.geometry.dimension()].to_vec();
        self.geometry.ignorable().for_each(|a| q[a] += self.start.q[a]);
        ends(&self.geometry, reason, gamma, &q)
    }
}

/// The equations over γ/unit. Ignorable coordinates are counted from the start.
struct SceneEquations<'g, S> {
    geometry: &'g Geometry<S>,
    unit: S,
    /// Momenta; those of the active coordinates are overwritten.
    p: Vec<S>,
    /// The determinants of the metric's blocks at the start.
    determinants: Vec<S>,
    values: ProgramSeries<S>,
    point: Point<S>,
}

impl<'g, S: Real> SceneEquations<'g, S> {
    fn new(geometry: &'g Geometry<S>, start: &Start<S>, unit: S, order: usize) -> Self {
        let Hamiltonian { program, velocities, forces, .. } = geometry.hamiltonian();
        Self {
            geometry,
            unit,
            p: start.p.clone(),
            determinants: geometry.determinants(&start.q),
            values: ProgramSeries::new(program, [&velocities[..], forces].concat(), order),
            point: geometry.point(),
        }
    }

    /// dq^a/dγ of all coordinates and dp_a/dγ of the active ones; `None` outside the domain.
    fn derivatives(&mut self, state: &[S]) -> Option<Vec<S>> {
        let n = self.geometry.dimension();
        for (&a, &p) in self.geometry.active().iter().zip(&state[n..]) {
            self.p[a] = p;
        }
        self.point.evaluate(&state[..n], &self.p).ok()?;
        let q_dot = (0..n).map(|a| self.point.q_dot(a));
        let p_dot = (n..state.len()).map(|component| self.point.p_dot(component - n));
        Some(q_dot.chain(p_dot).map(|rate| rate * self.unit).collect())
    }

    /// What rounding may do to the derivatives.
    fn rounding(&mut self, state: &[S], derivatives: &[S]) -> Vec<S> {
        let shifted = |(k, &value): (usize, &S)| value + value * (S::from(SHIFTS[k % SHIFTS.len()]) * S::EPSILON);
        let charges = self.p.clone();
        self.p = charges.iter().enumerate().map(shifted).collect();
        let state: Vec<S> = state.iter().enumerate().map(shifted).collect();
        let others = self.derivatives(&state);
        self.p = charges;
        match others {
            Some(others) => others.iter().zip(derivatives).map(|(&a, &b)| gap(a, b)).collect(),
            None => vec![S::ZERO; derivatives.len()],
        }
    }
}

impl<S: Real> Equations<S> for SceneEquations<'_, S> {
    fn kept(&self) -> usize {
        self.geometry.dimension() + self.geometry.active().len()
    }

    fn first_of_scale(&self, component: usize) -> usize {
        let is_ignorable = component < self.geometry.dimension() && !self.geometry.active().contains(&component);
        usize::from(is_ignorable)
    }

    fn expand(&mut self, state: &[S], order: usize) -> Series<S> {
        let n = self.geometry.dimension();
        let mut series: Series<S> = state.iter().map(|&value| vec![value]).collect();
        let mut place_of = vec![None; n];
        for (place, &a) in self.geometry.active().iter().enumerate() {
            place_of[a] = Some(n + place);
        }
        self.values.restart();
        for k in 0..order {
            let charge = |a: usize| if k == 0 { self.p[a] } else { S::ZERO };
            let q = (0..n).map(|a| (a, series[a][k]));
            let p = (0..n).map(|a| (2 * n + a, place_of[a].map_or_else(|| charge(a), |place| series[place][k])));
            self.values.extend(k, q.chain(p));
            let next = S::from((k + 1) as f64);
            for (component, series) in series.iter_mut().enumerate() {
                series.push(self.values.output(component)[k] * self.unit / next);
            }
        }
        series
    }

    fn kink_arguments(&self) -> impl Iterator<Item = &[S]> {
        self.values.kink_arguments()
    }

    fn missed(&mut self, series: &Series<S>, h: S, s: S, small: S) -> S {
        let state: Vec<S> = series.iter().map(|c| c[0] + increment(c, s)).collect();
        let Some(derivatives) = self.derivatives(&state) else { return S::from(f64::INFINITY) };
        let sizes: Vec<S> = (series.iter().enumerate())
            .map(|(component, c)| {
                let of_value = if self.first_of_scale(component) == 0 { c[0].abs() / h } else { S::ZERO };
                c[1].abs().max((c[2] * h).abs()).max(of_value).max(S::MIN_POSITIVE)
            })
            .collect();
        let gaps: Vec<S> = series.iter().zip(&derivatives).map(|(c, &d)| gap(slope(c, s), d)).collect();
        let largest = |gaps: &[S]| gaps.iter().zip(&sizes).fold(S::ZERO, |all, (&gap, &size)| all.max(gap / size));
        let missed = largest(&gaps);
        if missed <= small {
            return missed;
        }
        // A force that is the small difference of large ones is not known to so many digits.
        let rounding = self.rounding(&state, &derivatives);
        largest(&gaps.iter().zip(&rounding).map(|(&gap, &rounding)| gap - rounding).collect::<Vec<S>>())
    }

    fn is_inside(&mut self, state: &[S]) -> bool {
        self.derivatives(state).is_some()
    }

    fn is_near_the_edge(&mut self, state: &[S]) -> bool {
        let determinants = self.geometry.determinants(&state[..self.geometry.dimension()]);
        let edge = S::from(EDGE);
        determinants.iter().zip(&self.determinants).any(|(here, start)| {
            let (here, start) = (here.abs(), start.abs());
            here < edge * start || start < edge * here
        })
    }
}
