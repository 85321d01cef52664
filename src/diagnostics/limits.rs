//! The values at the first nodes of windows that begin where something jumps: the limits from inside.
//!
//! On the very surface a sign or a step is neither what it is before nor what it is behind, and the equations of a
//! window hold on the side that it goes to.

use crate::geometry::Samples;
use crate::number::Real;
use crate::solve::{Window, WorldLine};

/// The limit is looked for at this part of the first gap, or further by so many roundings of a number,
const NEAR: f64 = 1e-12;
const PLACE: f64 = 4.0;
/// and something jumps if it changes there by more than this part of what it is: what is smooth changes by `NEAR`.
const JUMPS: f64 = 1e-6;

/// Takes the limits in the place of the values at first nodes, where `rows` are what they are functions `of`.
pub(super) fn take_limits<S: Real>(
    run: &WorldLine<S>,
    rows: &[&[S]],
    samples: &mut Samples<S>,
    of: impl FnOnce(&[&[S]]) -> Samples<S>,
) {
    if !run.geometry().has_jumps() {
        return;
    }
    let firsts: Vec<usize> =
        run.windows.iter().map(Window::nodes).filter(|nodes| nodes.len() > 1).map(|n| n.start).collect();
    let near = |row: &&[S]| {
        let inside = |&k: &usize| {
            let gap = row[k + 1] - row[k];
            let by = (S::from(NEAR) * gap.abs()).max(S::from(PLACE) * S::EPSILON * row[k].abs());
            row[k] + if by < gap.abs() { by * gap.signum() } else { gap }
        };
        firsts.iter().map(inside).collect()
    };
    let beside: Vec<Vec<S>> = rows.iter().map(near).collect();
    let mut limits = of(&beside.iter().map(Vec::as_slice).collect::<Vec<_>>());
    for (row, limits) in samples.rows_mut().zip(limits.rows_mut()) {
        for (&k, limit) in firsts.iter().zip(limits) {
            let size = row[k].abs().max(row[k + 1].abs()).max(limit.abs());
            if (*limit - row[k]).abs() > S::from(JUMPS) * size {
                row[k] = *limit;
            }
        }
    }
}
