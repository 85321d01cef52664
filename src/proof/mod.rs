//! A proof of where a motion ends: the end of a run in 20 digits and more, with a bound of its error.
//!
//! A proof is an integration of its own, and believes nothing of the run. What it proves is a theorem about the
//! decimals of the case, under the arithmetic of IEEE 754 and provided that this code is what it says; `docs/proof.md`
//! has the theorem on a page.
//!
//! ```text
//! algebras     balls at the nodes and discs on the ellipse, as algebras of programs
//! tables       Legendre polynomials on nodes and ellipse, constants of interpolation and quadrature
//! equations    f and Df of a scene, without what nothing depends on
//! approximate  the motion in a window and its adjoint matrix, of which nothing is proved
//! defect       v − f(y) at the nodes, in balls
//! ellipse      bounds on an ellipse around the window, and what formulas do there that is not analytic
//! matrices     the adjoint matrix B, its defect E, a bound of its inverse
//! window       what becomes of the errors over a window
//! proved       what is kept of it
//! set          the set of errors
//! samples      the motion at given places
//! spread       the ends of the motions from a set of starts
//! run          from window to window, to the end
//! end          from the last window to γ_f, to t_f, or to where a formula is 0
//! watch        formulas that end the motion where they are 0
//! ```

mod algebras;
mod approximate;
mod defect;
mod ellipse;
mod end;
mod equations;
mod matrices;
mod proved;
mod run;
mod samples;
mod set;
mod spread;
mod tables;
mod watch;
mod window;

pub use algebras::Obstacle;

use std::fmt;
use std::time::Instant;

use crate::geometry::{self, Geometry, Start};
use crate::number::Extended;
use equations::{Equations, results};
use run::Run;
use set::sum_of_sizes;
use tables::UP;

/// The end of a motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Until {
    /// After this length of γ.
    Length(Extended),
    /// Where a coordinate has a value.
    Value(usize, Extended),
}

/// The motion of which something is to be proved.
#[derive(Debug, Clone, Copy)]
pub struct Motion<'m> {
    /// The space-time.
    pub geometry: &'m Geometry<Extended>,
    /// The start.
    pub start: &'m Start<Extended>,
    /// A coordinate that is no result.
    pub unused: Option<usize>,
    /// The end, if nothing that is watched ends it before.
    pub until: Until,
    /// What is said of the last coordinates, which are formulas, see [`Geometry::watching`].
    pub watched: &'m [Watched],
    /// γ − γ_i of places on the way, ascending, at which the motion is asked for.
    pub samples: &'m [Extended],
    /// The set of starts and of ends, if it is not one of each: see [`Generator`].
    pub generators: &'m [Generator],
    /// True if the way of such a set is kept, at the ends of windows that are not long.
    pub keeps_way: bool,
    /// Where it goes on behind an event, which of the motion before is known: every q^a and then every p_a, with all
    /// columns, of which none is a direction of starts. Else nothing.
    pub behind: &'m [Option<Spread>],
    /// True if what is known of the start is a set as large as the motion may be.
    pub is_spread: bool,
    /// By how much the length may be off, as the place of such an event is.
    pub late: f64,
    /// The place of a formula that is 0 at the start, and the side to which it has to leave: it is no motion of this
    /// scene if it does not.
    pub leaves: Option<(usize, f64)>,
}

/// A direction in which starts are spread: those are at q + Σ β q_k and p + Σ β p_k for all |β_k| ≤ 1, and their
/// motions end after the length and Σ β length_k, or where a coordinate has its value in all of them.
#[derive(Debug, Clone, PartialEq)]
pub struct Generator {
    /// The change of each q^a.
    pub q: Vec<f64>,
    /// The change of each p_a, NaN for one that is no result and is not known.
    pub p: Vec<f64>,
    /// The change of the length of γ.
    pub length: f64,
}

