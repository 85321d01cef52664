//! Some nodes of a run that is handed out part by part, evenly over it.

use crate::number::Real;
use crate::solve::WorldLine;
use crate::trajectory::Sample;

/// From half as many to so many nodes are kept, and all of a run that has no more.
const KEPT: usize = 1 << 14;

/// The nodes that are kept, of which only γ and places are looked at.
#[derive(Debug)]
pub(super) struct SomeNodes<S> {
    /// Every so manieth is kept.
    stride: usize,
    /// The number of nodes before the next one that is kept.
    skip: usize,
    pub(super) seen: Vec<Sample<S>>,
}

impl<S> Default for SomeNodes<S> {
    fn default() -> Self {
        Self { stride: 1, skip: 0, seen: Vec::new() }
    }
}

impl<S: Real> SomeNodes<S> {
    /// Sees a part of a run. It must continue the previous one or, if it contains the first window, begins the run
    /// again.
    pub(super) fn see(&mut self, part: &WorldLine<S>) {
        if part.window_count == part.windows.len() {
            *self = Self::default();
        }
        let mut rows: Vec<_> = (0..part.geometry().dimension()).map(|a| part.q(a)).collect();
        for gamma in part.gamma() {
            let q = rows.iter_mut().filter_map(Iterator::next);
            if self.skip > 0 {
                q.for_each(drop);
                self.skip -= 1;
                continue;
            }
            self.seen.push(Sample { gamma, q: q.collect(), q_dot: Vec::new(), p: Vec::new() });
            self.skip = self.stride - 1;
            if self.seen.len() == KEPT {
                let mut place = 0;
                self.seen.retain(|_| {
                    place += 1;
                    place % 2 == 1
                });
                self.skip += self.stride;
                self.stride *= 2;
            }
        }
    }
}
