//! Where the sweeps over a window start.

use super::state::FlowState;
use super::window::FlowWindow;
use super::work::Continue;
use crate::lobatto::simd::Level;
use crate::lobatto::tables::EXTRAPOLATED;

impl<const P: usize> FlowWindow<'_, P> {
    /// Puts a guess into the registers; whether it is a continuation of known rates.
    pub(super) fn guess(&mut self, start: &FlowState, h: f64) -> bool {
        let (known, degree, begin) = match (&self.rejected, &self.previous) {
            (Some(known), _) => (known, self.points() - 1, 0.0),
            (None, Some(known)) => (known, EXTRAPOLATED, 1.0),
            (None, None) => {
                self.tangent(start, h);
                return false;
            }
        };
        let unit = self.rule.unit;
        let ratio = h / known.length;
        let mut from = unit.continuation(degree, begin, ratio);
        from.factor = ratio;
        if self.geometry.is_separable() {
            // These rows are h² q̈; the others are not used.
            from.factor = ratio * ratio;
        }
        let rows = if self.geometry.is_separable() { self.m } else { 2 * self.m };
        let out = &mut self.scratch[..rows];
        Level::Best.dispatch(Continue { from: &from, tables: &unit.tables, rows: &known.rates[..rows], out });
        self.prepare(start, h, None);
        self.integrate_scratch();
        true
    }

    /// Puts the tangent at the start into the registers.
    pub(super) fn tangent(&mut self, start: &FlowState, h: f64) {
        for (place, (&q_at, &p_at)) in self.q_at.iter().zip(&self.p_at).enumerate() {
            self.registers[q_at].0 = [start.q[q_at].hi; P];
            self.registers[p_at].0 = [start.p[place].hi; P];
        }
        self.evaluate_sweep(h, false);
        self.evaluate_velocities(h, false);
        for (to, from) in self.scratch.iter_mut().zip(&self.rows.rates) {
            to.0 = from.0;
        }
        self.prepare(start, h, None);
        self.integrate_scratch();
    }

    /// Integrates the rows in `scratch`: a guess.
    fn integrate_scratch(&mut self) {
        let rows = std::mem::take(&mut self.scratch);
        let own = &self.rule.tables.own;
        if self.geometry.is_separable() {
            self.integrate(&own.a_squared[..], &rows[..self.m], true);
        } else {
            self.integrate(&own.a[..], &rows[self.m..], false);
            self.integrate(&own.a[..], &rows[..self.m], true);
        }
        self.scratch = rows;
    }
}
