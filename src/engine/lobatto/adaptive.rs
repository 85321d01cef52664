//! Windows as long, and a rule of as high an order, as the requested accuracy needs.

use std::ops::ControlFlow;

use super::attempt::{Attempt, Ended};
use super::force::{Force, PolynomialForce};
use super::formula::FormulaForce;
use super::judge::ROUNDING;
use super::kit::{self, Kit};
use super::view::WindowView;
use super::walk::Walk;
use super::{Goal, MarchFailure, State, Statistics};
use crate::engine::enclosure::Enclosure;
use crate::geometry::geodesic::acceleration_slope;
use crate::geometry::metric::Metric;
use crate::geometry::potential::Potential;
use crate::number::vector::Twofold;

/// Where an adaptive march ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Adapted {
    /// The last state.
    pub end: State,
    /// γ − γ_i at the last state.
    pub gamma: Twofold,
    /// The work done, including rejected windows.
    pub statistics: Statistics,
    /// An upper estimate of the error in t and x at all nodes, relative to max(1, largest |t − t_i|) and
    /// max(1, largest |x|).
    pub error_estimate: f64,
    /// How often the march was begun; every attempt but the last turned out not to be accurate enough.
    pub attempts: usize,
}

/// A march that keeps to a requested accuracy.
///
/// The rule is whichever of those with 16, 20 or 24 nodes is cheapest for the accuracy. The length of a window is
/// chosen such that the squares of the highest Legendre coefficients of a and u but the last, which bound the error at
/// the window's end, stay below a share of the accuracy, and what the coefficients themselves mean for the nodes inside
/// stays below the accuracy. Lengths change seldom: equal windows are more accurate than many that follow the force
/// closely.
///
/// There is no second integration to compare with. The local errors of the windows add up to a shift along the
/// world-line, and what K has lost, which is known exactly, is the error of the energy: that is all an error of one
/// coordinate and its velocity can be. How both grow follows from the flow at the joints (see the module `judge`).
/// Where that turns out to be more than was asked for, the march is begun again with a smaller share, down to rounding,
/// after which it fails.
///
/// The tables serve all lengths and are made once in the life of the program; the first march with a rule is a fraction
/// of a millisecond slower.
#[derive(Debug, Clone, Copy)]
pub struct Adaptive<'a> {
    metric: &'a Metric,
    q_t: f64,
    certify: bool,
}

/// A lower accuracy would cost hardly less, and windows that resolve nothing, such as next to a horizon, do not show
/// it.
const LOOSEST: f64 = 1e-4;

/// Above the first accuracy 16 nodes are cheapest, down to the second 20, and below that 24.
const COARSE: f64 = 2e-5;
const MEDIUM: f64 = 2e-7;

/// The first window to try, in radians of the oscillation that the force has there.
const FIRST: f64 = 1.5;
/// The whole range is tried in one window if it is no longer than this many first windows.
const ONE: f64 = 1.7;

impl<'a> Adaptive<'a> {
    /// With the charge `q_t`.
    pub fn new(metric: &'a Metric, q_t: f64) -> Self {
        Self { metric, q_t, certify: false }
    }

    /// Computes the certificate of every window too, for [`WindowView::certified`].
    pub fn certified(mut self) -> Self {
        self.certify = true;
        self
    }

    /// From `start` to `goal`, the error of t and x below `accuracy` at all nodes, relative to
    /// max(1, largest |t − t_i|) and max(1, largest |x|). `observe` sees every window of the world-line and may end the
    /// march; if a march is begun again, it sees index 0 again.
    ///
    /// # Errors
    /// [`MarchFailure`] where the world-line leaves the domain, and if the accuracy or the goal is not reached.
    pub fn run(
        &self,
        start: State,
        goal: Goal,
        accuracy: f64,
        observe: &mut dyn FnMut(&WindowView<'_>) -> ControlFlow<()>,
    ) -> Result<Adapted, MarchFailure> {
        let accuracy = accuracy.min(LOOSEST);
        if accuracy >= COARSE {
            self.with(kit::coarse(), start, goal, accuracy, observe)
        } else if accuracy >= MEDIUM {
            self.with(kit::medium(), start, goal, accuracy, observe)
        } else {
            self.with(kit::fine(), start, goal, accuracy, observe)
        }
    }

    fn with<const P: usize>(
        &self,
        kit: &'static Kit<P>,
        start: State,
        goal: Goal,
        accuracy: f64,
        observe: &mut dyn FnMut(&WindowView<'_>) -> ControlFlow<()>,
    ) -> Result<Adapted, MarchFailure> {
        let Self { metric, q_t, .. } = *self;
        match metric.potential() {
            Potential::Polynomial(p) => {
                let force = PolynomialForce::new(metric, q_t, p.coefficients());
                self.attempts(kit, (force, None), start, goal, accuracy, observe)
            }
            Potential::Formula(f) => {
                let force = FormulaForce::<P>::new(metric, q_t, f.program(), kit.rule.points());
                self.attempts(kit, (force, Enclosure::of_metric(metric)), start, goal, accuracy, observe)
            }
        }
    }

    fn attempts<const P: usize, F: Force>(
        &self,
        kit: &'static Kit<P>,
        (force, enclosure): (F, Option<Enclosure>),
        start: State,
        goal: Goal,
        accuracy: f64,
        observe: &mut dyn FnMut(&WindowView<'_>) -> ControlFlow<()>,
    ) -> Result<Adapted, MarchFailure> {
        let Self { metric, q_t, .. } = *self;
        let g = metric.at(start.x.hi);
        if !g.is_inside() {
            return Err(MarchFailure::OutsideDomain { window: 0, gamma: 0.0, x: start.x.hi, g00: g.g00 });
        }
        if accuracy < ROUNDING {
            return Err(MarchFailure::AccuracyNotReached { gamma: 0.0, estimate: ROUNDING });
        }
        let t_dot = q_t / g.g00;
        let length = match goal {
            Goal::Gamma(length) => length,
            Goal::Time(duration) => duration / t_dot,
        };
        let mut statistics = Statistics::default();
        if !(length > 0.0 && length.is_finite()) {
            return if length == 0.0 {
                Ok(Adapted { end: start, gamma: Twofold::ZERO, statistics, error_estimate: 0.0, attempts: 0 })
            } else {
                Err(MarchFailure::TimeNotReached { gamma: 0.0, elapsed: 0.0 })
            };
        }
        let stiffness = acceleration_slope(q_t, g.g00, g.first, g.second).abs();
        let first = FIRST / stiffness.max(1e-60).sqrt();
        // A second window costs more than finding out that one is needed.
        let first = if length < ONE * first { length } else { first };
        let mut walk = Walk::new(kit, force, enclosure, self.certify);
        // Long runs at the limit of the arithmetic leave no room for truncation beside rounding.
        let windows = length / first;
        let mut caution = if 1e-16 * windows.powf(1.5) > 20.0 * accuracy { 1e-3 } else { 1.0 };
        for attempts in 1.. {
            let attempt = Attempt { metric, q_t, start, goal, accuracy, length, first, caution };
            match attempt.walk(&mut walk, &mut statistics, observe) {
                Err(Ended::Failed(failure)) => return Err(failure),
                Err(Ended::Inaccurate { next }) => caution = next,
                Ok((end, gamma, error_estimate)) => {
                    return Ok(Adapted { end, gamma, statistics, error_estimate, attempts });
                }
            }
        }
        unreachable!("the shares run out")
    }
}
