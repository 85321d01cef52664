//! A suspect result is solved once more by the other system, which starts from another guess: where they end at different
//! critical points, neither is to be believed.

use geodesic_ivp::case::System;
use geodesic_ivp::scalar::Real;
use geodesic_ivp::{Case, Solution, solve};

/// The doubled system of more nodes takes longer than a warning is worth.
const MOST_NODES: usize = 5000;
/// Both systems agree to rounding where they end at the same point; rounding grows on long runs, to 6e-8 at most.
const SAME: f64 = 1e-6;

/// The warning, if the other system ends elsewhere. Asked only of a result that something else speaks against.
pub(super) fn second_opinion<S: Real>(case: &Case, solution: &Solution<S>) -> Option<String> {
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
    // That it finds none says nothing against the one that is there.
    let other = solve::<S>(&other).ok()?;
    let [t, x] = [solution.end.t, solution.end.x].map(S::to_f64);
    let [other_t, other_x] = [other.end.t, other.end.x].map(S::to_f64);
    let apart = |a: f64, b: f64| (a - b).abs() > SAME * a.abs().max(b.abs());
    (apart(t, other_t) || apart(x, other_x)).then(|| {
        format!(
            "there are several critical points: {name}, from another guess, ends at t = {other_t:.6}, x = {other_x:.6} \
             and not at t = {t:.6}, x = {x:.6}, further apart than {SAME:e} of them; raise n_gamma or windows until they agree"
        )
    })
}
