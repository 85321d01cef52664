//! From a valid setup to a critical point of its doubled action, or to the reason why there is none.

mod accuracy;
mod arithmetic;
mod critical_point;
mod derivative;
mod end_time;
mod extremal;
mod failure;
mod first_guess;
mod memory;
mod newton;
mod operator;
mod problem;
mod quadrature;
mod refinement;
mod run;
pub mod scene;
mod search;
mod setup;
mod solution;
mod spectral;
mod status;
mod trajectory;

pub use arithmetic::Arithmetic;
pub(crate) use extremal::Extremal;
pub use failure::{Domain, NoSolution};
pub use memory::{bytes_needed, scene_bytes_needed};
#[doc(hidden)]
pub use operator::WindowGrid;
pub use setup::{End, Scene, Settings, Setup, System};
pub(crate) use solution::WindowNodes;
pub use solution::{Backward, EndState, Joint, Solution, Window};
pub use status::{InitialGuess, IterationRecord, Iterations, Status};
pub use trajectory::Trajectory;

use self::critical_point::CriticalPointSolver;
use self::failure::At;
use self::newton::Failure;
use self::problem::Problem;
use self::run::{Observer, Piece, Place, Run};
use self::scene::limit::{self, Limit};
use crate::action::{Form, Layout, MULTIPLIERS};
use crate::metric::OutsideDomain;
use crate::sbp::SbpName;
use crate::scalar::Compensated;

/// Below this share of its first value, g00 is on its way to a horizon.
const HORIZON: f64 = 1e-2;

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

fn solve_seen<S: Arithmetic>(setup: &Setup<S>, observer: Option<Observer<'_, S>>) -> Result<Solution<S>, NoSolution> {
    if let Some(accuracy) = setup.settings.accuracy {
        return S::run_to_accuracy(setup, accuracy, observer);
    }
    match setup.scene.end {
        End::Duration(duration) => end_time::solve(setup, duration, observer),
        End::Length(length) => solve_to(setup, length, observer),
    }
}

