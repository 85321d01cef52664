//! The places of a run at which its formulas are looked at.

use super::loudest::Loudest;
use super::places::Places;
use crate::case::Case;
use crate::number::Real;
use crate::solve::{Setup, WorldLine};

/// Places that are spread over a run, and those at which formulas lose most.
#[derive(Debug)]
pub(crate) struct Sights {
    pub(super) places: Places,
    pub(super) loudest: Loudest,
}

impl Default for Sights {
    /// Some places, and one in each of the windows at which formulas lose most.
    fn default() -> Self {
        Self { places: Places::default(), loudest: Loudest::new(false) }
    }
}

impl Sights {
    /// From so many to twice as many places, and all nodes of the windows at which formulas lose most.
    pub(super) fn of(kept: usize) -> Self {
        Self { places: Places::of(kept), loudest: Loudest::new(true) }
    }

    /// Takes the next part of a run of `case` into account, where events have `set` parameters. A part that contains
    /// the first window begins the run again.
    pub(crate) fn see<S: Real, R: Real>(&mut self, of: (&Case, &Setup<R>), part: &WorldLine<S>, set: &[(usize, f64)]) {
        self.places.see(part, set);
        self.loudest.see(of, part, set);
    }
}
