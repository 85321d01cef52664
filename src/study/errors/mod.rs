//! The distance of a run from the world-line of the continuum.
//!
//! A run to an accuracy has an estimate of its own. Another is compared with a second solve by [`crate::engine`], which
//! shares neither grid nor operator with it and costs little. A run in extended precision that agrees with it to its
//! last digits is compared with the Taylor series of [`crate::reference`] in the same precision, and so is any run for
//! which that is wanted.
//!
//! Besides, a run has errors that it does not make itself: what it inherits from the run that it continues, and what
//! rounding takes from its formulas.

mod added_up;
mod beside;
mod between;
mod carried;
mod compare;
mod conditioning;
mod ends;
mod evaluated;
mod events;
mod finding;
mod further;
mod loudest;
mod meetings;
mod places;
mod sights;
mod uniqueness;

pub(crate) use compare::{chain_error, sizes_of};
pub(crate) use conditioning::lost_to;
pub(crate) use events::{OfRun, Paired, events_of_chain, first_touched, first_unseen, paired, passed};
pub(crate) use further::Further;
pub(crate) use sights::Sights;
pub(crate) use uniqueness::several_motions;

use self::between::own_windows;
use self::carried::accuracy_beside;
use self::compare::{ACCURACY, Points};
use self::ends::End;
use crate::number::Real;
use crate::number::norm::larger;
use crate::solve::{Setup, WorldLine};
use crate::trajectory::Sample;

/// If the errors of an extended run are below this, relative to the sizes of the coordinates, they are measured in
/// extended precision.
const BEYOND_F64: f64 = 1e-11;

/// Where a second solve does not reach the end, one to this accuracy may.
const COARSER: f64 = 1e-10;

/// The distance of a run from the world-line of the continuum.
#[derive(Debug, Clone, PartialEq)]
pub struct RunError {
    /// By how much each coordinate is off at the last node. If the value of a coordinate ended the run, points with
    /// that value are compared, and it has no error there.
    pub end: Vec<f64>,
    /// The largest of the same over the nodes, of which the last is compared as for `end`.
    pub largest: Vec<f64>,
    /// By how much the judge may be off itself, in the unit of each coordinate.
    pub own: Vec<f64>,
    /// By how much each momentum is off at the last node, at the same point as for `end`, if the judge knows momenta:
    /// where a force jumps just there, they may be off by far more than their coordinates.
    pub end_p: Option<Vec<f64>>,
    /// The judge that the run was compared with.
    pub judge: Judge,
    /// The share of its way by which the motion may be off because the judge stepped over a feature. In scenes it is 0
    /// where a force acts, which changes K, and in extended precision.
    pub stepped_over: f64,
}

/// The judge that a run is compared with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Judge {
    /// A second solve with this estimated relative error.
    SecondSolve(f64),
    /// A Taylor trajectory with this estimated relative error.
    Taylor(f64),
    /// A coarser march beside it, of which a run to an accuracy is the finer one.
    Companion,
}

impl Judge {
    /// A phrase for display.
    pub fn describe(self) -> String {
        match self {
            // Its last digits depend on the order of sums.
            Self::SecondSolve(error) => format!("from a second solve to {:.0e}", 10.0_f64.powf(error.log10().ceil())),
            Self::Taylor(error) => format!("from a Taylor series good to {error:.0e}"),
            Self::Companion => "from a run to a hundredth of the tolerance".to_owned(),
        }
    }

    /// Its relative error.
    pub fn relative_error(self) -> f64 {
        match self {
            Self::SecondSolve(error) | Self::Taylor(error) => error,
            Self::Companion => 0.0,
        }
    }

    /// The error of a Taylor trajectory.
    pub fn reference_error(self) -> Option<f64> {
        if let Self::Taylor(error) = self { Some(error) } else { None }
    }
}

impl RunError {
    /// No error of so many coordinates, yet.
    fn none(coordinates: usize) -> Self {
        let zeros = || vec![0.0; coordinates];
        Self { end: zeros(), largest: zeros(), own: zeros(), end_p: None, judge: Judge::Companion, stepped_over: 0.0 }
    }