/// Solves a case on γ − γ_i ∈ [0, `length`], window after window.
fn solve_to<S: Arithmetic>(
    setup: &Setup<S>,
    length: S,
    mut observer: Option<Observer<'_, S>>,
) -> Result<Solution<S>, NoSolution> {
    let windows = setup.settings.windows;
    let weak = setup.settings.form == Form::Weak && setup.settings.system == System::PhysicalLimit;
    if weak && matches!(setup.settings.sbp, SbpName::Gll(_)) {
        let observer = observer.as_mut().map(|observer| &mut **observer as Observer<'_, S>);
        if let Some(solution) = S::fast_run(setup, length, observer)? {
            return Ok(solution);
        }
    }
    let problem = Problem::new(setup, length / S::from(windows as f64));
    let nodes = if observer.is_some() { 1 } else { windows } * problem.sbp.points();
    let mut run = Run::new(&setup.scene, (problem.form, problem.sbp_name), problem.digits, nodes, observer);
    run.solution.length = length;
    each_window(problem, setup, length, run)
}

/// Every window by Newton's method or an explicit recursion, from where the one before ends.
fn each_window<S: Arithmetic>(
    mut problem: Problem<S>,
    setup: &Setup<S>,
    length: S,
    mut run: Run<'_, S>,
) -> Result<Solution<S>, NoSolution> {
    let (gamma_i, windows) = (problem.gamma_i, setup.settings.windows);
    // The time is summed so that nothing is lost over a million windows.
    let mut time = Compensated::default();
    for window in 0..windows {
        let gamma = S::from(window as f64) * problem.length;
        if window > 0 {
            problem.continue_from(gamma_i + gamma, run.solution.end.x, run.solution.end.x_dot);
        }
        let piece = match setup.settings.system {
            System::PhysicalLimit => solve_physical_limit(&problem, setup),
            System::Doubled => solve_doubled(&problem, setup),
        }?;
        let start: Compensated<S> = time;
        time = time.plus(piece.elapsed.last().copied().unwrap_or(S::ZERO));
        let end = if window + 1 == windows { length } else { S::from((window + 1) as f64) * problem.length };
        run.append(&problem, Place { gamma: [gamma, end], time: [start.high, time.high] }, piece)?;
    }
    Ok(run.solution)
}

fn solve_physical_limit<S: Arithmetic>(problem: &Problem<S>, setup: &Setup<S>) -> Result<Piece<S>, NoSolution> {
    let rough = S::rough_problem(problem, setup);
    let (start, rough_start) = (problem.start(), rough.start());
    let (window, rough_window) = (problem.window(&start), rough.window(&rough_start));
    let limit = limit::solve(&window, &rough_window, setup.settings.max_iterations).map_err(|failure| {
        let first = rough.derivative().first_unknown();
        let is_explicit = problem.form == Form::Strong && problem.sbp.is_two_step();
        let guess = if is_explicit { InitialGuess::None } else { InitialGuess::Nystrom4 };
        // Two rows and two unknowns a node: rows start at node 1, unknowns (strong) at node 2.
        let locate = |row: usize, u: &[f64]| {
            let node = row / 2;
            (node, node.checked_sub(first).map_or(rough.initial.x, |unknown| u[2 * unknown]))
        };
        no_solution(&rough, failure, guess, |node| rough.gamma(node), locate)
    })?;
    let multipliers: Option<[S; MULTIPLIERS]> = limit.multipliers(&window).try_into().ok();
    let lambda = multipliers.as_ref().map_or([].as_slice(), |lambda| lambda);
    let unknowns = problem.layout().physical_limit(&[&limit.q[0], &limit.q[1]], lambda);
    let gradient_norm = problem.action().gradient_norm(&unknowns);
    let last = problem.sbp.points() - 1;
    let Limit { mut q, p, history, initial_guess } = limit;
    // p_x = −dx/dγ.
    let end = [q[1][last], -p[0][last]];
    let (x, elapsed) = (q.remove(1), q.remove(0));
    let q_t = problem.invariants().q_t;
    Ok(Piece { end, q_t, elapsed, x, backward: None, multipliers, gradient_norm, initial_guess, history })
}

fn solve_doubled<S: Arithmetic>(problem: &Problem<S>, setup: &Setup<S>) -> Result<Piece<S>, NoSolution> {
    let guess = InitialGuess::WindowedAction;
    let rough = S::rough_problem(problem, setup);
    // The guess is one for the regularised action, whichever is solved.
    let guess_action = rough.action();
    let start = first_guess::windowed_action(&guess_action, &*rough.metric, rough.length).map_err(|window| {
        // The window is a short grid of its own: γ counts from its start.
        let mut failure = *window.failure;
        // However short the window, Newton's method does not get across a horizon: there it meets points outside, or
        // the particle has come so close that nothing smooth is left.
        let x = window.start.q[1];
        let (here, there) = (rough.metric.at(x), rough.metric.at(rough.initial.x));
        if failure.outside.is_some() || here.g00 < HORIZON * there.g00 {
            failure.status = Status::OutsideDomain;
            failure.outside.get_or_insert(OutsideDomain { index: 0, x, g00: here.g00 });
        } else {
            // A limit of iterations belonged to the window alone; no setting of the user would help.
            failure.status = Status::Stalled;
        }
        let layout = Layout::new(2, (failure.unknowns.len() - MULTIPLIERS) / 4, Form::Strong);
        let gamma = |node: usize| rough.gamma_i + window.gamma + node as f64 * window.spacing;
        no_solution(&rough, failure, guess, gamma, |unknown, u| on_forward_branch(layout, unknown, u))
    })?;
    let layout = problem.layout();
    let (action, rough_action) = (problem.action_of(setup.regularised), rough.action_of(setup.regularised));
    let solver = CriticalPointSolver::new(&rough_action);
    let root = solver.solve(&rough_action, start, setup.settings.max_iterations).and_then(|root| {
        solver.refine(&action, &rough_action, root, (setup.settings.digits, setup.settings.max_iterations))
    });
    let root = root.map_err(|failure| {
        let locate = |unknown: usize, u: &[f64]| on_forward_branch(layout, unknown, u);
        no_solution(&rough, failure, guess, |node| rough.gamma(node), locate)
    })?;
    let gradient_norm = action.gradient_norm(&root.unknowns);
    let of = |branch, a| layout.values(&root.unknowns, branch, a);
    let [t, x] = [0, 1].map(|a| of(0, a));
    let multipliers: Option<[S; MULTIPLIERS]> = layout.multipliers(&root.unknowns).try_into().ok();
    let last = problem.sbp.points() - 1;
    // D̄ is D at the last node.
    let x_dot = problem.sbp.derivative_at(x, last);
    let (x_dot, q_t) = match &multipliers {
        Some(lambda) => (x_dot - lambda[7] / problem.sbp.weights()[last], -lambda[4]),
        None => (x_dot, problem.invariants().q_t),
    };
    Ok(Piece {
        end: [x[last], x_dot],
        q_t,
        elapsed: t.to_vec(),
        x: x.to_vec(),
        backward: Some(Backward { elapsed: of(1, 0).to_vec(), x: of(1, 1).to_vec() }),
        multipliers,
        gradient_norm,
        initial_guess: guess,
        history: root.history,
    })
}

/// Node of an unknown of the doubled action, and x of the forward branch there.
fn on_forward_branch(layout: Layout, unknown: usize, u: &[f64]) -> (usize, f64) {
    let node = layout.node(unknown);
    (node, layout.values(u, 0, 1)[node])
}

/// Expresses a failed iteration in terms of the case: `gamma` is γ of a node, and `locate` maps an index of the
/// residual, at the last iterate, to its node and x.
fn no_solution(
    problem: &Problem,
    failure: Failure,
    initial_guess: InitialGuess,
    gamma: impl Fn(usize) -> f64,
    locate: impl Fn(usize, &[f64]) -> (usize, f64),
) -> NoSolution {
    NoSolution::iterated(failure, initial_guess, |outside, worst, unknowns| {
        let (index, x) = match outside {
            Some(point) => (point.index, point.x),
            None => worst.map_or((0, problem.initial.x), |index| locate(index, unknowns)),
        };
        let g00 = outside.map_or_else(|| problem.metric.g00(x), |point| point.g00);
        At::x(gamma(index), x, g00)
    })
}
