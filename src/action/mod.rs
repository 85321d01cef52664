//! The doubled geodesic action, its gradient and its sparse Hessian, in two forms.
//!
//! ```text
//! F(q)  = Σ_k H_k ( ½ g_ab(q_k) (D̄q^a)_k (D̄q^b)_k + A_a(q_k) (D̄q^a)_k )
//! E_IVP = F(q₁) − F(q₂) + terms that tie the branches to the initial data and to each other
//! ```
//!
//! in n coordinates, summed over a and b. The paper has two, t and x, with g = diag(g00(x), −1):
//!
//! ```text
//! F(t, x) = ½{ (D̄t)ᵀ g00(x) H (D̄t) − (D̄x)ᵀ H (D̄x) }
//! ```
//!
//! The two forms differ in these terms (`ends.rs`). The paper's *strong* form has eight constraints with Lagrange
//! multipliers. The *weak* form, which the paper's outlook asks for, has boundary terms and no multipliers.
//!
//! Forward branch 1 carries the initial data, and backward branch 2 is tied to it at the end. Nothing in this module
//! knows an equation of motion: a trajectory is a point where ∇E_IVP = 0. (The paper writes D̄ as a matrix on the
//! vector (x, 1). Its H̄ is H with a zero row and column for that last, *affine* entry, which therefore never
//! contributes.)
//!
//! ```
//! use geodesic_ivp::action::{DoubledAction, Form};
//! use geodesic_ivp::geometry::{Geometry, GeometryText, Law, Start};
//! use geodesic_ivp::sbp::{SbpOperator, coefficients::SBP21};
//!
//! // A free particle moves on a straight line, and that is a critical point of the weak action.
//! let geometry = Geometry::of_x(&GeometryText::of_x("0", 1.0, 1.0))?;
//! let (q, q_dot) = (vec![0.0, 0.0], vec![1.0, 0.5]);
//! let start = Start { p: geometry.momenta(&q, &q_dot), q, q_dot };
//! let sbp = SbpOperator::new(&SBP21, 11, 0.1)?;
//! let action = DoubledAction::new(Form::Weak, &sbp, &geometry, start);
//! let t: Vec<f64> = (0..11).map(|k| sbp.node(k)).collect();
//! let x: Vec<f64> = t.iter().map(|t| 0.5 * t).collect();
//! let mut gradient = vec![1.0; action.layout().unknowns()];
//! action.gradient(&action.layout().physical_limit(&[&t, &x], &[]), &mut gradient)?;
//! assert!(gradient.iter().all(|g| g.abs() < 1e-14));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod ends;
mod force;
mod hessian;
mod layout;
mod rounding;
mod state;

pub use layout::{Layout, MULTIPLIERS_PER_COORDINATE};
pub use rounding::GradientRounding;

use serde::{Deserialize, Serialize};

use self::force::MeanForce;
use self::layout::Unknowns;
use self::state::{BranchState, of_branch};
use crate::geometry::{Geometry, OutsideGeometry, Source, Start};
use crate::number::Real;
use crate::number::norm::max_abs;
use crate::sbp::{RegularisedOperator, SbpOperator};

/// The form of the action.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(try_from = "String", rename_all = "lowercase")]
pub enum Form {
    /// The form of the paper: Lagrange multipliers impose the initial conditions and connect the branches.
    #[default]
    Strong,
    /// The weak form that the paper's outlook asks for, with boundary terms in place of the multipliers. Q_t is exact
    /// at every node, the last one included.
    Weak,
}

impl Form {
    /// The name used in files.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Strong => "strong",
            Self::Weak => "weak",
        }
    }
}

impl TryFrom<String> for Form {
    type Error = String;

    fn try_from(name: String) -> Result<Self, String> {
        match name.as_str() {
            "strong" => Ok(Self::Strong),
            "weak" => Ok(Self::Weak),
            _ => Err(format!("unknown form \"{name}\", expected strong or weak")),
        }
    }
}

