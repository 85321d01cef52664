//! The doubled geodesic action E_IVP of the paper, its gradient and its sparse Hessian.
//!
//! ```text
//! F(t, x) = ½{ (D̄t)ᵀ g00(x) H (D̄t) − (D̄x)ᵀ H (D̄x) }
//! E_IVP   = F(t₁, x₁) − F(t₂, x₂)
//!         + λ1 (t₁[1] − t_i) + λ2 ((Dt₁)[1] − ṫ_i) + λ3 (x₁[1] − x_i) + λ4 ((Dx₁)[1] − ẋ_i)
//!         + λ5 (t₁[N] − t₂[N]) + λ6 (x₁[N] − x₂[N])
//!         + λ7 ((Dt₁)[N] − (Dt₂)[N]) + λ8 ((Dx₁)[N] − (Dx₂)[N])
//! ```
//!
//! Forward branch 1 carries the initial data, backward branch 2 is tied to it at the end. Nothing in this module
//! knows an equation of motion: a trajectory is wherever ∇E_IVP = 0. (H̄ of the paper is H with a zero row and column
//! for the affine entry, so the affine entry never contributes.)

mod hessian;
mod layout;

pub use hessian::{HessianPattern, SparseHessian};
pub use layout::{Layout, MULTIPLIERS};

use crate::geodesic::InitialData;
use crate::metric::{Metric, MetricSamples, OutsideDomain};
use crate::norm::max_abs;
use crate::sbp::{RegularisedOperator, SbpOperator};
use crate::scalar::{Real, sum};

/// E_IVP for one grid, metric and set of initial data, in 4N + 8 unknowns (see [`Layout`]).
#[derive(Debug, Clone)]
pub struct DoubledAction<'a, S = f64> {
    sbp: &'a SbpOperator<S>,
    metric: &'a Metric<S>,
    initial: InitialData<S>,
    bar_t: RegularisedOperator<'a, S>,
    bar_x: RegularisedOperator<'a, S>,
}

/// What one branch contributes at a point: the metric along it and its regularised velocities.
struct BranchState<S> {
    metric: MetricSamples<S>,
    t_dot: Vec<S>,
    x_dot: Vec<S>,
}

impl<S: Real> BranchState<S> {
    fn zeros(points: usize) -> Self {
        Self { metric: MetricSamples::zeros(points), t_dot: vec![S::ZERO; points], x_dot: vec![S::ZERO; points] }
    }
}

impl<'a, S: Real> DoubledAction<'a, S> {
    /// The action with the regularised operators D̄.
    pub fn new(sbp: &'a SbpOperator<S>, metric: &'a Metric<S>, initial: InitialData<S>) -> Self {
        let bar_t = RegularisedOperator::new(sbp, initial.t);
        let bar_x = RegularisedOperator::new(sbp, initial.x);
        Self { sbp, metric, initial, bar_t, bar_x }
    }

    /// The ablation: the same action with D in place of D̄. It has wrong critical points or none.
    pub fn without_regularisation(sbp: &'a SbpOperator<S>, metric: &'a Metric<S>, initial: InitialData<S>) -> Self {
        let plain = RegularisedOperator::without_regularisation(sbp);
        Self { sbp, metric, initial, bar_t: plain, bar_x: plain }
    }

    /// Where each unknown lives.
    pub fn layout(&self) -> Layout {
        Layout::new(self.sbp.points())
    }

