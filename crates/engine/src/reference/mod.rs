//! The reference: a trajectory of the geodesic equations to compare with, by a Taylor method of high order.
//!
//! ```text
//! dx/dγ = w,    dw/dγ = −½ g00′(x) (Q_t/g00(x))²,    dt/dγ = Q_t/g00(x)
//! ```
//!
//! Each step expands t and x in γ: to order 24 for the 16 digits of `f64`, and to higher orders for more digits. The
//! series are computed from the program of the potential, so that every potential of a case has a reference, formulas
//! included. The step is chosen so that the last terms are below the rounding of the first ones, and the states are
//! added up with compensated sums. A step is halved if V has a feature that the series do not show. It ends early where
//! an argument of `abs` changes its sign. The polynomials of the steps are the dense output. The whole integration is
//! done twice, with different orders and steps, and the difference is the reported error estimate. The number of steps
//! is limited, and the limit is lower for more digits, because their steps cost more.
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
//!
//! [`SceneReference`] is the same for scenes of n coordinates. The steps know only a system of equations of first order
//! (`equations.rs`); that of one coordinate (`one.rs`) and Hamilton's equations of a scene (`scene/`) are two of them.

mod equations;
mod one;
mod polynomials;
mod scene;
mod series;
mod size;
mod steps;
mod time_parametrised;

pub use scene::{ScenePoint, SceneReference, SceneReferenceEnds, TracedScene};
pub use time_parametrised::{TimeState, time_parametrised};

use std::fmt;

use crate::geodesic::InitialData;
use crate::metric::Metric;
use crate::scalar::Real;

use self::one::{KEPT, OneCoordinate, T, X, start_of};
use self::steps::{Accuracy, Goal, Steps, Stop};

/// The accuracy of the trajectory that is used. For a truncation error of 10^−d the cheapest order is about 1.15 d. A
/// higher order makes longer steps, which add less rounding.
fn accuracy(digits: u32) -> Accuracy {
    Accuracy { order: digits as usize * 3 / 2, share: 1.0, digits: digits + 1 }
}

/// The accuracy of the trajectory that checks it.
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
    /// The trajectory meets g00 ≤ 0 or a point where V is not finite; in a scene, a point where a determinant of the
    /// metric changes its sign or a number is not finite.
    OutsideDomain,
    /// V, or another formula, is not smooth enough there to be expanded in a series.
    Singular,
    /// The requested physical time, or value of a coordinate, is not reached, because t hardly grows any more.
    TimeNotReached,
    /// The range would take more Taylor steps than are allowed.
    TooLong {
        /// The number of steps that are allowed.
        most_steps: usize,
    },
}

impl EndReason {
    /// In words; `formula` has no series, and `value` is not reached.
    fn in_words(self, formula: &str, value: &str) -> String {
        match self {
            Self::OutsideDomain => "the geodesic leaves the domain".to_owned(),
            Self::Singular => format!("{formula} has no Taylor series"),
            Self::TimeNotReached => format!("{value} is not reached"),
            Self::TooLong { most_steps } => {
                format!("the whole run would take more than {most_steps} Taylor steps, the limit for so many digits")
            }
        }
    }
}

/// The error that a reference trajectory ends before the end of the requested range.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReferenceEnds {
    /// Why it ends.
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
        let what = self.reason.in_words("the potential", "the physical time t_f");
        let Self { gamma, x, g00, .. } = self;
        write!(f, "the reference trajectory ends at gamma - gamma_i = {gamma:.6}, x = {x:.6e}, g00 = {g00:.3e}: {what}")
    }
}

impl std::error::Error for ReferenceEnds {}

/// A trajectory of the geodesic equations with its own error estimate.
///
/// It is integrated over γ/unit, where the unit is near the length of the run. Coefficient j of a series has a size
/// like γ^−j, which could overflow or underflow for γ far from 1. The unit is a power of two, so that scaling by it
/// rounds nothing.
#[derive(Debug, Clone)]
pub struct ReferenceTrajectory<S = f64> {
    steps: Steps<S>,
    unit: S,
    error_estimate: f64,
}

