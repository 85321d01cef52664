//! Windows as long as an accuracy needs.
//!
//! The errors inside of a window do not add up, so that they may use up a part of the accuracy in every one. Those at its
//! end do: a window of length h of a run of length L has a share of about (h/L)^1.5 of the rest. What they add up to is
//! estimated on the way ([`ErrorEstimate`]), and an attempt that comes to more than the accuracy is begun again with
//! smaller shares.

use super::certificate::Certificate;
use super::control::Control;
use super::estimate::ErrorEstimate;
use super::ladder::Ladder;
use super::sizes::Sizes;
use super::window::{Known, Solver};
use super::{Accuracy, Failure, Window, Windows};
use crate::geometry::{Geometry, Start};
use crate::number::Compensated;

/// Errors inside a window may use up this part of the accuracy; the rest is for what windows add up to.
const INSIDE: f64 = 0.6;
/// Bounds of errors inside a window are multiplied by this.
const INSIDE_MARGIN: f64 = 1.5;
/// The estimate of what windows have added up to is multiplied by this.
const MARGIN: f64 = 2.5;
/// A window of length h of a run of length L may add this part of a (h/L)^1.5 at its end.
const SHARE: f64 = 0.2;
/// Sweeps leave this part of a share.
const LEFT: f64 = 0.01;
/// The highest modes of slopes that resolve the motion are less than this, relative to the largest slope.
const RESOLVED: f64 = 0.03;
/// A run is begun again at most so often.
const MOST_RESTARTS: usize = 6;
/// Errors are foreseen once this part of a run is behind.
const FORESEEN: f64 = 0.05;
/// Below this accuracy, rounding of the tables counts.
const EXACT: f64 = 1e-10;
/// A window that is longer than the rest of the run by no more than this part ends the run.
const STRETCH: f64 = 1e-7;

/// The windows of a run with rules of N nodes.
pub(super) struct Adaptive<'g, const N: usize> {
    solver: Solver<'g, N>,
    ladder: Ladder<N>,
    control: Control,
    estimate: Option<ErrorEstimate<'g, N>>,
    certificate: Option<Certificate<'g, N>>,
    wanted: Accuracy,
    /// What these need of a window.
    known: Known,
    start: &'g Start,
    sizes: Sizes,
    /// The length of the run.
    length: f64,
    /// The γ that windows have come to.
    gamma: Compensated<f64>,
    /// The rung of the window before, if there was one.
    previous: Option<i32>,
    /// Shares are smaller by this factor.
    strictness: f64,
    restarts: usize,
    refused: usize,
    sweeps: usize,
    largest_inside: f64,
    /// Number of windows that were solved.
    windows: usize,
    /// What the last one left behind.
    accepted: Accepted,
}

/// A window that was accepted.
#[derive(Debug, Clone, Copy, Default)]
struct Accepted {
    length: f64,
    sweeps: usize,
    is_last: bool,
    /// What sweeps left undone, relative to sizes.
    left: f64,
}

impl<'g, const N: usize> Adaptive<'g, N> {
    pub(super) fn new(geometry: &'g Geometry, start: &'g Start, sizes: Sizes, length: f64, wanted: Accuracy) -> Self {
        let mut solver = Solver::new(geometry, N, true);
        solver.begin(start, &sizes);
        let a = wanted.accuracy;
        let first = if N > 8 { 3.0 * a.powf(1.0 / 24.0) } else { 1.5 * a.powf(1.0 / 12.0) };
        Self {
            ladder: Ladder::new(solver.system.order, first * sizes.time, a < EXACT),
            control: Control::new(N),
            estimate: wanted.is_promised.then(|| ErrorEstimate::new(&solver, start)),
            certificate: wanted.is_certified.then(|| Certificate::new(geometry)),
            solver,
            known: match wanted {
                Accuracy { is_certified: true, .. } => Known::All,
                Accuracy { is_promised: true, .. } => Known::Velocities,
                _ => Known::Ends,
            },
            wanted,
            start,
            sizes,
            length,
            gamma: Compensated::default(),
            previous: None,
            strictness: 1.0,
            restarts: 0,
            refused: 0,
            sweeps: 0,
            largest_inside: 0.0,
            windows: 0,
            accepted: Accepted::default(),
        }
    }

