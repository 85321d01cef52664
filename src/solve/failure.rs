//! Why there is no critical point, in one coordinate and in scenes.

use std::fmt;

use super::status::{InitialGuess, Iterations, MOST_EVENTS, MOST_NODES, MOST_SWEEPS, Status};
use crate::geometry::{Geometry, OutsideGeometry};
use crate::number::Real;
use crate::number::norm::rounded_up;

/// The reason why there is no critical point, and where the solve stood.
#[derive(Debug, Clone, PartialEq)]
pub struct NoSolution {
    /// Any status but [`Status::Converged`].
    pub status: Status,
    /// γ of the node where it failed: of the point outside the domain, otherwise of the largest residual entry.
    pub gamma: f64,
    /// The names of the active coordinates with their values there, where they are known. In one coordinate it is x.
    pub point: Vec<(String, f64)>,
    /// The metric there.
    pub domain: Domain,
    /// Largest residual entry at the last accepted iterate (infinite if none was accepted); the estimated error where
    /// an accuracy is not reached.
    pub residual: f64,
    /// The need of a run beyond a limit: nodes, or evaluations of the force. Where an accuracy is not reached, the
    /// one for which rounding leaves room. It is 0 for every other status.
    pub needed: f64,
    /// The accuracy that was asked for and is not reached; 0 for every other status.
    pub asked: f64,
    /// True if an accuracy was asked for, so that windows and operator were not the user's to choose.
    pub adaptive: bool,
    /// The reasons for which a run to an accuracy may have failed.
    pub reasons: Box<Reasons>,
    /// The iterations done.
    pub iterations: Box<Iterations>,
}

/// The number that says whether a point is inside the domain of a metric.
#[derive(Debug, Clone, PartialEq)]
pub enum Domain {
    /// In one coordinate g00, which must be positive.
    G00(f64),
    /// In one coordinate, where a number is beyond the range of numbers: g00 there.
    Overflow(f64),
    /// In a scene the determinant that has the wrong sign.
    Determinant {
        /// The names of the coordinates in its block of the metric.
        coordinates: Vec<String>,
        /// The determinant.
        value: f64,
    },
    /// In a scene, where no determinant has the wrong sign. Outside the domain another number is not finite.
    Scene,
}

/// The place of a run to an accuracy where windows are shortest: a close encounter, a pole of coordinates or a
/// collision. What the run fails for may lie long behind it.
#[derive(Debug, Clone, PartialEq)]
pub struct Narrow {
    /// Its windows are this share of the longest one.
    pub share: f64,
    /// γ there.
    pub gamma: f64,
    /// The active coordinates there, with their names.
    pub point: Vec<(String, f64)>,
}

/// The event at which a run cannot go on, and how many there were.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LastEvent {
    /// Its name.
    pub name: String,
    /// The number of events that have acted.
    pub count: usize,
}

/// The reasons for which a run to an accuracy may have failed.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Reasons {
    /// Where the accuracy is not reached, the narrowest place of the motion.
    pub narrow: Option<Narrow>,
    /// The names of coordinates that come to 0 where it failed, if the motion has no rates there.
    pub towards_zero: Vec<String>,
    /// The event at which it failed, if one acted there.
    pub event: Option<LastEvent>,
}

/// A place where a solve can fail.
pub(super) struct At {
    pub(super) gamma: f64,
    pub(super) point: Vec<(String, f64)>,
    pub(super) domain: Domain,
}

impl At {
    /// The place at this γ where all coordinates are `q`.
    pub(super) fn new<S: Real>(geometry: &Geometry<S>, gamma: f64, q: &[S]) -> Self {
        if let Some(g00) = geometry.g00(q) {
            return Self::x(gamma, q[1].to_f64(), g00.to_f64());
        }
        let named = |&a: &usize| (geometry.names()[a].clone(), q[a].to_f64());
        Self { gamma, point: geometry.active().iter().map(named).collect(), domain: Domain::Scene }
    }

    /// The place at this γ of a node outside the domain.
    pub(super) fn outside<S: Real>(geometry: &Geometry<S>, gamma: f64, outside: &OutsideGeometry) -> Self {
        let q = [S::ZERO, S::from(outside.position)];
        if geometry.g00(&q).is_some() {
            return Self::new(geometry, gamma, &q);
        }
        Self { gamma, point: Vec::new(), domain: Domain::beyond(geometry, outside) }
    }

