//! A proof of where a motion ends: the end of a run in 20 digits and more, with a bound of its error.
//!
//! A proof is an integration of its own, and believes nothing of the run. What it proves is a theorem about the
//! decimals of the case, under the arithmetic of IEEE 754 and provided that this code is what it says; `docs/method.md`
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
mod set;
mod tables;
mod watch;
mod window;

pub use algebras::Obstacle;

use std::fmt;
use std::time::Instant;

use crate::geometry::{Direction, Geometry, Start};
use crate::number::Extended;
use crate::number::ball::two_sum;
use crate::number::vector::Level;
use approximate::Approximate;
use defect::Defect;
use ellipse::{Bounds, Ellipse};
use end::{End, Goal};
use equations::Equations;
use proved::Proved;
use set::Set;
use watch::{Met, Watches};
use window::{Prover, Refused, Window};

/// The first window is this share of the length; windows become longer or shorter at once.
const FIRST: f64 = 1.0 / 64.0;
/// A window may be that much longer than the one before, or shorter.
const LONGER: f64 = 1.15;
const SHORTER: f64 = 0.8;
/// A window that is shorter than this share of the longest one so far is in front of something.
const SHORTEST: f64 = 1e-8;
/// Before any window is proved they are halved, down to this share of the first.
const SHORTEST_FIRST: f64 = 1e-6;
/// A narrow place is passed by some hundred windows that are shorter than this share of the first. Where there are more
/// of them it has no end.
const SHORT: f64 = 1e-4;
const MOST_SHORT: usize = 2000;
/// Beyond this share of its coordinate a bound says nothing any more.
const LOST: f64 = 1e-3;

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
}

/// A formula that is met where it changes its sign.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Watched {
    /// The changes that count.
    pub direction: Direction,
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

impl Motion<'_> {
    /// The number of coordinates that are none of these formulas.
    fn results(&self) -> usize {
        self.geometry.dimension() - self.watched.len()
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
    /// Two events, or one and the end, are so close together that it is not known which comes first.
    Together,
    /// It was asked to stop.
    Stopped,
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Obstacle(obstacle) => write!(f, "{obstacle}"),
            Self::Short => f.write_str("windows that become ever shorter"),
            Self::Lost => f.write_str("a bound that has become too large"),
            Self::NotMonotone => f.write_str("a coordinate that is to reach a value and turns back"),
            Self::Grazed => f.write_str("an event that the motion may graze"),
            Self::Together => f.write_str("two events, or one and the end, that are too close together"),
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
    /// The place among the formulas that are watched of the one that ends it, if one does.
    pub ended_by: Option<usize>,
    /// Where formulas are met, in order, with the one that ends it.
    pub events: Vec<Event>,
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
    let failed = |end| {
        let seconds = begun.elapsed().as_secs_f64();
        Proof { end: Err(end), ended_by: None, events: Vec::new(), reached: 0.0, windows: 0, seconds }
    };
    let Ok(q_dot) = motion.geometry.velocities(&q, &p) else { return failed(Reason::Lost) };
    let motion = &Motion { start: &Start { q, q_dot, p }, ..*motion };
    let off: Vec<f64> = motion.watched.iter().map(|watched| watched.off).collect();
    let equations = Equations::new(motion.geometry, motion.start, motion.unused, &off);
    if equations.has_jump {
        return failed(Reason::Obstacle(Obstacle::Hidden));
    }
    let (goal, set) = (Goal::new(motion, &equations), Set::new(&equations));
    let watches = match Watches::new(motion, &equations, &set) {
        Ok(watches) => watches,
        Err(reason) => return failed(reason),
    };
    let mut run = Run {
        set,
        watches,
        ended_by: None,
        events: Vec::new(),
        prover: Prover {
            approximate: Approximate::new(&equations),
            defect: Defect::new(&equations),
            ellipse: Ellipse::new(&equations),
            equations,
        },
        is_finer,
        reached: 0.0,
        windows: 0,
        attempts: 0,
    };
    let end = run.to(motion, goal, goes_on);
    let end = end.map(|(goal, end)| end::coordinates(motion, &run.prover.equations, &goal, end.as_ref()));
    Proof {
        end,
        ended_by: run.ended_by,
        events: run.events,
        reached: run.reached,
        windows: run.windows,
        seconds: begun.elapsed().as_secs_f64(),
    }
}

