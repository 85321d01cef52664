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

#[cfg(test)]
mod tests {
    use super::{FlowState, Request, Target};
    use crate::geometry::Start;

    #[test]
    fn an_even_motion_is_foreseen() {
        let q_dot = [1.0, -0.5];
        let start = FlowState::new(&Start { q: vec![7.0, 3.0], q_dot: q_dot.to_vec(), p: vec![1.0, 1.0] }, &[1]);
        let whole = |value: f64, length: f64, gamma: f64| {
            let target = Some(Target { coordinate: 1, value });
            let (q_dot, momenta) = (&q_dot, &[1.0, 1.0]);
            let start = start.clone();
            let here = FlowState { q: vec![7.0.into(), (3.0 - 0.5 * gamma).into()], ..start.clone() };
            let request = Request { start, q_dot, momenta, length, target, accuracy: 1e-6, certify: false };
            request.whole(gamma, &here)
        };
        for gamma in [0.0, 1.0, 5.0, 8.0] {
            assert_eq!(whole(-1.0, 100.0, gamma), 8.0);
            assert_eq!(whole(-1.0, 6.0, gamma), 6.0);
            // A value that lies behind is not foreseen.
            assert_eq!(whole(4.0, 100.0, gamma), 100.0);
        }
    }
}
