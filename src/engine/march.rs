//! Windows of one length, one after the other.

use super::ladder::continued;
use super::rule::{Rule, Tables};
use super::sizes::Sizes;
use super::window::{Known, Solver};
use super::{Failure, Handed, Window, Windows};
use crate::geometry::{Geometry, Start};
use crate::number::vector::{Matrix, Twofold};

/// The windows of a run with a rule of up to N nodes.
pub(super) struct March<'g, const N: usize> {
    solver: Solver<'g, N>,
    start: Start,
    sizes: Sizes,
    tables: Tables<N>,
    continuation: Box<Matrix<N>>,
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
    /// Windows of length `h`. A tolerance of 0 stands for rounding.
    pub(super) fn new(
        geometry: &'g Geometry,
        (start, sizes): (&Start, Sizes),
        (windows, h): (usize, Twofold),
        rule: Rule<N>,
        tolerance: f64,
    ) -> Self {
        let mut solver = Solver::new(geometry, rule, false);
        solver.begin(start, &sizes);
        let (order, rule) = (solver.system.order, &solver.rule);
        Self {
            tables: rule.tables(order, h, true),
            continuation: rule.matrix(order.power_of(h.hi), continued(rule, order, 0)),
            tolerance,
            windows,
            solved: 0,
            is_resumed: false,
            has_failed: false,
            last: 0,
            sweeps: 0,
            start: start.clone(),
            sizes,
            solver,
        }
    }
}

impl<const N: usize> Windows for March<'_, N> {
    fn next(&mut self) -> Result<Option<Window<'_>>, Failure> {
        let Self { solver, tables, tolerance, .. } = self;
        if self.solved == self.windows {
            return Ok(None);
        }
        if self.solved > 0 {
            solver.advance();
        }
        let continuation = (self.solved > 0 || self.is_resumed).then_some(&*self.continuation);
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
        let Self { solver, tables, solved, last, .. } = self;
        let (index, length) = (*solved - 1, tables.length);
        let is_last = *solved == self.windows;
        Window { index, gamma: index as f64 * length, length, is_last, sweeps: *last, solved: solver }
    }

    fn sweeps(&self) -> usize {
        self.sweeps
    }

    fn rewind(&mut self) {
        self.solver.begin(&self.start, &self.sizes);
        (self.solved, self.is_resumed, self.has_failed, self.last, self.sweeps) = (0, false, false, 0, 0);
    }

    fn resume(&mut self, handed: &Handed) {
        self.is_resumed = self.solver.resume(handed, self.tables.length);
    }

    fn sizes(&self) -> Vec<f64> {
        self.solver.sizes()
    }

    fn place(&self) -> (f64, Vec<f64>) {
        let Self { solver, tables, .. } = self;
        let state = if self.has_failed { &solver.start } else { &solver.end };
        (self.solved as f64 * tables.length, state.positions())
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{kerr, lifted};
    use super::super::{Engine, State};
    use crate::geometry::{Geometry, Start};

    fn end((geometry, start): &(Geometry, Start), length: f64, steps: usize, stages: usize) -> State {
        let mut engine = Engine::gauss(geometry, start, length, steps, stages, 0.0).unwrap();
        let mut end = None;
        while let Some(window) = engine.next().unwrap() {
            end = Some(window.end().clone());
        }
        end.unwrap()
    }

    fn distance(one: &State, other: &State) -> f64 {
        let values = |state: &State| [state.positions(), state.momenta()].concat();
        values(one).iter().zip(values(other)).fold(0.0, |most, (a, b)| f64::max(most, (a - b).abs()))
    }

    /// An orbit in the potential of Hénon and Heiles.
    fn henon_heiles() -> (Geometry, Start) {
        lifted("(x^2 + y^2)/2 + x^2*y - y^3/3", &["x", "y"], &[0.1, 0.2], &[0.3, -0.1])
    }

    #[test]
    fn gauss_is_of_order_two_s() {
        for (scene, length) in [(henon_heiles(), 12.0), (kerr(), 8.0)] {
            let exact = end(&scene, length, 40, 12);
            for (stages, steps) in [(1, 80), (2, 30), (3, 16), (4, 10)] {
                let errors = [steps, 2 * steps].map(|steps| distance(&end(&scene, length, steps, stages), &exact));
                let order = (errors[0] / errors[1]).log2();
                assert!((order - 2.0 * stages as f64).abs() < 0.7, "{stages} stages: {order}, {errors:?}");
            }
        }
    }

    /// A symmetric method goes back the same way.
    #[test]
    fn gauss_is_reversible() {
        let (geometry, start) = henon_heiles();
        let there = end(&(geometry.clone(), start.clone()), 100.0, 300, 4);
        let mut turned = Start { q: there.positions(), q_dot: Vec::new(), p: start.p.iter().map(|p| -p).collect() };
        geometry.active().iter().zip(there.momenta()).for_each(|(&a, p)| turned.p[a] = -p);
        let back = end(&(geometry.clone(), turned), 100.0, 300, 4);
        let off = geometry.active().iter().map(|&a| (back.positions()[a] - start.q[a]).abs()).fold(0.0, f64::max);
        assert!(off < 1e-13, "{off:e}");
    }
}
