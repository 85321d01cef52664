//! Why there is no next window.

use super::State;
use crate::geometry::{Geometry, OutsideGeometry};
use crate::number::runge_kutta::runge_kutta;

/// Why there is no next window.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum Failure {
    /// A node is outside the domain.
    #[error("the motion leaves the domain")]
    OutsideDomain(OutsideGeometry),
    /// Sweeps do not converge.
    #[error("sweeps over a window do not converge")]
    NotConverged,
    /// No window is short enough for the accuracy.
    #[error("no window is short enough for the accuracy")]
    TooShort,
    /// Two marches differ by more than the accuracy: after [`Windows::begin_again`](super::Windows::begin_again) their
    /// tolerances are smaller.
    #[error("two marches differ by more than the accuracy: the run is to be begun again")]
    BeginAgain,
    /// A run to a value of a coordinate comes no nearer to it.
    #[error("the run comes no nearer to the value at which it is to end")]
    ValueNotReached,
    /// Two marches differ by more than the accuracy, however small their tolerances are.
    #[error("two marches differ by more than the accuracy, however small their tolerances are")]
    Accuracy,
}

/// Explicit steps along the way, and how many of them there may be where they are cut.
const STEPS: usize = 512;
const MOST_STEPS: usize = 4096;
/// A step is cut where two halves of it come to another place by more than this part of its way,
const APART: f64 = 1e-2;
/// and no more when it is shorter than this part of the first.
const SHORTEST: f64 = 1e-9;

/// Where the motion leaves the domain: γ, q^a, and the determinant that says so.
pub(super) type Edge = (f64, Vec<f64>, OutsideGeometry);

/// Follows the motion from a state at `gamma` over `length` by the classical Runge–Kutta method, and returns where it
/// leaves the domain. `momenta` are those of all coordinates at the start of the run.
///
/// Before a horizon windows become shorter and shorter, and rounding may end the run before it: the horizon is the
/// reason all the same.
pub(super) fn edge(geometry: &Geometry, state: &State, momenta: &[f64], length: f64, gamma: f64) -> Option<Edge> {
    let n = geometry.dimension();
    let mut now = [state.positions(), momenta.to_vec()].concat();
    geometry.active().iter().zip(state.momenta()).for_each(|(&a, p)| now[n + a] = p);
    let mut point = geometry.point();
    let first = length / STEPS as f64;
    let (mut h, mut done, mut whole, mut halves, mut failed) = (first, 0.0, now.clone(), now.clone(), now.clone());
    for _ in 0..MOST_STEPS {
        whole.copy_from_slice(&now);
        halves.copy_from_slice(&now);
        let mut slopes_at =
            |at: &[f64], out: &mut [f64]| point.slopes(at, out).inspect_err(|_| failed.copy_from_slice(at));
        let mut step = |state: &mut [f64], h| runge_kutta(state, h, &mut slopes_at);
        let ahead =
            step(&mut whole, h).and_then(|()| step(&mut halves, 0.5 * h)).and_then(|()| step(&mut halves, 0.5 * h));
        // Before a horizon the motion becomes ever faster, and a long step jumps over it.
        // An ignorable one steers nothing: in Schwarzschild's coordinates t has no limit there.
        let is_apart = |&a: &usize| (halves[a] - whole[a]).abs() > APART * (halves[a] - now[a]).abs();
        match ahead {
            Err(outside) if h <= SHORTEST * first => {
                failed.truncate(n);
                return Some((gamma + done, failed, outside));
            }
            Err(_) => h *= 0.5,
            Ok(()) if h > SHORTEST * first && geometry.active().iter().any(is_apart) => h *= 0.5,
            Ok(()) => {
                std::mem::swap(&mut now, &mut halves);
                done += h;
                if done >= length {
                    break;
                }
                h = (2.0 * h).min(first);
            }
        }
    }
    None
}
