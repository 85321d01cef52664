//! Limits of digits, numbers of nodes and spacings.

use super::SbpName;

/// More nodes than this would exhaust the memory.
const MOST_POINTS: usize = 100_000_000;

/// A value that is not acceptable.
pub(super) struct Invalid {
    /// Dotted key.
    pub(super) path: String,
    pub(super) message: String,
    pub(super) help: Option<String>,
}

fn invalid(path: &str, message: impl Into<String>) -> Invalid {
    Invalid { path: path.to_owned(), message: message.into(), help: None }
}

impl Invalid {
    fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }
}

/// Messages on an accuracy or a tolerance.
pub(super) const ACCURACY_AND_TOLERANCE: &str = "both solver.accuracy and solver.tolerance are given";
pub(super) const ONE_OF_THEM: &str =
    "keep accuracy for an error of the whole run, or tolerance for a run that goes on whatever errors grow to";
pub(super) const CHOSEN_WINDOWS: &str =
    "the program chooses operator and windows itself: leave n_gamma and windows out";
pub(super) const IN_F64: &str = "windows are chosen in double precision; for more digits give scheme and grid";
pub(super) const SENSITIVITY: &str = "solver.sensitivity needs solver.accuracy or solver.tolerance";
pub(super) const CARRIED_ON_WINDOWS: &str =
    "small changes are carried on windows that the program chooses: give solver.tolerance in place of scheme and grid";

/// Refuses numbers of nodes that do not fit the operator (if it is given) or the memory.
pub(super) fn check_nodes(sbp: Option<SbpName>, n_gamma: usize, windows: usize) -> Result<(), Invalid> {
    if let Some(sbp) = sbp {
        if let Some(nodes) = sbp.fixed_points().filter(|&nodes| nodes != n_gamma) {
            let message = format!("{sbp} has {nodes} nodes, got n_gamma = {n_gamma}");
            return Err(invalid("grid.n_gamma", message)
                .help("leave n_gamma out, or choose the spectral element of that many nodes"));
        }
        if n_gamma < sbp.minimum_points() {
            let message = format!("{sbp} needs at least {} points, got n_gamma = {n_gamma}", sbp.minimum_points());
            return Err(invalid("grid.n_gamma", message));
        }
    }
    if n_gamma > MOST_POINTS {
        let message = format!("n_gamma = {n_gamma} is above the limit of {MOST_POINTS} points");
        return Err(invalid("grid.n_gamma", message));
    }
    if n_gamma.saturating_mul(windows) > MOST_POINTS {
        let message = format!("{windows} windows of {n_gamma} points are above the limit of {MOST_POINTS}");
        return Err(invalid("grid.windows", message));
    }
    Ok(())
}

/// Refuses nodes so close together, over a range of γ of this length, that rounding makes them equal, also when γ_i is
/// added to them.
pub(super) fn check_spacing(path: &str, gamma_i: f64, intervals: usize, length: f64) -> Result<(), Invalid> {
    let spacing = length / intervals as f64;
    let largest = gamma_i.abs().max((gamma_i + length).abs());
    if spacing.is_finite() && spacing >= f64::MIN_POSITIVE && spacing > 4.0 * f64::EPSILON * largest {
        return Ok(());
    }
    let message = format!("the spacing {spacing:e} is too small or too large to tell neighbouring nodes apart");
    Err(invalid(path, message).help("shift gamma_i towards 0, or take fewer points or windows"))
}