/// A proof on its way.
struct Run<'g> {
    prover: Prover<'g>,
    set: Set,
    watches: Watches,
    /// The formula that ended it, once it has, and all that were met.
    ended_by: Option<usize>,
    events: Vec<Event>,
    /// True if windows have half the length that they may have.
    is_finer: bool,
    /// Exact up to the last window, as lengths of windows are.
    reached: f64,
    windows: usize,
    /// Windows that were tried.
    attempts: usize,
}

/// The ends that a window has.
enum Ahead {
    Nothing,
    /// The end of the motion, so far from its start.
    Passed(f64),
    /// A formula that is met before.
    Event(Met),
}

/// Lengths of windows, but for the last one, are multiples of a power of two, so that sums of them are exact.
fn on_grid(h: f64, unit: f64) -> f64 {
    (h / unit).floor().max(1.0) * unit
}

impl Run<'_> {
    /// To the end, which is `None` of a motion that does not vary, with what it is.
    fn to(
        &mut self,
        motion: &Motion<'_>,
        goal: Goal,
        goes_on: &mut dyn FnMut(Progress) -> bool,
    ) -> Result<(Goal, Option<End>), Reason> {
        if self.prover.equations.unknowns == 0 {
            return Ok((goal, None));
        }
        let first = goal.length() * FIRST;
        let unit = (first.log2().floor() - 40.0).exp2();
        let (mut h, mut longest, mut short, mut refused) = (on_grid(first, unit), 0.0_f64, 0, Reason::Short);
        let of_window = self.prover.equations.operations();
        loop {
            let operations = self.attempts as f64 * of_window;
            if !goes_on(Progress { reached: self.reached, operations }) {
                return Err(Reason::Stopped);
            }
            let (step, is_last) = goal.step(self.reached, h);
            let ahead = self.window(&goal, step).and_then(|proved| Ok((self.ahead(&goal, &proved)?, proved)));
            let factor = match ahead {
                Ok((Ahead::Event(met), _)) => {
                    let end = self.meet(motion, &goal, (&met, unit))?;
                    if motion.watched[met.watch].ends {
                        self.ended_by = Some(met.watch);
                        return Ok((met.goal, Some(end)));
                    }
                    // Behind it windows are as long as before.
                    h / step
                }
                Ok((Ahead::Passed(step), _)) => return self.last(goal, step),
                Ok((Ahead::Nothing, proved)) if is_last => return self.end(&goal, proved).map(|end| (goal, Some(end))),
                Ok((Ahead::Nothing, proved)) => {
                    longest = longest.max(step);
                    short += usize::from(step < first * SHORT);
                    // Windows may be so short beside what is behind them that γ does not stay exact.
                    if short > MOST_SHORT || two_sum(self.reached, step).1 != 0.0 {
                        return Err(self.reason(refused));
                    }
                    let factor = proved.quality.max(1e-30).powf(-1.0 / 64.0).clamp(SHORTER, LONGER);
                    let half = on_grid(0.5 * step, unit);
                    let proved = if self.is_finer { self.window(&goal, half)? } else { proved };
                    self.take(proved, None)?;
                    refused = Reason::Short;
                    factor
                }
                Err(reason) => {
                    let least = if longest > 0.0 { longest * SHORTEST } else { first * SHORTEST_FIRST };
                    // In the shortest windows numbers may leave the range first; longer ones have seen why.
                    refused = if reason == Reason::Short { refused } else { reason };
                    // Also where a step is not a number.
                    let can_be_shorter = step > least.max(2.0 * unit);
                    if !can_be_shorter {
                        return Err(self.reason(refused));
                    }
                    if longest > 0.0 { SHORTER } else { 0.5 }
                }
            };
            h = on_grid(step * factor, unit);
        }
    }

    /// Proves a window, on which the coordinate of the end has to come nearer to its value.
    fn window(&mut self, goal: &Goal, h: f64) -> Result<Proved, Reason> {
        self.attempts += 1;
        let proved = Level::Best.dispatch(Window { prover: &mut self.prover, set: &self.set, h });
        let proved = proved.map_err(|refused| match refused {
            Refused::Obstacle(obstacle) => Reason::Obstacle(obstacle),
            Refused::Unbounded => Reason::Short,
        })?;
        if goal.is_ahead(&proved.bounds.sides) { Ok(proved) } else { Err(Reason::NotMonotone) }
    }

    /// Looks for ends in a window.
    fn ahead(&self, goal: &Goal, proved: &Proved) -> Result<Ahead, Reason> {
        let met = self.watches.met(&self.prover.equations, &self.set, proved)?;
        match (goal.passed(&self.set, proved), met) {
            (None, None) => Ok(Ahead::Nothing),
            (Some(step), None) => Ok(Ahead::Passed(step)),
            (Some(step), Some(met)) if step < met.from => Ok(Ahead::Passed(step)),
            (Some(step), Some(met)) if step <= met.to => Err(Reason::Together),
            (_, Some(met)) => Ok(Ahead::Event(met)),
        }
    }

    /// The window until just behind the end, in which nothing else ends the motion.
    fn last(&mut self, goal: Goal, h: f64) -> Result<(Goal, Option<End>), Reason> {
        let proved = self.window(&goal, h)?;
        if self.watches.met(&self.prover.equations, &self.set, &proved)?.is_some() {
            return Err(Reason::Together);
        }
        let end = self.end(&goal, proved)?;
        Ok((goal, Some(end)))
    }

    /// The window until just behind where a formula is met, before which none is.
    fn meet(&mut self, motion: &Motion<'_>, goal: &Goal, (met, unit): (&Met, f64)) -> Result<End, Reason> {
        let step = if motion.watched[met.watch].ends { met.step } else { (met.step / unit).ceil() * unit };
        let proved = self.window(goal, step)?;
        if !motion.watched[met.watch].ends && two_sum(self.reached, step).1 != 0.0 {
            return Err(Reason::Short);
        }
        if !self.watches.meets_last(met.watch, &self.prover.equations, &self.set, &proved) {
            return Err(Reason::Grazed);
        }
        let end = self.end_at(&met.goal, proved, Some(met.watch))?;
        let coordinates = end::coordinates(motion, &self.prover.equations, &met.goal, Some(&end));
        self.events.push(Event { watch: met.watch, gamma: end.gamma, coordinates });
        Ok(end)
    }

    fn end(&mut self, goal: &Goal, proved: Proved) -> Result<End, Reason> {
        self.end_at(goal, proved, None)
    }

    /// The end just before that of a window, where this formula is met, if one is.
    fn end_at(&mut self, goal: &Goal, proved: Proved, met: Option<usize>) -> Result<End, Reason> {
        let (before, h) = (self.reached, proved.h);
        let bounds = self.take(proved, met)?;
        if self.is_lost() {
            return Err(Reason::Lost);
        }
        let reached = Extended::from(before) + Extended::from(h);
        End::new(&mut self.prover, &self.set, goal, (reached, h), &bounds)
    }

    /// Goes to the end of a window.
    fn take(&mut self, proved: Proved, met: Option<usize>) -> Result<Bounds, Reason> {
        self.watches.take(met, &self.prover.equations, &self.set, &proved);
        self.set.advance(&self.prover.equations, &proved).ok_or(Reason::Lost)?;
        self.reached += proved.h;
        self.windows += 1;
        self.prover.approximate.keep(proved.h, proved.modes);
        Ok(proved.bounds)
    }

    /// True if a bound says nothing any more. Before the end that stops no proof: what hardly moves yet may have larger
    /// bounds than it moves by. But where no window follows, it is why.
    fn is_lost(&self) -> bool {
        // What rests at 0 with all of its kind has no size.
        let is_kept = |(i, radius): (usize, &f64)| {
            let size = self.set.size_of_kind(i);
            *radius <= LOST * size || size == 0.0 && radius.is_finite()
        };
        !self.set.radii().iter().enumerate().all(is_kept)
    }

    /// Why a proof that goes no further ends, if this is why it was refused a window.
    fn reason(&self, refused: Reason) -> Reason {
        if refused == Reason::Short && self.is_lost() { Reason::Lost } else { refused }
    }
}

#[cfg(test)]
mod lemmas;
#[cfg(test)]
mod tests;
