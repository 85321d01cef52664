//! The differences of runs in `f64` and in extended precision, chosen by the type of the numbers.

use std::sync::Arc;

use super::world_line::Place;
use crate::number::{Extended, Real};
use crate::sbp::SbpOperator;

/// The numbers that [`solve`](crate::solve()) computes in: `f64` and [`Extended`].
pub trait Arithmetic: Real {
    /// `place` in `f64`, for [`Setup::rough`](super::Setup::rough): itself, or the one that `rounded` makes.
    fn rough_place(place: &Place<Self>, rounded: impl FnOnce() -> Place) -> Place;

    /// `sbp` in `f64`: itself, or the one that `rounded` makes.
    fn rough_operator(sbp: &Arc<SbpOperator<Self>>, rounded: impl FnOnce() -> SbpOperator) -> Arc<SbpOperator>;
}

impl Arithmetic for f64 {
    fn rough_place(place: &Place, _: impl FnOnce() -> Place) -> Place {
        place.clone()
    }

    fn rough_operator(sbp: &Arc<SbpOperator>, _: impl FnOnce() -> SbpOperator) -> Arc<SbpOperator> {
        Arc::clone(sbp)
    }
}

impl Arithmetic for Extended {
    fn rough_place(_: &Place<Self>, rounded: impl FnOnce() -> Place) -> Place {
        rounded()
    }

    fn rough_operator(_: &Arc<SbpOperator<Self>>, rounded: impl FnOnce() -> SbpOperator) -> Arc<SbpOperator> {
        Arc::new(rounded())
    }
}
