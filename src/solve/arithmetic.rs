//! What a run in `f64` and one in extended precision do differently, chosen by the type of the numbers.

use std::sync::Arc;

use super::failure::NoSolution;
use super::run::Observer;
use super::setup::Setup;
use super::solution::Solution;
use super::spectral;
use super::world_line::{Place, WorldLine};
use crate::geometry::Geometry;
use crate::geometry::metric::Metric;
use crate::number::{Extended, Real};
use crate::sbp::SbpOperator;

/// The numbers that [`solve`](crate::solve()) computes in: `f64` and [`Extended`].
#[expect(private_bounds, reason = "only this module solves")]
pub trait Arithmetic: Real + Engine {
    /// `place` in `f64`, for [`Setup::rough`]: itself, or the one that `rounded` makes.
    fn rough_place(
        place: &Place<Self, Metric<Self>>,
        rounded: impl FnOnce() -> Place<f64, Metric>,
    ) -> Place<f64, Metric>;
}

impl Arithmetic for f64 {
    fn rough_place(place: &Place<f64, Metric>, _: impl FnOnce() -> Place<f64, Metric>) -> Place<f64, Metric> {
        place.clone()
    }
}

impl Arithmetic for Extended {
    fn rough_place(_: &Place<Self, Metric<Self>>, rounded: impl FnOnce() -> Place<f64, Metric>) -> Place<f64, Metric> {
        rounded()
    }
}

/// The parts of a run that depend on the kind of numbers.
pub(super) trait Engine: Real {
    /// `sbp` in `f64`: itself, or the one that `rounded` makes.
    fn rough_operator(sbp: &Arc<SbpOperator<Self>>, rounded: impl FnOnce() -> SbpOperator) -> Arc<SbpOperator>;

    /// The run of spectral elements in the weak form, on γ − γ_i ∈ [0, `length`], by a fast iteration; none if there is
    /// no such iteration, or if it does not converge.
    fn fast_run(
        setup: &Setup<Self, Metric<Self>>,
        length: Self,
        observer: Option<Observer<'_, Self, Metric<Self>>>,
    ) -> Result<Option<Solution<Self>>, NoSolution>;

    /// The same for a scene.
    fn fast_scene(
        setup: &Setup<Self>,
        length: Self,
        observer: Option<Observer<'_, Self, Geometry<Self>>>,
    ) -> Result<Option<WorldLine<Self>>, NoSolution>;
}

impl Engine for f64 {
    fn rough_operator(sbp: &Arc<SbpOperator>, _: impl FnOnce() -> SbpOperator) -> Arc<SbpOperator> {
        Arc::clone(sbp)
    }

    fn fast_run(
        setup: &Setup<f64, Metric>,
        length: f64,
        observer: Option<Observer<'_, f64, Metric<f64>>>,
    ) -> Result<Option<Solution>, NoSolution> {
        spectral::march(setup, length, observer)
    }

    fn fast_scene(
        setup: &Setup<f64>,
        length: f64,
        observer: Option<Observer<'_, f64, Geometry>>,
    ) -> Result<Option<WorldLine>, NoSolution> {
        spectral::windows(setup, length, observer)
    }
}

impl Engine for Extended {
    fn rough_operator(_: &Arc<SbpOperator<Self>>, rounded: impl FnOnce() -> SbpOperator) -> Arc<SbpOperator> {
        Arc::new(rounded())
    }

    fn fast_run(
        _: &Setup<Self, Metric<Self>>,
        _: Self,
        _: Option<Observer<'_, Self, Metric<Self>>>,
    ) -> Result<Option<Solution<Self>>, NoSolution> {
        Ok(None)
    }

    fn fast_scene(
        _: &Setup<Self>,
        _: Self,
        _: Option<Observer<'_, Self, Geometry<Self>>>,
    ) -> Result<Option<WorldLine<Self>>, NoSolution> {
        Ok(None)
    }
}
