//! The comparison of a run with a second and cheaper solve, and with the Taylor series of [`crate::reference`]; and
//! that of a run with events that act with a second one.

use super::between::{Between, PROBES, middles, own_windows, share_of};
use super::ends::{End, rates_of_momenta};
use super::{Judge, RunError};
use crate::diagnostics::{Extent, origin};
use crate::engine::{Accuracy, Engine, GOOD_DIGITS, Handed, Rounds};
use crate::geometry::{Geometry, Start};
use crate::number::Real;
use crate::number::norm::larger;
use crate::reference::ReferenceTrajectory;
use crate::solve::{Off, Place, WorldLine};
use crate::study::acting::Piece;
use crate::trajectory::{Sample, Sampler};

/// The accuracy of every window of the second solve. What they add up to is estimated on its way.
pub(super) const ACCURACY: f64 = 1e-13;

/// The largest number of windows of the second solve: the first number is per node of the run, and the second one is
/// allowed in any case.
const WINDOWS: (usize, usize) = (1, 10_000);

/// The nodes of a run, counted from its start and its origin, or samples in place of some of them.
pub(super) struct Points<'l, S> {
    line: &'l WorldLine<S>,
    /// γ − γ_i.
    gamma: Vec<S>,
    /// q^a, a row for each coordinate.
    rows: Vec<Vec<S>>,
    /// dq^a/dγ at the end.
    q_dot: Vec<S>,
    /// What ended the run. The last point is compared where that ends the judge as well.
    end: End,
}

impl<'l, S: Real> Points<'l, S> {
    /// The samples before `line`, and its nodes.
    pub(super) fn new(line: &'l WorldLine<S>, samples: &[Sample<S>], end: End) -> Self {
        let first = line.gamma_from_start().next().unwrap_or(S::ZERO);
        let from_start = |sample: &Sample<S>| line.signed(sample.gamma - line.gamma_i);
        let mut before: Vec<&Sample<S>> = samples.iter().filter(|sample| from_start(sample) < first).collect();
        if before.first().zip(before.last()).is_some_and(|(first, last)| from_start(first) > from_start(last)) {
            before.reverse();
        }
        let row = |a: usize| {
            let sampled = before.iter().map(|sample| sample.q[a] - line.origin_of(a));
            sampled.chain(line.counted_from_origin(a, &line.q[a])).collect()
        };
        Self {
            gamma: before.iter().map(|sample| from_start(sample)).chain(line.gamma_from_start()).collect(),
            rows: (0..line.geometry().dimension()).map(row).collect(),
            q_dot: line.end_inside().q_dot,
            line,
            end,
        }
    }

    /// The size of every coordinate, shared with others of its kind. Ignorable ones count from the start.
    pub(super) fn sizes(&self) -> Vec<f64> {
        let place = &self.line.place;
        let far = |(a, row): (usize, &Vec<S>)| {
            let origin = origin(place, a);
            Extent::of(row.iter().map(|&q| (q - origin).to_f64())).size()
        };
        place.geometry.shared(&place.start.q, &self.rows.iter().enumerate().map(far).collect::<Vec<_>>())
    }

    /// By how much the last point is off at most in every coordinate, and in every momentum, where coordinates are off
    /// by `off` at equal γ from a world-line that is at `end` there. Where a value or an event ended the run, the place
    /// of the judge's own end is compared: its pace on the way there changes by about half of what it differs at both
    /// ends.
    fn at_end(&self, geometry: &Geometry, off: Vec<f64>, end: &Start) -> [Vec<f64>; 2] {
        let own = self.line.end_inside().in_f64().p;
        let off = Off { q: off, p: own.iter().zip(&end.p).map(|(own, p)| own - p).collect() };
        let late = self.end.late(&off, &end.q_dot);
        let of_momenta = off.p.iter().zip(rates_of_momenta(geometry, end));
        let of_momenta = of_momenta.map(|(off, rate)| (off - late * rate).abs()).collect();
        let coordinate = self.end.coordinate();
        let other_pace = |a: usize| match coordinate {
            Some(end_at) => (self.q_dot[a] / self.q_dot[end_at]).to_f64() * end.q_dot[end_at] - end.q_dot[a],
            None => self.q_dot[a].to_f64() - end.q_dot[a],
        };
        let at = |a: usize| (off.q[a] - late * end.q_dot[a]).abs() + 0.5 * (late * other_pace(a)).abs();
        let of_places = (0..off.q.len()).map(|a| if Some(a) == coordinate { 0.0 } else { at(a) });
        [of_places.collect(), of_momenta]
    }

    /// The errors of a judge that is off by this share of these sizes.
    fn own(&self, share: f64, sizes: &[f64]) -> Vec<f64> {
        self.end.with_late(sizes.iter().map(|size| share * size).collect(), self.line)
    }

