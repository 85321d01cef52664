//! A doubtful result is computed once more with the other system, which starts from another guess. If they end at
//! different critical points, neither should be believed.

use geodesic_ivp::case::System;
use geodesic_ivp::diagnostics::verdict::Reason;
use geodesic_ivp::solve::Arithmetic;
use geodesic_ivp::{Case, Solution, solve};

/// With more nodes the doubled system takes too long for a mere check.
const MOST_NODES: usize = 5000;
/// The relative difference up to which both systems have ended at the same point. Then they agree to rounding, which
/// grows on long runs, to 6e-8 at most.
const SAME: f64 = 1e-6;

/// The warning, if the other system ends elsewhere. It is only asked for if there is another warning already.
pub(super) fn second_opinion<S: Arithmetic>(case: &Case, solution: &Solution<S>) -> Option<Reason> {
    let nodes = case.grid.n_gamma * case.grid.windows;
    if case.solver.accuracy.is_some() || !case.scheme.regularised || case.is_extended() || nodes > MOST_NODES {
        return None;
    }
    let mut other = case.clone();
    let name = match case.solver.system {
        System::PhysicalLimit => {
            other.solver.system = System::Doubled;
            "the doubled system"
        }
        System::Doubled => {
            other.solver.system = System::PhysicalLimit;
            "the physical limit"
        }
    };
    // If the other system finds no critical point, that does not speak against this one.
    let other = solve::<S, _>(&other).ok()?;
    let [t, x] = [solution.end_state().t, solution.end_state().x].map(S::to_f64);
    let [other_t, other_x] = [other.end_state().t, other.end_state().x].map(S::to_f64);
    let apart = |a: f64, b: f64, size: f64| (a - b).abs() > SAME * a.abs().max(b.abs()).max(size);
    // A run may end near x = 0: the size of x is that along the way.
    let amplitude = solution.x().iter().fold(0.0, |most: f64, x| most.max(x.to_f64().abs()));
    (apart(t, other_t, 0.0) || apart(x, other_x, amplitude)).then(|| {
        let finding = format!(
            "there are several critical points: {name}, from another guess, ends at t = {other_t:.6}, x = {other_x:.6} \
             and not at t = {t:.6}, x = {x:.6}, further apart than {SAME:e} of them"
        );
        Reason::new(finding, "raise n_gamma or windows until they agree")
    })
}
