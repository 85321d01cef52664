//! The reference trajectory of any space-time.

use super::begun::Begun;
use super::ends::ReferenceEnds;
use super::steps::{Accuracy, Goal, Steps, Stop};
use crate::geometry::{Geometry, Start};
use crate::number::Real;

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
    pub(super) steps: Steps<S>,
    pub(super) unit: S,
    /// The start, from which ignorable coordinates are counted, and the active ones.
    start: Start<S>,
    active: Vec<usize>,
    error_estimate: f64,
}

/// Integrates over γ/unit.
fn integrate<S: Real>(
    run: &Begun<'_, S>,
    goal: Goal<S>,
    unit: S,
    accuracy: Accuracy,
) -> Result<Steps<S>, ReferenceEnds> {
    let mut equations = run.equations(unit, accuracy.order);
    Steps::integrate(&mut equations, &run.state(), goal.over(unit), accuracy)
        .map_err(|Stop { reason, gamma, state }| run.ends(reason, (gamma * unit).to_f64(), &state))
}

/// The unit of a trajectory of about that `length`: the power of two nearest to it, or a smaller one if with that the
/// integration cannot begin: coefficients would overflow, because the run takes very many steps.
fn unit_for<S: Real>(run: &Begun<'_, S>, length: S, accuracy: Accuracy) -> S {
    let near = length.to_f64().abs().log2().round().exp2();
    let near = if near.is_normal() { near } else { 1.0 };
    let smaller = (0..SMALLER_UNITS as i32).map(|k| near * 2.0_f64.powi(-SMALLER_BY * k));
    let mut units = smaller.filter(|unit| unit.is_normal()).map(S::from);
    let can_begin = |unit: S| {
        let mut equations = run.equations(unit, accuracy.order);
        Steps::can_begin(&mut equations, &run.state(), accuracy.order)
    };
    units.find(|&unit| can_begin(unit)).unwrap_or(S::from(near))
}

impl<S: Real> ReferenceTrajectory<S> {
    /// The trajectory in `geometry` from `start` over γ − γ_i ∈ [0, `length`], with that many `digits`: 16 for `f64`,
    /// and 16 to 70 in extended precision. It starts with the positions and momenta; velocities follow from them.
    ///
    /// # Errors
    /// [`ReferenceEnds`] if it leaves the domain or meets a singularity, or is too long.
    pub fn new(geometry: &Geometry<S>, start: &Start<S>, length: S, digits: u32) -> Result<Self, ReferenceEnds> {
        let (run, accuracy) = (Begun::new(geometry, start)?, accuracy(digits));
        let unit = unit_for(&run, length, accuracy);
        let steps = integrate(&run, Goal::Gamma(length), unit, accuracy)?;
        let check = integrate(&run, Goal::Gamma(length), unit, check_accuracy(digits))?;
        let (error_estimate, active) = (run.difference(&steps, &check), run.active().to_vec());
        Ok(Self { steps, unit, start: start.clone(), active, error_estimate })
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
        let (run, accuracy) = (Begun::new(geometry, start)?, Accuracy { order, share: 1.0, digits });
        let unit = unit_for(&run, length, accuracy);
        let steps = integrate(&run, Goal::Gamma(length), unit, accuracy)?;
        let active = run.active().to_vec();
        Ok(Self { steps, unit, start: start.clone(), active, error_estimate: f64::INFINITY })
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
        let unit = unit_for(&run, goal.scale(), accuracy);
        integrate(&run, goal, unit, accuracy).map(|steps| steps.end() * unit)
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
}
