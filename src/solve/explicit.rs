//! The two-step rule that SBP21's collocation system is.

use super::limit::Limit;
use super::newton::Failure;
use super::status::{InitialGuess, Status};
use super::window::Window;
use crate::geometry::OutsideGeometry;
use crate::number::Real;

/// A recursion that ended at a point outside the domain.
pub(super) fn outside<O>(point: O) -> Failure<O> {
    Failure { outside: Some(point), ..Failure::without_iterate(Status::OutsideDomain) }
}

/// The same point, said to be at a node.
fn at_node(point: OutsideGeometry, index: usize) -> OutsideGeometry {
    OutsideGeometry { index, ..point }
}

/// SBP21: one Euler step, then u_{k+1} = u_{k−1} + 2h u̇_k for every coordinate and every momentum. One evaluation a
/// node.
///
/// Exact charges say nothing about the rest here: the rule carries a computational (−1)^k mode, neutral only while
/// hω < 1.
pub(super) fn two_step<S: Real>(window: &Window<'_, S>) -> Result<Limit<S>, Failure> {
    let (points, h, geometry) = (window.points(), window.sbp.spacing(), window.geometry);
    let active = geometry.active();
    let mut q: Vec<Vec<S>> = window.start.q.iter().map(|&q| vec![q; points]).collect();
    let mut p: Vec<Vec<S>> = active.iter().map(|&a| vec![window.start.p[a]; points]).collect();
    let (mut here, mut momenta) = (window.start.q.clone(), window.start.p.clone());
    let mut point = geometry.point();
    for k in 0..points {
        for (place, &a) in active.iter().enumerate() {
            (here[a], momenta[a]) = (q[a][k], p[place][k]);
        }
        point.evaluate(&here, &momenta).map_err(|found| outside(at_node(found, k)))?;
        if k + 1 == points {
            break;
        }
        let (from, step) = if k == 0 { (0, h) } else { (k - 1, h + h) };
        for (a, q) in q.iter_mut().enumerate() {
            q[k + 1] = q[from] + step * point.q_dot(a);
        }
        for (place, p) in p.iter_mut().enumerate() {
            p[k + 1] = p[from] + step * point.p_dot(place);
        }
    }
    Ok(Limit { q, p, history: Vec::new(), initial_guess: InitialGuess::None })
}
