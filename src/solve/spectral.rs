//! Windows of the weak form on spectral elements, solved by the fixed-point iterations of [`crate::engine`].
//!
//! It is the same collocation system that Newton's method solves window by window, and every window is certified on the
//! same action; the iteration is just some fifty times faster. Where it does not converge, because a window is too long
//! for it, Newton's method takes over.

use super::accuracy::{JointOf, append};
use super::arithmetic::Arithmetic;
use super::failure::NoSolution;
use super::run::{Observer, Run};
use super::setup::{Settings, Setup, System};
use super::world_line::{Place, WorldLine};
use crate::action::Form;
use crate::engine::{Engine, MOST_POINTS};
use crate::sbp::SbpName;

/// The windows of the run of `setup` on γ − γ_i ∈ [0, `length`]. There are none if they are no elements in the weak
/// form, if the numbers have more digits or windows more nodes than the engine has, or if it does not get to the end:
/// Newton's method takes over there, and knows why.
pub(super) fn windows<S: Arithmetic>(
    setup: &Setup<S>,
    length: S,
    observer: Option<Observer<'_, S>>,
) -> Result<Option<WorldLine<S>>, NoSolution> {
    let Settings { n_gamma: points, windows, form, system, sbp, .. } = setup.settings;
    let is_weak = form == Form::Weak && system == System::PhysicalLimit && matches!(sbp, SbpName::Gll(_));
    let window_length = length.to_f64() / windows as f64;
    // Tables hold the square of the length, and half as many digits of it again.
    let square = window_length * window_length;
    let is_in_range = square.is_finite() && square > f64::MIN_POSITIVE / f64::EPSILON / f64::EPSILON;
    if S::IS_EXTENDED || !is_weak || !is_in_range || points > MOST_POINTS {
        return Ok(None);
    }
    let Place { geometry, start, .. } = &setup.rough;
    let Ok(mut engine) = Engine::equal(geometry, start, length.to_f64(), windows, points) else { return Ok(None) };
    if let Some(carried) = &setup.carried {
        engine.resume(&carried.handed);
    }
    let mut run = Run::new(setup, &setup.settings, observer);
    run.expect(windows, points);
    run.reserve();
    run.line.length = length;
    let operator = run.line.operators.element(points, S::from(window_length));
    let mut joint = JointOf::new(start);
    for index in 1..=windows {
        let Ok(Some(mut window)) = engine.next() else { return Ok(None) };
        let gamma = if index == windows { length } else { S::from(index as f64 * window_length) };
        run.line.iterations.count += window.sweeps;
        if index == windows {
            run.line.handed = window.handed();
        }
        if append(&mut run, &mut window, &mut joint, (geometry, operator), gamma).is_err() {
            return Ok(None);
        }
    }
    Ok(Some(run.line))
}
