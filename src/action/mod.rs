//! The doubled geodesic action, its gradient and its sparse Hessian, in two forms.
//!
//! ```text
//! F(t, x) = ½{ (D̄t)ᵀ g00(x) H (D̄t) − (D̄x)ᵀ H (D̄x) }
//! E_IVP   = F(t₁, x₁) − F(t₂, x₂) + terms that tie the branches to the initial data and to each other
//! ```
//!
//! The two forms differ in these terms. The paper's *strong* form has eight constraints with Lagrange multipliers
//! (`multipliers.rs`). The *weak* form, which the paper's outlook asks for, has boundary terms and no multipliers
//! (`boundary.rs`).
//!
//! Forward branch 1 carries the initial data, and backward branch 2 is tied to it at the end. Nothing in this module
//! knows an equation of motion: a trajectory is a point where ∇E_IVP = 0. (The paper writes D̄ as a matrix on the
//! vector (x, 1). Its H̄ is H with a zero row and column for that last, *affine* entry, which therefore never
//! contributes.)
//!
//! ```
//! use geodesic_ivp::action::DoubledAction;
//! use geodesic_ivp::geodesic::InitialData;
//! use geodesic_ivp::metric::Metric;
//! use geodesic_ivp::potential::Potential;
//! use geodesic_ivp::sbp::{SbpOperator, coefficients::SBP21};
//!
//! // A free particle moves on a straight line, and that is a critical point of the weak action.
//! let metric = Metric::new(Potential::free(), 1.0, 1.0);
//! let initial = InitialData { t: 0.0, x: 0.0, t_dot: 1.0, x_dot: 0.5 };
//! let sbp = SbpOperator::new(&SBP21, 11, 0.1)?;
//! let action = DoubledAction::weak(&sbp, &metric, initial);
//! let t: Vec<f64> = (0..11).map(|k| sbp.node(k)).collect();
//! let x: Vec<f64> = t.iter().map(|t| 0.5 * t).collect();
//! let mut gradient = vec![1.0; action.layout().unknowns()];
//! action.gradient(&action.layout().physical_limit(&t, &x, &[]), &mut gradient)?;
//! assert!(gradient.iter().all(|g| g.abs() < 1e-14));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod boundary;
mod form;
mod hessian;
mod layout;
mod multipliers;
mod rounding;

pub use form::Form;
pub use hessian::{HessianPattern, SparseHessian};
pub use layout::{Branch, Layout, MULTIPLIERS};
pub use rounding::GradientRounding;

use self::boundary::BranchEnds;
use crate::geodesic::InitialData;
use crate::metric::{Metric, MetricSamples, OutsideDomain};
use crate::sbp::{RegularisedOperator, SbpOperator};
use crate::scalar::Real;

/// E_IVP for one grid, metric and set of initial data, in 4N + 8 unknowns (strong) or 4N (weak), see [`Layout`].
#[derive(Debug, Clone)]
pub struct DoubledAction<'a, S = f64> {
    form: Form,
    sbp: &'a SbpOperator<S>,
    metric: &'a Metric<S>,
    initial: InitialData<S>,
    /// Q_t of the initial data, which the weak form takes in place of ṫ_i.
    q_t: S,
    bar_t: RegularisedOperator<'a, S>,
    bar_x: RegularisedOperator<'a, S>,
}

/// One branch evaluated on its nodes: the metric, and the regularised velocities D̄t and D̄x.
struct BranchState<S> {
    metric: MetricSamples<S>,
    t_dot: Vec<S>,
    x_dot: Vec<S>,
}

impl<S: Real> BranchState<S> {
    fn zeros(points: usize) -> Self {
        Self { metric: MetricSamples::zeros(points), t_dot: vec![S::ZERO; points], x_dot: vec![S::ZERO; points] }
    }

    /// F of the branch.
    fn value(&self, sbp: &SbpOperator<S>) -> S {
        let integrand = (self.metric.g00.iter().zip(&self.t_dot).zip(&self.x_dot))
            .map(|((&g00, &t_dot), &x_dot)| (g00 * t_dot * t_dot - x_dot * x_dot).half())
            .collect::<Vec<_>>();
        sbp.integrate(&integrand)
    }
}

