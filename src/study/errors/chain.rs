//! The error of a run with events that act, by a second one.

use super::stepped_over::own_windows;
use super::{Judge, RunError};
use crate::engine::GOOD_DIGITS;
use crate::number::Real;
use crate::solve::{Limit, WorldLine};
use crate::study::acting::Piece;
use crate::trajectory::Sampler;

/// Events with no more than this part of the way so far between them come at once.
const AT_ONCE: f64 = 1e-9;

/// The error of a chain of pieces.
pub(crate) struct ChainError {
    /// The error, coordinate by coordinate.
    pub(crate) error: RunError,
    /// The largest one, relative to the size of its coordinate.
    pub(crate) estimate: f64,
    /// γ, from the start of the last piece, until which each of [`GOOD_DIGITS`] is kept.
    pub(crate) good_until: [f64; GOOD_DIGITS.len()],
}

/// Compares the pieces of a run with those of a second one, at the same γ on the ends and in the middles of windows.
/// Errors are `margin` times the differences. `None` if other events acted in it, or in another order; but events that
/// come at once may be in any order, whose result the pieces behind them show.
pub(crate) fn chain_error<S: Real>(pieces: &[Piece<S>], second: &[Piece<S>], margin: f64) -> Option<ChainError> {
    let [flights, others] = [pieces, second].map(flights);
    if flights.len() != others.len() || flights.iter().zip(&others).any(|(one, other)| one.1 != other.1) {
        return None;
    }
    let (last, of_second) = (&pieces.last()?.line, &second.last()?.line);
    let sizes = &last.sizes;
    let relative = |off: &[f64]| {
        let shares = off.iter().zip(sizes).filter(|(off, _)| **off != 0.0).map(|(off, size)| off / size);
        shares.fold(0.0, f64::max)
    };
    let own = second.iter().filter_map(|piece| piece.line.error_estimate).fold(0.0, f64::max);
    let (mut largest, mut end, mut good) = (vec![0.0_f64; sizes.len()], Vec::new(), GOOD_DIGITS.map(|_| None));
    for ((piece, _), (other, _)) in flights.iter().zip(&others) {
        let (mut here, mut there) = (Sampler::new(&piece.line), Sampler::new(&other.line));
        for gamma in places(&piece.line) {
            let sample = here.at_gamma(gamma).ok()?.q;
            end = off(&sample, gamma, &other.line, &mut there)?.iter().map(|off| margin * off.abs()).collect();
            largest.iter_mut().zip(&end).for_each(|(largest, off)| *largest = largest.max(*off));
            let share = relative(&end) + own;
            for (good, digits) in good.iter_mut().zip(GOOD_DIGITS) {
                let is_good = share <= 10.0_f64.powi(-digits);
                *good = if is_good { *good } else { good.or(Some((gamma - last.gamma_i).to_f64())) };
            }
        }
    }
    if let (Limit::Value { coordinate: clock, .. }, None) = (pieces.last()?.setup.limit, last.ended_by) {
        let (q_dot, late) = (last.end().q_dot, end[clock]);
        let pace = |a: usize| (q_dot[a] / q_dot[clock]).to_f64().abs();
        end.iter_mut().enumerate().for_each(|(a, off)| *off = if a == clock { 0.0 } else { *off + late * pace(a) });
        largest.iter_mut().zip(&end).for_each(|(largest, off)| *largest = largest.max(*off));
    }
    let estimate = relative(&largest) + own;
    let stepped_over = pieces.iter().map(|piece| own_windows(&piece.setup, &piece.line)).fold(0.0, f64::max);
    let judge = Judge::SecondSolve(of_second.accuracy.map_or(own, |accuracy| own.max(accuracy.value())));
    let error = RunError { end, largest, own: sizes.iter().map(|size| own * size).collect(), judge, stepped_over };
    let whole = last.length.to_f64();
    Some(ChainError { error, estimate, good_until: good.map(|good| good.unwrap_or(whole)) })
}

/// The pieces of a run that are more than next to nothing, each with the events up to the next one, in the order of
/// the case.
fn flights<S: Real>(pieces: &[Piece<S>]) -> Vec<(&Piece<S>, Vec<usize>)> {
    let mut flights: Vec<(&Piece<S>, Vec<usize>)> = Vec::new();
    for piece in pieces {
        let whole = piece.line.gamma_f() - pieces[0].line.gamma_i;
        match flights.last_mut() {
            Some((_, acted)) if (piece.line.length / whole).to_f64() <= AT_ONCE => acted.extend(&piece.acted),
            _ => flights.push((piece, piece.acted.clone())),
        }
    }
    flights.iter_mut().for_each(|(_, acted)| acted.sort_unstable());
    flights
}

/// γ at the ends and in the middles of the windows of a piece.
fn places<S: Real>(line: &WorldLine<S>) -> impl Iterator<Item = S> + '_ {
    let start = line.gamma_i;
    let of_windows = line.windows.iter().flat_map(move |window| {
        let [first, last] = window.gamma;
        [start + (first + last).half(), start + last]
    });
    std::iter::once(start).chain(of_windows)
}

/// By how much a state is off from that of another piece at the same γ. Beyond its ends that one goes straight on.
fn off<S: Real>(q: &[S], gamma: S, line: &WorldLine<S>, sampler: &mut Sampler<'_, S>) -> Option<Vec<f64>> {
    let end = line.gamma_f();
    let inside = if gamma > end { end } else { gamma.max(line.gamma_i) };
    let sample = sampler.at_gamma(inside).ok()?;
    let rest = gamma - inside;
    let there = sample.q.iter().zip(&sample.q_dot).map(|(&q, &q_dot)| q + rest * q_dot);
    Some(q.iter().zip(there).map(|(&q, there)| (q - there).to_f64()).collect())
}
