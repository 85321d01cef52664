//! Windows as long as an accuracy needs.
//!
//! A tolerance is that of every window by itself. Errors inside of a window do not add up, so that they may use up a
//! part of it in every one. Those at its end do, and may be a hundredth. What they add up to is known only by another
//! march, see [`companion`](super::companion).

mod accept;
mod ending;
mod places;

use super::between::{Between, Kink};
use super::defect::Defect;
use super::failure::edge;
use super::ladder::Control;
use super::ladder::Ladder;
use super::sweeps::Swept;
use super::tuning::{AHEAD, ALONE, EXACT, FIRST, LOOSEST};
use super::view::Lent;
use super::window::Solver;
use super::{Accuracy, Failure, Handed, OfState, POINTS, Window, Windows};
use crate::geometry::{Geometry, OutsideGeometry, Start};
use crate::number::Compensated;
use crate::sbp::collocation::Collocation;
use crate::sbp::legendre::Family;

/// The windows of a run.
pub(super) struct Adaptive<'g> {
    pub(super) lent: Lent<'g, POINTS>,
    ladder: Ladder,
    /// Looks between the nodes, where something can hide there.
    pub(super) between: Option<Between>,
    defect: Defect<'g>,
    barycentric: places::Weights,
    tolerance: f64,
    /// The accuracy that is asked of the run: what may hide between the nodes changes its end by less.
    accuracy: f64,
    handed: Option<Handed>,
    /// True if it begins off by the last digits of its start.
    is_shaken: bool,
    /// The length of the run; an estimate, if it ends at a target.
    pub(super) length: f64,
    pub(super) target: Option<Target>,
    sweeps: usize,
    pub(super) attempt: Attempt,
}

/// The run as far as it has come since it began or was begun again.
#[derive(Default)]
pub(super) struct Attempt {
    control: Control,
    /// The γ that windows have come to.
    pub(super) gamma: Compensated<f64>,
    /// The rung of the window before, if there was one.
    previous: Option<i32>,
    /// The rate of the coordinate by which the run ends, at the end of the window before.
    pub(super) rate: f64,
    /// γ and q^a where the run failed.
    pub(in crate::engine) failed_at: Option<(f64, Vec<f64>)>,
    /// Number of windows in which something may hide.
    unresolved: usize,
    /// γ at the first place where the motion touches a place where a force jumps.
    touched: Option<f64>,
    /// Number of windows that were solved.
    pub(super) windows: usize,
    /// The last one, as it was accepted.
    pub(super) accepted: Accepted,
}

/// The value of a coordinate at which a run ends.
#[derive(Debug, Clone, Copy)]
pub(super) struct Target {
    pub(super) coordinate: usize,
    pub(super) value: f64,
    /// The coordinate at the start.
    pub(super) from: f64,
    /// The least distance so far, and the number of windows since.
    pub(super) nearest: f64,
    pub(super) idle: usize,
}

impl Target {
    pub(super) fn new(coordinate: usize, value: f64, from: f64) -> Self {
        Self { coordinate, value, from, nearest: f64::INFINITY, idle: 0 }
    }

    /// The length of the run, if it is at `q` after a part of the length γ.
    pub(super) fn foreseen(&self, q: f64, gamma: f64) -> f64 {
        let done = (q - self.from) / (self.value - self.from);
        if done > 0.0 { gamma / done.min(1.0) } else { f64::INFINITY }
    }
}

/// A window that was accepted.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Accepted {
    pub(super) length: f64,
    pub(super) is_last: bool,
    kink: Kink,
    swept: Swept,
}

impl<'g> Adaptive<'g> {
    /// A run of this length, or to a target after about this length, with a tolerance of windows that serves an
    /// accuracy of the run.
    pub(super) fn new(
        geometry: &'g Geometry,
        start: &Start,
        (length, target): (f64, Option<Target>),
        wanted: Accuracy,
    ) -> Result<Self, OutsideGeometry> {
        let operators = Collocation::shared(Family::Lobatto, POINTS);
        let [tolerance, accuracy] = of_windows(wanted);
        let solver = Solver::new(geometry, start, length, operators, true)?;
        Ok(Self {
            ladder: ladder(&solver, tolerance),
            between: Between::new(&solver),
            defect: Defect::new(&solver),
            barycentric: places::barycentric(&solver.rule),
            handed: None,
            is_shaken: false,
            length: if length.is_finite() || target.is_none() { length } else { solver.scales.time },
            lent: solver.into(),
            tolerance,
            accuracy,
            target,
            sweeps: 0,
            attempt: Attempt::default(),
        })
    }

    /// The same run from a start that is off by its last digits.
    pub(super) fn shaken(mut self) -> Self {
        self.is_shaken = true;
        self.settle();
        self
    }

    /// Puts the solver at the start.
    fn settle(&mut self) {
        let solver = &mut self.lent.solver;
        solver.begin();
        self.handed.iter().for_each(|handed| _ = solver.resume(handed, 0.0));
        if self.is_shaken {
            solver.shake();
            // It looks with the same constants.
            self.defect = Defect::new(solver);
        }
    }

    /// Goes back to the start, with another tolerance.
    pub(super) fn begin(&mut self, wanted: Accuracy) {
        let [tolerance, _] = of_windows(wanted);
        if tolerance != self.tolerance {
            (self.tolerance, self.ladder) = (tolerance, ladder(&self.lent.solver, tolerance));
        }
        self.rewind();
    }