/// Integrates over γ/unit.
fn integrate<S: Real>(
    metric: &Metric<S>,
    initial: InitialData<S>,
    goal: Goal<S>,
    unit: S,
    accuracy: Accuracy,
) -> Result<Steps<S>, ReferenceEnds> {
    let initial = stretched(initial, unit);
    let program = metric.potential().program();
    let mut equations = OneCoordinate::new(metric, &program, initial, accuracy.order);
    Steps::integrate(&mut equations, &start_of(initial), goal, accuracy).map_err(|Stop { reason, gamma, state }| {
        let (gamma, g00) = (gamma.to_f64() * unit.to_f64(), metric.g00(state[X]).to_f64());
        ReferenceEnds { reason, gamma, x: state[X].to_f64(), g00 }
    })
}

/// How often a unit is made smaller at most, and by which power of two each time.
const SMALLER_UNITS: usize = 20;
const SMALLER_BY: i32 = 20;

/// The power of two nearest to `length`, or a smaller one if with that the integration cannot begin: coefficients would
/// overflow, because the run takes very many steps.
fn unit_of<S: Real>(length: S, mut can_begin: impl FnMut(S) -> bool) -> S {
    let near = length.to_f64().abs().log2().round().exp2();
    let near = if near.is_normal() { near } else { 1.0 };
    let smaller = (0..SMALLER_UNITS as i32).map(|k| near * 2.0_f64.powi(-SMALLER_BY * k));
    let mut units = smaller.filter(|unit| unit.is_normal()).map(S::from);
    units.find(|&unit| can_begin(unit)).unwrap_or(S::from(near))
}

/// The unit of a trajectory of about that `length`.
fn unit_for<S: Real>(metric: &Metric<S>, initial: InitialData<S>, length: S, accuracy: Accuracy) -> S {
    let program = metric.potential().program();
    unit_of(length, |unit| {
        let initial = stretched(initial, unit);
        let mut equations = OneCoordinate::new(metric, &program, initial, accuracy.order);
        Steps::can_begin(&mut equations, &start_of(initial), accuracy.order)
    })
}

fn stretched<S: Real>(initial: InitialData<S>, unit: S) -> InitialData<S> {
    InitialData { t_dot: initial.t_dot * unit, x_dot: initial.x_dot * unit, ..initial }
}

/// The largest of the differences relative to the sizes.
fn largest_relative<S: Real>(distances: impl IntoIterator<Item = (S, S)>) -> f64 {
    distances.into_iter().fold(0.0, |largest, (distance, size)| {
        let relative = if distance.is_finite() { (distance / size).to_f64() } else { f64::INFINITY };
        largest.max(relative)
    })
}

impl<S: Traced> ReferenceTrajectory<S> {
    /// The geodesic of `metric` from `initial` over γ − γ_i ∈ [0, `length`], with that many `digits`: 16 for `f64`, and
    /// 16 to 70 in extended precision. Time is counted from the start.
    ///
    /// # Errors
    /// [`ReferenceEnds`] if the geodesic meets g00 ≤ 0 or a singularity of V, or is too long.
    pub fn new(metric: &Metric<S>, initial: InitialData<S>, length: S, digits: u32) -> Result<Self, ReferenceEnds> {
        S::trajectory(metric, initial, length, digits)
    }

    /// The same geodesic, by series of the given `order` whose last terms are `digits` decimal digits below the first,
    /// and without the second integration. Its error estimate is infinite. It is meant for callers who compare it with
    /// something better.
    ///
    /// # Errors
    /// [`ReferenceEnds`] if the geodesic meets g00 ≤ 0 or a singularity of V, or is too long.
    pub fn unchecked(
        metric: &Metric<S>,
        initial: InitialData<S>,
        length: S,
        order: usize,
        digits: u32,
    ) -> Result<Self, ReferenceEnds> {
        S::unchecked_trajectory(metric, initial, length, order, digits)
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
        S::length_of_trajectory(metric, initial, duration, digits)
    }