    /// Takes the next node into account, which is off by this.
    fn see(&mut self, off: impl IntoIterator<Item = f64>) {
        for ((largest, last), off) in self.largest.iter_mut().zip(&mut self.end).zip(off) {
            *last = off.abs();
            *largest = larger(*largest, *last);
        }
    }

    /// The same, where the coordinates are off by this at the end.
    pub(crate) fn with_end(self, end: &[f64]) -> Self {
        let largest = self.largest.iter().zip(end).map(|(largest, end)| larger(*largest, *end)).collect();
        Self { largest, end: end.to_vec(), ..self }
    }

    /// Upper estimates of the absolute errors of the coordinates at the last node.
    pub fn at_most_at_end(&self) -> Vec<f64> {
        self.with_own(&self.end)
    }

    /// Upper estimates of the largest absolute errors of the coordinates over the nodes.
    pub fn at_most(&self) -> Vec<f64> {
        self.with_own(&self.largest)
    }

    fn with_own(&self, found: &[f64]) -> Vec<f64> {
        found.iter().zip(&self.own).map(|(found, own)| found + own).collect()
    }
}

/// The error of the run of `setup`, of which only its last part, `line`, and `samples` of all of it may be kept; `None`
/// if no second solve reaches the end.
pub fn run_error<S: Real>(setup: &Setup<S>, line: &WorldLine<S>, samples: &[Sample<S>]) -> Option<RunError> {
    own_error(setup, (line, None), samples, Noise::default())
}

/// The losses of the formulas of a run to rounding.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Noise {
    /// The share that slopes lose.
    pub(crate) share: f64,
    /// The loss of K.
    pub(crate) norm: f64,
}

/// The same, where rounding takes this from formulas: a second solve to less than that gets nowhere. The error at an
/// event that ended a run may be known from the end of its judge.
pub(crate) fn own_error<S: Real>(
    setup: &Setup<S>,
    (line, at_end): (&WorldLine<S>, Option<&[f64]>),
    samples: &[Sample<S>],
    Noise { share, norm }: Noise,
) -> Option<RunError> {
    let end = End::new(setup, line);
    if line.error_estimate.is_some() {
        // Nothing is known of a chain whose judge has met other events.
        if line.errors.is_empty() {
            return None;
        }
        let mut found = RunError::none(line.errors.len());
        found.see(line.errors.iter().copied());
        match (at_end, end.coordinate()) {
            (Some(at_end), _) => found = found.with_end(at_end),
            (None, Some(coordinate)) => found.end[coordinate] = 0.0,
            (None, None) => found.see(end.with_late(found.end.clone(), line)),
        }
        return Some(RunError { stepped_over: own_windows(setup, line, norm), ..found });
    }
    let points = Points::new(line, samples, end);
    let found = points.with_second_solve(&setup.rough, setup.handed(), [ACCURACY, norm]);
    // Rounding, of V say, may let no window be short enough for that.
    let coarser = larger(accuracy_beside(share), COARSER);
    let found = found.or_else(|| points.with_second_solve(&setup.rough, setup.handed(), [coarser, norm]));
    let is_beyond = |error: &RunError| {
        let sizes = points.sizes();
        error.at_most().iter().zip(&sizes).all(|(most, size)| *most <= BEYOND_F64 * size)
    };
    let is_asked = S::IS_EXTENDED && found.as_ref().is_none_or(is_beyond);
    if is_asked { points.with_taylor(&setup.rough, norm).or(found) } else { found }
}

/// The same against a Taylor reference of as many digits; `None` if that does not reach the end.
pub fn reference_error<S: Real>(setup: &Setup<S>, line: &WorldLine<S>, samples: &[Sample<S>]) -> Option<RunError> {
    Points::new(line, samples, End::new(setup, line)).with_taylor(&setup.rough, 0.0)
}
