//! Windows of one length, one after the other.

use super::certificate::Certificate;
use super::rule::Tables;
use super::sizes::Sizes;
use super::window::{Known, Solver};
use super::{Failure, Window, Windows};
use crate::geometry::{Geometry, Start};
use crate::number::vector::{Matrix, Twofold};

/// The windows of a run with rules of up to N nodes.
pub(super) struct March<'g, const N: usize> {
    solver: Solver<'g, N>,
    tables: Tables<N>,
    continuation: Box<Matrix<N>>,
    certificate: Certificate<'g, N>,
    /// Number of windows, and of those that were solved.
    windows: usize,
    solved: usize,
}

impl<'g, const N: usize> March<'g, N> {
    /// Windows of length `h`, of `points` ≤ N nodes each.
    pub(super) fn new(
        geometry: &'g Geometry,
        (start, sizes): (&Start, &Sizes),
        (windows, h): (usize, Twofold),
        points: usize,
    ) -> Self {
        let mut solver = Solver::new(geometry, points, false);
        solver.begin(start, sizes);
        let order = solver.system.order;
        Self {
            tables: solver.rule.tables(order, h, true),
            continuation: solver.rule.matrix(order.power_of(h.hi), &solver.rule.continued(order, 1.0)),
            certificate: Certificate::new(geometry),
            windows,
            solved: 0,
            solver,
        }
    }
}

impl<const N: usize> Windows for March<'_, N> {
    fn next(&mut self) -> Result<Option<Window<'_>>, Failure> {
        let Self { solver, tables, .. } = self;
        if self.solved == self.windows {
            return Ok(None);
        }
        let continuation = (self.solved > 0).then(|| {
            solver.advance();
            &*self.continuation
        });
        // Sweeps go on until two changes in turn are rounding errors: ended early, they leave an error of one sign.
        let swept = match solver.solve(tables, continuation, 0.0) {
            // A guess may lie outside the domain.
            Err(_) if continuation.is_some() => solver.solve(tables, None, 0.0)?,
            solved => solved?,
        };
        solver.finish(tables, Known::All);
        let length = tables.length;
        let gradient_norm = Some(self.certificate.of(solver, length));
        let index = self.solved;
        self.solved += 1;
        Ok(Some(Window {
            index,
            gamma: index as f64 * length,
            length,
            sweeps: swept.sweeps,
            gradient_norm,
            solved: solver,
        }))
    }
}
