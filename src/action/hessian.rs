//! The Hessian of the doubled action: symmetric, indefinite, sparse.
//!
//! The sparsity depends on the operator only, so the pattern is found once and every later Hessian refills its
//! values in O(N). Per branch, with G = g00, u = D̄t:
//!
//! ```text
//! ∂²F/∂t² = D̄ᵀ H G D̄,    ∂²F/∂t∂x = D̄ᵀ H g00′ u,    ∂²F/∂x² = ½ H g00″ u² − D̄ᵀ H D̄
//! ```

use faer::sparse::{Argsort, Pair, SparseColMat, SymbolicSparseColMat};

use super::DoubledAction;
use super::Form;
use super::boundary::BranchEnds;
use crate::metric::OutsideDomain;

/// A Hessian as a compressed sparse column matrix with one row per unknown; both triangles are stored.
pub type SparseHessian = SparseColMat<usize, f64>;

/// The sparsity of the Hessian and the order in which its contributions are visited.
pub struct HessianPattern {
    symbolic: SymbolicSparseColMat<usize>,
    order: Argsort<usize>,
    contributions: usize,
}

impl HessianPattern {
    /// The positions of the nonzero entries, for a symbolic factorisation.
    pub fn symbolic(&self) -> &SymbolicSparseColMat<usize> {
        &self.symbolic
    }
}

impl std::fmt::Debug for HessianPattern {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "HessianPattern({} contributions)", self.contributions)
    }
}

impl DoubledAction<'_> {
    /// The pattern of [`Self::hessian`].
    pub fn hessian_pattern(&self) -> HessianPattern {
        let mut indices = Vec::new();
        // The pattern does not depend on the values, so zeros are as good as any.
        let zeros = vec![0.0; self.sbp.points()];
        let curvatures = [0, 1].map(|_| Curvature { tt: zeros.clone(), tx: zeros.clone(), xx: zeros.clone() });
        self.visit(&curvatures, &[BranchEnds::default(); 2], |row, col, _| indices.push(Pair { row, col }));
        let unknowns = self.layout().unknowns();
        let (symbolic, order) = SymbolicSparseColMat::try_new_from_indices(unknowns, unknowns, &indices)
            .expect("indices lie inside the matrix");
        HessianPattern { symbolic, order, contributions: indices.len() }
    }

    /// The Hessian ∇²E_IVP at `u`, with the `pattern` of [`Self::hessian_pattern`].
    ///
    /// # Errors
    /// [`OutsideDomain`] if g00 is not positive and finite at a node of either branch.
    pub fn hessian(&self, u: &[f64], pattern: &HessianPattern) -> Result<SparseHessian, OutsideDomain> {
        let weights = self.sbp.weights();
        let states = self.both_branches(u)?;
        let ends = self.ends(u, &states);
        let curvatures = states.map(|branch| {
            let (mut tt, mut tx, mut xx) = (branch.metric.g00, branch.metric.first, branch.metric.second);
            for (k, t_dot) in branch.t_dot.iter().enumerate() {
                tt[k] *= weights[k];
                tx[k] *= weights[k] * t_dot;
                xx[k] *= 0.5 * weights[k] * t_dot * t_dot;
            }
            Curvature { tt, tx, xx }
        });
        let mut values = Vec::with_capacity(pattern.contributions);
        self.visit(&curvatures, &ends, |_, _, value| values.push(value));
        Ok(SparseColMat::new_from_argsort(pattern.symbolic.clone(), &pattern.order, &values)
            .expect("the pattern was made for this operator"))
    }

    /// Calls `push(row, column, value)` for every contribution, always in the same order. Contributions to the same
    /// entry are to be added.
    fn visit(&self, curvatures: &[Curvature; 2], ends: &[BranchEnds<f64>; 2], mut push: impl FnMut(usize, usize, f64)) {
        let layout = self.layout();
        let weights = self.sbp.weights();
        for (branch, curvature) in curvatures.iter().enumerate() {
            let sign = if branch == 0 { 1.0 } else { -1.0 };
            let (t, x) = (layout.t(branch), layout.x(branch));
            for (k, &weight) in weights.iter().enumerate() {
                for (a, d_a) in self.bar_t.row(k) {
                    for (b, d_b) in self.bar_t.row(k) {
                        push(t + a, t + b, sign * d_a * curvature.tt[k] * d_b);
                    }
                    push(t + a, x + k, sign * d_a * curvature.tx[k]);
                    push(x + k, t + a, sign * d_a * curvature.tx[k]);
                }
                push(x + k, x + k, sign * curvature.xx[k]);
                for (a, d_a) in self.bar_x.row(k) {
                    for (b, d_b) in self.bar_x.row(k) {
                        push(x + a, x + b, -sign * d_a * weight * d_b);
                    }
                }
            }
        }
        match self.form {
            Form::Strong => self.visit_constraints(&mut push),
            Form::Weak => self.visit_boundary(ends, &mut push),
        }
    }
}

/// The diagonal factors in the three blocks of a branch's Hessian: H g00, H g00′ D̄t and ½ H g00″ (D̄t)².
struct Curvature {
    tt: Vec<f64>,
    tx: Vec<f64>,
    xx: Vec<f64>,
}