    /// Compares with a second solve from `place`. `None` if that does not reach the end.
    pub(super) fn with_second_solve(
        &self,
        place: &Place,
        handed: &Handed,
        [accuracy, lost]: [f64; 2],
    ) -> Option<RunError> {
        let (geometry, start) = (&*place.geometry, &*place.start);
        let (most, last) = (WINDOWS.1.max(WINDOWS.0 * self.gamma.len()), self.gamma.len() - 1);
        let length = self.gamma[last].to_f64();
        let march = || {
            let mut engine = Engine::accurate(geometry, start, length, Accuracy::Estimated(accuracy)).ok()?;
            engine.resume(handed);
            Some(engine)
        };
        let (mut engine, mut found, mut next) = (march()?, RunError::none(start.q.len()), 0);
        let (mut q, mut p) = (vec![Vec::new(); start.q.len()], vec![Vec::new(); geometry.active().len()]);
        let (mut end, mut end_p) = (start.q.clone(), start.p.clone());
        // Windows that may add up to anything are never begun again.
        while let Some(window) = engine.next().ok()? {
            let (begin, h, dense) = (window.gamma, window.length, window.dense());
            let is_here = |k: &usize| window.is_last || self.gamma[*k].to_f64() < begin + h;
            let here = next..(next..last).take_while(is_here).last().map_or(next, |k| k + 1);
            q.iter_mut().chain(&mut p).for_each(Vec::clear);
            let fractions = here.clone().map(|k| ((self.gamma[k].to_f64() - begin) / h).clamp(0.0, 1.0));
            dense.append(fractions, &mut q, &mut p);
            for k in here.clone() {
                found.see(self.rows.iter().zip(&q).map(|(row, q)| row[k].to_f64() - q[k - next]));
            }
            next = here.end;
            end.clone_from(&window.end().positions());
            geometry.active().iter().zip(window.end().momenta()).for_each(|(&a, p)| end_p[a] = p);
            if window.index >= most {
                return None;
            }
        }
        if next < last {
            return None;
        }
        let off: Vec<f64> = self.rows.iter().zip(&end).map(|(row, q)| row[last].to_f64() - q).collect();
        let q_dot = geometry.velocities(&end, &end_p).ok()?;
        let [at_end, off_p] = self.at_end(geometry, off, &Start { q: end, q_dot, p: end_p });
        found.see(at_end);
        let (estimate, sizes) = (engine.error_estimate()?, engine.sizes());
        let (own, judge) = (self.own(estimate, &sizes), Judge::SecondSolve(estimate));
        // As those of a run to an accuracy, its windows are proved to see everything, as a rule.
        let is_proved = engine.unresolved() == 0;
        let stepped_over = if is_proved { 0.0 } else { share_of(&mut march()?, (place, length, lost), most) };
        Some(RunError { own, end_p: Some(off_p), judge, stepped_over, ..found })
    }

    /// Compares with a Taylor reference of as many digits, with that from `place` in `f64`. `None` if that does not
    /// reach the end.
    pub(super) fn with_taylor(&self, place: &Place, lost: f64) -> Option<RunError> {
        let WorldLine { length, digits, place: Place { geometry, start }, .. } = self.line;
        let reference = ReferenceTrajectory::new(geometry, start, *length, *digits).ok()?;
        let mut found = RunError::none(geometry.dimension());
        let last = self.gamma.len() - 1;
        let off = |k: usize, exact: &[S]| -> Vec<f64> {
            self.rows.iter().zip(exact).map(|(row, &q)| (row[k] - q).to_f64()).collect()
        };
        (0..last).for_each(|k| found.see(off(k, &reference.at(self.gamma[k]).q)));
        let end = reference.at(*length);
        let [at_end, off_p] = self.at_end(&place.geometry, off(last, &end.q), &end.in_f64());
        found.see(at_end);
        let mut between = Between::new(&place.geometry, &place.start, length.to_f64(), lost);
        if !S::IS_EXTENDED {
            between.see_points(middles(PROBES).map(|share| reference.at(*length * S::from(share)).in_f64()).collect());
        }
        let error = reference.error_estimate();
        let (own, judge) = (self.own(error, &self.sizes()), Judge::Taylor(error));
        Some(RunError { own, end_p: Some(off_p), judge, stepped_over: between.share(), ..found })
    }
}

/// The sizes of coordinates in a run with events that act. An ignorable coordinate counts from the start elsewhere, by
/// its way. Events may send it back, and its size is that of its range, however long its way is.
pub(crate) fn sizes_of(pieces: &[Piece]) -> Vec<f64> {
    let lines = || pieces.iter().map(|piece| &piece.line);
    let Some(last) = lines().next_back() else { return Vec::new() };
    let size = |(a, &size): (usize, &f64)| {
        let is_active = last.geometry().active().contains(&a);
        if is_active { size } else { Extent::of(lines().flat_map(|line| line.q(a))).range() }
    };
    last.sizes.iter().enumerate().map(size).collect()
}