    /// The place at this γ where all coordinates are `q`, which is outside the domain.
    pub(super) fn beyond<S: Real>(geometry: &Geometry<S>, gamma: f64, q: &[S], outside: &OutsideGeometry) -> Self {
        let at = Self::new(geometry, gamma, q);
        if geometry.g00(q).is_some() { at } else { Self { domain: Domain::beyond(geometry, outside), ..at } }
    }

    /// The place at this γ where a number of a window whose last node is at `q` is beyond the range of numbers.
    pub(super) fn overflow<S: Real>(geometry: &Geometry<S>, gamma: f64, q: &[S]) -> Self {
        match geometry.g00(q) {
            Some(g00) => Self::x(gamma, q[1].to_f64(), g00.to_f64()).overflowing(),
            None => Self { gamma, point: Vec::new(), domain: Domain::Scene },
        }
    }

    /// A place in one coordinate.
    pub(super) fn x(gamma: f64, x: f64, g00: f64) -> Self {
        let domain = if g00 == f64::INFINITY { Domain::Overflow(g00) } else { Domain::G00(g00) };
        Self { gamma, point: vec![("x".to_owned(), x)], domain }
    }

    /// The same place, where a number, maybe another than g00, is not finite. If g00 has no value, that is the reason.
    pub(super) fn overflowing(self) -> Self {
        match self.domain {
            Domain::G00(g00) if !g00.is_nan() => Self { domain: Domain::Overflow(g00), ..self },
            _ => self,
        }
    }
}

impl Domain {
    /// The reason why a point of a scene is outside.
    fn beyond<S: Real>(geometry: &Geometry<S>, outside: &OutsideGeometry) -> Self {
        let Some(block) = outside.block else { return Self::Scene };
        let coordinates = geometry.blocks()[block].iter().map(|&a| geometry.names()[a].clone()).collect();
        Self::Determinant { coordinates, value: outside.determinant }
    }

    fn is_of_x(&self) -> bool {
        matches!(self, Self::G00(_) | Self::Overflow(_))
    }
}

/// A number for a message: six decimals, or an exponent where those would be noise or a long row of zeros.
fn compact(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 || (1e-3..1e9).contains(&size) { format!("{value:.6}") } else { format!("{value:.6e}") }
}

/// A place for a message.
fn place(gamma: f64, point: &[(String, f64)]) -> String {
    let point = point.iter().map(|(name, value)| format!(", {name} = {}", compact(*value)));
    format!("gamma = {}{}", compact(gamma), point.collect::<String>())
}

impl NoSolution {
    /// A failure that has nothing but a status and a place.
    pub(super) fn new(status: Status, At { gamma, point, domain }: At) -> Self {
        Self {
            status,
            gamma,
            point,
            domain,
            residual: f64::INFINITY,
            needed: 0.0,
            asked: 0.0,
            adaptive: false,
            reasons: Box::default(),
            iterations: Box::new(Iterations::from(InitialGuess::None)),
        }
    }

    /// A march that ended without a result.
    pub(super) fn marched(status: Status, at: At) -> Self {
        Self { iterations: Box::new(Iterations::from(InitialGuess::Extrapolation)), ..Self::new(status, at) }
    }

    /// A march to an accuracy that ended without a result.
    pub(super) fn adaptive(status: Status, at: At) -> Self {
        Self { adaptive: true, ..Self::marched(status, at) }
    }

    /// The failure of a run at an event, at this γ and q^a.
    pub(crate) fn at_event(status: Status, geometry: &Geometry, gamma: f64, q: &[f64], event: LastEvent) -> Self {
        let mut failure = Self::adaptive(status, At::new(geometry, gamma, q));
        failure.reasons.event = Some(event);
        failure
    }
}

/// Says what the pace of a run beyond the limit of evaluations means for it.
fn pace(needed: f64) -> String {
    if needed.is_finite() {
        format!("at this pace the run needs {needed:.1e} of them, above the limit of {MOST_SWEEPS:.0e}")
    } else {
        "the run makes no progress".to_owned()
    }
}

impl fmt::Display for NoSolution {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.message(f)?;
        match self.reasons.towards_zero.as_slice() {
            [] => Ok(()),
            names => write!(f, "; {} → 0, where the formulas have no value", names.join(", ")),
        }
    }
}

