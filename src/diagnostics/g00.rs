//! g00 and its derivatives on the nodes of a run in t and x.

use crate::geometry::{Geometry, Samples, Source};
use crate::number::Real;

/// g00, g00′ and g00″ on the nodes.
#[derive(Clone, Copy)]
pub(super) struct G00<'s, S> {
    samples: &'s Samples<S>,
    sources: [Source<S>; 3],
}

impl<'s, S: Real> G00<'s, S> {
    pub(super) fn new(geometry: &Geometry<S>, samples: &'s Samples<S>) -> Self {
        Self { samples, sources: geometry.sources_of_g00() }
    }

    /// All three at node k of the run.
    pub(super) fn at(self, k: usize) -> [S; 3] {
        self.sources.map(|source| self.samples.at(source, k))
    }
}