    /// The point at γ − γ_i = `gamma`, which must be inside the range of the trajectory.
    pub fn at(&self, gamma: S) -> ReferencePoint<S> {
        S::point_of_trajectory(self, gamma)
    }
}

impl<S: Real> ReferenceTrajectory<S> {
    fn new_here(metric: &Metric<S>, initial: InitialData<S>, length: S, digits: u32) -> Result<Self, ReferenceEnds> {
        let accuracy = accuracy(digits);
        let unit = unit_for(metric, initial, length, accuracy);
        let goal = Goal::Gamma(length / unit);
        let steps = integrate(metric, initial, goal, unit, accuracy)?;
        let check = integrate(metric, initial, goal, unit, check_accuracy(digits))?;
        let error_estimate = largest_relative(steps.distances(&check, KEPT));
        Ok(Self { steps, unit, error_estimate })
    }

    fn unchecked_here(
        metric: &Metric<S>,
        initial: InitialData<S>,
        length: S,
        order: usize,
        digits: u32,
    ) -> Result<Self, ReferenceEnds> {
        let accuracy = Accuracy { order, share: 1.0, digits };
        let unit = unit_for(metric, initial, length, accuracy);
        let steps = integrate(metric, initial, Goal::Gamma(length / unit), unit, accuracy)?;
        Ok(Self { steps, unit, error_estimate: f64::INFINITY })
    }

    fn length_of_here(
        metric: &Metric<S>,
        initial: InitialData<S>,
        duration: S,
        digits: u32,
    ) -> Result<S, ReferenceEnds> {
        let accuracy = accuracy(digits);
        let unit = unit_for(metric, initial, duration / initial.t_dot, accuracy);
        let length = duration / stretched(initial, unit).t_dot;
        let goal = Goal::Value { component: T, value: duration, sign: S::ONE, length };
        integrate(metric, initial, goal, unit, accuracy).map(|steps| steps.end() * unit)
    }

    /// The estimated relative error: the largest difference in t or x at the ends of its steps between this trajectory
    /// and one with another order and other steps, relative to the largest |t − t_i| or |x|.
    pub fn error_estimate(&self) -> f64 {
        self.error_estimate
    }

    /// Number of Taylor steps.
    pub fn steps(&self) -> usize {
        self.steps.len()
    }

    fn at_here(&self, gamma: S) -> ReferencePoint<S> {
        let (components, s) = self.steps.at(gamma / self.unit);
        let (x, t) = (&components[X], &components[T]);
        let [t_dot, x_dot] = [t, x].map(|component| component.slope(s) / self.unit);
        ReferencePoint { elapsed: t.value(s), x: x.value(s), t_dot, x_dot }
    }
}

crate::compiled! {
    /// Numbers in which trajectories are computed.
    pub trait Traced {
        fn trajectory(
            metric: &Metric<Self>,
            initial: InitialData<Self>,
            length: Self,
            digits: u32,
        ) -> Result<ReferenceTrajectory<Self>, ReferenceEnds> = ReferenceTrajectory::new_here;
        fn unchecked_trajectory(
            metric: &Metric<Self>,
            initial: InitialData<Self>,
            length: Self,
            order: usize,
            digits: u32,
        ) -> Result<ReferenceTrajectory<Self>, ReferenceEnds> = ReferenceTrajectory::unchecked_here;
        fn length_of_trajectory(
            metric: &Metric<Self>,
            initial: InitialData<Self>,
            duration: Self,
            digits: u32,
        ) -> Result<Self, ReferenceEnds> = ReferenceTrajectory::length_of_here;
        fn point_of_trajectory(
            this: &ReferenceTrajectory<Self>,
            gamma: Self,
        ) -> ReferencePoint<Self> = ReferenceTrajectory::at_here;
    }
}
