//! A run that is judged by a finer one.
//!
//! Two marches go side by side, the second one with a hundredth of the tolerance of the first. The finer one is the
//! run, and the largest distance of the other from it is its error: what a hundredth of the tolerance changes is what
//! the tolerance did. Nobody has to believe an estimate for that, but only that the finer run is the better one. Of
//! 75 659 pairs of random motions the finer one was off by more than that, or than its own tolerance, in 0.09 %.
//!
//! If they differ by more than an accuracy, they begin again with smaller tolerances, see [`rounds`](super::rounds).
//! Before the last round they stop at once where they do.
//!
//! Windows of both have other ends, as two runs in the same windows can be wrong alike. The coarse one begins off by
//! the last digits of the start, see [`shaken`](super::shaken).

use super::adaptive::{Adaptive, Target};
use super::local::larger;
use super::rounds::{ROUNDED, Rounds};
use super::solved::Handed;
use super::window::Known;
use super::{Accuracy, Failure, GOOD_DIGITS, OfState, POINTS, Window, Windows};
use crate::geometry::{Geometry, OutsideGeometry, Start};

/// A later round fights the rounding of formulas where the finer march has so many times the windows of the other, once
/// it has that many: by the order of windows a hundredth of the tolerance costs 1.4 times as many.
const FUTILE: usize = 4;
const FUTILE_FROM: usize = 200;
/// A coordinate that begins to move may grow for a while, as in the tail of a pulse, and a distance of both marches is
/// nothing beside what it grows to: it is too much if it still is so many windows behind.
const PATIENCE: usize = 16;
/// The nodes of a window of the finer march at which both are compared, evenly over the window and at its end.
const PLACES: [usize; 4] = [4, 7, 11, POINTS - 1];

/// Two marches side by side.
pub(super) struct Companion<'g> {
    finer: Adaptive<'g>,
    coarser: Adaptive<'g>,
    round: Rounds,
    /// The coordinates that rounding moves where the marches of the last round begin to differ by too much.
    refused: Option<Vec<usize>>,
    /// The sweeps of the rounds that were given up, which a count of the work includes.
    sweeps: usize,
    seen: Seen,
}

/// The distance of the marches as far as they were compared.
#[derive(Default)]
struct Seen {
    /// True once the last window of the finer march was compared.
    is_followed: bool,
    /// The place in [`PLACES`] that is compared next.
    place: usize,
    /// True once the coarse march has gone on behind the end of the run.
    is_beyond: bool,
    /// True once the coarse march has failed where the finer one has passed.
    is_lost: bool,
    /// The largest distance in a coordinate, relative to its size, and absolute.
    largest: f64,
    most: Vec<f64>,
    /// The number of windows in turn in which the distance was too large for the sizes that they have.
    too_large: usize,
    /// γ and the place at the first of these.
    parted: Option<(f64, Vec<f64>)>,
    /// The largest absolute one in the last window.
    here: Vec<f64>,
    /// The largest way of the finer march from its start.
    ways: Vec<f64>,
    /// γ until which errors are below each of [`GOOD_DIGITS`].
    good_until: [f64; GOOD_DIGITS.len()],
}

impl<'g> Companion<'g> {
    /// A run of this length, or to a target after about this length, to an accuracy or with a tolerance.
    pub(super) fn new(
        geometry: &'g Geometry,
        start: &Start,
        (length, target): (f64, Option<Target>),
        wanted: Accuracy,
    ) -> Result<Self, OutsideGeometry> {
        let round = Rounds::new(wanted);
        let [coarser, finer] = round.marches().map(|march| Adaptive::new(geometry, start, (length, target), march));
        Ok(Self {
            finer: finer?,
            coarser: coarser?.shaken(),
            round,
            refused: None,
            sweeps: 0,
            seen: Seen::new(geometry),
        })
    }

    /// Goes back to the start, with the tolerances of a round.
    fn begin(&mut self, round: Rounds) {
        (self.round, self.refused) = (round, None);
        let [coarser, finer] = round.marches();
        self.coarser.begin(coarser);
        self.finer.begin(finer);
        self.seen = Seen::new(self.finer.lent.solver.geometry);
    }

