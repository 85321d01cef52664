//! The reference trajectory of any space-time.

use super::equations::Equations;
use super::steps::{Accuracy, Goal, Steps};
use super::{EndReason, ReferenceEnds};
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

/// The unit of a trajectory of about that `length`: the power of two nearest to it, or a smaller one if with that the
/// integration cannot begin: coefficients would overflow, because the run takes very many steps.
fn unit_for<S: Real>(geometry: &Geometry<S>, start: &Start<S>, length: S, Accuracy { order, .. }: Accuracy) -> S {
    let near = length.to_f64().abs().log2().round().exp2();
    let near = if near.is_normal() { near } else { 1.0 };
    let smaller = (0..SMALLER_UNITS as i32).map(|k| near * 2.0_f64.powi(-SMALLER_BY * k));
    let can_begin = |unit: &S| Steps::can_begin(Equations::new(geometry, start, *unit, order), order);
    smaller.filter(|unit| unit.is_normal()).map(S::from).find(can_begin).unwrap_or(S::from(near))
}

/// The largest relative difference between two integrations. Coordinates with the same g_aa at the start have the same
/// unit, and share the largest size: of x and y one may be zero but for rounding.
fn difference<S: Real>(geometry: &Geometry<S>, start: &Start<S>, steps: &Steps<S>, check: &Steps<S>) -> f64 {
    let (distances, sizes): (Vec<S>, Vec<S>) = steps.distances(check, geometry.dimension()).into_iter().unzip();
    let sizes = geometry.shared(&start.q, &sizes);
    distances.into_iter().zip(sizes).fold(0.0, |largest, (distance, size)| {
        let relative = if distance.is_finite() { (distance / size).to_f64() } else { f64::INFINITY };
        largest.max(relative)
    })
}

/// A trajectory of the equations of motion with its own error estimate.
///
/// It is integrated over γ/unit, where the unit is near the length of the run. Coefficient j of a series has a size
/// like γ^−j, which could overflow or underflow for γ far from 1. The unit is a power of two, so that scaling by it
/// rounds nothing.
///
/// ```
/// use geodesic_ivp::geometry::{Geometry, Preset, Start};
/// use geodesic_ivp::reference::ReferenceTrajectory;
///
/// // A circular orbit at r = 10 around a mass 1: E = 0.8/√0.7, L = 10/√7, φ = γ L/r².
/// let preset = Preset::from_name("schwarzschild").expect("it is a preset");
/// let geometry: Geometry = Geometry::new(&preset.text())?;
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
    /// The start, from which ignorable coordinates are counted.
    start: Start<S>,
    geometry: Geometry<S>,
    error_estimate: f64,
}

impl<S: Real> ReferenceTrajectory<S> {
    /// The trajectory in `geometry` from `start` over γ − γ_i ∈ [0, `length`], with that many `digits`: 16 for `f64`,
    /// and 16 to 70 in extended precision. It starts with the positions and momenta; velocities follow from them.
    ///
    /// # Errors
    /// [`ReferenceEnds`] if it leaves the domain or meets a singularity, or is too long.
    pub fn new(geometry: &Geometry<S>, start: &Start<S>, length: S, digits: u32) -> Result<Self, ReferenceEnds> {
        let rough = Self::over(geometry, start, (length, None), accuracy(digits))?;
        let check = check_accuracy(digits);
        let equations = Equations::new(&rough.geometry, start, rough.unit, check.order);
        let check = Steps::integrate(equations, Goal { length: length / rough.unit, value: None }, check)?;
        Ok(Self { error_estimate: difference(&rough.geometry, start, &rough.steps, &check), ..rough })
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
        Self::over(geometry, start, (length, None), Accuracy { order, share: 1.0, digits })
    }

    /// The trajectory with an accuracy, and without an error estimate, over a length or, after about that length, to a
    /// value of a coordinate.
    fn over(
        geometry: &Geometry<S>,
        start: &Start<S>,
        (length, value): (S, Option<(usize, S)>),
        accuracy: Accuracy,
    ) -> Result<Self, ReferenceEnds> {
        let around = geometry.clone().with_domain_of(&start.q);
        let geometry = around.map_err(|_| ReferenceEnds::new(geometry, EndReason::OutsideDomain, S::ZERO, &start.q))?;
        let unit = unit_for(&geometry, start, length, accuracy);
        let value = value.map(|(a, value)| {
            let distance = value - start.q[a];
            (a, if geometry.active().contains(&a) { value } else { distance }, distance.signum())
        });
        let equations = Equations::new(&geometry, start, unit, accuracy.order);
        let steps = Steps::integrate(equations, Goal { length: length / unit, value }, accuracy)?;
        Ok(Self { steps, unit, start: start.clone(), geometry, error_estimate: f64::INFINITY })
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
        let length = ((value - start.q[a]) / start.q_dot[a]).abs();
        // From rest nothing tells how far it is.
        let length = if length.is_finite() { length } else { S::ONE };
        let found = Self::over(geometry, start, (length, Some((a, value))), accuracy(digits))?;
        Ok(found.steps.end.high * found.unit)
    }

    /// The point at γ − γ_i = `gamma`, which must be inside the range of the trajectory.
    pub fn at(&self, gamma: S) -> Start<S> {
        let (step, s) = self.steps.at(gamma / self.unit);
        let n = self.start.q.len();
        let offset = |a: usize| if self.geometry.active().contains(&a) { S::ZERO } else { self.start.q[a] };
        let q = (0..n).map(|a| offset(a) + step.value(a, s)).collect();
        let q_dot = (0..n).map(|a| step.slope(a, s) / self.unit).collect();
        let mut p = self.start.p.clone();
        for (place, &a) in self.geometry.active().iter().enumerate() {
            p[a] = step.value(n + place, s);
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
        self.steps.steps.len()
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
