//! The two-step rule that SBP21's collocation system is.

use super::limit::Limit;
use super::newton::Failure;
use super::status::{InitialGuess, Status};
use super::window::Window;
use crate::geometry::{OnNodes, OutsideGeometry};
use crate::number::Real;

/// A recursion that ended at a point outside the domain.
pub(super) fn outside<O>(point: O) -> Failure<O> {
    Failure { outside: Some(point), ..Failure::without_iterate(Status::OutsideDomain) }
}

/// SBP21: one Euler step, then u_{k+1} = u_{k−1} + 2h u̇_k for every coordinate and every momentum. One evaluation a
/// node; in 16 digits of active coordinates, as ignorable ones are sums, whose terms are computed on many nodes at a
/// time.
///
/// Exact charges say nothing about the rest here: the rule carries a computational (−1)^k mode, neutral only while
/// hω < 1.
pub(super) fn two_step<S: Real>(window: &Window<'_, S>) -> Result<Limit<S>, Failure> {
    let (points, h, geometry) = (window.points(), window.sbp.spacing(), window.geometry);
    let active = geometry.active();
    let state = active.iter().map(|&a| window.start.q[a]).chain(active.iter().map(|&a| window.start.p[a]));
    let rates = &mut geometry.rates(window.start);
    let others = geometry.ignorable().filter(|_| rates.has_ignorable()).map(|a| window.start.q[a]);
    let mut u: Vec<Vec<S>> = state.chain(others).map(|value| vec![value; points]).collect();
    let left = (0..points).find_map(|k| {
        u.iter().take(2 * active.len()).enumerate().for_each(|(place, row)| rates.set(place, row[k]));
        if let Err(point) = rates.evaluate() {
            return Some((k, point));
        }
        u.iter_mut().enumerate().for_each(|(place, row)| step(row, k, h, rates.get(place)));
        None
    });
    let others = u.split_off(2 * active.len());
    let p = u.split_off(active.len());
    let mut q: Vec<Vec<S>> = window.start.q.iter().map(|&q| vec![q; points]).collect();
    active.iter().copied().zip(u).chain(geometry.ignorable().zip(others)).for_each(|(a, row)| q[a] = row);
    if !rates.has_ignorable() {
        let mut motion = geometry.motion_on_nodes();
        let known = left.as_ref().map_or(points, |(k, _)| *k);
        let on = OnNodes { q: &q, p: &p, start: &window.start.p };
        let slopes = motion.ignorable_rates(on, known).map_err(outside)?;
        if left.is_none() {
            for (a, slopes) in geometry.ignorable().zip(slopes) {
                (0..points).for_each(|k| step(&mut q[a], k, h, slopes[k]));
            }
        }
    }
    match left {
        Some((index, point)) => Err(outside(OutsideGeometry { index, ..point })),
        None => Ok(Limit { q, p, history: Vec::new(), initial_guess: InitialGuess::None }),
    }
}

/// The value at node k + 1, if there is one, from the rate at node k.
#[inline]
fn step<S: Real>(row: &mut [S], k: usize, h: S, rate: S) {
    let (from, step) = if k == 0 { (0, h) } else { (k - 1, h + h) };
    let next = row[from] + step * rate;
    if let Some(value) = row.get_mut(k + 1) {
        *value = next;
    }
}