    /// Compares the marches over the last window of the finer one, up to where the coarse one has come to. Returns
    /// false if that has gone on by a window, and true once all is compared.
    ///
    /// # Errors
    /// If they differ by more than the accuracy.
    fn follow(&mut self) -> Result<bool, Failure> {
        let Self { finer, coarser, seen, .. } = self;
        if seen.is_lost {
            (seen.place, seen.is_followed) = (0, true);
            let is_refused = finer.attempt.accepted.is_last && !self.round.allows(f64::INFINITY);
            return if is_refused { Err(Failure::Accuracy) } else { Ok(true) };
        }
        let (is_last, has_landed) = (finer.attempt.accepted.is_last, finer.has_landed());
        finer.lent.solver.know(Known::Ways);
        while let Some(&node) = PLACES.get(seen.place) {
            // At a value of a coordinate both have come to their end, wherever it is.
            let is_end = has_landed && node == POINTS - 1;
            let gamma = if is_end { f64::INFINITY } else { finer.gamma_at(node) };
            if gamma > coarser.come_to() && !coarser.is_over() {
                return match coarser.next() {
                    Ok(_) => Ok(false),
                    Err(_) => self.lose().map(|()| true),
                };
            }
            // To a value the coarse march may be shorter, and else by a rounding of the sum of its windows.
            if is_end || gamma <= coarser.come_to() || finer.target.is_none() {
                coarser.lent.solver.know(Known::Ways);
                seen.compare(finer, coarser, node, gamma);
            }
            seen.place += 1;
        }
        (seen.place, seen.is_followed) = (0, true);
        seen.add(finer);
        if is_last {
            // On the way sizes were what was expected of them.
            seen.largest = seen.by_sizes(finer);
        }
        let error = self.round.error(seen.largest);
        let reached = finer.gamma_at_end();
        for (until, digits) in seen.good_until.iter_mut().zip(GOOD_DIGITS) {
            if error <= 10.0_f64.powi(-digits) {
                *until = reached;
            }
        }
        if self.round.allows(error) {
            // A distance that was too much for the sizes on the way may be little for those at the end.
            if is_last {
                self.finer.forgive();
            }
            return Ok(true);
        }
        let is_too_large = !self.round.allows(self.round.error(self.seen.by_sizes(&self.finer)));
        self.seen.too_large = if is_too_large { self.seen.too_large + 1 } else { 0 };
        if self.seen.too_large == 1 {
            self.seen.parted = Some((reached, self.finer.lent.solver.end.positions()));
        }
        // A coordinate that had hardly moved was off by too much there: the run does not fail there.
        if !is_too_large && self.refused.take().is_some() {
            self.finer.forgive();
        }
        if is_last || self.seen.too_large > PATIENCE { self.refuse(is_last).map(|()| true) } else { Ok(true) }
    }

    /// Goes on without the coarse march, which has failed where the finer one has passed: they differ by anything. With
    /// smaller tolerances they may both pass.
    fn lose(&mut self) -> Result<(), Failure> {
        self.seen.largest = f64::INFINITY;
        self.seen.most.fill(f64::INFINITY);
        if !self.round.allows(f64::INFINITY) && self.round.next(f64::INFINITY).is_some() {
            return Err(Failure::BeginAgain);
        }
        self.seen.is_lost = true;
        self.follow().map(drop)
    }

    /// Stops where the marches differ by more than the accuracy, if they can do so again with smaller tolerances. If
    /// not, the run goes on to its end, and tells there what it comes to.
    fn refuse(&mut self, is_last: bool) -> Result<(), Failure> {
        // Where a finer march is not possible, the rounding of both is what they differ by.
        if self.round.next(self.seen.largest).is_some() {
            return Err(Failure::BeginAgain);
        }
        if self.refused.is_none() {
            match self.finer.reason(Failure::Accuracy) {
                Failure::Accuracy => {
                    self.refused = Some(self.finer.moved_by_rounding());
                    self.finer.attempt.failed_at = self.seen.parted.take().or(self.finer.attempt.failed_at.take());
                }
                other => return Err(other),
            }
        }
        if is_last { Err(Failure::Accuracy) } else { Ok(()) }
    }

    /// True if windows of a later round become too many for what is asked of them.
    fn is_futile(&self) -> bool {
        let [finer, coarser] = [&self.finer, &self.coarser].map(|march| march.attempt.windows);
        self.round.is_later() && finer > FUTILE_FROM.max(FUTILE * coarser)
    }
}

impl Seen {
    fn new(geometry: &Geometry) -> Self {
        let none = vec![0.0; geometry.results()];
        Self { most: none.clone(), ways: none.clone(), here: none, ..Self::default() }
    }

    /// Compares at a node of the finer march, with the place of the coarse one at this γ, or at its end.
    fn compare(&mut self, finer: &Adaptive<'_>, coarser: &Adaptive<'_>, node: usize, gamma: f64) {
        let weights = coarser.weights_at(gamma);
        for (a, (here, most)) in self.here.iter_mut().zip(&mut self.ways).enumerate() {
            let way = finer.way_at_node(a, node);
            *here = larger(*here, (way - coarser.way_at(a, &weights)).abs());
            *most = larger(*most, way.abs());
        }
    }

