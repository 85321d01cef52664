//! Whether something steep may hide between the nodes of a window of one coordinate.

use super::attempt::Attempt;
use super::force::Force;
use super::judge::Judge;
use super::walk::{Length, Walk};
use super::{State, Statistics};
use crate::engine::enclosure::{Found, UNSEEN, negligible_potential};

/// Windows shorter than this part of the first are not cut any more.
const LEAST: f64 = 1e-9;

impl<const P: usize, F: Force> Walk<P, F> {
    /// Looks between the nodes of the window that was solved.
    fn look(&mut self, tolerances: impl FnOnce() -> Vec<f64>) -> Found {
        let Self { kit, window, enclosure, .. } = self;
        let Some(enclosure) = enclosure else { return Found::Nothing };
        let (nodes, a) = (kit.rule.nodes(), &window.a.0);
        enclosure.path.begin(kit.rule.points());
        enclosure.path.push(0, &window.x.0, |k| {
            let distance = nodes[k + 1].hi - nodes[k].hi;
            0.5 * distance * distance * (a[k] + a[k + 1])
        });
        enclosure.look(tolerances)
    }
}

impl Attempt<'_> {
    /// Whether the window from `start` that was solved is to be shortened, because something may hide in it. If that
    /// does not help any more, it is counted and taken as it is.
    pub(super) fn hides<const P: usize, F: Force>(
        &self,
        walk: &mut Walk<P, F>,
        (length, start): (Length, &State),
        judge: &Judge<'_>,
        statistics: &mut Statistics,
    ) -> bool {
        if walk.enclosure.is_none() || walk.look(|| self.negligible(start, judge)) == Found::Nothing {
            return false;
        }
        if length.h.hi > LEAST * self.first {
            return true;
        }
        statistics.unproved += 1;
        false
    }

    /// By how much V and V′ may change on all of the way without an effect.
    fn negligible(&self, start: &State, judge: &Judge<'_>) -> Vec<f64> {
        negligible_potential(self.metric, (self.q_t, start.x.hi), self.length, judge.sizes, UNSEEN * self.accuracy)
    }
}
