//! Where the sweeps over a window start.

use super::window::{FlowWindow, Known};
use super::work::Continue;
use crate::engine::lobatto::tables::EXTRAPOLATED;
use crate::number::vector::Level;

impl<const P: usize> FlowWindow<'_, P> {
    /// Puts a guess into the registers; whether it is a continuation of known rates.
    pub(super) fn guess(&mut self, h: f64) -> bool {
        // A polynomial is continued far with few of its degrees only.
        let degree = |known: &Known<P>| (EXTRAPOLATED as f64 / (h / known.length).max(1.0)) as usize;
        let (known, degree, begin) = match (&self.rejected, &self.previous) {
            (Some(known), _) => (known, self.points() - 1, 0.0),
            (None, Some(known)) => (known, degree(known), 1.0),
            (None, None) => {
                self.unknowns.tangent();
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
        self.unknowns.start_from(out);
        true
    }
}
