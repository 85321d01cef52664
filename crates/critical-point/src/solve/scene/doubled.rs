//! The critical point of the doubled action of a window in all its unknowns.

use super::failure;
use super::run::Piece;
use super::setup::SceneSetup;
use super::window::Window;
use crate::action::{Form, Layout};
use crate::geometry::{Geometry, OutsideGeometry};
use crate::scalar::Real;
use crate::solve::critical_point::CriticalPointSolver;
use crate::solve::failure::NoSolution;
use crate::solve::first_guess::{self, WindowFailure};
use crate::solve::status::{InitialGuess, Status};

/// The critical point of a window that starts at γ − γ_i = `gamma` and is `length` long.
pub(super) fn solve<S: Real>(
    window: &Window<'_, S, Geometry<S>>,
    rough: &Window<'_, f64, Geometry>,
    setup: &SceneSetup<S>,
    gamma: f64,
) -> Result<Piece<S>, NoSolution> {
    let guess = InitialGuess::WindowedAction;
    let (action, rough_action) = (window.action(), rough.action());
    let length = rough.sbp.node(rough.points() - 1);
    let start = first_guess::windowed_action(&rough_action, rough.geometry, length)
        .map_err(|failure| of_guess(rough, failure, gamma))?;
    let solver = CriticalPointSolver::new(&rough_action);
    let root = solver.solve(&rough_action, start, setup.settings.max_iterations).and_then(|root| {
        solver.refine(&action, &rough_action, root, (setup.settings.digits, setup.settings.max_iterations))
    });
    let layout = action.layout();
    let root = root.map_err(|failure| {
        let locate = |unknown: usize, u: &[f64]| on_forward_branch(rough, layout, unknown, u);
        failure::iterated(rough, failure, guess, |node| gamma + rough.sbp.node(node), locate)
    })?;
    let gradient_norm = action.gradient_norm(&root.unknowns);
    let rows = |branch| layout.branch(&root.unknowns, branch).into_iter().map(<[S]>::to_vec).collect::<Vec<_>>();
    let multipliers = layout.multipliers(&root.unknowns).to_vec();
    let q = rows(0);
    let last = window.points() - 1;
    // D̄ is D at the last node. The momentum there is p*_a = p_a + κ_a/H_N, and −ν_a where the coordinate is ignorable.
    let slopes: Vec<S> = q.iter().map(|row| window.sbp.derivative_at(row, last)).collect();
    let end: Vec<S> = q.iter().map(|row| row[last]).collect();
    let mut p = window.geometry.momenta_here(&end, &slopes);
    for (a, p) in p.iter_mut().enumerate() {
        match window.form {
            Form::Strong if window.geometry.active().contains(&a) => {
                *p += multipliers[layout.kappa(a)] / window.sbp.weights()[last];
            }
            Form::Strong => *p = -multipliers[layout.nu(a)],
            Form::Weak if window.geometry.active().contains(&a) => {}
            Form::Weak => *p = window.start.p[a],
        }
    }
    let backward = rows(1);
    let (initial_guess, history) = (guess, root.history);
    Ok(Piece { q, p: Vec::new(), end: p, backward, multipliers, gradient_norm, initial_guess, history })
}

/// A guess that failed, in terms of the scene.
fn of_guess(window: &Window<'_, f64, Geometry>, failed: WindowFailure<OutsideGeometry>, gamma: f64) -> NoSolution {
    let WindowFailure { failure, start, gamma: from, spacing } = failed;
    let mut failure = *failure;
    // A limit of iterations belonged to the short window alone; no setting of the user would help.
    failure.status = if failure.outside.is_some() { Status::OutsideDomain } else { Status::Stalled };
    let here = move |_: usize, _: &[f64]| (0, window.geometry.active().iter().map(|&a| start.q[a]).collect());
    let gamma = |node: usize| gamma + from + node as f64 * spacing;
    failure::iterated(window, failure, InitialGuess::WindowedAction, gamma, here)
}

/// Node of an unknown, and the active coordinates of the forward branch there.
fn on_forward_branch(
    window: &Window<'_, f64, Geometry>,
    layout: Layout,
    unknown: usize,
    u: &[f64],
) -> (usize, Vec<f64>) {
    let node = layout.node(unknown);
    (node, window.geometry.active().iter().map(|&a| layout.values(u, 0, a)[node]).collect())
}