/// E_IVP for one grid, Lagrangian and set of initial data, in 2nN + 4n unknowns (strong) or 2nN (weak), see [`Layout`].
#[derive(Debug)]
pub struct DoubledAction<'a, S = f64> {
    /// The form: strong or weak.
    pub form: Form,
    /// The SBP operator the action is built on.
    pub sbp: &'a SbpOperator<S>,
    lagrangian: &'a Geometry<S>,
    /// The initial data: the positions with the velocities (strong) or the momenta (weak).
    pub initial: Start<S>,
    /// D̄ of each coordinate.
    bars: Vec<RegularisedOperator<'a, S>>,
}

impl<'a, S: Real> DoubledAction<'a, S> {
    /// The action in this form, with the regularised operators D̄, of a world-line that starts at `initial`.
    pub fn new(form: Form, sbp: &'a SbpOperator<S>, lagrangian: &'a Geometry<S>, initial: Start<S>) -> Self {
        let bars = initial.q.iter().map(|&q| RegularisedOperator::new(sbp, q)).collect();
        Self { form, sbp, lagrangian, initial, bars }
    }

    /// The strong form with D in place of D̄, to show what the regularisation is for: this action has wrong critical
    /// points or none.
    pub fn without_regularisation(self) -> Self {
        let bars = vec![RegularisedOperator::without_regularisation(self.sbp); self.bars.len()];
        Self { form: Form::Strong, bars, ..self }
    }

    /// The order of the unknowns.
    pub fn layout(&self) -> Layout {
        Layout::new(self.bars.len(), self.sbp.points(), self.form)
    }

    /// The states of both branches of `u`. In the physical limit they are the same, and there is one.
    fn states(&self, u: &Unknowns<'_, S>) -> Result<Vec<BranchState<S>>, OutsideGeometry> {
        let [one, two] = &u.branches;
        let is_same = |(one, two): (&&[S], &&[S])| std::ptr::eq(*one, *two) || one == two;
        let branches = if one.iter().zip(two).all(is_same) { vec![one] } else { vec![one, two] };
        let evaluated = |branch: &Vec<&[S]>| {
            let mut state = BranchState::zeros(self.lagrangian, branch[0].len());
            state.evaluate(self.lagrangian, &self.bars, branch).map(|()| state)
        };
        branches.into_iter().map(evaluated).collect()
    }

    /// The value E_IVP(u).
    ///
    /// # Errors
    /// The first node of either branch that lies outside the domain.
    pub fn value(&self, u: &[S]) -> Result<S, OutsideGeometry> {
        let u = &self.layout().split(u);
        let states = self.states(u)?;
        let values = &self.lagrangian.structure().values;
        let [forward, backward] = [0, 1].map(|branch| of_branch(&states, branch).value(values, self.sbp));
        let ties = match self.form {
            Form::Strong => self.multiplier_terms(u),
            Form::Weak => self.boundary_terms(&self.ties(u, &states)),
        };
        let force = MeanForce::new(self, u, &states).map_or(S::ZERO, |mean| self.force_term(&mean));
        Ok(forward - backward + ties + force)
    }

    /// Writes ∇E_IVP(u) into `out`, which is as long as `u`: the derivatives with respect to both branches and then, in
    /// the strong form, the constraints.
    ///
    /// # Errors
    /// The first node of either branch that lies outside the domain.
    pub fn gradient(&self, u: &[S], out: &mut [S]) -> Result<(), OutsideGeometry> {
        let (layout, u) = (self.layout(), &self.layout().split(u));
        self.branch_gradients(&self.states(u)?, u, &mut out[..layout.multiplier_range().start]);
        if self.form == Form::Strong {
            layout.multipliers_mut(out).copy_from_slice(&self.constraints_of(u));
        }
        Ok(())
    }