impl<'a, S: Real> DoubledAction<'a, S> {
    /// The paper's strong form, with the regularised operators D̄.
    pub fn new(sbp: &'a SbpOperator<S>, metric: &'a Metric<S>, initial: InitialData<S>) -> Self {
        let bar_t = RegularisedOperator::new(sbp, initial.t);
        let bar_x = RegularisedOperator::new(sbp, initial.x);
        Self { form: Form::Strong, sbp, metric, initial, q_t: initial.invariants(metric).q_t, bar_t, bar_x }
    }

    /// The weak form, without multipliers, which the paper's outlook asks for.
    pub fn weak(sbp: &'a SbpOperator<S>, metric: &'a Metric<S>, initial: InitialData<S>) -> Self {
        Self { form: Form::Weak, ..Self::new(sbp, metric, initial) }
    }

    /// The strong form with D in place of D̄, to show what the regularisation is for: this action has wrong critical
    /// points or none.
    pub fn without_regularisation(sbp: &'a SbpOperator<S>, metric: &'a Metric<S>, initial: InitialData<S>) -> Self {
        let plain = RegularisedOperator::without_regularisation(sbp);
        Self { bar_t: plain, bar_x: plain, ..Self::new(sbp, metric, initial) }
    }

    /// The order of the unknowns.
    pub fn layout(&self) -> Layout {
        Layout::new(self.sbp.points(), self.form)
    }

    /// The form: strong or weak.
    pub fn form(&self) -> Form {
        self.form
    }

    /// The SBP operator the action is built on.
    pub fn sbp(&self) -> &'a SbpOperator<S> {
        self.sbp
    }

    /// The initial data: t_i, x_i, ẋ_i and ṫ_i (strong) or Q_t (weak).
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

    /// The ends of both branches of `u`, from their `states`.
    fn ends(&self, u: &[S], states: &[BranchState<S>; 2]) -> [BranchEnds<S>; 2] {
        let branches = self.layout().branches(u);
        [0, 1].map(|branch: usize| BranchEnds::new(&branches[branch], &states[branch]))
    }

    /// The value E_IVP(u).
    ///
    /// # Errors
    /// [`OutsideDomain`] if g00 is not positive and finite at a node of either branch.
    pub fn value(&self, u: &[S]) -> Result<S, OutsideDomain> {
        let states = self.both_branches(u)?;
        let [forward, backward] = [0, 1].map(|branch: usize| states[branch].value(self.sbp));
        let ties = match self.form {
            Form::Strong => self.multiplier_terms(u),
            Form::Weak => self.boundary_terms(&self.ends(u, &states)),
        };
        Ok(forward - backward + ties)
    }

    /// Writes ∇E_IVP(u) into `out`, which is as long as `u`: the derivatives with respect to both branches and then, in
    /// the strong form, the constraints.
    ///
    /// # Errors
    /// [`OutsideDomain`] if g00 is not positive and finite at a node of either branch.
    pub fn gradient(&self, u: &[S], out: &mut [S]) -> Result<(), OutsideDomain> {
        let layout = self.layout();
        let mut ends = [BranchEnds::default(); 2];
        // Both branches use the same buffers, one after the other.
        let mut state = BranchState::zeros(self.sbp.points());
        let parts = layout.branches(u).into_iter().zip(layout.branches_mut(out));
        for ((sign, ends), (branch, out)) in [S::ONE, -S::ONE].into_iter().zip(&mut ends).zip(parts) {
            self.branch_into(branch.t, branch.x, &mut state)?;
            *ends = BranchEnds::new(&branch, &state);
            self.branch_gradient(&mut state, sign, out.t, out.x);
        }
        match self.form {
            Form::Strong => self.add_multiplier_gradient(u, out),
            Form::Weak => self.add_boundary_gradient(&ends, out),
        }
        Ok(())
    }

    /// `sign` · (∂F/∂t, ∂F/∂x) with ∂F/∂t = D̄ᵀHv, ∂F/∂x = ½H g00′(D̄t)² − D̄ᵀHw, v = g00∘D̄t, w = D̄x.
    /// Overwrites the velocities of `branch`.
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
}
