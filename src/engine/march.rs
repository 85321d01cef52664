//! Windows of one length, one after the other.

use super::certificate::Certificate;
use super::rule::Tables;
use super::sizes::Sizes;
use super::window::Solver;
use super::{Failure, Window};
use crate::geometry::{Geometry, Start};
use crate::number::vector::Twofold;

/// The windows of a run with rules of up to N nodes.
pub(super) struct March<'g, const N: usize> {
    solver: Solver<'g, N>,
    tables: Tables<N>,
    certificate: Certificate<'g, N>,
    pub(super) window: Window,
}

impl<'g, const N: usize> March<'g, N> {
    /// Windows of length `h`, of `points` ≤ N nodes each.
    pub(super) fn new(geometry: &'g Geometry, start: &Start, sizes: &Sizes, h: Twofold, points: usize) -> Self {
        let solver = Solver::new(geometry, start, sizes, points);
        Self {
            tables: solver.rule.tables(solver.system.order, h),
            certificate: Certificate::new(geometry),
            window: Window::new(geometry, points),
            solver,
        }
    }

    /// Solves the next window.
    ///
    /// # Errors
    /// As [`Engine::next`](super::Engine::next).
    pub(super) fn next(&mut self) -> Result<&Window, Failure> {
        let Self { solver, tables, certificate, window } = self;
        // Sweeps go on until two changes in turn are rounding errors: ended early, they leave an error of one sign.
        window.sweeps = solver.solve(tables, 0.0)?.sweeps;
        solver.finish(tables);
        window.gradient_norm = certificate.of(solver, tables.length);
        window.take(solver);
        solver.advance();
        Ok(window)
    }
}
