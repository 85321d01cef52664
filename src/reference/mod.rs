//! The trajectory to compare with: the geodesic equations integrated by a Taylor method of high order.
//!
//! ```text
//! dx/dγ = w,    dw/dγ = −½ g00′(x) (Q_t/g00(x))²,    dt/dγ = Q_t/g00(x)
//! ```
//!
//! Each step expands t and x in γ, to order 24 for the 16 digits of `f64` and to higher ones for more, from the
//! potential's own program, so every potential of a case has a reference, formulas included. The step is chosen so that
//! the last terms are below the rounding of the first; the state is summed with compensation. A step is halved where V
//! has a feature that the series do not know of, and stops where an argument of `abs` changes its sign. The polynomials
//! of the steps are the dense output. The whole integration is done twice, with different order and steps, and the
//! difference is the reported error estimate. The number of steps is limited according to the cost of a step with that
//! many digits.
//!
//! ```
//! use geodesic_ivp::geodesic::InitialData;
//! use geodesic_ivp::metric::Metric;
//! use geodesic_ivp::potential::Potential;
//! use geodesic_ivp::reference::ReferenceTrajectory;
//!
//! let metric: Metric = Metric::new(Potential::quartic(0.5), 1.0, 1.0);
//! let initial = InitialData { t: 0.0, x: 1.0, t_dot: 1.0, x_dot: 0.1 };
//! let reference = ReferenceTrajectory::new(&metric, initial, 1.0, 16)?;
//! assert!((reference.at(1.0).x - 0.159_778_018_885_407).abs() < 1e-14);
//! # Ok::<(), geodesic_ivp::reference::ReferenceEnds>(())
//! ```

mod series;
mod steps;
mod time_parametrised;

pub use time_parametrised::{TimeState, time_parametrised};

use std::fmt;

use crate::geodesic::InitialData;
use crate::metric::Metric;
use crate::scalar::Real;

use self::steps::{Accuracy, Goal, Steps};

/// The trajectory that is used. The cheapest order for a truncation of 10^−d is about 1.15 d; a little more makes
/// longer steps and adds less rounding.
fn accuracy(digits: u32) -> Accuracy {
    Accuracy { order: digits as usize * 3 / 2, share: 1.0, digits: digits + 1 }
}

/// The trajectory that checks it.
fn check_accuracy(digits: u32) -> Accuracy {
    Accuracy { order: digits as usize * 5 / 4, share: 0.7, digits: digits + 1 }
}

/// A point of the reference trajectory.
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

/// Why a reference trajectory ends early.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EndReason {
    /// It meets g00 ≤ 0 or a point where V is not finite.
    OutsideDomain,
    /// V is not smooth enough there to be expanded in a series.
    Singular,
    /// The requested physical time is not reached: t hardly grows any more.
    TimeNotReached,
    /// The range takes more Taylor steps than are allowed.
    TooLong {
        /// The number of steps that are allowed.
        most_steps: usize,
    },
}

/// There is no trajectory to compare with over the whole range.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReferenceEnds {
    /// Why.
    pub reason: EndReason,
    /// γ − γ_i where it ends.
    pub gamma: f64,
    /// x there.
    pub x: f64,
    /// g00 there.
    pub g00: f64,
}

impl fmt::Display for ReferenceEnds {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let what = match self.reason {
            EndReason::OutsideDomain => "the geodesic leaves the domain".to_owned(),
            EndReason::Singular => "the potential has no Taylor series".to_owned(),
            EndReason::TimeNotReached => "the physical time t_f is not reached".to_owned(),
            EndReason::TooLong { most_steps } => {
                format!("the whole run would take more than {most_steps} Taylor steps, the limit for so many digits")
            }
        };
        let Self { gamma, x, g00, .. } = self;
        write!(f, "the reference trajectory ends at gamma - gamma_i = {gamma:.6}, x = {x:.6e}, g00 = {g00:.3e}: {what}")
    }
}

impl std::error::Error for ReferenceEnds {}

/// A trajectory of the geodesic equations with its own error estimate.
///
/// It is integrated over γ/unit, with a unit near the length of the run: coefficient j of a series has the size of
/// γ^−j, and would leave the range of numbers where γ is far from 1. The unit is a power of two and rounds nothing.
#[derive(Debug, Clone)]
pub struct ReferenceTrajectory<S = f64> {
    steps: Steps<S>,
    unit: S,
    error_estimate: f64,
}

