//! Where the sweeps over a window start.

use super::window::{FlowWindow, Known};
use super::work::Continue;
use crate::lobatto::simd::Level;
use crate::lobatto::tables::EXTRAPOLATED;

impl<const P: usize> FlowWindow<'_, P> {
    /// Puts a guess into the registers; whether it is a continuation of known rates.
    pub(super) fn guess(&mut self, h: f64) -> bool {
        // A polynomial is continued far with few of its degrees only.
        let degree = |known: &Known<P>| (EXTRAPOLATED as f64 / (h / known.length).max(1.0)) as usize;
        let (known, degree, begin) = match (&self.rejected, &self.previous) {
            (Some(known), _) => (known, self.points() - 1, 0.0),
            (None, Some(known)) => (known, degree(known), 1.0),
            (None, None) => {
                self.tangent();
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
        self.integrate_scratch();
        true
    }

    /// Puts the start into the registers, and with constant kinetic part the line of the free motion.
    pub(super) fn tangent(&mut self) {
        for (row, &register) in self.q_at.iter().chain(&self.p_at).enumerate() {
            let start = self.starts[row];
            let to = &mut self.registers[register].0;
            to.iter_mut().zip(&self.low[row].0).for_each(|(to, low)| *to = start + low);
        }
    }

    /// Integrates the rows in `scratch`: a guess.
    fn integrate_scratch(&mut self) {
        let rows = std::mem::take(&mut self.scratch);
        let tables = self.rule.tables;
        if self.geometry.is_separable() {
            self.integrate(&tables.a_squared[..], &rows[..self.m], true);
        } else {
            self.integrate(&tables.a[..], &rows[self.m..], false);
            self.integrate(&tables.a[..], &rows[..self.m], true);
        }
        self.scratch = rows;
    }
}
