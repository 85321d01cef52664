//! The reference trajectory of any space-time.

use super::ends::{EndReason, ReferenceEnds};
use super::equations::Equations;
use super::steps::{Accuracy, Goal, Steps, Stop};
use crate::geometry::{Geometry, Start};
use crate::number::Real;

/// Values that a function is looked at in each step, to find where it changes its sign.
const PROBES: usize = 16;

/// The accuracy of the trajectory that is used. For a truncation error of 10^−d the cheapest order is about 1.15 d. A
/// higher order makes longer steps, which add less rounding.
fn accuracy(digits: u32) -> Accuracy {
    Accuracy { order: digits as usize * 3 / 2, share: 1.0, digits: digits + 1 }
}

/// The accuracy of the trajectory that checks it.
fn check_accuracy(digits: u32) -> Accuracy {
    Accuracy { order: digits as usize * 5 / 4, share: 0.7, digits: digits + 1 }
}

/// The most times that a unit is made smaller, and the power of two of each time.
const SMALLER_UNITS: usize = 20;
const SMALLER_BY: i32 = 20;

/// A scene with a start.
struct Begun<'g, S> {
    geometry: Geometry<S>,
    start: &'g Start<S>,
}

impl<'g, S: Real> Begun<'g, S> {
    /// With the domain that the start lies in.
    ///
    /// # Errors
    /// If it starts outside the domain.
    fn new(geometry: &Geometry<S>, start: &'g Start<S>) -> Result<Self, ReferenceEnds> {
        let around = geometry.clone().around(&start.q);
        let geometry = around.map_err(|_| ends(geometry, EndReason::OutsideDomain, 0.0, &start.q))?;
        Ok(Self { geometry, start })
    }

    /// The state at the start. Positions and momenta have no unit of γ.
    fn state(&self) -> Vec<S> {
        let mut state = self.start.q.clone();
        self.geometry.ignorable().for_each(|a| state[a] = S::ZERO);
        state.extend(self.geometry.active().iter().map(|&a| self.start.p[a]));
        state
    }

    /// The unit of a trajectory of about that `length`: the power of two nearest to it, or a smaller one if with that
    /// the integration cannot begin: coefficients would overflow, because the run takes very many steps.
    fn unit_for(&self, length: S, Accuracy { order, .. }: Accuracy) -> S {
        let near = length.to_f64().abs().log2().round().exp2();
        let near = if near.is_normal() { near } else { 1.0 };
        let smaller = (0..SMALLER_UNITS as i32).map(|k| near * 2.0_f64.powi(-SMALLER_BY * k));
        let can_begin = |unit: &S| {
            let mut equations = Equations::new(&self.geometry, self.start, *unit, order);
            Steps::can_begin(&mut equations, &self.state(), order)
        };
        smaller.filter(|unit| unit.is_normal()).map(S::from).find(can_begin).unwrap_or(S::from(near))
    }

    /// Integrates over γ/`unit`.
    fn integrate(&self, goal: Goal<S>, unit: S, accuracy: Accuracy) -> Result<Steps<S>, ReferenceEnds> {
        let mut equations = Equations::new(&self.geometry, self.start, unit, accuracy.order);
        let steps = Steps::integrate(&mut equations, &self.state(), goal.over(unit), accuracy);
        steps.map_err(|Stop { reason, gamma, state }| {
            let mut q = state[..self.geometry.dimension()].to_vec();
            self.geometry.ignorable().for_each(|a| q[a] += self.start.q[a]);
            ends(&self.geometry, reason, (gamma * unit).to_f64(), &q)
        })
    }

    /// The goal that coordinate `a` has a value, over γ.
    fn goal(&self, a: usize, value: S) -> Goal<S> {
        let distance = value - self.start.q[a];
        let length = (distance / self.start.q_dot[a]).abs();
        // From rest nothing tells how far it is.
        let length = if length.is_finite() { length } else { S::ONE };
        let value = if self.geometry.active().contains(&a) { value } else { distance };
        Goal::Value { component: a, value, sign: distance.signum(), length }
    }

    /// The largest relative difference between two integrations. Coordinates with the same g_aa at the start have the
    /// same unit, and share the largest size: of x and y one may be zero but for rounding.
    fn difference(&self, steps: &Steps<S>, check: &Steps<S>) -> f64 {
        let n = self.geometry.dimension();
        let distances = steps.distances(check, n);
        let sizes: Vec<S> = distances.iter().map(|(_, size)| *size).collect();
        let sizes = self.geometry.shared(&self.start.q, &sizes);
        distances.iter().zip(sizes).fold(0.0, |largest, (&(distance, _), size)| {
            let relative = if distance.is_finite() { (distance / size).to_f64() } else { f64::INFINITY };
            largest.max(relative)
        })
    }
}

/// The error that a trajectory ends where the coordinates are `q`.
fn ends<S: Real>(geometry: &Geometry<S>, reason: EndReason, gamma: f64, q: &[S]) -> ReferenceEnds {
    let g00 = geometry.g00(q);
    let place = match g00 {
        Some(g00) => [("x", q[1]), ("g00", g00)].map(|(name, value)| (name.to_owned(), value.to_f64())).to_vec(),
        None => geometry.names().iter().cloned().zip(q.iter().map(|q| q.to_f64())).collect(),
    };
    ReferenceEnds { reason, gamma, place, is_of_x: g00.is_some() }
}

