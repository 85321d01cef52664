//! Formulas that end the motion where they change their signs, or are met there, each the value of an unknown z.
//!
//! In a window z = y ± ε, where y is a polynomial with the slope v, so that |z − y(m)| ≤ |v| |τ − m| + ε on the way
//! from m to τ. Parts of the window where that leaves z on one side of 0 are found by halving. In what is left
//! ż = f(y + e) is no further from v than d and |J| ε: where that has one sign z passes 0 once.

use super::end::{Goal, way};
use super::equations::Equations;
use super::proved::Proved;
use super::set::Set;
use super::tables::UP;
use super::{Motion, Reason, Watched};
use crate::geometry::Direction;

/// A window is halved so many times to find where a value is 0, and looked at in no more than so many places: a value
/// may be 0 on all of it.
const HALVINGS: usize = 24;
const MOST_LOOKS: usize = 1024;

/// A value that is nearer to 0 than so many times what it may be off by is about to pass it: the window in which all
/// motions of a set do so begins before that.
const NEAR: f64 = 4.0;

/// A formula that is watched, with the side of 0 that it is on at the start of the next window.
struct Watch {
    unknown: usize,
    direction: Direction,
    side: Side,
}

/// Where a value is.
#[derive(Clone, Copy)]
enum Side {
    /// On this side of 0.
    Of(f64),
    /// At 0, from where it goes to this side, or nobody knows to which: it has just been met, or the motion starts
    /// there.
    Leaves(Option<f64>),
}

/// The formulas that are watched.
pub(super) struct Watches(Vec<Watch>);

/// A part of a window, from one place to another, where a value may be 0.
#[derive(Clone, Copy)]
struct Part {
    from: f64,
    to: f64,
}

/// Where a formula is met in a window.
pub(super) struct Met {
    /// The place of the formula among those that are watched.
    pub(super) watch: usize,
    pub(super) from: f64,
    pub(super) to: f64,
    /// Just behind it, as far as the polynomial of the window knows.
    pub(super) step: f64,
    /// An end there.
    pub(super) goal: Goal,
}

impl Watches {
    /// Those of a motion.
    pub(super) fn new(motion: &Motion<'_>, equations: &Equations<'_>, set: &Set) -> Result<Self, Reason> {
        let first = motion.geometry.dimension() - motion.watched.len();
        let watch = |(k, watched): (usize, &Watched)| {
            let unknown = equations.of.iter().position(|of| *of == (first + k, false)).ok_or(Reason::Grazed)?;
            let value = set.start[unknown] + set.centre[unknown];
            let is_known = value.abs() * (1.0 - 4.0 * f64::EPSILON) > set.radii()[unknown];
            let leaves = motion.leaves.filter(|(place, _)| *place == k).map(|(_, side)| side);
            let side = if is_known && leaves.is_none() { Side::Of(value.signum()) } else { Side::Leaves(leaves) };
            Ok(Watch { unknown, direction: watched.direction, side })
        };
        motion.watched.iter().enumerate().map(watch).collect::<Result<_, _>>().map(Self)
    }

    /// The length of a window in which a formula passes 0, if it does so at the end of this one, or is about to:
    /// motions of a set pass it one after the other, and all of them in one window, some way behind its start.
    pub(super) fn longer(&self, equations: &Equations<'_>, set: &Set, proved: &Proved) -> Option<f64> {
        let h = proved.h;
        let longer = self.0.iter().filter_map(|watch| {
            let seen = Seen::new(equations, set, proved, watch.unknown);
            let (value, rate) = (seen.value(h), slope(&proved.modes[watch.unknown], h, h));
            let is_about_to = value * rate < 0.0 && value.abs() < NEAR * seen.room;
            let passes = is_about_to || seen.parts().last().is_some_and(|part| part.to == h);
            let step = h + 2.0 * (value.abs() + seen.room) / rate.abs();
            (passes && step.is_finite()).then_some(step)
        });
        longer.reduce(f64::max)
    }

    /// The first formula that is met in a window, if there is one; an error if it is not known whether one is.
    pub(super) fn met(&self, equations: &Equations<'_>, set: &Set, proved: &Proved) -> Result<Option<Met>, Reason> {
        let mut first: Option<Met> = None;
        for (place, watch) in self.0.iter().enumerate() {
            let seen = Seen::new(equations, set, proved, watch.unknown);
            let passed = seen.passed(watch.side).ok_or(Reason::Grazed)?;
            if passed.last().is_some_and(|(part, _)| part.to == proved.h) {
                return Err(Reason::Grazed);
            }
            if let Some(&(part, side)) = passed.iter().find(|(_, side)| watch.direction.counts(*side > 0.0)) {
                match &first {
                    Some(first) if first.to < part.from => {}
                    Some(first) if first.from <= part.to => return Err(Reason::Together),
                    _ => first = Some(seen.met(place, part, side).ok_or(Reason::Grazed)?),
                }
            }
        }
        Ok(first)
    }

    /// True if this formula, and no other, is met in a window, and once.
    pub(super) fn meets_once(&self, watch: usize, equations: &Equations<'_>, set: &Set, proved: &Proved) -> bool {
        self.0.iter().enumerate().all(|(place, other)| {
            let Some(passed) = Seen::new(equations, set, proved, other.unknown).passed(other.side) else {
                return false;
            };
            let mut met = passed.iter().filter(|(_, side)| other.direction.counts(*side > 0.0));
            (place != watch || met.next().is_some()) && met.next().is_none()
        })
    }

