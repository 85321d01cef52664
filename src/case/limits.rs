//! Limits of numbers of nodes and of spacings, for cases and for studies on other grids.

use super::reader::Field;
use super::{CaseError, SbpName};
use crate::action::Form;
use crate::engine::Handed;
use crate::number::Real;
use crate::solve::{Limit, Settings, Setup};

/// More nodes than this would exhaust the memory.
const MOST_POINTS: usize = 100_000_000;

/// A value that is not acceptable: its key in `[grid]`, why, and what to do.
pub(super) struct Invalid(&'static str, String, Option<&'static str>);

impl Invalid {
    /// The same with its place.
    pub(super) fn error(self, grid: &Field<'_>) -> CaseError {
        let Self(key, message, help) = self;
        grid.at(key).error(message).with_hint(help.map(str::to_owned))
    }
}

/// Refuses numbers of nodes that do not fit the operator or the memory.
pub(super) fn check_nodes(sbp: SbpName, n_gamma: usize, windows: usize) -> Result<(), Invalid> {
    let (mut key, mut help) = ("n_gamma", None);
    let message = if let Some(nodes) = sbp.fixed_points().filter(|&nodes| nodes != n_gamma) {
        help = Some("leave n_gamma out, or choose the spectral element of that many nodes");
        format!("{sbp} has {nodes} nodes, got n_gamma = {n_gamma}")
    } else if n_gamma < sbp.minimum_points() {
        format!("{sbp} needs at least {} points, got n_gamma = {n_gamma}", sbp.minimum_points())
    } else if n_gamma > MOST_POINTS {
        format!("n_gamma = {n_gamma} is above the limit of {MOST_POINTS} points")
    } else if n_gamma.saturating_mul(windows) > MOST_POINTS {
        key = "windows";
        format!("{windows} windows of {n_gamma} points are above the limit of {MOST_POINTS}")
    } else {
        return Ok(());
    };
    Err(Invalid(key, message, help))
}

/// Refuses nodes so close together, over a range of γ of this length, that rounding makes them equal, also when γ_i is
/// added to them.
pub(super) fn check_spacing(key: &'static str, gamma_i: f64, intervals: usize, length: f64) -> Result<(), Invalid> {
    let spacing = length / intervals as f64;
    let largest = gamma_i.abs().max((gamma_i + length).abs());
    if spacing.is_finite() && spacing >= f64::MIN_POSITIVE && spacing > 4.0 * f64::EPSILON * largest {
        return Ok(());
    }
    let message = format!("the spacing {spacing:e} is too small or too large to tell neighbouring nodes apart");
    Err(Invalid(key, message, Some("shift gamma_i towards 0, or take fewer points or windows")))
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
    if !setup.settings.regularised && form == Form::Weak {
        return Err("regularised = false is not possible with form = \"weak\"".to_owned());
    }
    check_nodes(sbp, n_gamma, windows)
        .and_then(|()| check_spacing("gamma_f", 0.0, intervals, length.to_f64()))
        .map_err(|Invalid(_, message, _)| message)?;
    Ok(Setup {
        gamma_i: S::ZERO,
        carried: None,
        dropped: Handed::default(),
        limit: Limit::Length(length),
        until: Vec::new(),
        sides: Vec::new(),
        settings: Settings { sbp, form, n_gamma, windows, accuracy: None, ..setup.settings },
        ..setup.clone()
    })
}