    /// Solves windows until one is accurate enough.
    fn accept(&mut self) -> Result<Accepted, Failure> {
        let accuracy = self.wanted.accuracy;
        loop {
            let rung = self.control.rung;
            if !Ladder::<N>::has(rung) {
                return Err(Failure::TooShort);
            }
            let (rest, full) = ((self.length - self.gamma.high) - self.gamma.low, self.ladder.length(rung));
            let is_last = rest <= full * (1.0 + STRETCH);
            let odd;
            let (tables, continuation) = if is_last && rest != full {
                odd = self.ladder.odd(&self.solver.rule, rest);
                (&odd, None)
            } else {
                self.ladder.rung(&self.solver.rule, rung, self.previous)
            };
            let part = tables.length / self.length;
            let share = self.strictness * SHARE * accuracy * part * part.sqrt();
            let Ok(swept) = self.solver.solve(tables, continuation, LEFT * share) else {
                self.refused += 1;
                self.control.refuse();
                continue;
            };
            self.sweeps += swept.sweeps;
            let local = swept.local;
            let inside = INSIDE_MARGIN * local.inside;
            let is_resolved = local.roughness < RESOLVED;
            if !is_resolved {
                self.control.refuse();
            }
            if !is_resolved || !self.control.accepts(inside / (INSIDE * accuracy), local.end / share) {
                self.refused += 1;
                continue;
            }
            self.solver.finish(tables, self.known);
            self.previous = Some(rung);
            self.largest_inside = self.largest_inside.max(inside);
            return Ok(Accepted { length: tables.length, sweeps: swept.sweeps, is_last, left: swept.left });
        }
    }

    /// Carries the error over the window that was accepted.
    ///
    /// # Errors
    /// If windows add up to more than the accuracy, or are expected to.
    fn follow(&mut self, accepted: Accepted) -> Result<(), Failure> {
        let Some(estimate) = &mut self.estimate else { return Ok(()) };
        estimate.follow(&self.solver, accepted.length, accepted.left, accepted.is_last);
        // Errors are expected to grow at least linearly in what is left.
        let allowed = (1.0 - INSIDE) * self.wanted.accuracy;
        let excess = MARGIN * estimate.now / allowed;
        let way = (self.length / estimate.reached).min(1.0 / FORESEEN);
        if excess <= 1.0 && (way >= 1.0 / FORESEEN || excess * way <= 1.0) {
            return Ok(());
        }
        let expected = excess.max(1e-3) * way.powf(1.5);
        // Shorter windows make no smaller rounding errors.
        if self.restarts == MOST_RESTARTS || MARGIN * estimate.rounding_now > allowed {
            return Err(Failure::Rounding);
        }
        self.strictness *= (0.2 / expected).clamp(1e-4, 0.3);
        Err(Failure::BeginAgain)
    }
}

impl<const N: usize> Windows for Adaptive<'_, N> {
    fn next(&mut self) -> Result<Option<Window<'_>>, Failure> {
        if self.windows > 0 {
            if self.accepted.is_last {
                return Ok(None);
            }
            self.solver.advance();
            self.gamma = self.gamma.plus(self.accepted.length);
        }
        let accepted = self.accept()?;
        self.follow(accepted)?;
        let Accepted { length, sweeps, .. } = accepted;
        let gradient_norm = self.certificate.as_mut().map(|certificate| certificate.of(&self.solver, length));
        (self.accepted, self.windows) = (accepted, self.windows + 1);
        let (index, gamma) = (self.windows - 1, self.gamma.high);
        Ok(Some(Window { index, gamma, length, sweeps, gradient_norm, solved: &mut self.solver }))
    }

    fn begin_again(&mut self) {
        self.restarts += 1;
        self.solver.begin(self.start, &self.sizes);
        self.control = Control::new(N);
        self.estimate.iter_mut().for_each(ErrorEstimate::begin);
        (self.gamma, self.previous, self.largest_inside, self.windows) = (Compensated::default(), None, 0.0, 0);
    }

    fn rewind(&mut self) {
        self.begin_again();
        (self.restarts, self.refused, self.sweeps) = (0, 0, 0);
        self.strictness = 1.0;
    }

    fn error_estimate(&self) -> Option<f64> {
        self.estimate.as_ref().map(|estimate| MARGIN * estimate.largest + self.largest_inside)
    }
}
