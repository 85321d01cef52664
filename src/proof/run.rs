//! A proof goes from window to window: each takes the set of errors at its start to that at its end, and is made
//! shorter where the theorem does not hold, down to a length at which the proof ends with the reason.

use super::approximate::Approximate;
use super::defect::Defect;
use super::ellipse::{Bounds, Ellipse};
use super::end::{self, End, Goal};
use super::equations::Equations;
use super::proved::Proved;
use super::samples::Samples;
use super::set::Set;
use super::watch::{Met, Watches};
use super::window::{Prover, Refused, Window};
use super::{Coordinate, Event, Motion, Progress, Proof, Reason, spread};
use crate::number::Extended;
use crate::number::ball::two_sum;
use crate::number::vector::Level;

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

/// A proof on its way.
pub(super) struct Run<'m, 'g> {
    motion: &'m Motion<'m>,
    prover: Prover<'g>,
    set: Set,
    watches: Watches,
    samples: Samples<'m>,
    way: Vec<(f64, Vec<Coordinate>)>,
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
    /// A formula passes 0 at its end: a window so long has passed it.
    Passing(f64),
}

/// Lengths of windows, but for the last one, are multiples of a power of two, so that sums of them are exact.
fn on_grid(h: f64, unit: f64) -> f64 {
    (h / unit).floor().max(1.0) * unit
}

impl<'m, 'g> Run<'m, 'g> {
    /// At the start of a motion.
    pub(super) fn new(motion: &'m Motion<'m>, equations: Equations<'g>, is_finer: bool) -> Result<Self, Reason> {
        let set = Set::new(&equations, equations.columns(motion.generators).ok_or(Reason::Constant)?);
        let set = set.behind(equations.of.iter().map(|&of| motion.begun(of)));
        Ok(Self {
            watches: Watches::new(motion, &equations, &set)?,
            samples: Samples::new(motion),
            way: Vec::new(),
            motion,
            set,
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
        })
    }

    /// The proof, but for its time.
    pub(super) fn proof(mut self, goes_on: &mut dyn FnMut(Progress) -> bool) -> Proof {
        let goal = Goal::new(self.motion, &self.prover.equations);
        let length = goal.exact_length();
        let mut state = Vec::new();
        let end = self.to(goal, goes_on).map(|end| {
            // Where nothing varies there is no window.
            let end = end.unwrap_or_else(|| End::after(length));
            if !self.motion.generators.is_empty() || self.ended_by.is_some() {
                state = spread::state(self.motion, &self.prover.equations, &end);
            }
            end::coordinates(self.motion, &self.prover.equations, end.gamma, &end.unknowns)
        });
        Proof {
            end,
            state,
            ended_by: self.ended_by,
            events: self.events,
            samples: self.samples.found,
            way: self.way,
            reached: self.reached,
            windows: self.windows,
            seconds: 0.0,
        }
    }