/// A trajectory of the equations of motion with its own error estimate.
///
/// It is integrated over γ/unit, where the unit is near the length of the run. Coefficient j of a series has a size
/// like γ^−j, which could overflow or underflow for γ far from 1. The unit is a power of two, so that scaling by it
/// rounds nothing.
///
/// ```
/// use geodesic_ivp::geometry::{Geometry, GeometryText, Preset, Start};
/// use geodesic_ivp::reference::ReferenceTrajectory;
///
/// // A circular orbit at r = 10 around a mass 1: E = 0.8/√0.7, L = 10/√7, φ = γ L/r².
/// let preset = Preset::from_name("schwarzschild").expect("it is a preset");
/// let geometry: Geometry = Geometry::new(&GeometryText::Metric(preset.text()))?;
/// let (q, q_dot) = (vec![0.0, 10.0, 0.0], vec![1.0 / 0.7_f64.sqrt(), 0.0, 0.1 / 7.0_f64.sqrt()]);
/// let p = geometry.momenta(&q, &q_dot);
/// let reference = ReferenceTrajectory::new(&geometry, &Start { q, q_dot, p }, 100.0, 16)?;
/// let end = reference.at(100.0);
/// assert!((end.q[1] - 10.0).abs() < 1e-13 && (end.q[2] - 10.0 / 7.0_f64.sqrt()).abs() < 1e-13);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct ReferenceTrajectory<S = f64> {
    steps: Steps<S>,
    unit: S,
    /// The start, from which ignorable coordinates are counted, and the active ones.
    start: Start<S>,
    active: Vec<usize>,
    error_estimate: f64,
}

impl<S: Real> ReferenceTrajectory<S> {
    /// The trajectory in `geometry` from `start` over γ − γ_i ∈ [0, `length`], with that many `digits`: 16 for `f64`,
    /// and 16 to 70 in extended precision. It starts with the positions and momenta; velocities follow from them.
    ///
    /// # Errors
    /// [`ReferenceEnds`] if it leaves the domain or meets a singularity, or is too long.
    pub fn new(geometry: &Geometry<S>, start: &Start<S>, length: S, digits: u32) -> Result<Self, ReferenceEnds> {
        let (run, rough) = Self::over(geometry, start, length, accuracy(digits))?;
        let check = run.integrate(Goal::Gamma(length), rough.unit, check_accuracy(digits))?;
        Ok(Self { error_estimate: run.difference(&rough.steps, &check), ..rough })
    }

    /// The same trajectory, by series of the given `order` whose last terms are `digits` decimal digits below the
    /// first, and without the second integration. Its error estimate is infinite. It is meant for callers who compare
    /// it with something better.
    ///
    /// # Errors
    /// [`ReferenceEnds`] if it leaves the domain or meets a singularity, or is too long.
    pub fn unchecked(
        geometry: &Geometry<S>,
        start: &Start<S>,
        length: S,
        order: usize,
        digits: u32,
    ) -> Result<Self, ReferenceEnds> {
        Ok(Self::over(geometry, start, length, Accuracy { order, share: 1.0, digits })?.1)
    }

    /// The trajectory with an accuracy, and without an error estimate.
    fn over<'s>(
        geometry: &Geometry<S>,
        start: &'s Start<S>,
        length: S,
        accuracy: Accuracy,
    ) -> Result<(Begun<'s, S>, Self), ReferenceEnds> {
        let run = Begun::new(geometry, start)?;
        let unit = run.unit_for(length, accuracy);
        let steps = run.integrate(Goal::Gamma(length), unit, accuracy)?;
        let (start, active) = (start.clone(), geometry.active().to_vec());
        Ok((run, Self { steps, unit, start, active, error_estimate: f64::INFINITY }))
    }

    /// The value of γ − γ_i at which coordinate `a`, which grows or falls all the way, has the given value.
    ///
    /// # Errors
    /// [`ReferenceEnds`] if the trajectory leaves the domain before that, or takes too long to get there.
    pub fn length_of(
        geometry: &Geometry<S>,
        start: &Start<S>,
        a: usize,
        value: S,
        digits: u32,
    ) -> Result<S, ReferenceEnds> {
        let (run, accuracy) = (Begun::new(geometry, start)?, accuracy(digits));
        let goal = run.goal(a, value);
        let unit = run.unit_for(goal.scale(), accuracy);
        run.integrate(goal, unit, accuracy).map(|steps| steps.end() * unit)
    }

    /// The point at γ − γ_i = `gamma`, which must be inside the range of the trajectory.
    pub fn at(&self, gamma: S) -> Start<S> {
        let (components, s) = self.steps.at(gamma / self.unit);
        let n = self.start.q.len();
        let offset = |a: usize| if self.active.contains(&a) { S::ZERO } else { self.start.q[a] };
        let q = (0..n).map(|a| offset(a) + components[a].value(s)).collect();
        let q_dot = (0..n).map(|a| components[a].slope(s) / self.unit).collect();
        let mut p = self.start.p.clone();
        for (place, &a) in self.active.iter().enumerate() {
            p[a] = components[n + place].value(s);
        }
        Start { q, q_dot, p }
    }

    /// The estimated relative error: the largest difference in a coordinate at the ends of its steps between this
    /// trajectory and one with another order and other steps. It is relative to the largest absolute value of the
    /// coordinate, or of one with the same g_aa at the start. Ignorable coordinates are counted from there.
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

    /// Every γ − γ_i, in order, at which `f` changes its sign. Two changes that are closer together than a sixteenth of
    /// a Taylor step may be missed.
    pub fn sign_changes(&self, f: impl Fn(&Start<S>) -> S) -> Vec<S> {
        self.directed_sign_changes(f).into_iter().map(|(gamma, _)| gamma).collect()
    }

    /// The same, with whether `f` is positive after the change.
    pub fn directed_sign_changes(&self, f: impl Fn(&Start<S>) -> S) -> Vec<(S, bool)> {
        let value = |gamma: S| f(&self.at(gamma * self.unit));
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