    /// Goes to the end of a window, just before which this one is met, if one is.
    pub(super) fn take(&mut self, met: Option<usize>, equations: &Equations<'_>, set: &Set, proved: &Proved) {
        for (place, watch) in self.0.iter_mut().enumerate() {
            let seen = Seen::new(equations, set, proved, watch.unknown);
            let parts = seen.parts();
            let way = parts.last().and_then(|&part| seen.way_on(part));
            watch.side = match way {
                way if met == Some(place) => Side::Leaves(way),
                Some(way) => Side::Of(way),
                None => seen.side_at_start(&parts, watch.side),
            };
        }
    }
}

/// An unknown in a window.
struct Seen<'w> {
    set: &'w Set,
    proved: &'w Proved,
    unknown: usize,
    /// Bounds of |v|, of |v′| and of |ż − v|.
    fastest: f64,
    bent: f64,
    off: f64,
    /// A bound of |z − y|, rounding of y included.
    room: f64,
}

impl<'w> Seen<'w> {
    fn new(equations: &Equations<'_>, set: &'w Set, proved: &'w Proved, unknown: usize) -> Self {
        let modes = &proved.modes[unknown];
        let fastest = modes.iter().map(|mode| mode.abs()).sum::<f64>() * UP;
        // |P_k′| ≤ k (k + 1)/2, by 2/h for the length of the window.
        let slope = |(k, mode): (usize, &f64)| (k * (k + 1)) as f64 * mode.abs();
        let bent = modes.iter().enumerate().map(slope).sum::<f64>() / proved.h * UP * UP;
        let of_errors = (equations.entries.iter().zip(&proved.bounds.jacobian))
            .filter(|(entry, _)| entry.row == unknown)
            .map(|(entry, jacobian)| jacobian * proved.added.epsilon[entry.column] * UP);
        // P_k and their sum round each term by less than so many parts.
        let rounding = 128.0 * f64::EPSILON;
        Self {
            set,
            proved,
            unknown,
            fastest,
            bent,
            off: (proved.defect[unknown] + of_errors.sum::<f64>() + rounding * fastest) * UP,
            room: (proved.added.epsilon[unknown] + rounding * (set.start[unknown].abs() + proved.h * fastest)) * UP,
        }
    }

    /// y at a place.
    fn value(&self, at: f64) -> f64 {
        self.set.start[self.unknown] + way(&self.proved.modes[self.unknown], self.proved.h, at)
    }

    /// Where it may be 0, in order: no two of these parts touch each other.
    fn parts(&self) -> Vec<Part> {
        let mut parts: Vec<Part> = Vec::new();
        let (mut left, mut looks) = (vec![(0.0, self.proved.h, 0)], 0);
        while let Some((from, to, halvings)) = left.pop() {
            looks += 1;
            let middle = 0.5 * (from + to);
            let most = (self.fastest * (to - from) * 0.5 + self.room) * UP * UP;
            // A comparison that is false for NaN.
            if self.value(middle).abs() > most {
                continue;
            }
            if halvings < HALVINGS && looks < MOST_LOOKS {
                left.extend([(middle, to, halvings + 1), (from, middle, halvings + 1)]);
            } else {
                match parts.last_mut().filter(|last| last.to == from) {
                    Some(last) => last.to = to,
                    None => parts.push(Part { from, to }),
                }
            }
        }
        parts
    }

    /// The sign of ż on a part, if it has one.
    fn way_on(&self, Part { from, to }: Part) -> Option<f64> {
        let slope = slope(&self.proved.modes[self.unknown], self.proved.h, 0.5 * (from + to));
        let room = (self.off + self.bent * (to - from) * 0.5) * UP;
        (slope.abs() * (1.0 - 4.0 * f64::EPSILON) > room).then_some(slope.signum())
    }

    /// The parts in which the value passes 0 once on its way from `side`, each with the side behind it. A value that is
    /// at 0 at the start leaves it there and passes nothing. `None` if it is not known.
    fn passed(&self, side: Side) -> Option<Vec<(Part, f64)>> {
        let parts = self.parts();
        let (mut side, mut passed) = (self.side_at_start(&parts, side), Vec::new());
        for part in parts {
            let way = self.way_on(part)?;
            match side {
                Side::Leaves(to) if part.from == 0.0 && to.is_none_or(|to| to == way) => {}
                Side::Of(before) if way == -before => passed.push((part, way)),
                _ => return None,
            }
            side = Side::Of(way);
        }
        Some(passed)
    }

    /// What is known of the side at the start: a value that was at 0 may have left it.
    fn side_at_start(&self, parts: &[Part], side: Side) -> Side {
        let is_beside = parts.first().is_none_or(|part| part.from > 0.0);
        match side {
            Side::Leaves(to) if is_beside => {
                let here = self.value(0.0).signum();
                if to.is_none_or(|to| to == here) { Side::Of(here) } else { side }
            }
            _ => side,
        }
    }

    /// The end in a part where it passes 0 to `side`.
    fn met(&self, watch: usize, Part { from, to }: Part, side: f64) -> Option<Met> {
        let goal = Goal::zero(self.unknown, side);
        let step = goal.passed_within(self.set, self.proved, [from, to])?;
        Some(Met { watch, from, to, step, goal })
    }
}

/// v at a place of a window of this length, but for rounding.
fn slope(modes: &[f64], length: f64, at: f64) -> f64 {
    let x = 2.0 * at / length - 1.0;
    let (mut before, mut here, mut sum) = (1.0, x, modes[0]);
    for (k, mode) in modes.iter().enumerate().skip(1) {
        sum += mode * here;
        (before, here) = (here, ((2 * k + 1) as f64 * x * here - k as f64 * before) / (k + 1) as f64);
    }
    sum
}
