//! The error of a run with events that act, by a second one.

use super::between::own_windows;
use super::compare::end_coordinate;
use super::{Judge, RunError};
use crate::engine::GOOD_DIGITS;
use crate::number::Real;
use crate::study::acting::Piece;
use crate::trajectory::Sampler;

/// Events with no more than this part of the way so far between them come at once.
const AT_ONCE: f64 = 1e-9;

/// The error of a chain of pieces; the largest one, relative to the size of its coordinate; and γ, from the start of
/// the last piece, until which each of [`GOOD_DIGITS`] is kept.
pub(crate) type ChainError = (RunError, f64, [f64; GOOD_DIGITS.len()]);

/// Compares the pieces of a run with those of a second one, at the same γ on the ends and in the middles of windows.
/// Errors are `margin` times the differences. `None` if other events acted in it, or in another order; but events that
/// come at once may be in any order, whose result the pieces behind them show.
pub(crate) fn chain_error(pieces: &[Piece], second: &[Piece], margin: f64) -> Option<ChainError> {
    let [flights, others] = [pieces, second].map(flights);
    if flights.len() != others.len() || flights.iter().zip(&others).any(|(one, other)| one.1 != other.1) {
        return None;
    }
    let (end, of_second) = (pieces.last()?, &second.last()?.line);
    let (last, sizes) = (&end.line, &end.line.sizes);
    let relative = |off: &[f64]| {
        let shares = off.iter().zip(sizes).filter(|(off, _)| **off != 0.0).map(|(off, size)| off / size);
        shares.fold(0.0, f64::max)
    };
    let own = second.iter().filter_map(|piece| piece.line.error_estimate).fold(0.0, f64::max);
    let (mut found, mut good) = (RunError::none(sizes.len()), GOOD_DIGITS.map(|_| None));
    for ((piece, _), (other, _)) in flights.iter().zip(&others) {
        let (mut here, mut there) = (Sampler::new(&piece.line), Sampler::new(&other.line));
        let (start, of_other) = (piece.line.gamma_i, &other.line);
        let of_windows = piece.line.windows.iter().flat_map(|window| {
            let [first, last] = window.gamma;
            [start + (first + last).half(), start + last]
        });
        for gamma in std::iter::once(start).chain(of_windows) {
            let q = here.at_gamma(gamma).ok()?.q;
            // Beyond its ends the other piece goes straight on.
            let end = of_other.gamma_f();
            let inside = if gamma > end { end } else { gamma.max(of_other.gamma_i) };
            let other = there.at_gamma(inside).ok()?;
            let straight = other.q.iter().zip(&other.q_dot).map(|(&q, &q_dot)| q + (gamma - inside) * q_dot);
            found.see(q.iter().zip(straight).map(|(&q, other)| margin * (q - other)));
            let share = relative(&found.end) + own;
            for (good, digits) in good.iter_mut().zip(GOOD_DIGITS) {
                let is_good = share <= 10.0_f64.powi(-digits);
                *good = if is_good { *good } else { good.or(Some(gamma - last.gamma_i)) };
            }
        }
    }
    if let Some(end_coordinate) = end_coordinate(&end.setup, last) {
        let (q_dot, late) = (last.end().q_dot, found.end[end_coordinate]);
        let pace = |a: usize| (q_dot[a] / q_dot[end_coordinate]).abs();
        let off = |(a, off): (usize, &f64)| if a == end_coordinate { 0.0 } else { *off + late * pace(a) };
        found.see(found.end.iter().enumerate().map(off).collect::<Vec<_>>());
    }
    let estimate = relative(&found.largest) + own;
    let stepped_over = pieces.iter().map(|piece| own_windows(&piece.setup, &piece.line)).fold(0.0, f64::max);
    let judge = Judge::SecondSolve(of_second.accuracy.map_or(own, |accuracy| own.max(accuracy.value())));
    let error = RunError { own: sizes.iter().map(|size| own * size).collect(), judge, stepped_over, ..found };
    let whole = last.length;
    Some((error, estimate, good.map(|good| good.unwrap_or(whole))))
}

/// The pieces of a run that are more than next to nothing, each with the events up to the next one, in the order of
/// the case.
fn flights(pieces: &[Piece]) -> Vec<(&Piece, Vec<usize>)> {
    let mut flights: Vec<(&Piece, Vec<usize>)> = Vec::new();
    for piece in pieces {
        let whole = piece.line.gamma_f() - pieces[0].line.gamma_i;
        match flights.last_mut() {
            Some((_, acted)) if piece.line.length / whole <= AT_ONCE => acted.extend(&piece.acted),
            _ => flights.push((piece, piece.acted.clone())),
        }
    }
    flights.iter_mut().for_each(|(_, acted)| acted.sort_unstable());
    flights
}
