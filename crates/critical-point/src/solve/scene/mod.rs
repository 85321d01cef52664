//! Critical points of the doubled action in scenes of n coordinates.

mod accuracy;
mod crossing;
mod end;
mod setup;

pub use super::world_line::{Place, WorldLine};
pub use setup::{SceneLimit, SceneSetup, Until};

use super::run::Run;
use crate::geometry::Geometry;
use crate::scalar::Real;
use crate::solve::{Arithmetic, NoSolution, Settings};

/// Solves a scene in the arithmetic of `S`: `f64`, or [`Extended`](crate::scalar::Extended) to the digits that the
/// setup asks for. More digits are obtained by refinement: everything that searches and steers is done in `f64`.
///
/// # Errors
/// [`NoSolution`] says how the solve ended, where, and with what residual.
///
/// # Panics
/// If the setup is not valid: too few nodes for the operator, or no windows.
pub fn solve_scene<S: Arithmetic>(setup: &SceneSetup<S>) -> Result<WorldLine<S>, NoSolution> {
    S::run_scene(setup)
}

/// [`solve_scene`] itself, which [`Arithmetic`] compiles once.
pub(super) fn solve<S: Arithmetic>(setup: &SceneSetup<S>) -> Result<WorldLine<S>, NoSolution> {
    if let Some(accuracy) = setup.settings.accuracy {
        return accuracy::solve(setup, accuracy);
    }
    let whole = match setup.limit {
        SceneLimit::Length(length) if setup.until.is_empty() => return solve_to(setup, length),
        SceneLimit::Length(length) => length,
        SceneLimit::Value { coordinate, value } => {
            let mut line = end::at_value(setup, coordinate, value)?;
            if !setup.until.is_empty() {
                line = end::until(setup, line.length)?;
            }
            // A search meets the value but for rounding.
            let ended_at = line.ended_by.is_none().then(|| (coordinate, line.last_joint().q[coordinate]));
            return Ok(WorldLine { ended_at, ..line });
        }
    };
    end::until(setup, whole)
}

/// Solves a scene on γ − γ_i ∈ [0, `length`], window after window.
fn solve_to<S: Arithmetic>(setup: &SceneSetup<S>, length: S) -> Result<WorldLine<S>, NoSolution> {
    run(setup, &setup.settings).solve(&setup.settings, &*setup.rough.geometry, true, length)
}

/// A run without windows.
fn run<S: Real>(setup: &SceneSetup<S>, settings: &Settings) -> Run<'static, S, Geometry<S>> {
    Run::new(setup.place.clone(), None, setup.gamma_i, settings, None)
}
