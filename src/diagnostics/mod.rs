//! Independent judges of a solution. They use nodes, operator and metric, and never call a solver.

mod bound;
mod charges;
mod residuals;
mod sawtooth;

pub use bound::Bound;
pub use charges::{Charges, FreeParticleCharges};
pub use residuals::GeodesicResiduals;
pub use sawtooth::sawtooth;

use std::ops::Range;

use crate::case::Form;
use crate::norm::max_abs;
use crate::scalar::Real;
use crate::solve::{Solution, WindowView};

/// A drift of K by more than this share means that x is not resolved.
const LARGE_DRIFT: f64 = 0.1;

/// Everything that is measured on a solution.
#[derive(Debug, Clone)]
pub struct Diagnostics<S = f64> {
    /// Dt on the nodes; D̄t in the weak form.
    pub t_dot: Vec<S>,
    /// Dx on the nodes; D̄x in the weak form.
    pub x_dot: Vec<S>,
    /// ΔQ_t, its corrected form and ΔK.
    pub charges: Charges<S>,
    /// ΔGᵗ and ΔGˣ.
    pub residuals: GeodesicResiduals<S>,
    /// H_BVP and what bounds it.
    pub bound: Bound<S>,
    /// Amplitude of the even–odd oscillation of x; none if there are too few nodes. See [`sawtooth()`].
    pub sawtooth: Option<S>,
    /// Q_x and Q_η, if the potential vanishes.
    pub free_particle: Option<FreeParticleCharges<S>>,
    /// Number of nodes of a window; of those, from the first, at which Q_t and K are judged; and at which ΔG is.
    nodes: usize,
    interior_nodes: usize,
    interior_residual_nodes: usize,
}

impl<S: Real> Diagnostics<S> {
    /// Measures `solution`.
    pub fn new(solution: &Solution<S>) -> Self {
        let t_dot = on_windows(solution, |window, _| window.derivative(window.elapsed, S::ZERO));
        let x_dot = on_windows(solution, |window, _| window.derivative(window.x, window.start.x));
        let metric = solution.metric.sample(&solution.x).expect("a solution lies inside the domain");
        let charges = Charges::new(solution, &metric.g00, &t_dot, &x_dot);
        let residuals = GeodesicResiduals::new(solution, &metric, &t_dot, &x_dot);
        let bound = Bound::new(solution, &metric.g00);
        let interior_nodes = solution.exact_nodes();
        let sawtooth = (solution.sbp.is_equidistant())
            .then(|| solution.views().filter_map(|window| sawtooth(&window.x[..interior_nodes])).reduce(S::max))
            .flatten();
        let free_particle = FreeParticleCharges::new(solution, &t_dot, &x_dot);
        let interior_residual_nodes = match solution.form {
            Form::Strong => solution.sbp.points() - solution.sbp.rows_reaching_last_node(),
            Form::Weak => solution.sbp.points(),
        };
        Self {
            t_dot,
            x_dot,
            charges,
            residuals,
            bound,
            sawtooth,
            free_particle,
            nodes: solution.sbp.points(),
            interior_nodes,
            interior_residual_nodes,
        }
    }

    /// What in these numbers says that the trajectory should not be believed, a sentence each.
    pub fn warnings(&self, solution: &Solution<S>) -> Vec<String> {
        let k = solution.invariants().k.to_f64();
        let mut warnings = Vec::new();
        let drift = self.max_abs_delta_k().to_f64();
        if drift > LARGE_DRIFT * k.abs() {
            warnings.push(format!(
                "K drifts by {drift:.2e} of {k:.2e}: x is not resolved, however exact Q_t is; raise n_gamma or windows, or \
                 use an operator of higher order"
            ));
        }
        if let Some(reached) = short_of_digits(solution) {
            warnings.push(format!(
                "the iteration ends at the rounding of the arithmetic: about {reached} of {} digits are certain; the \
                 physical limit, or more digits, have more",
                solution.digits
            ));
        }
        if k >= 0.0 && self.bound.h_bvp > self.bound.h_bvp_bound {
            let [h_bvp, h_bvp_bound] = [self.bound.h_bvp, self.bound.h_bvp_bound].map(S::to_f64);
            warnings.push(format!("H_BVP = {h_bvp:.3e} exceeds its bound Q_t (t_f - t_i) = {h_bvp_bound:.3e}"));
        }
        warnings
    }

