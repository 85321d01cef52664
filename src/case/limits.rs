//! Limits of numbers of nodes and of spacings, for cases and for studies on other grids.

use super::SbpName;
use crate::action::Form;
use crate::number::Real;
use crate::solve::{Limit, Settings, Setup};

/// More nodes than this would exhaust the memory.
const MOST_POINTS: usize = 100_000_000;

/// A value that is not acceptable: its dotted key, why, and what to do.
pub(super) type Invalid = (&'static str, String, Option<&'static str>);

/// Refuses numbers of nodes that do not fit the operator (if it is given) or the memory.
pub(super) fn check_nodes(sbp: Option<SbpName>, n_gamma: usize, windows: usize) -> Result<(), Invalid> {
    if let Some(sbp) = sbp {
        if let Some(nodes) = sbp.fixed_points().filter(|&nodes| nodes != n_gamma) {
            let help = "leave n_gamma out, or choose the spectral element of that many nodes";
            return Err(("grid.n_gamma", format!("{sbp} has {nodes} nodes, got n_gamma = {n_gamma}"), Some(help)));
        }
        if n_gamma < sbp.minimum_points() {
            let message = format!("{sbp} needs at least {} points, got n_gamma = {n_gamma}", sbp.minimum_points());
            return Err(("grid.n_gamma", message, None));
        }
    }
    if n_gamma > MOST_POINTS {
        let message = format!("n_gamma = {n_gamma} is above the limit of {MOST_POINTS} points");
        return Err(("grid.n_gamma", message, None));
    }
    if n_gamma.saturating_mul(windows) > MOST_POINTS {
        let message = format!("{windows} windows of {n_gamma} points are above the limit of {MOST_POINTS}");
        return Err(("grid.windows", message, None));
    }
    Ok(())
}

/// Refuses nodes so close together, over a range of γ of this length, that rounding makes them equal, also when γ_i is
/// added to them.
pub(super) fn check_spacing(path: &'static str, gamma_i: f64, intervals: usize, length: f64) -> Result<(), Invalid> {
    let spacing = length / intervals as f64;
    let largest = gamma_i.abs().max((gamma_i + length).abs());
    if spacing.is_finite() && spacing >= f64::MIN_POSITIVE && spacing > 4.0 * f64::EPSILON * largest {
        return Ok(());
    }
    let message = format!("the spacing {spacing:e} is too small or too large to tell neighbouring nodes apart");
    Err((path, message, Some("shift gamma_i towards 0, or take fewer points or windows")))
}

/// The settings of the solver on another grid: with that operator and form and so many nodes in each window, on
/// γ ∈ [0, `length`], and without an accuracy. A spectral element gets as many windows as make about that number of
/// nodes in all.
///
/// # Errors
/// A message that says what is wrong with that grid.
pub fn on_grid<S: Real>(
    setup: &Setup<S>,
    (sbp, form): (SbpName, Form),
    n_gamma: usize,
    length: S,
) -> Result<Setup<S>, String> {
    let (n_gamma, windows) = match sbp.fixed_points() {
        Some(nodes) => (nodes, (n_gamma.saturating_sub(1) / (nodes - 1)).max(1)),
        None => (n_gamma, setup.settings.windows),
    };
    let intervals = n_gamma.max(2).saturating_sub(1).saturating_mul(windows);
    if !setup.regularised && form == Form::Weak {
        return Err("regularised = false is not possible with form = \"weak\"".to_owned());
    }
    check_nodes(Some(sbp), n_gamma, windows)
        .and_then(|()| check_spacing("grid.gamma_f", 0.0, intervals, length.to_f64()))
        .map_err(|(_, message, _)| message)?;
    Ok(Setup {
        gamma_i: S::ZERO,
        carried: None,
        limit: Limit::Length(length),
        until: Vec::new(),
        sides: Vec::new(),
        settings: Settings { sbp, form, n_gamma, windows, accuracy: None, ..setup.settings },
        ..setup.clone()
    })
}