    /// Takes what was compared in a window.
    fn add(&mut self, finer: &Adaptive<'_>) {
        let done = finer.done();
        for (a, (most, here)) in self.most.iter_mut().zip(&mut self.here).enumerate() {
            let off = std::mem::take(here);
            *most = larger(*most, off);
            self.largest = larger(self.largest, off * finer.inverse_for_sums(a, done));
        }
    }

    /// The largest distance so far, relative to the sizes that are known here.
    fn by_sizes(&self, finer: &Adaptive<'_>) -> f64 {
        let done = finer.done();
        let shares = self.most.iter().enumerate().map(|(a, most)| most * finer.inverse_for_sums(a, done));
        shares.fold(0.0, larger)
    }
}

impl Windows for Companion<'_> {
    fn next(&mut self) -> Result<Option<Window<'_>>, Failure> {
        while self.next_of_judge()?.is_some() {}
        self.seen.is_followed = false;
        if self.is_futile() {
            return Err(self.finer.reason(Failure::Accuracy));
        }
        let is_over = self.finer.next()?.is_none();
        if is_over {
            self.seen.is_followed = true;
            return Ok(None);
        }
        Ok(Some(self.finer.window()))
    }

    fn next_of_judge(&mut self) -> Result<Option<Window<'_>>, Failure> {
        // The last window may have been solved again since it was seen.
        if self.finer.attempt.windows > 0 && !self.seen.is_followed && !self.follow()? {
            return Ok(Some(self.coarser.window()));
        }
        // Where an event has ended the run, the coarse march may meet it a little later.
        let is_there = self.coarser.is_over() || self.seen.is_beyond || self.seen.is_lost;
        if self.finer.attempt.accepted.is_last && !is_there {
            self.seen.is_beyond = true;
            // Behind the event there may be nothing.
            return Ok(self.coarser.next().unwrap_or(None));
        }
        Ok(None)
    }

    fn end_where(&mut self, between: [f64; 2], side: f64, value: OfState<'_>) -> Result<bool, Failure> {
        self.finer.end_where(between, side, value)
    }

    fn set_floors(&mut self, floors: &[(usize, f64)]) {
        self.finer.set_floors(floors);
        self.coarser.set_floors(floors);
    }

    fn window(&mut self) -> Window<'_> {
        self.finer.window()
    }

    fn sweeps(&self) -> usize {
        self.sweeps + self.finer.sweeps() + self.coarser.sweeps()
    }

    fn begin_again(&mut self) {
        self.sweeps = self.sweeps();
        self.begin(self.round.next(self.seen.largest).expect("marches begin again where there is a further round"));
    }

    fn rewind(&mut self) {
        self.sweeps = 0;
        self.begin(self.round.first());
    }

    fn resume(&mut self, handed: &Handed) {
        self.finer.resume(handed);
        self.coarser.resume(handed);
    }

    fn error_estimate(&self) -> Option<f64> {
        Some(self.round.error(self.seen.largest))
    }

    fn errors(&self) -> Vec<f64> {
        let (Seen { largest, most, ways, .. }, rounded) = (&self.seen, |size: f64| ROUNDED * size);
        let estimate = self.round.error(*largest);
        // A coordinate that rests in both marches, as that across the plane of an orbit, has no error of others.
        let rests = |a: usize, size: f64| a < most.len() && larger(most[a], ways[a]) <= rounded(size);
        let of = |(a, &size): (usize, &f64)| if rests(a, size) { 2.0 * rounded(size) } else { estimate * size };
        self.finer.sizes().iter().enumerate().map(of).collect()
    }

    fn reachable(&self) -> Option<f64> {
        if self.is_futile() { None } else { self.error_estimate() }
    }

    fn good_until(&self) -> [f64; GOOD_DIGITS.len()] {
        self.seen.good_until
    }

    fn sizes(&self) -> Vec<f64> {
        self.finer.sizes()
    }

    fn place(&self) -> (f64, Vec<f64>) {
        self.finer.place()
    }

    fn moved_by_rounding(&mut self) -> Vec<usize> {
        self.refused.clone().unwrap_or_else(|| self.finer.moved_by_rounding())
    }

    fn unresolved(&self) -> usize {
        self.finer.unresolved()
    }

    fn touched(&self) -> Option<f64> {
        self.finer.touched()
    }
}
