//! Why there is no critical point, in one coordinate and in scenes.

use std::fmt;

use super::WorldLine;
use super::status::{InitialGuess, IterationRecord, Iterations, MOST_EVENTS, MOST_NODES, MOST_SWEEPS, Status};
use crate::geometry::{Geometry, OffTable, OutsideGeometry};
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
    /// In one coordinate: g00 at a place at which a number is beyond the range of doubles.
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
    /// The names of coordinates that only rounding moves where it failed.
    pub of_rounding: Vec<String>,
    /// The table that has no value where it failed.
    pub off_table: Option<OffTable>,
    /// The event at which it failed, if one acted there.
    pub event: Option<LastEvent>,
    /// A formula that loses more digits than the accuracy leaves, if one does.
    pub lost: Option<Lossy>,
}

/// A formula that loses digits to rounding.
#[derive(Debug, Clone, PartialEq)]
pub struct Lossy {
    /// A sentence about it.
    pub finding: String,
    /// True if a coordinate is too far from 0, and the formula is written well.
    pub is_far: bool,
}

/// A run that has not come to its end: why, and as far as it came.
#[derive(Debug)]
pub(crate) struct Unfinished<S> {
    pub(crate) failure: NoSolution,
    /// The windows before, or the last of them if no more was to be kept; none if there is none.
    pub(crate) line: Option<WorldLine<S>>,
}

impl<S: Real> Unfinished<S> {
    /// The run that has come to `line`.
    pub(super) fn new(failure: NoSolution, mut line: WorldLine<S>) -> Box<Self> {
        line.length = line.windows.last().map_or(S::ZERO, |window| window.gamma[1]);
        Box::new(Self { failure, line: Some(line).filter(|line| !line.windows.is_empty()) })
    }
}

impl<S> From<NoSolution> for Box<Unfinished<S>> {
    fn from(failure: NoSolution) -> Self {
        Self::new(Unfinished { failure, line: None })
    }
}

impl Domain {
    pub(super) fn is_of_x(&self) -> bool {
        matches!(self, Self::G00(_) | Self::Overflow(_))
    }
}

/// A number for a message: six decimals, or an exponent where those would be noise or a long row of zeros.
fn compact(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 || (1e-3..1e9).contains(&size) { format!("{value:.6}") } else { format!("{value:.6e}") }
}

/// The active coordinates at `q` with their names.
pub(super) fn point<S: Real>(geometry: &Geometry<S>, q: &[S]) -> Vec<(String, f64)> {
    geometry.active().iter().map(|&a| (geometry.names()[a].clone(), q[a].to_f64())).collect()
}

/// A place for a message.
fn place(gamma: f64, point: &[(String, f64)]) -> String {
    let point = point.iter().map(|(name, value)| format!(", {name} = {}", compact(*value)));
    format!("gamma = {}{}", compact(gamma), point.collect::<String>())
}

impl NoSolution {
    /// A failure that has nothing but a status, and a place where all coordinates are `q`.
    pub(super) fn new<S: Real>(status: Status, geometry: &Geometry<S>, gamma: f64, q: &[S]) -> Self {
        let domain = match geometry.g00(q).map(S::to_f64) {
            Some(g00) if g00 == f64::INFINITY => Domain::Overflow(g00),
            Some(g00) => Domain::G00(g00),
            None => Domain::Scene,
        };
        Self::at(status, gamma, point(geometry, q), domain)
    }

    fn at(status: Status, gamma: f64, point: Vec<(String, f64)>, domain: Domain) -> Self {
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
            iterations: Box::new(Iterations::of(InitialGuess::None, Vec::new())),
        }
    }

    /// The failure at a node outside the domain, where all coordinates are `q` if that is known.
    pub(super) fn outside<S: Real>(
        geometry: &Geometry<S>,
        gamma: f64,
        q: Option<&[S]>,
        outside: &OutsideGeometry,
    ) -> Self {
        let (status, x) = (Status::OutsideDomain, [S::ZERO, S::from(outside.position)]);
        let mut failure = if geometry.c_squared.is_some() {
            Self::new(status, geometry, gamma, q.unwrap_or(&x))
        } else {
            let names = |block: usize| geometry.blocks[block].iter().map(|&a| geometry.names()[a].clone()).collect();
            let determinant = |block| Domain::Determinant { coordinates: names(block), value: outside.determinant };
            let point = q.map_or_else(Vec::new, |q| point(geometry, q));
            Self::at(status, gamma, point, outside.block.map_or(Domain::Scene, determinant))
        };
        failure.reasons.off_table = q.and_then(|q| geometry.off_table(q));
        failure
    }

    /// The failure of a window whose last node is at `q`, in which a number, maybe another than g00, is beyond the
    /// range of numbers. If g00 has no value, that is the reason.
    pub(super) fn overflow<S: Real>(geometry: &Geometry<S>, gamma: f64, q: &[S]) -> Self {
        let mut failure = Self::new(Status::OutsideDomain, geometry, gamma, q);
        match failure.domain {
            Domain::G00(g00) if !g00.is_nan() => failure.domain = Domain::Overflow(g00),
            Domain::Scene => failure.point.clear(),
            _ => {}
        }
        failure
    }

    /// The same after these iterations.
    pub(super) fn after(self, initial_guess: InitialGuess, history: Vec<IterationRecord>) -> Self {
        Self { iterations: Box::new(Iterations::of(initial_guess, history)), ..self }
    }

    /// The same of a march by the engine.
    pub(super) fn marched(self) -> Self {
        self.after(InitialGuess::Extrapolation, Vec::new())
    }

    /// The same of a march to an accuracy.
    pub(super) fn adaptive(self) -> Self {
        Self { adaptive: true, ..self.marched() }
    }

    /// The failure of a run at an event, at this γ and q^a.
    pub(crate) fn at_event(status: Status, geometry: &Geometry, gamma: f64, q: &[f64], event: LastEvent) -> Self {
        let mut failure = Self::new(status, geometry, gamma, q).adaptive();
        failure.reasons.event = Some(event);
        failure
    }
}