/// The steps over γ/unit.
fn integrate<S: Real>(
    metric: &Metric<S>,
    initial: InitialData<S>,
    goal: Goal<S>,
    unit: S,
    accuracy: Accuracy,
) -> Result<Steps<S>, ReferenceEnds> {
    let goal = match goal {
        Goal::Gamma(length) => Goal::Gamma(length / unit),
        Goal::Time(duration) => Goal::Time(duration),
    };
    Steps::integrate(metric, stretched(initial, unit), goal, accuracy)
        .map_err(|end| ReferenceEnds { gamma: end.gamma * unit.to_f64(), ..end })
}

/// How often, and by which power of two, a unit is made smaller.
const SMALLER_UNITS: usize = 20;
const SMALLER_BY: i32 = 20;

/// The power of two near a length; a smaller one if the length is so many steps long that coefficients would leave the
/// range of numbers.
fn unit_of<S: Real>(metric: &Metric<S>, initial: InitialData<S>, length: S, accuracy: Accuracy) -> S {
    let near = length.to_f64().abs().log2().round().exp2();
    let near = if near.is_normal() { near } else { 1.0 };
    let smaller = (0..SMALLER_UNITS as i32).map(|k| near * 2.0_f64.powi(-SMALLER_BY * k));
    let mut units = smaller.filter(|unit| unit.is_normal()).map(S::from);
    units.find(|&unit| Steps::can_begin(metric, stretched(initial, unit), accuracy)).unwrap_or(S::from(near))
}

fn stretched<S: Real>(initial: InitialData<S>, unit: S) -> InitialData<S> {
    InitialData { t_dot: initial.t_dot * unit, x_dot: initial.x_dot * unit, ..initial }
}

impl<S: Real> ReferenceTrajectory<S> {
    /// The geodesic of `metric` from `initial` over γ − γ_i ∈ [0, `length`] to that many `digits` (16 to 70; no more
    /// than 16 for `f64`). Time counts from the start.
    ///
    /// # Errors
    /// [`ReferenceEnds`] if it meets g00 ≤ 0 or a singularity of V, or is too long.
    pub fn new(metric: &Metric<S>, initial: InitialData<S>, length: S, digits: u32) -> Result<Self, ReferenceEnds> {
        let accuracy = accuracy(digits);
        let (goal, unit) = (Goal::Gamma(length), unit_of(metric, initial, length, accuracy));
        let steps = integrate(metric, initial, goal, unit, accuracy)?;
        let check = integrate(metric, initial, goal, unit, check_accuracy(digits))?;
        let error_estimate = steps.distance(&check);
        Ok(Self { steps, unit, error_estimate })
    }

    /// The same by series of `order` whose last terms are `digits` decimal digits below the first, and without the
    /// second integration, so the error estimate is infinite. It is meant for callers who compare with something
    /// better.
    ///
    /// # Errors
    /// [`ReferenceEnds`] if it meets g00 ≤ 0 or a singularity of V, or is too long.
    pub fn unchecked(
        metric: &Metric<S>,
        initial: InitialData<S>,
        length: S,
        order: usize,
        digits: u32,
    ) -> Result<Self, ReferenceEnds> {
        let accuracy = Accuracy { order, share: 1.0, digits };
        let unit = unit_of(metric, initial, length, accuracy);
        let steps = integrate(metric, initial, Goal::Gamma(length), unit, accuracy)?;
        Ok(Self { steps, unit, error_estimate: f64::INFINITY })
    }

    /// The value of γ − γ_i at which t − t_i = `duration`.
    ///
    /// # Errors
    /// [`ReferenceEnds`] if the geodesic leaves the domain before that time, or takes too long to reach it.
    pub fn length_of(
        metric: &Metric<S>,
        initial: InitialData<S>,
        duration: S,
        digits: u32,
    ) -> Result<S, ReferenceEnds> {
        let accuracy = accuracy(digits);
        let unit = unit_of(metric, initial, duration / initial.t_dot, accuracy);
        integrate(metric, initial, Goal::Time(duration), unit, accuracy).map(|steps| steps.end() * unit)
    }

    /// The largest difference in t or x, relative to the largest |t − t_i| or |x|, between this trajectory and one of
    /// another order and step, over the ends of its steps.
    pub fn error_estimate(&self) -> f64 {
        self.error_estimate
    }

    /// Number of Taylor steps.
    pub fn steps(&self) -> usize {
        self.steps.len()
    }

    /// The point at γ − γ_i = `gamma`, inside the range it was made for.
    pub fn at(&self, gamma: S) -> ReferencePoint<S> {
        let ReferencePoint { elapsed, x, t_dot, x_dot } = self.steps.at(gamma / self.unit);
        ReferencePoint { elapsed, x, t_dot: t_dot / self.unit, x_dot: x_dot / self.unit }
    }
}