    /// The SBP operator the action is built on.
    pub fn sbp(&self) -> &'a SbpOperator<S> {
        self.sbp
    }

    /// The initial data that the multipliers λ1 … λ4 enforce.
    pub fn initial(&self) -> InitialData<S> {
        self.initial
    }

    fn branch(&self, t: &[S], x: &[S]) -> Result<BranchState<S>, OutsideDomain> {
        let mut state = BranchState::zeros(t.len());
        self.branch_into(t, x, &mut state)?;
        Ok(state)
    }

    fn branch_into(&self, t: &[S], x: &[S], state: &mut BranchState<S>) -> Result<(), OutsideDomain> {
        self.bar_t.apply(t, &mut state.t_dot);
        self.bar_x.apply(x, &mut state.x_dot);
        self.metric.sample_into(x, &mut state.metric)
    }

    fn both_branches(&self, u: &[S]) -> Result<[BranchState<S>; 2], OutsideDomain> {
        let [forward, backward] = self.layout().branches(u);
        Ok([self.branch(forward.t, forward.x)?, self.branch(backward.t, backward.x)?])
    }

    /// The eight constraints C_j that the multipliers λ_j enforce, in order.
    pub fn constraints(&self, u: &[S]) -> [S; MULTIPLIERS] {
        let [b1, b2] = self.layout().branches(u);
        let last = self.sbp.points() - 1;
        let row = |k: usize, u: &[S]| self.sbp.derivative_at(u, k);
        [
            b1.t[0] - self.initial.t,
            row(0, b1.t) - self.initial.t_dot,
            b1.x[0] - self.initial.x,
            row(0, b1.x) - self.initial.x_dot,
            b1.t[last] - b2.t[last],
            b1.x[last] - b2.x[last],
            row(last, b1.t) - row(last, b2.t),
            row(last, b1.x) - row(last, b2.x),
        ]
    }

    /// E_IVP(u).
    ///
    /// # Errors
    /// [`OutsideDomain`] if g00 is not positive and finite at a node of either branch.
    pub fn value(&self, u: &[S]) -> Result<S, OutsideDomain> {
        let [forward, backward] = self.both_branches(u)?.map(|branch| {
            let integrand = (branch.metric.g00.iter().zip(&branch.t_dot).zip(&branch.x_dot))
                .map(|((&g00, &t_dot), &x_dot)| (g00 * t_dot * t_dot - x_dot * x_dot).half())
                .collect::<Vec<_>>();
            self.sbp.integrate(&integrand)
        });
        let constraints = self.constraints(u);
        let multipliers = self.layout().multipliers(u);
        Ok(forward - backward + sum(multipliers.iter().zip(constraints).map(|(&lambda, c)| lambda * c)))
    }

    /// `out` = ∇E_IVP(u), all 4N + 8 entries: the derivative with respect to the branches, then the constraints.
    ///
    /// # Errors
    /// [`OutsideDomain`] if g00 is not positive and finite at a node of either branch.
    pub fn gradient(&self, u: &[S], out: &mut [S]) -> Result<(), OutsideDomain> {
        let layout = self.layout();
        let constraints = self.constraints(u);
        let lambda = layout.multipliers(u);
        // One branch after the other, in the same room.
        let mut state = BranchState::zeros(self.sbp.points());
        let parts = layout.branches(u).into_iter().zip(layout.branches_mut(out));
        for (sign, (branch, out)) in [S::ONE, -S::ONE].into_iter().zip(parts) {
            self.branch_into(branch.t, branch.x, &mut state)?;
            self.branch_gradient(&mut state, sign, out.t, out.x);
        }
        let last = self.sbp.points() - 1;
        let [b1, b2] = layout.branches_mut(out);
        b1.t[0] += lambda[0];
        b1.x[0] += lambda[2];
        for (sign, branch) in [(S::ONE, &mut *b1.t), (-S::ONE, &mut *b2.t)] {
            branch[last] += sign * lambda[4];
            self.add_row(last, sign * lambda[6], branch);
        }
        for (sign, branch) in [(S::ONE, &mut *b1.x), (-S::ONE, &mut *b2.x)] {
            branch[last] += sign * lambda[5];
            self.add_row(last, sign * lambda[7], branch);
        }
        self.add_row(0, lambda[1], b1.t);
        self.add_row(0, lambda[3], b1.x);
        layout.multipliers_mut(out).copy_from_slice(&constraints);
        Ok(())
    }

    /// `out` += `factor` · Dᵀe_k.
    fn add_row(&self, k: usize, factor: S, out: &mut [S]) {
        for (column, d) in self.sbp.row(k) {
            out[column] += factor * d;
        }
    }

    /// `sign` · (∂F/∂t, ∂F/∂x) with ∂F/∂t = D̄ᵀHv, ∂F/∂x = ½H g00′(D̄t)² − D̄ᵀHw, v = g00∘D̄t, w = D̄x.
    /// The velocities are used up.
    fn branch_gradient(&self, branch: &mut BranchState<S>, sign: S, out_t: &mut [S], out_x: &mut [S]) {
        self.bar_x.apply_transpose_weighted(&branch.x_dot, out_x);
        let weights = self.sbp.weights();
        for (k, out) in out_x.iter_mut().enumerate() {
            let t_dot = branch.t_dot[k];
            *out = sign * (weights[k].half() * branch.metric.first[k] * t_dot * t_dot - *out);
        }
        for (t_dot, &g00) in branch.t_dot.iter_mut().zip(&branch.metric.g00) {
            *t_dot *= g00;
        }
        self.bar_t.apply_transpose_weighted(&branch.t_dot, out_t);
        for out in out_t {
            *out *= sign;
        }
    }

    /// The size of the rounding error to be expected in the entries of ∇E_IVP at `u`, by kind of row. Differences of t
    /// and x are divided by h, so it grows like N.
    ///
    /// # Errors
    /// [`OutsideDomain`] if g00 is not positive and finite at a node of either branch.
    pub fn gradient_rounding(&self, u: &[S]) -> Result<GradientRounding, OutsideDomain> {
        let layout = self.layout();
        let lambda = layout.multipliers(u);
        let h = self.sbp.spacing().to_f64();
        let size = |u: &[S]| max_abs(u).to_f64();
        let of = |indices: [usize; 2]| indices.into_iter().map(|j| lambda[j].to_f64().abs()).fold(0.0, f64::max);
        let (mut t, mut x) = (0.0_f64, 0.0_f64);
        // λ1, λ5 and λ3, λ6 enter as they are, λ2, λ7 and λ4, λ8 with a row of D.
        let (mut t_row, mut x_row) = (of([0, 4]) + of([1, 6]) / h, of([2, 5]) + of([3, 7]) / h);
        let mut state = BranchState::zeros(self.sbp.points());
        for branch in layout.branches(u) {
            self.branch_into(branch.t, branch.x, &mut state)?;
            let t_dot = size(&state.t_dot).max(self.initial.t_dot.to_f64().abs());
            let x_dot = size(&state.x_dot).max(self.initial.x_dot.to_f64().abs());
            // A particle that starts at x = 0, perhaps at rest, moves by h ẋ and ½h²ẍ: that is what is rounded.
            let fall = 0.5 * h * h * size(&state.metric.first) * t_dot * t_dot;
            let t_size = size(branch.t).max(h * t_dot);
            let x_size = size(branch.x).max(h * x_dot).max(fall).max(f64::MIN_POSITIVE);
            (t, x) = (t.max(t_size), x.max(x_size));
            t_row = t_row.max(size(&state.metric.g00) * t_size / h);
            // ½ H g00′ ṫ² inherits twice the relative error of ṫ, which is ε|t|/(h ṫ).
            let force = size(self.sbp.weights()) * size(&state.metric.first) * t_dot * t_size / h;
            x_row = x_row.max(x_size / h).max(force);
        }
        let epsilon = S::EPSILON.to_f64();
        // Rows of D with larger coefficients show more of the rounding of t and x; ∇E applies D twice.
        let once = epsilon * self.sbp.stiffness();
        let twice = once * self.sbp.stiffness();
        Ok(GradientRounding { t_rows: twice * t_row, x_rows: twice * x_row, t: once * t, x: once * x })
    }
}

/// Rounding errors to be expected in ∇E_IVP.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GradientRounding {
    /// Of ∂E/∂t.
    pub t_rows: f64,
    /// Of ∂E/∂x.
    pub x_rows: f64,
    /// Of a value of t: the constraints of λ1 and λ5; divided by h those of λ2 and λ7.
    pub t: f64,
    /// Of a value of x: the constraints of λ3 and λ6; divided by h those of λ4 and λ8.
    pub x: f64,
}
