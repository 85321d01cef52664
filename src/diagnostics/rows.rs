//! Operations on a row of values on the nodes of a run, window by window, whatever the number of coordinates.

use std::ops::Range;

use crate::number::Real;
use crate::number::norm::max_abs;
use crate::solve::WindowGrid;

/// d/dγ of a row as the form of the action means it; `starts` are its initial values in the windows.
pub(super) fn derivative<'g, S: Real + 'g>(
    grids: impl Iterator<Item = WindowGrid<'g, S>>,
    row: &[S],
    starts: impl Iterator<Item = S>,
) -> Vec<S> {
    let mut slopes = vec![S::ZERO; row.len()];
    for (grid, start) in grids.zip(starts) {
        grid.derivative(&row[grid.nodes()], start, &mut slopes[grid.nodes()]);
    }
    slopes
}

/// The deviation of a charge with the multipliers' share κ/H_N at the last node of each window that has multipliers.
/// `shares` are the κ.
pub(super) fn corrected<'g, S: Real + 'g>(
    grids: impl Iterator<Item = WindowGrid<'g, S>>,
    delta: &[S],
    shares: impl Iterator<Item = Option<S>>,
) -> Vec<S> {
    let mut corrected = delta.to_vec();
    for (grid, share) in grids.zip(shares) {
        if let Some(share) = share {
            corrected[grid.nodes().end - 1] += share / grid.sbp().weights()[grid.points() - 1];
        }
    }
    corrected
}

/// A row of Dq in which the last node of each window has its value of `ends`: in the strong form D takes up its defect
/// there, and dq/dγ is what the next window starts with.
pub(super) fn handed_on<'g, S: Real + 'g>(
    grids: impl Iterator<Item = WindowGrid<'g, S>>,
    mut row: Vec<S>,
    ends: impl Iterator<Item = S>,
) -> Vec<S> {
    grids.zip(ends).for_each(|(grid, end)| row[grid.nodes().end - 1] = end);
    row
}

/// The largest absolute value over these parts of a row; NaN if any value there is.
pub(super) fn largest<S: Real>(row: &[S], parts: impl Iterator<Item = Range<usize>>) -> S {
    parts.fold(S::ZERO, |largest, part| max_abs(&[largest, max_abs(&row[part])]))
}
