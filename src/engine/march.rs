//! Windows of one length, one after the other.

use super::ladder::continued;
use super::rule::{Continuation, Tables};
use super::view::Lent;
use super::window::{Known, Solver};
use super::{Failure, Handed, Window, Windows};
use crate::geometry::{Geometry, OutsideGeometry, Start};
use crate::number::Compensated;
use crate::sbp::collocation::Collocation;

/// The windows of a run with a rule of up to N nodes.
pub(super) struct March<'g, const N: usize> {
    lent: Lent<'g, N>,
    tables: Tables<N>,
    continuation: Continuation<N>,
    /// Sweeps leave no more, relative to sizes.
    tolerance: f64,
    /// Number of windows, and of those that were solved.
    windows: usize,
    solved: usize,
    /// True if the slopes before the first window are known.
    is_resumed: bool,
    /// True if the next window has no solution.
    has_failed: bool,
    /// Number of sweeps over the last one, and over all.
    last: usize,
    sweeps: usize,
}

impl<'g, const N: usize> March<'g, N> {
    /// So many windows over a run of this length. A tolerance of 0 stands for rounding.
    pub(super) fn new(
        geometry: &'g Geometry,
        start: &Start,
        (length, windows): (f64, usize),
        operators: &'static Collocation,
        tolerance: f64,
    ) -> Result<Self, OutsideGeometry> {
        let h = Compensated::from(length) / Compensated::from(windows as f64);
        let solver = Solver::new(geometry, start, length, operators, false)?;
        let (order, rule) = (solver.system.order, &solver.rule);
        Ok(Self {
            tables: rule.tables(order, h, true),
            continuation: rule.continuation(order.power_of(h.high), continued(rule, order, 0)),
            tolerance,
            windows,
            solved: 0,
            is_resumed: false,
            has_failed: false,
            last: 0,
            sweeps: 0,
            lent: solver.into(),
        })
    }
}

impl<const N: usize> Windows for March<'_, N> {
    fn next(&mut self) -> Result<Option<Window<'_>>, Failure> {
        let Self { lent: Lent { solver, .. }, tables, tolerance, .. } = self;
        if self.solved == self.windows {
            return Ok(None);
        }
        if self.solved > 0 {
            solver.advance();
        }
        let continuation = (self.solved > 0 || self.is_resumed).then_some(&self.continuation);
        // Sweeps to rounding go on until two changes in turn are no more than that: ended early, they leave an error of
        // one sign.
        let swept = match solver.solve(tables, continuation, *tolerance) {
            // A guess may lie outside the domain.
            Err(_) if continuation.is_some() => solver.solve(tables, None, *tolerance),
            solved => solved,
        };
        self.has_failed = swept.is_err();
        let swept = swept?;
        solver.finish(tables, Known::Ends);
        (self.last, self.sweeps, self.solved) = (swept.sweeps, self.sweeps + swept.sweeps, self.solved + 1);
        Ok(Some(self.window()))
    }

    fn window(&mut self) -> Window<'_> {
        let Self { lent, tables, solved, last, .. } = self;
        let (index, length) = (*solved - 1, tables.length);
        let is_last = *solved == self.windows;
        Window { index, gamma: index as f64 * length, length, is_last, sweeps: *last, solved: lent }
    }

    fn sweeps(&self) -> usize {
        self.sweeps
    }

    fn rewind(&mut self) {
        self.lent.solver.begin();
        (self.solved, self.is_resumed, self.has_failed, self.last, self.sweeps) = (0, false, false, 0, 0);
    }

    fn resume(&mut self, handed: &Handed) {
        self.is_resumed = self.lent.solver.resume(handed, self.tables.length);
    }

    fn sizes(&self) -> Vec<f64> {
        self.lent.solver.sizes()
    }

    fn place(&self) -> (f64, Vec<f64>) {
        let Self { lent: Lent { solver, .. }, tables, .. } = self;
        let state = if self.has_failed { &solver.start } else { &solver.end };
        (self.solved as f64 * tables.length, state.positions())
    }
}