    /// Writes the gradient with respect to both branches, or to the forward one alone if there is no more room.
    fn branch_gradients(&self, states: &[BranchState<S>], u: &Unknowns<'_, S>, out: &mut [S]) {
        let layout = self.layout();
        let forward = layout.row(1, 0);
        let mut momentum = vec![S::ZERO; self.sbp.points()];
        for a in 0..layout.dimension {
            self.coordinate_gradient(&states[0], a, &mut momentum, layout.values_mut(out, 0, a));
        }
        if out.len() > forward {
            match states {
                [_] => out.copy_within(..forward, forward),
                _ => (0..layout.dimension).for_each(|a| {
                    self.coordinate_gradient(&states[1], a, &mut momentum, layout.values_mut(out, 1, a));
                }),
            }
            out[forward..].iter_mut().for_each(|out| *out = -*out);
        }
        if let Some(mean) = MeanForce::new(self, u, states) {
            self.add_force_gradient(&mean, out);
        }
        match self.form {
            Form::Strong => self.add_multiplier_gradient(u, out),
            Form::Weak => self.add_boundary_gradient(&self.ties(u, states), states, out),
        }
    }

    /// The largest entry of ∇E_IVP(u); infinite where a node is outside the domain, or where the Lagrangian overflows:
    /// its squares of velocities do so before the gradient, and K with them.
    pub fn gradient_norm(&self, u: &[S]) -> S {
        self.gradient_norm_of(&self.layout().split(u))
    }

    /// The same in the physical limit, where both branches are equal to `q`, an array for each coordinate. In the weak
    /// form `multipliers` is empty.
    pub fn gradient_norm_in_limit(&self, q: &[&[S]], multipliers: &[S]) -> S {
        self.gradient_norm_of(&Unknowns { branches: [q.to_vec(), q.to_vec()], multipliers })
    }

    fn gradient_norm_of(&self, u: &Unknowns<'_, S>) -> S {
        let (infinite, layout) = (S::from(f64::INFINITY), self.layout());
        let Ok(states) = self.states(u) else { return infinite };
        let values = &self.lagrangian.structure().values;
        if !states.iter().all(|state| state.is_finite(values)) {
            return infinite;
        }
        // Only λ and μ act on one branch alone. Without them the gradients of equal branches differ in sign only.
        let of_start = &u.multipliers[..u.multipliers.len() / 2];
        let branches = if states.len() == 1 && of_start.iter().all(|&m| m == S::ZERO) { 1 } else { 2 };
        let mut gradient = vec![S::ZERO; layout.row(branches, 0)];
        self.branch_gradients(&states, u, &mut gradient);
        if self.form == Form::Strong {
            gradient.extend(self.constraints_of(u));
        }
        max_abs(&gradient)
    }

    /// ∂F/∂q^a = D̄ᵀH p_a + H f_a with f_a = ½ ∂_a g_bc D̄q^b D̄q^c + ∂_a A_b D̄q^b. `momentum` is room for N numbers.
    fn coordinate_gradient(&self, state: &BranchState<S>, a: usize, momentum: &mut [S], out: &mut [S]) {
        let structure = self.lagrangian.structure();
        momentum.fill(S::ZERO);
        state.contraction(structure, 0..momentum.len()).add_momentum(a, momentum);
        self.bars[a].apply_transpose_weighted(momentum, out);
        let weights = self.sbp.weights();
        for term in structure.first.iter().filter(|term| term.by == [a]) {
            let [b, c] = term.ab.map(|b| state.velocities.row(b));
            let factor = if term.ab[0] == term.ab[1] { S::ONE.half() } else { S::ONE };
            let nodes = out.iter_mut().zip(weights).zip(b.iter().zip(c));
            match term.value {
                Source::Constant(value) => {
                    nodes.for_each(|((out, &weight), (&b, &c))| *out += factor * weight * value * b * c);
                }
                Source::Row(row) => {
                    let nodes = nodes.zip(state.samples.row(row));
                    nodes.for_each(|(((out, &weight), (&b, &c)), &value)| *out += factor * weight * value * b * c);
                }
            }
        }
    }
}
