//! The tolerances of two marches that judge each other, round by round.
//!
//! ```text
//! t = a/3
//! up to three rounds:
//!   march with the tolerances t and t/100
//!   e = max(largest distance + 5e-15, t/100) ≤ a: the finer march is the run
//!   t = t a/(3 distance), at most t/100; in the last round as small as possible
//! ```
//!
//! A distance tells how far apart the marches were where they were stopped, and not what would have become of them: of
//! a fall that passes a mass nine times it sees one. As a decade of the tolerance costs one window in ten, the last
//! round tries no less than what there is.

use super::Accuracy;
use super::tuning::LOOSEST;
use crate::number::norm::larger;

/// The tolerance of the finer march, in units of the other's: with a tenth 0.86 % of the finer ones were off by more
/// than the distance, with a thousandth 0.003 %, at a higher price.
const FINER: f64 = 1e-2;
/// The first tolerance of the coarse march is this share of the accuracy, so that most runs need one round.
const SHARE: f64 = 1.0 / 3.0;
/// Two marches round in their own ways, and may round alike: relative to sizes, what that leaves unseen.
pub(super) const ROUNDED: f64 = 5e-15;
/// The most rounds.
const ROUNDS: usize = 3;
/// The tolerance of the finer march is no tighter than this: rounding is all that would change. That of the other is
/// never the same, as equal windows agree on anything.
const TIGHTEST: f64 = 1e-16;

/// A round of two marches to an accuracy, or with a tolerance.
#[derive(Debug, Clone, Copy)]
pub struct Rounds {
    wanted: Accuracy,
    /// The tolerance of the coarse march.
    tolerance: f64,
    round: usize,
}

/// A tolerance that the coarse march can have.
fn possible(tolerance: f64) -> f64 {
    tolerance.clamp(TIGHTEST / FINER, LOOSEST)
}

impl Rounds {
    /// The first round.
    pub fn new(wanted: Accuracy) -> Self {
        let share = if wanted.is_promised() { SHARE } else { 1.0 };
        Self { wanted, tolerance: possible(share * wanted.value()), round: 1 }
    }

    /// The coarse march and the finer one, which is the run.
    pub fn marches(&self) -> [Accuracy; 2] {
        let accuracy = self.wanted.value();
        [1.0, FINER].map(|part| Accuracy::Alone { tolerance: part * self.tolerance, accuracy })
    }

    /// The error of the finer march where the largest distance is this, both relative to sizes.
    pub fn error(&self, distance: f64) -> f64 {
        larger(distance + ROUNDED, FINER * self.tolerance)
    }

    /// True if an error is no larger than what is promised. Where nothing is promised, any error is small enough.
    pub fn allows(&self, error: f64) -> bool {
        !self.wanted.is_promised() || error <= self.wanted.value()
    }

    /// True if it is not the first round.
    pub fn is_later(&self) -> bool {
        self.round > 1
    }

    /// The first round again.
    #[must_use]
    pub fn first(&self) -> Self {
        Self::new(self.wanted)
    }

    /// The next round, where the largest distance was this; `None` if there is none. The distance falls in proportion
    /// to the tolerance at most.
    pub fn next(&self, distance: f64) -> Option<Self> {
        let finer = FINER * self.tolerance;
        let expected = self.tolerance * SHARE * self.wanted.value() / distance;
        // Two marches that met other events, or none, have no distance.
        let expected = if distance.is_finite() && expected < finer { expected } else { finer };
        let tolerance = possible(if self.round + 1 == ROUNDS { 0.0 } else { expected });
        let is_possible = self.round < ROUNDS && tolerance < self.tolerance;
        is_possible.then_some(Self { tolerance, round: self.round + 1, ..*self })
    }
}