impl NoSolution {
    fn message(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { status, residual, needed, .. } = self;
        let count = self.iterations.count;
        let place = place(self.gamma, &self.point);
        if let Some(event) = &self.reasons.event {
            return self.message_of(event, &place, f);
        }
        match (status, &self.domain) {
            (Status::OutsideDomain, Domain::G00(g00)) => {
                write!(f, "the geodesic leaves the domain at {place}: g00 = {g00:.3e} (iteration {count}")?;
                // Where the equations are explicit, or the first guess already leaves, there is no residual.
                if residual.is_finite() { write!(f, ", residual {residual:.2e})") } else { write!(f, ")") }
            }
            (Status::OutsideDomain, Domain::Overflow(_)) => {
                write!(f, "a number is beyond the range of numbers at {place}")
            }
            (Status::OutsideDomain, Domain::Determinant { coordinates, value }) => write!(
                f,
                "the geodesic leaves the domain at {place}: the determinant of the metric in ({}) is {value:.3e}",
                coordinates.join(", ")
            ),
            (Status::OutsideDomain, Domain::Scene) => {
                write!(f, "the geodesic leaves the domain at {place}: a number is not finite")
            }
            (Status::EndTimeNotReached, domain) => {
                let end = if domain.is_of_x() { "the physical time t_f" } else { "the end" };
                write!(f, "{end} is not reached: the search ended at {place}")
            }
            (Status::AccuracyNotReached, _) => {
                write!(
                    f,
                    "the accuracy {:e} is not reached: at {place} the error is estimated at {residual:.1e}, and \
                     rounding leaves room for {:.0e}",
                    self.asked,
                    rounded_up(*needed)
                )?;
                self.reasons.narrow.iter().try_for_each(|Narrow { share, gamma, point }| {
                    let place = self::place(*gamma, point);
                    write!(f, "; windows are shortest, {share:.0e} of the longest, at {place}")
                })
            }
            (Status::EvaluationLimit, _) => {
                write!(f, "stopped after {count} evaluations of the force at {place}: {}", pace(*needed))
            }
            (Status::TooManyNodes, _) => write!(
                f,
                "stopped at {place}: the run would have {needed:.1e} nodes, above the limit of {MOST_NODES:.0e} that \
                 are kept in memory"
            ),
            _ if self.adaptive => {
                write!(f, "no critical point found ({status}): no window, however short, converges at {place}")
            }
            _ => write!(
                f,
                "no critical point found ({status}) after {count} iterations: largest residual {residual:.2e} at \
                 {place}"
            ),
        }
    }

    /// Says why a run could not go on from an event, or not be trusted behind it.
    fn message_of(
        &self,
        LastEvent { name, count }: &LastEvent,
        place: &str,
        f: &mut fmt::Formatter<'_>,
    ) -> fmt::Result {
        let Self { asked, residual, .. } = self;
        match self.status {
            Status::OutsideDomain => {
                write!(f, "the event '{name}' sets a state outside of the domain, or no number, at {place}")
            }
            Status::AccuracyNotReached if residual.is_finite() => write!(
                f,
                "the accuracy {asked:e} is not reached: through {count} events the error grows to {residual:.1e} at \
                 {place}"
            ),
            Status::AccuracyNotReached => write!(
                f,
                "the accuracy {asked:e} is not reached: on the way to {place} other events act if the last digits are \
                 others"
            ),
            _ if *count >= MOST_EVENTS => {
                write!(f, "stopped at {place} by the event '{name}': {count} have acted, the most of a run")
            }
            _ => write!(
                f,
                "events do not end at {place}: '{name}' comes again sooner than rounding resolves, after {count} that \
                 have acted"
            ),
        }
    }
}

impl std::error::Error for NoSolution {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_say_what_would_be_needed_in_scenes_too() {
        let places =
            [At::x(1.0, 2.0, 3.0), At { gamma: 1.0, point: vec![("r".to_owned(), 2.0)], domain: Domain::Scene }];
        for (at, name) in places.into_iter().zip(["x", "r"]) {
            let adaptive = NoSolution::adaptive(Status::TooManyNodes, at);
            let at = |status, needed| NoSolution { status, needed, ..adaptive.clone() }.to_string();
            let place = format!("at gamma = 1.000000, {name} = 2.000000: ");
            let nodes = format!("stopped {place}the run would have 6.0e7 nodes, above the limit of 5e7 that");
            assert!(at(Status::TooManyNodes, 6e7).starts_with(&nodes), "{}", at(Status::TooManyNodes, 6e7));
            let pace = format!("evaluations of the force {place}at this pace the run needs 2.0e12 of them, above");
            assert!(at(Status::EvaluationLimit, 2e12).contains(&pace), "{}", at(Status::EvaluationLimit, 2e12));
            let stuck = at(Status::EvaluationLimit, f64::INFINITY);
            assert!(stuck.ends_with("the run makes no progress"), "{stuck}");
        }
    }
}
