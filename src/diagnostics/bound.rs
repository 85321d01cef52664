//! The stability bound of the paper.

use crate::sbp::RegularisedOperator;
use crate::scalar::{Real, sum};
use crate::solve::{Solution, WindowView};

/// H_BVP = ∫ ½( g00 ṫ² + ẋ² ) dγ and its bound Q_t (t_f − t_i).
///
/// In the continuum H_BVP = Q_t (t_f − t_i) − ½ K (γ_f − γ_i), so the bound holds if and only if K ≥ 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bound<S = f64> {
    /// H_BVP by the operator's quadrature with the regularised velocities.
    pub h_bvp: S,
    /// Q_t (t_N − t_i).
    pub h_bvp_bound: S,
}

impl<S: Real> Bound<S> {
    /// From a solution and g00 on its nodes.
    pub(super) fn new(solution: &Solution<S>, g00: &[S]) -> Self {
        let nodes = solution.sbp.points();
        let of_window = |(window, g00): (WindowView<'_, S>, &[S])| {
            let t_dot = RegularisedOperator::new(window.sbp, S::ZERO).derivative(window.elapsed);
            let x_dot = RegularisedOperator::new(window.sbp, window.start.x).derivative(window.x);
            let integrand: Vec<S> =
                g00.iter().zip(&t_dot).zip(&x_dot).map(|((&g, &u), &w)| (g * u * u + w * w).half()).collect();
            window.sbp.integrate(&integrand)
        };
        let h_bvp = sum(solution.views().zip(g00.chunks_exact(nodes)).map(of_window));
        Self { h_bvp, h_bvp_bound: solution.invariants().q_t * solution.duration() }
    }
}