    /// The error that a window may add at its end.
    fn share(&self) -> f64 {
        ALONE * self.tolerance
    }

    /// The reason of a failure: the motion may leave the domain soon.
    pub(super) fn reason(&mut self, failure: Failure) -> Failure {
        let (gamma, state) = match failure {
            Failure::Accuracy => (self.gamma_at_end(), &self.lent.solver.end),
            _ => (self.attempt.gamma.high, &self.lent.solver.start),
        };
        // Behind the end of the run there may be anything.
        let rest = match failure {
            Failure::Accuracy if self.attempt.accepted.is_last => 0.0,
            _ if self.target.is_some() => f64::INFINITY,
            _ => self.length - gamma,
        };
        let edge = AHEAD.into_iter().find_map(|windows| {
            let ahead = rest.min(windows * self.ladder.length(0));
            edge(self.lent.solver.geometry, state, &self.lent.solver.initial.p, ahead, gamma)
        });
        let (place, found) = match edge {
            Some((gamma, q, outside)) => ((gamma, q), Failure::OutsideDomain(outside)),
            None => ((gamma, state.positions()), failure),
        };
        self.attempt.failed_at = Some(place);
        found
    }

    /// Forgets a failure that was none, as is seen at the end.
    pub(super) fn forgive(&mut self) {
        self.attempt.failed_at = None;
    }

    /// γ at the end of the accepted window.
    pub(super) fn gamma_at_end(&self) -> f64 {
        self.attempt.gamma.high + self.attempt.accepted.length
    }

    /// True if the coordinate may come to the value in it, on the way to that `side`.
    pub(super) fn may_pass(&self, coordinate: usize, value: f64, side: f64) -> bool {
        let has_passed = |q: f64| (q - value) * side >= 0.0;
        let Solver { system, end, .. } = &self.lent.solver;
        let on_the_way = match self.lent.solver.place(coordinate) {
            Ok(place) => system.position(place).0.iter().any(|&q| has_passed(q)),
            // It may go there and back, if its rate changes its sign.
            Err(j) => self.lent.solver.rate_nodes(j).0.iter().any(|rate| rate * side <= 0.0),
        };
        on_the_way || has_passed(end.q[coordinate].high)
    }
}

/// The tolerance of windows, and the accuracy that they serve.
fn of_windows(wanted: Accuracy) -> [f64; 2] {
    let accuracy = if let Accuracy::Alone { accuracy, .. } = wanted { accuracy } else { wanted.value() };
    [wanted.value(), accuracy].map(|value| value.min(LOOSEST))
}

/// The lengths of windows for a tolerance, of which the first one suits the motion at its start.
fn ladder(solver: &Solver<'_, POINTS>, tolerance: f64) -> Ladder {
    Ladder::new(solver.system.order, FIRST * tolerance.powf(1.0 / 24.0) * solver.scales.time, tolerance < EXACT)
}

impl Windows for Adaptive<'_> {
    fn next(&mut self) -> Result<Option<Window<'_>>, Failure> {
        if self.attempt.windows > 0 {
            if self.attempt.accepted.is_last {
                return Ok(None);
            }
            if let Some(target) = self.target {
                self.attempt.rate = self.lent.solver.end_rate(target.coordinate);
            }
            self.lent.solver.advance();
            self.attempt.gamma = self.attempt.gamma.plus(self.attempt.accepted.length);
        }
        let least = self.least();
        if self.attempt.control.is_stuck(self.attempt.gamma.high, least) {
            return Err(self.reason(Failure::TooShort));
        }
        self.attempt.accepted = self.accept()?;
        self.land()?;
        self.attempt.windows += 1;
        Ok(Some(self.window()))
    }

    fn end_where(&mut self, between: [f64; 2], side: f64, value: OfState<'_>) -> Result<bool, Failure> {
        self.end_at_change(between, side, value)
    }

    fn set_floors(&mut self, floors: &[(usize, f64)]) {
        let solver = &mut self.lent.solver;
        solver.scales.raise(solver.geometry, &solver.initial, floors);
        self.settle();
    }

    fn window(&mut self) -> Window<'_> {
        let Accepted { length, is_last, swept: Swept { sweeps, .. }, .. } = self.attempt.accepted;
        let (index, gamma) = (self.attempt.windows - 1, self.attempt.gamma.high);
        Window { index, gamma, length, is_last, sweeps, solved: &mut self.lent }
    }

    fn sweeps(&self) -> usize {
        self.sweeps
    }

    fn rewind(&mut self) {
        self.settle();
        self.target = self.target.map(|it| Target::new(it.coordinate, it.value, it.from));
        (self.attempt, self.sweeps) = (Attempt::default(), 0);
    }

    fn resume(&mut self, handed: &Handed) {
        self.handed = Some(handed.clone());
        self.settle();
    }

    fn sizes(&self) -> Vec<f64> {
        self.lent.solver.sizes()
    }

    fn place(&self) -> (f64, Vec<f64>) {
        self.attempt.failed_at.clone().unwrap_or_else(|| (self.gamma_at_end(), self.lent.solver.end.positions()))
    }

    fn moved_by_rounding(&mut self) -> Vec<usize> {
        self.lent.solver.moved_by_rounding(self.attempt.accepted.length)
    }

    fn unresolved(&self) -> usize {
        self.attempt.unresolved
    }

    fn touched(&self) -> Option<f64> {
        self.attempt.touched
    }
}
