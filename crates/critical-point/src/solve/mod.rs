//! From a valid setup to a critical point of its doubled action, or to the reason why there is none.

mod accuracy;
mod arithmetic;
mod collocation;
mod critical_point;
mod derivative;
mod end;
mod explicit;
mod extremal;
mod failure;
mod first_guess;
mod leap;
mod limit;
mod memory;
mod newton;
mod operator;
mod piece;
mod places;
mod quadrature;
mod refinement;
mod run;
pub mod scene;
mod search;
mod setup;
mod solution;
mod space;
mod spectral;
mod status;
mod window;
mod world_line;

pub use arithmetic::Arithmetic;
pub use failure::{Domain, NoSolution};
pub use memory::{bytes_needed, scene_bytes_needed};
#[doc(hidden)]
pub use operator::WindowGrid;
pub use setup::{End, Scene, Settings, Setup, System};
pub use solution::{EndState, Solution};
pub use space::Space;
pub use status::{InitialGuess, IterationRecord, Iterations, Status};
pub use world_line::{Joint, Window, WindowNodes};

use self::end::Target;
use self::run::Observer;
use crate::action::Form;
use crate::metric::Metric;
use crate::sbp::SbpName;

/// Solves a setup, which a `Case` makes, in the arithmetic of `S`: `f64`, or
/// [`Extended`](crate::scalar::Extended) to the digits that it asks for
/// (`Case::is_extended` says which of the two a case wants). More digits are obtained by
/// refinement: everything that searches and steers is done in `f64`.
///
/// The physical limit costs O(N) time and memory, one potential evaluation a node for SBP21. The doubled system is
/// solved by Newton's method with a sparse LU, in time linear in N in practice.
///
/// With [`Settings::accuracy`] the program chooses operator and windows itself, see [`Solution::error_estimate`].
///
/// # Errors
/// [`NoSolution`] says how the solve ended, where, and with what residual. An unconverged trajectory is never returned.
///
/// # Panics
/// If the setup is not valid, which one of a valid case is, or if it asks for an accuracy and `S` is not `f64`.
pub fn solve<S: Arithmetic>(setup: impl Into<Setup<S>>) -> Result<Solution<S>, NoSolution> {
    S::run(&setup.into(), None)
}

/// [`solve`] in the memory of one window: `observe` sees every window as a solution of its own, at its place in the run
/// (its γ, t and constants of motion are those of the run), and what is returned is the last one with the certificate
/// and the iterations of all.
///
/// A run may have to begin again, when another method takes over or more accuracy is needed: `observe` then sees a
/// window with `window_count` 1 again, and everything before it is void.
///
/// # Errors
/// As [`solve`]; the windows seen so far are those before the one that failed.
///
/// # Panics
/// As [`solve`].
pub fn solve_window_by_window<S: Arithmetic>(
    setup: impl Into<Setup<S>>,
    observe: &mut dyn FnMut(&Solution<S>),
) -> Result<Solution<S>, NoSolution> {
    S::run(&setup.into(), Some(observe))
}

fn solve_seen<S: Arithmetic>(
    setup: &Setup<S>,
    observer: Option<Observer<'_, S, Metric<S>>>,
) -> Result<Solution<S>, NoSolution> {
    if let Some(accuracy) = setup.settings.accuracy {
        return S::run_to_accuracy(setup, accuracy, observer);
    }
    match setup.scene.end {
        End::Duration(duration) => solve_to_time(setup, duration, observer),
        End::Length(length) => solve_to(setup, length, observer),
    }
}

/// Solves a case until t − t_i is `duration`.
///
/// Where the windows are observed, the search keeps no more than one, and the run that was found is repeated once.
fn solve_to_time<S: Arithmetic>(
    setup: &Setup<S>,
    duration: S,
    observer: Option<Observer<'_, S, Metric<S>>>,
) -> Result<Solution<S>, NoSolution> {
    let digits_of_runs = setup.settings.digits;
    let target = Target { coordinate: 0, value: duration, digits_of_runs, is_of_way: true };
    let place = &setup.scene.place;
    // Most of the search is cheapest in f64.
    let guess = if S::IS_EXTENDED {
        S::from(solve_to_time::<f64>(&setup.in_f64(), duration.to_f64(), Some(&mut |_| ()))?.length)
    } else {
        target.guess(place)
    };
    let search = |solve_to: &mut dyn FnMut(S) -> Result<Solution<S>, NoSolution>| {
        target.search(place, setup.scene.gamma_i, guess, solve_to)
    };
    match observer {
        None => search(&mut |length| solve_to(setup, length, None)),
        Some(observer) => {
            let found = search(&mut |length| solve_to(setup, length, Some(&mut |_| ())))?;
            solve_to(setup, found.length, Some(observer))
        }
    }
}

/// Solves a case on γ − γ_i ∈ [0, `length`], window after window.
fn solve_to<S: Arithmetic>(
    setup: &Setup<S>,
    length: S,
    mut observer: Option<Observer<'_, S, Metric<S>>>,
) -> Result<Solution<S>, NoSolution> {
    let weak = setup.settings.form == Form::Weak && setup.settings.system == System::PhysicalLimit;
    if weak && matches!(setup.settings.sbp, SbpName::Gll(_)) {
        let observer = observer.as_mut().map(|observer| &mut **observer as Observer<'_, S, Metric<S>>);
        if let Some(solution) = S::fast_run(setup, length, observer)? {
            return Ok(solution);
        }
    }
    let run = setup.scene.run(&setup.settings, observer);
    run.solve(&setup.settings, setup.rough.metric(), setup.regularised, length)
}
