//! A world-line of a scene, window by window.

use std::ops::ControlFlow;

use super::attempt::{Ended, Walk};
use super::judge::ROUNDING;
use super::request::{Request, Target};
use super::rule::{self, Rule};
use super::state::FlowState;
use super::stop::{Stop, Watch};
use super::view::FlowView;
use super::{FlowFailure, Followed};
use crate::geometry::{Geometry, Start};

/// A march along a world-line of a scene that keeps to a requested accuracy.
#[derive(Debug, Clone, Copy)]
pub struct Flow<'g> {
    geometry: &'g Geometry,
    certify: bool,
    target: Option<Target>,
}

/// A lower accuracy would cost hardly less, and windows that resolve nothing do not show it.
const LOOSEST: f64 = 1e-4;

/// Above the first accuracy 16 nodes are cheapest, down to the second 20, and below that 24.
const COARSE: f64 = 5e-9;
const MEDIUM: f64 = 5e-11;

impl<'g> Flow<'g> {
    /// In `geometry`, whose determinants have the signs of the start.
    pub fn new(geometry: &'g Geometry) -> Self {
        Self { geometry, certify: false, target: None }
    }

    /// Ends with this value of a coordinate, as a stop that stands before all others. Errors are those at equal values
    /// of this coordinate then, as well as those at equal γ.
    pub fn to_value(mut self, coordinate: usize, value: f64) -> Self {
        self.target = Some(Target { coordinate, value });
        self
    }

    /// Computes the certificate of every window too.
    pub fn certified(mut self) -> Self {
        self.certify = true;
        self
    }

    /// From `start` over `length` of γ, which may be infinite, or to the first change of sign of one of the `stops`.
    /// `observe` sees every window of the world-line and may end the march; if a march is begun again, it sees index 0
    /// again.
    ///
    /// # Errors
    /// [`FlowFailure`] where the world-line leaves the domain, and if the accuracy is not reached.
    pub fn run(
        &self,
        start: &Start,
        length: f64,
        stops: &mut [&mut dyn Stop],
        accuracy: f64,
        observe: &mut dyn FnMut(&FlowView<'_>) -> ControlFlow<()>,
    ) -> Result<Followed, FlowFailure> {
        let accuracy = accuracy.min(LOOSEST);
        let request = Request {
            start: FlowState::new(start, self.geometry.active()),
            q_dot: &start.q_dot,
            momenta: &start.p,
            length,
            target: self.target,
            accuracy,
            certify: self.certify,
        };
        let mut target = self.target;
        let target = target.iter_mut().map(|target| target as &mut dyn Stop);
        let stops = target.chain(stops.iter_mut().map(|stop| &mut **stop as &mut dyn Stop));
        let mut watches: Vec<Watch<'_>> = stops.map(|stop| Watch::new(stop, &start.p)).collect();
        if accuracy >= COARSE {
            self.with(rule::coarse(), &request, &mut watches, observe)
        } else if accuracy >= MEDIUM {
            self.with(rule::medium(), &request, &mut watches, observe)
        } else {
            self.with(rule::fine(), &request, &mut watches, observe)
        }
    }

    fn with<const P: usize>(
        &self,
        rule: Rule<P>,
        request: &Request<'_>,
        watches: &mut [Watch<'_>],
        observe: &mut dyn FnMut(&FlowView<'_>) -> ControlFlow<()>,
    ) -> Result<Followed, FlowFailure> {
        if request.accuracy < ROUNDING {
            let q = request.start.q.iter().map(|q| q.hi).collect();
            return Err(FlowFailure::AccuracyNotReached { gamma: 0.0, q, estimate: ROUNDING });
        }
        let mut walk = Walk::new(self.geometry, request, rule);
        let (mut caution, mut missed) = (1.0, f64::INFINITY);
        for attempts in 1.. {
            match walk.attempt(caution, missed, watches, observe) {
                Err(Ended::Failed(failure)) => return Err(failure),
                Err(Ended::Inaccurate { factor, expected }) => {
                    caution *= factor;
                    missed = expected;
                }
                Ok(followed) => return Ok(Followed { attempts, ..followed }),
            }
        }
        unreachable!("the shares run out")
    }
}