impl fmt::Display for NoSolution {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let event = self.reasons.event.as_ref();
        f.write_str(&event.map_or_else(|| self.message(), |event| self.message_of(event)))?;
        match self.reasons.towards_zero.as_slice() {
            [] => Ok(()),
            names => write!(f, "; {} → 0, where the formulas have no value", names.join(", ")),
        }?;
        match self.reasons.of_rounding.as_slice() {
            [] => Ok(()),
            [name] => write!(f, "; rounding alone moves {name} there"),
            names => write!(f, "; rounding alone moves {} there", names.join(", ")),
        }?;
        self.reasons.lost.iter().try_for_each(|lost| write!(f, "; {}", lost.finding))
    }
}

impl NoSolution {
    fn message(&self) -> String {
        let Self { status, residual, needed, asked, .. } = self;
        let (count, place) = (self.iterations.count, place(self.gamma, &self.point));
        if let Some(off) = &self.reasons.off_table {
            return format!("the motion leaves what is known of a function at {place}: {off}");
        }
        match (status, &self.domain) {
            (Status::OutsideDomain, Domain::G00(g00)) => {
                // Where the equations are explicit, or the first guess already leaves, there is no residual.
                let residual = if residual.is_finite() { format!(", residual {residual:.2e}") } else { String::new() };
                format!("the geodesic leaves the domain at {place}: g00 = {g00:.3e} (iteration {count}{residual})")
            }
            (Status::OutsideDomain, Domain::Overflow(_)) => {
                format!("a number is beyond the range of numbers at {place}")
            }
            (Status::OutsideDomain, Domain::Determinant { coordinates, value }) => format!(
                "the geodesic leaves the domain at {place}: the determinant of the metric in ({}) is {value:.3e}",
                coordinates.join(", ")
            ),
            (Status::OutsideDomain, Domain::Scene) => {
                format!("the geodesic leaves the domain at {place}: a number is not finite")
            }
            (Status::EndTimeNotReached, domain) => {
                let end = if domain.is_of_x() { "the physical time t_f" } else { "the end" };
                format!("{end} is not reached: the search ended at {place}")
            }
            (Status::AccuracyNotReached, _) => {
                let narrow = self.reasons.narrow.iter().map(|Narrow { share, gamma, point }| {
                    let place = self::place(*gamma, point);
                    format!("; steps are shortest, {share:.0e} of the longest, at {place}")
                });
                let in_the_end = Some(rounded_up(*needed)).filter(|most| most.is_finite());
                let in_the_end = in_the_end.map_or(String::new(), |most| format!(", and in the end by {most:.0e}"));
                format!(
                    "the accuracy {asked:e} is not reached: from {place} on a run and one to a hundredth of its \
                     tolerance differ by more{in_the_end}{}",
                    narrow.collect::<String>()
                )
            }
            (Status::EvaluationLimit, _) => {
                let pace = if needed.is_finite() {
                    format!("at this pace the run needs {needed:.1e} of them, above the limit of {MOST_SWEEPS:.0e}")
                } else {
                    "the run makes no progress".to_owned()
                };
                format!("stopped after {count} evaluations of the force at {place}: {pace}")
            }
            (Status::TooManyNodes, _) => format!(
                "stopped at {place}: the run would have {needed:.1e} nodes, above the limit of {MOST_NODES:.0e} that \
                 are kept in memory"
            ),
            _ if self.adaptive => {
                format!("no critical point found ({status}): no window, however short, converges at {place}")
            }
            _ => format!(
                "no critical point found ({status}) after {count} iterations: largest residual {residual:.2e} at \
                 {place}"
            ),
        }
    }

    /// Says why a run could not go on from an event, or not be trusted behind it.
    fn message_of(&self, LastEvent { name, count }: &LastEvent) -> String {
        let (Self { asked, residual, .. }, place) = (self, place(self.gamma, &self.point));
        match self.status {
            Status::OutsideDomain => {
                format!("the event '{name}' sets a state outside of the domain, or no number, at {place}")
            }
            Status::AccuracyNotReached if residual.is_finite() => format!(
                "the accuracy {asked:e} is not reached: through {count} events the error grows to {residual:.1e} at \
                 {place}"
            ),
            Status::AccuracyNotReached => format!(
                "the accuracy {asked:e} is not reached: on the way to {place} other events act if the last digits are \
                 others"
            ),
            Status::EventsRest => {
                format!("the event '{name}' leaves the motion at rest at {place}, and forces hold it there")
            }
            _ if *count >= MOST_EVENTS => {
                format!("stopped at {place} by the event '{name}': {count} have acted, the most of a run")
            }
            _ => format!(
                "events do not end at {place}: '{name}' comes again sooner than rounding resolves, after {count} that \
                 have acted"
            ),
        }
    }
}

impl std::error::Error for NoSolution {}
