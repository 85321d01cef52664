//! The reference trajectory of a scene of n coordinates.
//!
//! ```text
//! q̇^a = g^ab (p_b − A_b),    ṗ_a = ½ ∂_a g_bc q̇^b q̇^c + ∂_a A_b q̇^b + F_a,    ˙ = d/dγ
//! ```
//!
//! The state is q^a of all coordinates and p_a of the active ones; the momenta of the ignorable ones are constants. It
//! is the same Taylor method as in one coordinate, on the program of Hamilton's equations.

mod ends;
mod equations;

pub use ends::SceneReferenceEnds;

use self::equations::{SceneEquations, start_of};
use super::steps::{Accuracy, Goal, Steps, Stop};
use super::{EndReason, accuracy, check_accuracy, largest_relative, unit_of};
use crate::geometry::{Geometry, Start};
use crate::scalar::Real;

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

/// A trajectory of Hamilton's equations of a scene with its own error estimate.
///
/// It is integrated over γ/unit like [`ReferenceTrajectory`](super::ReferenceTrajectory).
///
/// ```
/// use geodesic_ivp::geometry::{Geometry, GeometryText, Preset, Start};
/// use geodesic_ivp::reference::SceneReference;
///
/// // A circular orbit at r = 10 around a mass 1: E = 0.8/√0.7, L = 10/√7, φ = γ L/r².
/// let preset = Preset::from_name("schwarzschild").expect("it is a preset");
/// let geometry: Geometry = Geometry::new(&GeometryText::Metric(preset.text()))?;
/// let (q, q_dot) = (vec![0.0, 10.0, 0.0], vec![1.0 / 0.7_f64.sqrt(), 0.0, 0.1 / 7.0_f64.sqrt()]);
/// let p = geometry.momenta(&q, &q_dot);
/// let reference = SceneReference::new(&geometry, &Start { q, q_dot, p }, 100.0, 16)?;
/// let end = reference.at(100.0);
/// assert!((end.q[1] - 10.0).abs() < 1e-13 && (end.q[2] - 10.0 / 7.0_f64.sqrt()).abs() < 1e-13);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct SceneReference<S = f64> {
    steps: Steps<S>,
    unit: S,
    start: Start<S>,
    /// The active coordinates.
    active: Vec<usize>,
    error_estimate: f64,
}

/// Values that a function is looked at in each step, to find where it changes its sign.
const PROBES: usize = 16;

/// What is integrated.
struct Run<'g, S> {
    geometry: &'g Geometry<S>,
    start: &'g Start<S>,
}

impl<S: Real> Run<'_, S> {
    /// The unit for a range of that length.
    fn unit(&self, length: S, accuracy: Accuracy) -> S {
        let start = start_of(self.geometry, self.start);
        unit_of(length, |unit| {
            let mut equations = SceneEquations::new(self.geometry, self.start, unit, accuracy.order);
            Steps::can_begin(&mut equations, &start, accuracy.order)
        })
    }

    /// Integrates over γ/unit.
    fn integrate(&self, goal: Goal<S>, unit: S, accuracy: Accuracy) -> Result<Steps<S>, SceneReferenceEnds> {
        let mut equations = SceneEquations::new(self.geometry, self.start, unit, accuracy.order);
        let start = start_of(self.geometry, self.start);
        Steps::integrate(&mut equations, &start, goal, accuracy)
            .map_err(|Stop { reason, gamma, state }| self.ends(reason, gamma * unit, &state))
    }

    /// The error that it ends in a state.
    fn ends(&self, reason: EndReason, gamma: S, state: &[S]) -> SceneReferenceEnds {
        let mut q = state[..self.geometry.dimension()].to_vec();
        self.geometry.ignorable().for_each(|a| q[a] += self.start.q[a]);
        let q = self.geometry.names().iter().cloned().zip(q.iter().map(|q| q.to_f64())).collect();
        SceneReferenceEnds { reason, gamma: gamma.to_f64(), q }
    }

    /// The largest difference in a coordinate relative to its size. Coordinates with the same g_aa at the start have
    /// the same unit, and share the largest size: of x and y one may be zero but for rounding.
    fn difference(&self, steps: &Steps<S>, check: &Steps<S>) -> f64 {
        let n = self.geometry.dimension();
        let distances = steps.distances(check, n);
        let sizes: Vec<S> = distances.iter().map(|(_, size)| *size).collect();
        let sizes = self.geometry.shared(&self.start.q, &sizes);
        largest_relative((0..n).map(|a| (distances[a].0, sizes[a])))
    }
}

