//! The two-step rule that SBP21's collocation system is, and steps that are long enough to leap over what lies outside
//! the domain: a horizon and what is behind it. The nodes on both sides are inside, and say nothing.

use super::newton::Failure;
use super::piece::{Piece, Problem};
use super::status::InitialGuess;
use crate::geometry::{Geometry, Motion, OnNodes, OutsideGeometry, Rates};
use crate::number::Real;

/// A step is looked into if some coordinate changes by more than this multiple of its largest change so far.
const LONG: f64 = 2.0;
/// Most pieces that a step is divided into.
const MOST_PIECES: f64 = 1024.0;

/// SBP21: one Euler step, then u_{k+1} = u_{k−1} + 2h u̇_k for every coordinate and every momentum. One evaluation a
/// node; in 16 digits of active coordinates, as ignorable ones are sums, whose terms are computed on many nodes at a
/// time.
///
/// Exact charges say nothing about the rest here: the rule carries a computational (−1)^k mode, neutral only while
/// hω < 1.
pub(super) fn two_step<S: Real>(window: &Problem<'_, S>) -> Result<Piece<S>, Failure> {
    let (points, h, geometry) = (window.points(), window.sbp.spacing(), window.geometry);
    let active = geometry.active();
    let state = active.iter().map(|&a| window.start.q[a]).chain(active.iter().map(|&a| window.start.p[a]));
    let rates = &mut Rates::new(geometry, window.start);
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
        let mut motion = Motion::new(geometry);
        let known = left.as_ref().map_or(points, |(k, _)| *k);
        let on = OnNodes { q: &q, p: &p, start: &window.start.p };
        motion.rates(on, known, &mut []).map_err(Failure::outside)?;
        if left.is_none() {
            for (a, slopes) in geometry.ignorable().zip(&motion.ignorable) {
                (0..points).for_each(|k| step(&mut q[a], k, h, slopes[k]));
            }
        }
    }
    let left = left.map(|(index, point)| OutsideGeometry { index, ..point });
    let left = left.or_else(|| leap(geometry, &q)).map(Failure::outside);
    left.map_or_else(|| Ok(Piece::in_limit(window, [q, p], Vec::new(), InitialGuess::None)), Err)
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

/// The first point outside the domain within a long step, on the straight line from node to node, with the index of the
/// node behind it. `q` has a row for each coordinate. A step is divided into pieces as long as the longest one before.
pub(super) fn leap<S: Real>(geometry: &Geometry<S>, q: &[Vec<S>]) -> Option<OutsideGeometry> {
    let mut long: Vec<(usize, f64)> = geometry.active().iter().flat_map(|&a| long_steps(&q[a])).collect();
    long.sort_by_key(|&(k, _)| k);
    long.chunk_by(|(one, _), (other, _)| one == other).find_map(|steps| {
        let ratio = steps.iter().fold(0.0, |most, &(_, ratio)| f64::max(most, ratio));
        within(geometry, q, steps[0].0, ratio.ceil().min(MOST_PIECES) as usize)
    })
}

/// The steps of a coordinate that are much longer than the longest one before, with the ratio.
fn long_steps<S: Real>(row: &[S]) -> Vec<(usize, f64)> {
    let (mut longest, mut long) = (0.0_f64, Vec::new());
    for (k, pair) in row.windows(2).enumerate() {
        let change = (pair[1] - pair[0]).abs().to_f64();
        if change > LONG * longest && longest > 0.0 {
            long.push((k + 1, change / longest));
        }
        longest = longest.max(change);
    }
    long
}

/// The first point outside the domain between nodes k − 1 and k, among those that divide the step into equal pieces.
fn within<S: Real>(geometry: &Geometry<S>, q: &[Vec<S>], k: usize, pieces: usize) -> Option<OutsideGeometry> {
    let share = |piece: usize| S::from(piece as f64 / pieces as f64);
    let inside = |row: &Vec<S>| (1..pieces).map(|piece| row[k - 1] + share(piece) * (row[k] - row[k - 1])).collect();
    let points: Vec<Vec<S>> = q.iter().map(inside).collect();
    let rows: Vec<&[S]> = points.iter().map(Vec::as_slice).collect();
    let outside = geometry.fill(&rows, &mut geometry.room(pieces - 1)).err()?;
    Some(OutsideGeometry { index: k, ..outside })
}