    /// max |ΔQ_t| over all nodes but the last of each window; over all nodes in the weak form.
    pub fn max_abs_delta_q_t_interior(&self) -> S {
        self.max_abs_on(&self.charges.delta_q_t, self.interior_nodes)
    }

    /// Largest |ΔQ_t| at the last node of a window.
    pub fn max_abs_delta_q_t_last(&self) -> S {
        let last = self.charges.delta_q_t.iter().skip(self.nodes - 1).step_by(self.nodes);
        last.fold(S::ZERO, |largest, deviation| largest.max(deviation.abs()))
    }

    /// ΔQ_t at the last node.
    pub fn delta_q_t_last(&self) -> S {
        self.charges.delta_q_t.last().copied().unwrap_or(S::ZERO)
    }

    /// max |ΔQ_t + (λ7/H_N) e_N| over all nodes.
    pub fn max_abs_delta_q_t_corrected(&self) -> S {
        max_abs(&self.charges.delta_q_t_corrected)
    }

    /// max of |ΔGᵗ| and |ΔGˣ| over the nodes whose row of D does not reach node N; over all nodes in the weak form.
    pub fn max_abs_delta_g_interior(&self) -> S {
        let nodes = self.interior_residual_nodes;
        self.max_abs_on(&self.residuals.delta_g_t, nodes).max(self.max_abs_on(&self.residuals.delta_g_x, nodes))
    }

    /// max |ΔK| over all nodes but the last of each window; over all nodes in the weak form.
    pub fn max_abs_delta_k(&self) -> S {
        self.max_abs_on(&self.charges.delta_k, self.interior_nodes)
    }

    /// max |ΔK| at the ends of the windows, from the values that a continuation starts with.
    pub fn max_abs_delta_k_ends(&self) -> S {
        max_abs(&self.charges.delta_k_ends)
    }

    /// max |u| over the first `count` nodes of every window; NaN if any is.
    fn max_abs_on(&self, u: &[S], count: usize) -> S {
        let of_windows: Vec<S> = u.chunks_exact(self.nodes).map(|window| max_abs(&window[..count])).collect();
        max_abs(&of_windows)
    }
}

/// What `of_window` says of every window and its range of nodes, in one vector.
fn on_windows<S: Real>(
    solution: &Solution<S>,
    of_window: impl Fn(WindowView<'_, S>, Range<usize>) -> Vec<S>,
) -> Vec<S> {
    let nodes = solution.sbp.points();
    let mut views = solution.views().enumerate();
    let mut range = |(index, window)| of_window(window, index * nodes..(index + 1) * nodes);
    let mut all = views.next().map_or_else(Vec::new, &mut range);
    all.reserve_exact(nodes * (solution.windows.len() - 1));
    views.for_each(|window| all.extend(range(window)));
    all
}

/// Newton's method in `f64` ends with a step below this share, which leaves half as many zeros more; a larger one means that
/// rounding has ended it.
const SMALL_CORRECTION: f64 = 1e-8;

/// The digits that the last correction left unchanged, if they are fewer than were asked for.
fn short_of_digits<S: Real>(solution: &Solution<S>) -> Option<u32> {
    let reached = -solution.last_correction.log10();
    let wanted = if S::IS_EXTENDED { f64::from(solution.digits) } else { -SMALL_CORRECTION.log10() };
    (solution.last_correction > 0.0 && reached < wanted).then_some(reached.max(0.0) as u32)
}
