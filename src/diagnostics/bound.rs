//! The paper's stability bound on H_BVP.

use super::g00::G00;
use crate::number::{Real, sum};
use crate::sbp::RegularisedOperator;
use crate::solve::{Solution, WindowNodes};

/// H_BVP = ∫ ½( g00 ṫ² + ẋ² ) dγ and its bound Q_t (t_f − t_i).
///
/// In the continuum H_BVP = Q_t (t_f − t_i) − ½ K (γ_f − γ_i), so the bound holds if and only if K ≥ 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bound<S = f64> {
    /// H_BVP by the operator's quadrature with the regularised velocities.
    pub h_bvp: S,
    /// Q_t (t_N − t_i).
    pub h_bvp_bound: S,
    /// ½ K (γ_f − γ_i), the distance of H_BVP from its bound in the continuum.
    pub distance: S,
}

/// The relative excess over the bound that is put down to rounding. A world-line with K = 0 meets its bound exactly, so
/// that rounding alone can take it beyond.
const ROUNDING: f64 = 1e-12;

impl<S: Real> Bound<S> {
    /// Returns true if H_BVP ≤ Q_t (t_N − t_i) on the grid.
    pub fn is_kept(&self) -> bool {
        let allowed = S::from(ROUNDING) * self.h_bvp_bound.abs();
        self.h_bvp <= self.h_bvp_bound + allowed
    }

    /// H_BVP − Q_t (t_N − t_i) + ½ K (γ_f − γ_i), which is 0 in the continuum.
    pub fn defect(&self) -> S {
        (self.h_bvp - self.h_bvp_bound) + self.distance
    }

    /// From a solution and g00 on its nodes.
    pub(super) fn new(solution: &Solution<S>, g00: G00<'_, S>) -> Self {
        let (mut t_dot, mut x_dot) = (Vec::new(), Vec::new());
        let of_window = |view: WindowNodes<'_, S>| {
            for room in [&mut t_dot, &mut x_dot] {
                room.resize(view.grid.points(), S::ZERO);
            }
            RegularisedOperator::new(view.grid.sbp(), S::ZERO).apply(view.row(0), &mut t_dot);
            RegularisedOperator::new(view.grid.sbp(), view.start.q[1]).apply(view.row(1), &mut x_dot);
            for ((u, &w), node) in t_dot.iter_mut().zip(&x_dot).zip(view.grid.nodes()) {
                let [g, ..] = g00.at(node);
                *u = (g * *u * *u + w * w).half();
            }
            view.grid.sbp().integrate(&t_dot)
        };
        let h_bvp = sum(solution.views().map(of_window));
        let begun = solution.joint(0).q[0];
        let length = solution.windows.last().map_or(S::ZERO, |window| window.gamma[1])
            - solution.windows.first().map_or(S::ZERO, |window| window.gamma[0]);
        let (q_t, k) = (solution.q_t(), solution.norm());
        let h_bvp_bound = q_t * (solution.duration() - begun);
        Self { h_bvp, h_bvp_bound, distance: (k * length).half() }
    }

    /// The sums over a run, from those over its first part, `self`, and its second part, `next`.
    pub(super) fn followed_by(self, next: Self) -> Self {
        Self {
            h_bvp: self.h_bvp + next.h_bvp,
            h_bvp_bound: self.h_bvp_bound + next.h_bvp_bound,
            distance: self.distance + next.distance,
        }
    }
}