impl<S: TracedScene> SceneReference<S> {
    /// The trajectory from `start` over γ − γ_i ∈ [0, `length`], with that many `digits`: 16 for `f64`, and 16 to 70 in
    /// extended precision. It starts with the positions and momenta; velocities follow from them.
    ///
    /// # Errors
    /// [`SceneReferenceEnds`] if it leaves the domain or meets a singularity, or is too long.
    pub fn new(geometry: &Geometry<S>, start: &Start<S>, length: S, digits: u32) -> Result<Self, SceneReferenceEnds> {
        S::world_line(geometry, start, length, digits)
    }

    /// The same trajectory, by series of the given `order` whose last terms are `digits` decimal digits below the
    /// first, and without the second integration. Its error estimate is infinite. It is meant for callers who compare
    /// it with something better.
    ///
    /// # Errors
    /// [`SceneReferenceEnds`] if it leaves the domain or meets a singularity, or is too long.
    pub fn unchecked(
        geometry: &Geometry<S>,
        start: &Start<S>,
        length: S,
        order: usize,
        digits: u32,
    ) -> Result<Self, SceneReferenceEnds> {
        S::unchecked_world_line(geometry, start, length, order, digits)
    }

    /// The value of γ − γ_i at which coordinate `a`, which grows or falls all the way, has the given value.
    ///
    /// # Errors
    /// [`SceneReferenceEnds`] if the trajectory leaves the domain before that, or takes too long to get there.
    pub fn length_of(
        geometry: &Geometry<S>,
        start: &Start<S>,
        a: usize,
        value: S,
        digits: u32,
    ) -> Result<S, SceneReferenceEnds> {
        S::length_of_world_line(geometry, start, a, value, digits)
    }

    /// The point at γ − γ_i = `gamma`, which must be inside the range of the trajectory.
    pub fn at(&self, gamma: S) -> ScenePoint<S> {
        S::point_of_world_line(self, gamma)
    }

    /// Every γ − γ_i, in order, at which `f` changes its sign. Two changes that are closer together than a sixteenth of
    /// a Taylor step may be missed.
    pub fn sign_changes(&self, f: impl Fn(&ScenePoint<S>) -> S) -> Vec<S> {
        self.directed_sign_changes(f).into_iter().map(|(gamma, _)| gamma).collect()
    }

    /// The same, with whether `f` is positive after the change.
    pub fn directed_sign_changes(&self, f: impl Fn(&ScenePoint<S>) -> S) -> Vec<(S, bool)> {
        S::sign_changes(self, &f)
    }
}

impl<S: Real> SceneReference<S> {
    fn new_here(geometry: &Geometry<S>, start: &Start<S>, length: S, digits: u32) -> Result<Self, SceneReferenceEnds> {
        let geometry = around(geometry, start)?;
        let (run, accuracy) = (Run { geometry: &geometry, start }, accuracy(digits));
        let unit = run.unit(length, accuracy);
        let goal = Goal::Gamma(length / unit);
        let steps = run.integrate(goal, unit, accuracy)?;
        let check = run.integrate(goal, unit, check_accuracy(digits))?;
        let error_estimate = run.difference(&steps, &check);
        Ok(Self { steps, unit, start: start.clone(), active: geometry.active().to_vec(), error_estimate })
    }

    fn unchecked_here(
        geometry: &Geometry<S>,
        start: &Start<S>,
        length: S,
        order: usize,
        digits: u32,
    ) -> Result<Self, SceneReferenceEnds> {
        let geometry = around(geometry, start)?;
        let (run, accuracy) = (Run { geometry: &geometry, start }, Accuracy { order, share: 1.0, digits });
        let unit = run.unit(length, accuracy);
        let steps = run.integrate(Goal::Gamma(length / unit), unit, accuracy)?;
        Ok(Self {
            steps,
            unit,
            start: start.clone(),
            active: geometry.active().to_vec(),
            error_estimate: f64::INFINITY,
        })
    }

    fn length_of_here(
        geometry: &Geometry<S>,
        start: &Start<S>,
        a: usize,
        value: S,
        digits: u32,
    ) -> Result<S, SceneReferenceEnds> {
        let geometry = around(geometry, start)?;
        let (run, accuracy) = (Run { geometry: &geometry, start }, accuracy(digits));
        let distance = value - start.q[a];
        let length = (distance / start.q_dot[a]).abs();
        // From rest nothing tells how far it is.
        let length = if length.is_finite() { length } else { S::ONE };
        let unit = run.unit(length, accuracy);
        let value = if geometry.active().contains(&a) { value } else { distance };
        let goal = Goal::Value { component: a, value, sign: distance.signum(), length: length / unit };
        run.integrate(goal, unit, accuracy).map(|steps| steps.end() * unit)
    }