/// A number at the end of the motions from a set of starts: it is no further than the radius from value + Σ β column_k.
#[derive(Debug, Clone, PartialEq)]
pub struct Spread {
    /// The middle.
    pub value: Extended,
    /// What each direction makes of it.
    pub columns: Vec<f64>,
    /// The radius.
    pub radius: f64,
    /// For two starts it differs by Σ (β_k − β′_k) column_k, but for so many times the largest |β_k − β′_k|.
    pub slack: f64,
}

impl Spread {
    /// A bound of the distance from the middle.
    pub fn reach(&self) -> f64 {
        (sum_of_sizes(&self.columns) + self.radius) * UP
    }
}

/// A formula that is met where it changes its sign.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Watched {
    /// The changes that count.
    pub direction: geometry::Direction,
    /// By how much its value at the start may be off.
    pub off: f64,
    /// True if it ends the motion.
    pub ends: bool,
}

/// Where a formula is met.
#[derive(Debug, Clone, PartialEq)]
pub struct Event {
    /// Its place among those that are watched.
    pub watch: usize,
    /// γ − γ_i there, and a bound of its distance from the true one.
    pub gamma: (Extended, f64),
    /// The coordinates there.
    pub coordinates: Vec<Coordinate>,
}

impl<'m> Motion<'m> {
    /// The motion from a start, of which nothing is watched on the way.
    pub fn new(geometry: &'m Geometry<Extended>, start: &'m Start<Extended>, until: Until) -> Self {
        Self {
            geometry,
            start,
            until,
            unused: None,
            watched: &[],
            samples: &[],
            generators: &[],
            keeps_way: false,
            behind: &[],
            is_spread: false,
            late: 0.0,
            leaves: None,
        }
    }

    /// True if it stands for a set of motions.
    fn is_set(&self) -> bool {
        self.is_spread || !self.generators.is_empty()
    }

    /// The number of coordinates that are none of these formulas, and no unknown parameters.
    fn results(&self) -> usize {
        results(self.geometry, self.watched.len())
    }

    /// What is known of a coordinate at the start, or of its momentum, where the motion goes on behind an event.
    fn begun(&self, (coordinate, is_momentum): (usize, bool)) -> Option<&Spread> {
        let place = coordinate + if is_momentum { self.geometry.dimension() } else { 0 };
        self.behind.get(place).and_then(Option::as_ref)
    }

    /// By how much a coordinate may be off at the start.
    fn off_at_start(&self, a: usize) -> f64 {
        self.begun((a, false)).map_or(0.0, Spread::reach)
    }
}

/// Why a proof ends before the motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Reason {
    /// What formulas do ahead.
    Obstacle(Obstacle),
    /// Windows become ever shorter, as in front of a pole or a very narrow feature, or beside all that is behind.
    Short,
    /// The bound has become too large to be of use.
    Lost,
    /// The coordinate that the motion ends by does not grow, or fall, all the way.
    NotMonotone,
    /// It is not known whether a formula changes its sign.
    Grazed,
    /// A direction changes a constant of the motion on which that depends, such as a momentum.
    Constant,
    /// Two events, or one and the end, are so close together that it is not known which comes first.
    Together,
    /// Behind an event a formula is 0 that was not met there.
    Left,
    /// What an event sets is not smooth where it acts.
    Rough,
    /// It was asked to stop.
    Stopped,
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Obstacle(obstacle) => write!(f, "{obstacle}"),
            Self::Short => f.write_str("steps that become ever shorter"),
            Self::Lost => f.write_str("a bound that has become too large"),
            Self::NotMonotone => f.write_str("a coordinate that is to reach a value and turns back"),
            Self::Grazed => f.write_str("an event or a kink that the motion may graze"),
            Self::Together => f.write_str("two events, or one and the end, that are too close together"),
            Self::Constant => f.write_str("an unknown that changes a conserved momentum"),
            Self::Left => f.write_str("an event behind which another formula is 0"),
            Self::Rough => f.write_str("an event that sets what is not smooth there"),
            Self::Stopped => f.write_str("an interrupt"),
        }
    }
}