/// Events with no more than this part of the way so far between them come at once.
const AT_ONCE: f64 = 1e-9;

/// The error of a chain of pieces.
pub(crate) struct ChainError {
    pub(crate) error: RunError,
    /// The largest distance of the two chains, relative to the size of its coordinate, with the margin.
    pub(crate) distance: f64,
    /// γ, from the start of the last piece, until which each of [`GOOD_DIGITS`] is kept.
    pub(crate) good_until: [f64; GOOD_DIGITS.len()],
}

/// Compares the pieces of a run with those of a coarser one, at the same γ on the ends and in the middles of windows.
/// Distances count by a margin, and errors as those of marches of this round. Where other events act, or in another
/// order, nothing is known of what follows; but events that come at once may be in any order, whose result the pieces
/// behind them show. `None` if a piece has no samples.
pub(crate) fn chain_error(pieces: &[Piece], coarser: &[Piece], (margin, round): (f64, &Rounds)) -> Option<ChainError> {
    let [flights, others] = [pieces, coarser].map(flights);
    let alike = flights.iter().zip(&others).take_while(|(one, other)| one.acted == other.acted).count();
    let end = pieces.last()?;
    let (last, sizes) = (&end.line, &sizes_of(pieces));
    let relative = |off: &[f64]| {
        let results = off.iter().zip(sizes).take(last.geometry().results());
        let shares = results.filter(|(off, _)| **off != 0.0).map(|(off, size)| off / size);
        shares.fold(0.0, larger)
    };
    let (mut found, mut good) = (RunError::none(sizes.len()), GOOD_DIGITS.map(|_| None));
    for (k, (Flight { piece, .. }, other)) in flights.iter().zip(&others).take(alike + 1).enumerate() {
        let (mut here, mut there) = (Sampler::new(&piece.line), Sampler::new(&other.piece.line));
        let (start, of_other) = (piece.line.gamma_i, &other.piece.line);
        let of_windows = piece.line.windows.iter().flat_map(|window| {
            let [first, last] = window.gamma;
            [start + (first + last).half(), start + last]
        });
        for gamma in std::iter::once(start).chain(of_windows) {
            let q = here.at_gamma(gamma).ok()?.q;
            // Beyond its ends the other piece goes straight on.
            let end = of_other.gamma_f();
            if k == alike && gamma > end {
                break;
            }
            let inside = if gamma > end { end } else { gamma.max(of_other.gamma_i) };
            let other = there.at_gamma(inside).ok()?;
            let straight = other.q.iter().zip(&other.q_dot).map(|(&q, &q_dot)| q + (gamma - inside) * q_dot);
            found.see(q.iter().zip(straight).map(|(&q, other)| margin * (q - other)));
            let share = round.error(relative(&found.end));
            for (good, digits) in good.iter_mut().zip(GOOD_DIGITS) {
                let is_good = share <= 10.0_f64.powi(-digits);
                *good = if is_good { *good } else { good.or(Some(gamma - last.gamma_i)) };
            }
        }
    }
    if let Some((one, other)) = flights.iter().zip(&others).nth(alike) {
        let gamma = one.piece.line.gamma_f().min(other.piece.line.gamma_f()) - last.gamma_i;
        good.iter_mut().for_each(|good| *good = good.or(Some(gamma)));
        found.see(std::iter::repeat(f64::INFINITY));
    }
    found.see(End::new(&end.setup, last).with_late(found.end.clone(), last));
    let (distance, whole) = (relative(&found.largest), last.length);
    let stepped_over = pieces.iter().map(|piece| own_windows(&piece.setup, &piece.line, 0.0)).fold(0.0, larger);
    let least = round.error(0.0);
    let error = RunError { own: sizes.iter().map(|size| least * size).collect(), stepped_over, ..found };
    Some(ChainError { error, distance, good_until: good.map(|good| good.unwrap_or(whole)) })
}

/// A piece with the events that acted up to the next one.
struct Flight<'p> {
    piece: &'p Piece,
    acted: Vec<usize>,
}

/// The pieces of a run that are more than next to nothing, each with the events up to the next one, in the order of
/// the case.
fn flights(pieces: &[Piece]) -> Vec<Flight<'_>> {
    let mut flights: Vec<Flight<'_>> = Vec::new();
    for piece in pieces {
        let whole = piece.line.gamma_f() - pieces[0].line.gamma_i;
        match flights.last_mut() {
            Some(Flight { acted, .. }) if piece.line.length / whole <= AT_ONCE => acted.extend(&piece.acted),
            _ => flights.push(Flight { piece, acted: piece.acted.clone() }),
        }
    }
    flights.iter_mut().for_each(|flight| flight.acted.sort_unstable());
    flights
}
