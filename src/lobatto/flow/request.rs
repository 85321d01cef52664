//! What is asked of a march.

use super::state::FlowState;
use super::stop::{PhasePoint, Stop};

/// A coordinate and the value with which a run ends.
#[derive(Debug, Clone, Copy)]
pub(super) struct Target {
    pub(super) coordinate: usize,
    pub(super) value: f64,
}

impl Stop for Target {
    fn value(&mut self, point: PhasePoint<'_>) -> f64 {
        point.q[self.coordinate] - self.value
    }

    fn counts(&self, _: bool) -> bool {
        true
    }
}

/// What is asked for.
pub(super) struct Request<'r> {
    pub(super) start: FlowState,
    /// dq^a/dγ and p_a of all coordinates at the start.
    pub(super) q_dot: &'r [f64],
    pub(super) momenta: &'r [f64],
    /// γ at most; may be infinite.
    pub(super) length: f64,
    pub(super) target: Option<Target>,
    pub(super) accuracy: f64,
    pub(super) certify: bool,
}

impl Request<'_> {
    /// How long a run is that has come to `state` after `gamma`: a target goes on coming nearer at its pace so far.
    pub(super) fn whole(&self, gamma: f64, state: &FlowState) -> f64 {
        let Some(Target { coordinate, value }) = self.target else { return self.length };
        let here = state.q[coordinate].hi;
        let elapsed = here - self.start.q[coordinate].hi;
        let rest = (value - here) * if gamma > 0.0 { gamma / elapsed } else { 1.0 / self.q_dot[coordinate] };
        if rest >= 0.0 { (gamma + rest).min(self.length) } else { self.length }
    }
}
