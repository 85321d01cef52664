//! From a valid setup to a critical point of its doubled action, or to the reason why there is none.
//!
//! [`solve_in_parts`] keeps the memory of a few windows, however long the run. Measures of parts can be joined:
//!
//! ```
//! use geodesic_ivp::case::builtin;
//! use geodesic_ivp::diagnostics::Diagnostics;
//! use geodesic_ivp::solve::solve_in_parts;
//! use geodesic_ivp::{Case, Solution};
//!
//! let case = Case::parse("windows", builtin::text("quartic-windows").expect("it is built in"), &[])?;
//! let mut measures: Option<Diagnostics> = None;
//! let last = solve_in_parts(&case, &mut |window: &Solution| {
//!     let here = Diagnostics::new(window);
//!     measures = Some(match measures.take() {
//!         Some(before) => before.followed_by(here),
//!         None => here,
//!     });
//! })?;
//! assert_eq!(last.window_count, 200);
//! assert!(measures.expect("there are windows").norm.max_ends < 1e-13);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! The reason of a failure has its place and an advice, and prints as a sentence.

mod acting;
mod advice;
mod beginning;
mod collocation;
mod continuation;
mod critical_point;
mod end;
mod explicit;
mod failure;
mod grid;
mod guess;
mod newton;
mod pair;
mod piece;
mod run;
mod seen;
mod setup;
mod signs;
mod status;
mod sweeps;
mod world_line;

pub use acting::{Change, Quantity};
pub(crate) use beginning::{At, Beginning, OfState, Slack, noise, rounding};
pub use continuation::{Carried, Continuation, Off};
pub(crate) use failure::Unfinished;
pub use failure::{Domain, LastEvent, Lossy, Narrow, NoSolution, Reasons};
pub use grid::Window;
pub(crate) use seen::Seen;
pub use setup::{Limit, Settings, Setup, System, Until, bytes_needed};
pub(crate) use signs::{Along, Search, Sign, Wanted};
pub(crate) use status::MOST_EVENTS;
pub use status::{InitialGuess, IterationRecord, Iterations, Status};
pub use world_line::{EndState, Joint, Place, Solution, WindowNodes, WorldLine};

use self::run::{Observer, Run};
use crate::number::Real;

/// Solves a setup, which a case makes, in the arithmetic of `S`: `f64`, or [`Extended`](crate::number::Extended) to the
/// digits that it asks for (`Case::is_extended` says which of the two a case wants). More digits are obtained by
/// refinement: everything that searches and steers is done in `f64`.
///
/// The physical limit costs O(N) time and memory, one potential evaluation a node for SBP21. The doubled system is
/// solved by Newton's method with a sparse LU, in time linear in N in practice.
///
/// With [`Settings::accuracy`] the program chooses operator and windows itself, see [`WorldLine::error_estimate`].
///
/// A run with events that act ends at the first of them; [`crate::study::acting`] goes on from there.
///
/// # Errors
/// [`NoSolution`] says how the solve ended, where, and with what residual. An unconverged trajectory is never returned.
///
/// # Panics
/// If the setup is not valid, which one of a valid case is.
pub fn solve<S: Real>(setup: impl Into<Setup<S>>) -> Result<WorldLine<S>, NoSolution> {
    solve_observed(&setup.into(), None, None).map_err(|unfinished| unfinished.failure)
}

/// [`solve`] in the memory of a few windows: `observe` sees part after part as a solution of its own, at its place in
/// the run (its γ, t and constants of motion are those of the run), and what is returned is the last one with the
/// certificate and the iterations of all.
///
/// A run may have to begin again, when another method takes over or more accuracy is needed: `observe` then sees the
/// first window again, in a part whose `window_count` is that of its windows, and everything before it is void.
///
/// # Errors
/// As [`solve`]; the windows seen so far are those before the one that failed.
///
/// # Panics
/// As [`solve`].
pub fn solve_in_parts<S: Real>(
    setup: impl Into<Setup<S>>,
    observe: &mut dyn FnMut(&Solution<S>),
) -> Result<Solution<S>, NoSolution> {
    solve_observed(&setup.into(), Some(observe), None).map_err(|unfinished| unfinished.failure)
}

/// The solve behind both, part by part if there is an observer. `of_judge` sees the windows of the march that
/// judges the run, if there is one.
///
/// # Errors
/// [`Unfinished`], with the windows before the one that failed.
pub(crate) fn solve_observed<S: Real>(
    setup: &Setup<S>,
    observer: Option<Observer<'_, S>>,
    of_judge: Option<Observer<'_, S>>,
) -> Result<WorldLine<S>, Box<Unfinished<S>>> {
    if let Some(accuracy) = setup.settings.accuracy {
        return sweeps::to_accuracy(setup, accuracy, observer, of_judge);
    }
    if let (Limit::Length(length), true) = (setup.limit, setup.until.is_empty()) {
        return solve_to(setup, length, observer);
    }
    let Some(observer) = observer else { return end::solve(setup, true) };
    // The search keeps no more than a few windows, and the run that was found is repeated once.
    let WorldLine { ended_by, ended_at, length, .. } = end::solve(setup, false)?;
    Ok(WorldLine { ended_by, ended_at, ..solve_to(setup, length, Some(observer))? })
}

/// Solves a setup on γ − γ_i ∈ [0, `length`], window after window.
fn solve_to<S: Real>(
    setup: &Setup<S>,
    length: S,
    mut observer: Option<Observer<'_, S>>,
) -> Result<WorldLine<S>, Box<Unfinished<S>>> {
    let again = observer.as_mut().map(|observer| &mut **observer as Observer<'_, S>);
    match sweeps::equal(setup, length, again) {
        Some(line) => Ok(line),
        None => Run::new(setup, &setup.settings, observer).solve(setup, length),
    }
}
