//! The routes to a world-line that are special to one kind of space-time.

use super::accuracy;
use super::arithmetic::Arithmetic;
use super::crossing::{self, Near};
use super::failure::NoSolution;
use super::places::Places;
use super::run::Observer;
use super::setup::{Settings, Setup, System};
use super::world_line::{Place, WorldLine};
use crate::action::Form;
use crate::geometry::Geometry;
use crate::geometry::metric::Metric;
use crate::sbp::SbpName;

/// Whether a fixed-point iteration solves the equations of such windows.
fn has_sweeps(settings: &Settings) -> bool {
    let is_weak = settings.form == Form::Weak && settings.system == System::PhysicalLimit;
    is_weak && matches!(settings.sbp, SbpName::Gll(_))
}

/// A space-time for which [`solve`](crate::solve()) finds world-lines.
#[expect(private_bounds, reason = "only this module solves")]
pub trait Routes<S: Arithmetic>: Places<S> {
    /// The run to an accuracy.
    ///
    /// # Errors
    /// [`NoSolution`] if it is not reached; in one coordinate also if S is not `f64`.
    fn to_accuracy(
        setup: &Setup<S, Self>,
        accuracy: f64,
        observer: Option<Observer<'_, S, Self>>,
    ) -> Result<WorldLine<S, Self>, NoSolution>;

    /// The run on γ − γ_i ∈ [0, `length`] by a fast iteration; none if there is no such iteration, or if it does not
    /// converge.
    fn fast(
        setup: &Setup<S, Self>,
        length: S,
        observer: Option<Observer<'_, S, Self>>,
    ) -> Result<Option<WorldLine<S, Self>>, NoSolution>;

    /// About where a formula that ends the run first changes its sign within `length`; `None` if none does.
    fn first_change(setup: &Setup<S, Self>, length: f64) -> Option<Near>;
}

impl<S: Arithmetic> Routes<S> for Metric<S> {
    fn to_accuracy(
        setup: &Setup<S, Self>,
        accuracy: f64,
        observer: Option<Observer<'_, S, Self>>,
    ) -> Result<WorldLine<S, Self>, NoSolution> {
        let Place { geometry, start, .. } = &setup.rough;
        accuracy::solve(setup, (geometry.scene(), start), accuracy, observer)
    }

    fn fast(
        setup: &Setup<S, Self>,
        length: S,
        observer: Option<Observer<'_, S, Self>>,
    ) -> Result<Option<WorldLine<S, Self>>, NoSolution> {
        if has_sweeps(&setup.settings) { S::fast_run(setup, length, observer) } else { Ok(None) }
    }

    /// Formulas are those of scenes.
    fn first_change(_: &Setup<S, Self>, _: f64) -> Option<Near> {
        None
    }
}

impl<S: Arithmetic> Routes<S> for Geometry<S> {
    fn to_accuracy(
        setup: &Setup<S, Self>,
        accuracy: f64,
        observer: Option<Observer<'_, S, Self>>,
    ) -> Result<WorldLine<S, Self>, NoSolution> {
        let Place { geometry, start, .. } = &setup.rough;
        accuracy::solve(setup, (geometry, start), accuracy, observer)
    }

    fn fast(
        setup: &Setup<S, Self>,
        length: S,
        observer: Option<Observer<'_, S, Self>>,
    ) -> Result<Option<WorldLine<S, Self>>, NoSolution> {
        if has_sweeps(&setup.settings) { S::fast_scene(setup, length, observer) } else { Ok(None) }
    }

    fn first_change(setup: &Setup<S, Self>, length: f64) -> Option<Near> {
        crossing::first(setup, length)
    }
}
