//! A point of a world-line in phase space.

use crate::engine::lobatto::Twofold;
use crate::geometry::Start;

/// All positions and the momenta of active coordinates, each an unevaluated sum.
#[derive(Debug, Default, PartialEq)]
pub struct FlowState {
    /// q^a of all coordinates.
    pub q: Vec<Twofold>,
    /// p_a of the active coordinates, in order.
    pub p: Vec<Twofold>,
}

impl Clone for FlowState {
    fn clone(&self) -> Self {
        Self { q: self.q.clone(), p: self.p.clone() }
    }

    /// Keeps its memory.
    fn clone_from(&mut self, other: &Self) {
        self.q.clone_from(&other.q);
        self.p.clone_from(&other.p);
    }
}

impl FlowState {
    /// The start of a world-line.
    pub fn new(start: &Start, active: &[usize]) -> Self {
        let q = start.q.iter().map(|&q| q.into()).collect();
        Self { q, p: active.iter().map(|&a| start.p[a].into()).collect() }
    }

    pub(super) fn is_finite(&self) -> bool {
        self.q.iter().chain(&self.p).all(|value| value.hi.is_finite())
    }
}

#[cfg(test)]
mod tests {
    use super::FlowState;

    #[test]
    fn a_state_is_finite_in_all_of_its_numbers() {
        let state = |q: f64, p: f64| FlowState { q: vec![1.0.into(), q.into()], p: vec![p.into()] };
        assert!(state(-1e300, 0.0).is_finite());
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert!(!state(bad, 0.0).is_finite() && !state(0.0, bad).is_finite());
        }
    }
}
