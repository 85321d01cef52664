//! The regularised (null-space consistent) operator D̄.
//!
//! D annihilates the constants, and its interior stencil also annihilates the π-mode (−1)^k. Only the boundary rows
//! respond to that mode, so that it hardly contributes to an action built from D. Such an action has wrong critical
//! points or none. Rothkopf & Nordström add the initial value as a penalty,
//!
//! ```text
//! D̄x = Dx + H⁻¹E_0 (x − x_i)      (σ_0 = −1 in their notation)
//! ```
//!
//! which is affine in x. In affine coordinates it is an (N+1)×(N+1) matrix that acts on (x, 1).

use super::SbpOperator;
use crate::number::Real;

/// D̄ for one coordinate with its initial value.
#[derive(Debug, Clone, Copy)]
pub struct RegularisedOperator<'a, S = f64> {
    sbp: &'a SbpOperator<S>,
    initial_value: S,
    /// 1/H_1, or 0 without the regularisation.
    penalty: S,
}

impl<'a, S: Real> RegularisedOperator<'a, S> {
    /// D̄ = D + H⁻¹E_0(· − `initial_value`).
    pub fn new(sbp: &'a SbpOperator<S>, initial_value: S) -> Self {
        Self { sbp, initial_value, penalty: S::ONE / sbp.weights()[0] }
    }

    /// D itself in place of D̄, to show what the regularisation is for.
    pub fn without_regularisation(sbp: &'a SbpOperator<S>) -> Self {
        Self { sbp, initial_value: S::ZERO, penalty: S::ZERO }
    }

    /// Writes D̄`u` into `out`; both have length N.
    pub fn apply(&self, u: &[S], out: &mut [S]) {
        self.sbp.apply(u, out);
        out[0] += self.penalty * (u[0] - self.initial_value);
    }

    /// Writes D̄_linᵀ H `v` into `out`, where D̄_lin = D + H⁻¹E_0 is the linear part. With the regularisation the
    /// result is −HDv + E_N v.
    pub fn apply_transpose_weighted(&self, v: &[S], out: &mut [S]) {
        self.sbp.apply_transpose_weighted(v, out);
        out[0] += self.penalty * self.sbp.weights()[0] * v[0];
    }

    /// The entries of row k of the linear part D̄_lin as (column, coefficient). Its pattern is that of D with the first
    /// diagonal entry added.
    pub fn row(&self, k: usize) -> impl Iterator<Item = (usize, S)> + '_ {
        let penalty = if k == 0 { self.penalty } else { S::ZERO };
        self.sbp.row(k).chain((k == 0).then_some((0, penalty)))
    }
}
