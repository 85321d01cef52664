//! The narrowest place of a motion: where its windows are shortest. A close encounter, a pole of coordinates and a
//! collision are such places, and what a run to an accuracy fails for may lie long behind them.

use std::fmt;

use super::acting::LastEvent;
use super::failure::At;
use super::point::Point;

/// A place is narrow if windows there are shorter than this share of the longest one.
const SHARE: f64 = 1e-3;
/// The remedy where there is such a place.
pub(super) const ADVICE: &str = concat!(
    "a close encounter or a collision: conformal = a formula that grows there as the force does, such as a sum of ",
    "1/distance, makes windows even and loses fewer digits; after a collision there is no motion; at a pole, choose ",
    "coordinates without one (the preset kerr-schild has none); or ask for a larger solver.accuracy, or for ",
    "solver.tolerance in its place, which goes to the end",
);

/// The narrowest place of a motion.
#[derive(Debug, Clone, PartialEq)]
pub struct Narrow {
    /// Its windows are this share of the longest one.
    pub share: f64,
    /// γ there.
    pub gamma: f64,
    /// The active coordinates there, with their names.
    pub point: Vec<(String, f64)>,
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

/// The narrowest windows of a run so far.
#[derive(Debug, Clone, Default)]
pub(super) struct Lengths {
    longest: f64,
    /// The shortest, its γ, and q^a there.
    shortest: Option<(f64, f64, Vec<f64>)>,
}

impl Lengths {
    /// Takes a window into account that begins at this γ and these q^a.
    pub(super) fn see(&mut self, length: f64, gamma: f64, q: impl FnOnce() -> Vec<f64>) {
        self.longest = self.longest.max(length);
        if self.shortest.as_ref().is_none_or(|(shortest, ..)| length < *shortest) {
            self.shortest = Some((length, gamma, q()));
        }
    }

    /// The narrowest place, if there is one that is narrow. `place` names it.
    pub(super) fn narrow(&self, place: impl FnOnce(f64, &[f64]) -> At) -> Option<Narrow> {
        let (shortest, gamma, q) = self.shortest.as_ref()?;
        let share = shortest / self.longest;
        (share < SHARE).then(|| {
            let At { gamma, point, .. } = place(*gamma, q);
            Narrow { share, gamma, point }
        })
    }
}

impl fmt::Display for Narrow {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let point = Point { gamma: self.gamma, point: &self.point };
        write!(f, "windows are shortest, {:.0e} of the longest, at {point}", self.share)
    }
}