/// A coordinate at the end: a number, and a bound of its distance from the true one.
#[derive(Debug, Clone, PartialEq)]
pub struct Coordinate {
    /// Its place among the coordinates.
    pub coordinate: usize,
    /// The number, in extended precision.
    pub value: Extended,
    /// The bound, absolute.
    pub radius: f64,
    /// True if it moves at a constant velocity.
    pub is_steady: bool,
}

/// How far a proof is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress {
    /// γ − γ_i until where windows are proved.
    pub reached: f64,
    /// The operations that it took so far: a count, which is the same on every machine.
    pub operations: f64,
}

/// What is proved.
#[derive(Debug, Clone, PartialEq)]
pub struct Proof {
    /// The coordinates at the end, or why there is no proof of them.
    pub end: Result<Vec<Coordinate>, Reason>,
    /// Every q^a and p_a at the end, if they are results: of the motions of a set, or where a formula ends it.
    pub state: Vec<Option<Spread>>,
    /// The place among the formulas that are watched of the one that ends it, if one does.
    pub ended_by: Option<usize>,
    /// Where formulas are met, in order, with the one that ends it.
    pub events: Vec<Event>,
    /// The coordinates at the places that were asked for, as far as it came.
    pub samples: Vec<Vec<Coordinate>>,
    /// γ − γ_i at the ends of windows with the coordinates there, if they are kept, with the start.
    pub way: Vec<(f64, Vec<Coordinate>)>,
    /// γ − γ_i until where windows are proved.
    pub reached: f64,
    /// The number of windows.
    pub windows: usize,
    /// The seconds that it took.
    pub seconds: f64,
}

/// Proves where a motion ends. `goes_on` hears after every window how far it came, and may stop the proof.
pub fn prove(motion: &Motion<'_>, goes_on: &mut dyn FnMut(Progress) -> bool) -> Proof {
    proved(motion, false, goes_on)
}

/// Proves it in windows of half the length that they may have, which has other defects and other errors. As both are
/// theorems about one motion, what they say of its end has to agree.
pub fn prove_finer(motion: &Motion<'_>, goes_on: &mut dyn FnMut(Progress) -> bool) -> Proof {
    proved(motion, true, goes_on)
}

fn proved(motion: &Motion<'_>, is_finer: bool, goes_on: &mut dyn FnMut(Progress) -> bool) -> Proof {
    let begun = Instant::now();
    // The state is q and p. The velocities of a run that is continued have no more digits than were written.
    let (q, p) = (motion.start.q.clone(), motion.start.p.clone());
    let failed = |reason| {
        let seconds = begun.elapsed().as_secs_f64();
        let (state, events, samples, way) = Default::default();
        Proof { end: Err(reason), state, ended_by: None, events, samples, way, reached: 0.0, windows: 0, seconds }
    };
    let Ok(q_dot) = motion.geometry.velocities(&q, &p) else { return failed(Reason::Lost) };
    let motion = &Motion { start: &Start { q, q_dot, p }, ..*motion };
    let off: Vec<f64> = motion.watched.iter().map(|watched| watched.off).collect();
    // Motions of a set are late by what its columns say of the coordinate that ends them.
    let followed = match motion.until {
        Until::Value(a, _) if motion.is_spread => Some(a),
        _ => None,
    };
    let equations = Equations::new(motion.geometry, motion.start, [motion.unused, followed], &off);
    if equations.has_jump {
        return failed(Reason::Obstacle(Obstacle::Hidden));
    }
    match Run::new(motion, equations, is_finer) {
        Ok(run) => Proof { seconds: begun.elapsed().as_secs_f64(), ..run.proof(goes_on) },
        Err(reason) => failed(reason),
    }
}

#[cfg(test)]
mod lemmas;
#[cfg(test)]
mod tests;
