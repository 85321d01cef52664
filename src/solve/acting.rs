//! Events that act: where a formula changes its sign the state is changed, and another run goes on from there.

use crate::geometry::{Geometry, Observable, Start};

/// A quantity of the state, by the index of its coordinate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// q^a.
    Position(usize),
    /// dq^a/dγ.
    Velocity(usize),
    /// p_a.
    Momentum(usize),
    /// A parameter of the scene, by its place there.
    Parameter(usize),
}

/// The change of the state that an event makes. What is not set stays: positions and velocities or, where momenta are
/// set, the other momenta.
#[derive(Debug, Clone)]
pub struct Change {
    /// The name of the event.
    pub name: String,
    /// The quantities that are set, and their formulas in the state before.
    pub set: Vec<(Quantity, Observable)>,
    /// True in the lift of Newton's law, where the velocity of the last coordinate, s, keeps K at 0.
    pub is_lifted: bool,
}

impl Change {
    /// Evaluates what the event sets in this state, where K was `norm` at the start of the run.
    pub(crate) fn values(&mut self, before: &Start, norm: f64) -> Vec<(Quantity, f64)> {
        let Start { q, q_dot, p } = before;
        self.set.iter_mut().map(|(quantity, formula)| (*quantity, formula.at(q, q_dot, p, norm))).collect()
    }

    /// The state after the event, which sets these values, in the geometry that holds from there on; `None` outside of
    /// its domain.
    pub(crate) fn of(&self, geometry: &Geometry, before: &Start, values: &[(Quantity, f64)]) -> Option<Start> {
        let Start { mut q, mut q_dot, mut p } = before.clone();
        let has_momenta = values.iter().any(|(quantity, _)| matches!(quantity, Quantity::Momentum(_)));
        for &(quantity, value) in values {
            match quantity {
                Quantity::Position(a) => q[a] = value,
                Quantity::Velocity(a) => q_dot[a] = value,
                Quantity::Momentum(a) => p[a] = geometry.seen(a, value),
                Quantity::Parameter(_) => {}
            }
        }
        if has_momenta {
            q_dot = geometry.velocities(&q, &p).ok()?;
        }
        if self.is_lifted {
            let s = q.len() - 1;
            let mut k = |s_dot: f64| {
                q_dot[s] = s_dot;
                geometry.norm(&q, &q_dot)
            };
            let (at_zero, at_one) = (k(0.0), k(1.0));
            q_dot[s] = -at_zero / (at_one - at_zero);
        }
        if self.is_lifted || !has_momenta {
            p = geometry.momenta(&q, &q_dot);
        }
        let is_finite = q.iter().chain(&q_dot).chain(&p).all(|value| value.is_finite());
        (is_finite && geometry.point().evaluate(&q, &p).is_ok()).then_some(Start { q, q_dot, p })
    }
}
