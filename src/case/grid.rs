//! The settings of a solver, on another grid.

use super::limits::{check_nodes, check_spacing};
use crate::action::Form;
use crate::number::Real;
use crate::sbp::SbpName;
use crate::solve::{Limit, Settings, Setup};

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
        .map_err(|invalid| invalid.message)?;
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