    /// The estimated relative error: the largest difference in a coordinate at the ends of its steps between this
    /// trajectory and one with another order and other steps. It is relative to the largest absolute value of the
    /// coordinate, or of one with the same g_aa at the start. Ignorable coordinates are counted from the start.
    pub fn error_estimate(&self) -> f64 {
        self.error_estimate
    }

    /// Number of Taylor steps.
    pub fn steps(&self) -> usize {
        self.steps.len()
    }

    /// γ − γ_i at the end of the range.
    pub fn end(&self) -> S {
        self.steps.end() * self.unit
    }

    fn at_here(&self, gamma: S) -> ScenePoint<S> {
        let (components, s) = self.steps.at(gamma / self.unit);
        let n = self.start.q.len();
        let offset = |a: usize| if self.active.contains(&a) { S::ZERO } else { self.start.q[a] };
        let q = (0..n).map(|a| offset(a) + components[a].value(s)).collect();
        let q_dot = (0..n).map(|a| components[a].slope(s) / self.unit).collect();
        let mut p = self.start.p.clone();
        for (place, &a) in self.active.iter().enumerate() {
            p[a] = components[n + place].value(s);
        }
        ScenePoint { q, q_dot, p }
    }

    fn sign_changes_here(&self, f: &dyn Fn(&ScenePoint<S>) -> S) -> Vec<(S, bool)> {
        let value = |gamma: S| f(&self.at_here(gamma * self.unit));
        let ends: Vec<S> = self.steps.ends().collect();
        let mut found = Vec::new();
        let (mut before, mut sign) = (ends[0], value(ends[0]));
        for pair in ends.windows(2) {
            for probe in 1..=PROBES {
                let gamma = pair[0] + (pair[1] - pair[0]) * S::from(probe as f64 / PROBES as f64);
                let next = value(gamma);
                if next != S::ZERO {
                    if sign != S::ZERO && next.signum() != sign.signum() {
                        let change = bisected(before, gamma, |gamma| value(gamma) * sign > S::ZERO) * self.unit;
                        found.push((change, next > S::ZERO));
                    }
                    (before, sign) = (gamma, next);
                }
            }
        }
        found
    }
}

/// Where `is_before` becomes false between the two numbers.
fn bisected<S: Real>(from: S, to: S, is_before: impl Fn(S) -> bool) -> S {
    let (mut from, mut to) = (from, to);
    loop {
        let middle = (from + to).half();
        if middle <= from || middle >= to {
            return to;
        }
        if is_before(middle) { from = middle } else { to = middle }
    }
}

/// The geometry with the domain that the start lies in.
fn around<S: Real>(geometry: &Geometry<S>, start: &Start<S>) -> Result<Geometry<S>, SceneReferenceEnds> {
    geometry.clone().around_here(&start.q).map_err(|_| SceneReferenceEnds {
        reason: EndReason::OutsideDomain,
        gamma: 0.0,
        q: geometry.names().iter().cloned().zip(start.q.iter().map(|q| q.to_f64())).collect(),
    })
}

crate::compiled! {
    /// Numbers in which trajectories of scenes are computed.
    pub trait TracedScene {
        fn world_line(
            geometry: &Geometry<Self>,
            start: &Start<Self>,
            length: Self,
            digits: u32,
        ) -> Result<SceneReference<Self>, SceneReferenceEnds> = SceneReference::new_here;
        fn unchecked_world_line(
            geometry: &Geometry<Self>,
            start: &Start<Self>,
            length: Self,
            order: usize,
            digits: u32,
        ) -> Result<SceneReference<Self>, SceneReferenceEnds> = SceneReference::unchecked_here;
        fn length_of_world_line(
            geometry: &Geometry<Self>,
            start: &Start<Self>,
            a: usize,
            value: Self,
            digits: u32,
        ) -> Result<Self, SceneReferenceEnds> = SceneReference::length_of_here;
        fn point_of_world_line(this: &SceneReference<Self>, gamma: Self) -> ScenePoint<Self> = SceneReference::at_here;
        fn sign_changes(
            this: &SceneReference<Self>,
            f: &dyn Fn(&ScenePoint<Self>) -> Self,
        ) -> Vec<(Self, bool)> = SceneReference::sign_changes_here;
    }
}
