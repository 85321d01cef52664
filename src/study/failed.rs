//! Why there is no run, and what there is of it.

use std::fmt;

use crate::diagnostics::Diagnostics;
use crate::number::Real;
use crate::solve::{NoSolution, WorldLine};
use crate::trajectory::{Crossing, NoSamples, Sample};

/// A piece of a run, and what was measured on its nodes.
pub type Part<S> = (WorldLine<S>, Diagnostics<S>);

/// A run before its failure.
pub struct Before<S: Real> {
    /// Its pieces, the last one as far as it came; of a run that is streamed its last windows.
    pub parts: Vec<Part<S>>,
    /// The events of the case, in the order of γ.
    pub events: Vec<Crossing<S>>,
    /// The samples that were asked for.
    pub samples: Vec<Sample<S>>,
}

/// A million nodes are no message.
impl<S: Real> fmt::Debug for Before<S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let windows = self.parts.last().map_or(0, |(line, _)| line.window_count);
        f.debug_struct("Before").field("windows", &windows).field("events", &self.events.len()).finish_non_exhaustive()
    }
}

/// Why there is no run.
#[derive(Debug)]
pub enum NoRun<S: Real> {
    /// It was not solved, with what there is before the failure.
    Unsolved(NoSolution, Before<S>),
    /// It has no such samples.
    Unsampled(NoSamples<S>),
}