    /// To the end, which is `None` of a motion that does not vary.
    fn to(&mut self, goal: Goal, goes_on: &mut dyn FnMut(Progress) -> bool) -> Result<Option<End>, Reason> {
        if self.prover.equations.unknowns == 0 {
            return Ok(None);
        }
        let first = goal.length() * FIRST;
        let unit = (first.log2().floor() - 40.0).exp2();
        let most = if self.motion.keeps_way { first } else { f64::INFINITY };
        self.keep_way();
        let (mut h, mut longest, mut short, mut refused) = (on_grid(first, unit), 0.0_f64, 0, Reason::Short);
        // A window may be tried in a longer one's place once.
        let mut is_longer = false;
        let of_window = self.prover.equations.operations();
        loop {
            let operations = self.attempts as f64 * of_window + self.samples.operations();
            if !goes_on(Progress { reached: self.reached, operations }) {
                return Err(Reason::Stopped);
            }
            let (step, is_last) = goal.step(self.reached, h);
            let may_be = |longer: f64| !is_longer && !is_last && longer <= most;
            let ahead = self.seen(&goal, (step, is_last), may_be);
            let factor = match ahead {
                Ok((Ahead::Event(met), _)) => {
                    let end = self.meet(&goal, (&met, unit))?;
                    if self.motion.watched[met.watch].ends {
                        self.ended_by = Some(met.watch);
                        return Ok(Some(end));
                    }
                    // Behind it windows are as long as before.
                    is_longer = false;
                    h / step
                }
                Ok((Ahead::Passed(step), _)) => return self.last(&goal, step).map(Some),
                Ok((Ahead::Passing(longer), _)) => {
                    is_longer = true;
                    longer / step
                }
                Ok((Ahead::Nothing, proved)) if is_last => return self.end_at(&goal, proved, None).map(Some),
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
                    (refused, is_longer) = (Reason::Short, false);
                    factor
                }
                Err(reason) => {
                    // In the shortest windows numbers may leave the range first; longer ones have seen why.
                    refused = if reason == Reason::Short { refused } else { reason };
                    self.shorter(step, [longest, first, unit], refused)?
                }
            };
            h = on_grid((step * factor).min(most), unit);
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

    /// By how much the next window is shorter than one that was refused, where the longest one and the first step are
    /// known; or the reason, if none may be.
    fn shorter(&self, step: f64, [longest, first, unit]: [f64; 3], refused: Reason) -> Result<f64, Reason> {
        let least = if longest > 0.0 { longest * SHORTEST } else { first * SHORTEST_FIRST };
        // Also where a step is not a number.
        let can_be_shorter = step > least.max(2.0 * unit);
        if !can_be_shorter {
            return Err(self.reason(refused));
        }
        Ok(if longest > 0.0 { SHORTER } else { 0.5 })
    }

    /// A window of this length, and what lies in it. One in which a formula passes 0 at the end is none, if it may not
    /// be longer.
    fn seen(
        &mut self,
        goal: &Goal,
        (step, is_last): (f64, bool),
        may_be: impl Fn(f64) -> bool,
    ) -> Result<(Ahead, Proved), Reason> {
        let proved = self.window(goal, step)?;
        match self.ahead(goal, &proved, is_last)? {
            Ahead::Passing(longer) if !may_be(longer) => Err(Reason::Grazed),
            ahead => Ok((ahead, proved)),
        }
    }

    /// Looks for ends in a window, which may be the last one.
    fn ahead(&self, goal: &Goal, proved: &Proved, is_last: bool) -> Result<Ahead, Reason> {
        let (equations, set) = (&self.prover.equations, &self.set);
        let longer = || self.watches.longer(equations, set, proved).map(Ahead::Passing);
        let met = match self.watches.met(equations, set, proved) {
            Ok(Some(met)) => Some(met),
            Ok(None) if is_last => None,
            Ok(None) => match longer() {
                Some(longer) => return Ok(longer),
                None => None,
            },
            Err(reason) => return longer().ok_or(reason),
        };
        match (goal.passed(&self.set, proved), met) {
            (None, None) => Ok(Ahead::Nothing),
            (Some(step), None) => Ok(Ahead::Passed(step)),
            (Some(step), Some(met)) if step < met.from => Ok(Ahead::Passed(step)),
            (Some(step), Some(met)) if step <= met.to => Err(Reason::Together),
            (_, Some(met)) => Ok(Ahead::Event(met)),
        }
    }

    /// The window until just behind the end, in which nothing else ends the motion.
    fn last(&mut self, goal: &Goal, h: f64) -> Result<End, Reason> {
        let proved = self.window(goal, h)?;
        if self.watches.met(&self.prover.equations, &self.set, &proved)?.is_some() {
            return Err(Reason::Together);
        }
        self.end_at(goal, proved, None)
    }

    /// The window until just behind where a formula is met, before which none is.
    fn meet(&mut self, goal: &Goal, (met, unit): (&Met, f64)) -> Result<End, Reason> {
        let ends = self.motion.watched[met.watch].ends;
        // Where another window follows γ has to stay exact.
        let step = if ends { met.step } else { (met.step / unit).ceil() * unit };
        let proved = self.window(goal, step)?;
        if !ends && two_sum(self.reached, step).1 != 0.0 {
            return Err(Reason::Short);
        }
        if !self.watches.meets_once(met.watch, &self.prover.equations, &self.set, &proved) {
            return Err(Reason::Grazed);
        }
        let end = self.end_at(&met.goal, proved, Some(met.watch))?;
        let coordinates = end::coordinates(self.motion, &self.prover.equations, end.gamma, &end.unknowns);
        self.events.push(Event { watch: met.watch, gamma: end.gamma, coordinates });
        Ok(end)
    }

    /// The end just before that of a window, where this formula is met, if one is.
    fn end_at(&mut self, goal: &Goal, proved: Proved, met: Option<usize>) -> Result<End, Reason> {
        let (before, h) = (self.reached, proved.h);
        let bounds = self.take(proved, met)?;
        if self.is_lost() {
            return Err(Reason::Lost);
        }
        let reached = Extended::from(before) + Extended::from(h);
        End::new(&mut self.prover, &self.set, goal, (reached, h), &bounds, self.motion.generators)
    }

    /// Goes to the end of a window.
    fn take(&mut self, proved: Proved, met: Option<usize>) -> Result<Bounds, Reason> {
        self.watches.take(met, &self.prover.equations, &self.set, &proved);
        self.samples.take(&self.prover.equations, &self.set, &proved, self.reached);
        self.set.advance(&self.prover.equations, &proved).ok_or(Reason::Lost)?;
        self.reached += proved.h;
        self.windows += 1;
        self.prover.approximate.keep(proved.h, proved.modes);
        self.keep_way();
        Ok(proved.bounds)
    }

    /// Keeps where the motions are, if that is wanted.
    fn keep_way(&mut self) {
        if !self.motion.keeps_way {
            return;
        }
        let Set { start, centre, .. } = &self.set;
        let middles = start.iter().zip(centre).map(|(start, centre)| Extended::from(*start) + Extended::from(*centre));
        let here: Vec<(Extended, f64)> = middles.zip(self.set.radii()).collect();
        let gamma = (Extended::from(self.reached), 0.0);
        self.way.push((self.reached, end::coordinates(self.motion, &self.prover.equations, gamma, &here)));
    }

    /// True if a bound says nothing any more. Before the end that stops no proof: what hardly moves yet may have larger
    /// bounds than it moves by. But where no window follows, it is why.
    fn is_lost(&self) -> bool {
        // What rests at 0 with all of its kind has no size, and a set of starts may be as large as the motion.
        let is_set = self.motion.is_set();
        let is_kept = |(i, radius): (usize, &f64)| {
            let size = self.set.size_of_kind(i);
            *radius <= LOST * size || (is_set || size == 0.0) && radius.is_finite()
        };
        !self.set.radii().iter().enumerate().all(is_kept)
    }

    /// Why a proof that goes no further ends, if this is why it was refused a window.
    fn reason(&self, refused: Reason) -> Reason {
        if refused == Reason::Short && self.is_lost() { Reason::Lost } else { refused }
    }
}
