//! The sweep over N_γ and operators, its errors against the reference trajectory, and their slopes.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use rayon::prelude::*;
use serde::Serialize;

use super::fit::{Fit, points_above_plateau};
use crate::case::{Case, End, Form, SbpName};
use crate::diagnostics::Diagnostics;
use crate::metric::Metric;
use crate::reference::{ReferenceEnds, ReferenceTrajectory};
use crate::scalar::Real;
use crate::solve::{Solution, Status, solve};

/// The measured errors of one grid.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Errors {
    /// |t_N − t(γ_f)|.
    pub eps_t_final: f64,
    /// |x_N − x(γ_f)|.
    pub eps_x_final: f64,
    /// ((t − t(γ))ᵀ H (t − t(γ)))^½.
    pub eps_t_l2: f64,
    /// ((x − x(γ))ᵀ H (x − x(γ)))^½.
    pub eps_x_l2: f64,
    /// ΔQ_t at the last node.
    pub delta_q_t_last: f64,
    /// max |ΔK| over all nodes but the last of each window (weak form: over all).
    pub delta_k_max: f64,
}

/// One grid of the sweep.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ConvergencePoint {
    /// Operator.
    pub sbp: SbpName,
    /// Form of the action.
    pub form: Form,
    /// Different nodes of all windows.
    pub n_gamma: usize,
    /// Spacing.
    pub delta_gamma: f64,
    /// The errors, if the solve converged.
    pub errors: Option<Errors>,
    /// Newton iterations.
    pub iterations: usize,
    /// Seconds in the solver, while other grids are solved beside it.
    pub seconds: f64,
    /// How the solve ended.
    pub status: Status,
}

/// The quantities whose slopes are fitted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
#[allow(missing_docs)] // Named as in `Errors`.
pub enum Quantity {
    EpsTFinal,
    EpsXFinal,
    EpsTL2,
    EpsXL2,
}

impl Quantity {
    /// All of them, in the order of the files.
    pub const ALL: [Self; 4] = [Self::EpsTFinal, Self::EpsXFinal, Self::EpsTL2, Self::EpsXL2];

    /// The name used in files.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::EpsTFinal => "eps_t_final",
            Self::EpsXFinal => "eps_x_final",
            Self::EpsTL2 => "eps_t_l2",
            Self::EpsXL2 => "eps_x_l2",
        }
    }

    /// The name for people.
    pub fn symbol(self) -> &'static str {
        match self {
            Self::EpsTFinal => "ε_t(γ_f)",
            Self::EpsXFinal => "ε_x(γ_f)",
            Self::EpsTL2 => "ε_t(L2)",
            Self::EpsXL2 => "ε_x(L2)",
        }
    }

    /// Whether it is an error at γ_f.
    pub fn is_at_end(self) -> bool {
        matches!(self, Self::EpsTFinal | Self::EpsXFinal)
    }

    /// Its value.
    pub fn of(self, errors: &Errors) -> f64 {
        match self {
            Self::EpsTFinal => errors.eps_t_final,
            Self::EpsXFinal => errors.eps_x_final,
            Self::EpsTL2 => errors.eps_t_l2,
            Self::EpsXL2 => errors.eps_x_l2,
        }
    }
}

/// What the errors are measured against.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReferenceInfo<S = f64> {
    /// Its own estimate of its relative error.
    pub error_estimate: f64,
    /// Taylor steps.
    pub steps: usize,
    /// γ_f.
    pub gamma_final: S,
    /// t(γ_f).
    pub t_final: S,
    /// x(γ_f).
    pub x_final: S,
    /// Largest |t − t_i|: the size that errors of t are compared with.
    pub t_size: f64,
    /// Largest |x| at a node of the finest grid: the size that errors of x are compared with.
    pub x_size: f64,
}

/// The whole sweep.
#[derive(Debug, Clone)]
pub struct Convergence<S = f64> {
    /// The grids that were finished: operators in the order asked for, then N ascending.
    pub points: Vec<ConvergencePoint>,
    /// What they are compared with.
    pub reference: ReferenceInfo<S>,
    /// Digits of the arithmetic: what the rounding plateau is judged by.
    pub digits: u32,
    /// Whether the sweep was cancelled before all grids were done.
    pub interrupted: bool,
}

/// Why there is no sweep at all.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SweepError {
    /// There is no trajectory to compare with.
    #[error(transparent)]
    Reference(#[from] ReferenceEnds),
    /// A grid is not possible: too few nodes for the operator, too many, or too close.
    #[error("{0}")]
    Grid(String),
}

/// Solves `case` for every operator with its form and every number of nodes, in parallel; results come in a fixed order.
///
/// A case that ends at a physical time is swept at the γ_f at which the reference reaches it. `finished` is called for
/// every grid as it is done; a true `cancel` keeps grids that have not begun from beginning.
///
/// # Errors
/// [`SweepError`] if a grid cannot exist or there is no reference. A grid without a solution is a point with its
/// status.
pub fn sweep<S: Real>(
    case: &Case,
    schemes: &[(SbpName, Form)],
    n_gamma: &[usize],
    cancel: &AtomicBool,
    finished: &(dyn Fn(&ConvergencePoint) + Sync),
) -> Result<Convergence<S>, SweepError> {
    let metric: Metric<S> = case.metric();
    let initial = case.initial_data();
    let digits = case.digits::<S>();
    let length = match case.end() {
        End::Duration(duration) => ReferenceTrajectory::length_of(&metric, initial, duration, digits)?,
        End::Length(length) => length,
    };
    let mut n_gamma = n_gamma.to_vec();
    n_gamma.sort_unstable();
    n_gamma.dedup();
    let mut cases: Vec<Case> = Vec::new();
    for &scheme in schemes {
        if cases.iter().all(|case| (case.scheme.sbp, case.scheme.form) != scheme) {
            for &n in &n_gamma {
                cases.push(case.on_grid(scheme, n, length).map_err(SweepError::Grid)?);
            }
        }
    }
    // Few nodes round to one and the same number of spectral elements.
    cases.dedup_by(|a, b| (a.scheme, &a.grid) == (b.scheme, &b.grid));
    let reference = ReferenceTrajectory::new(&metric, initial, length, digits)?;
    let end = reference.at(length);
    let samples = n_gamma.last().copied().unwrap_or(2).clamp(2, 4096);
    let x_size = (0..samples)
        .map(|k| reference.at(length * S::from(k as f64 / (samples - 1) as f64)).x.to_f64().abs())
        .fold(f64::MIN_POSITIVE, f64::max);

    let all = cases.len();
    // The largest grids first, so that no core is left alone with one at the end.
    let mut jobs: Vec<(usize, Case)> = cases.into_iter().enumerate().collect();
    jobs.sort_by_key(|(_, case)| std::cmp::Reverse(case.grid.n_gamma * case.grid.windows));
    let mut points: Vec<(usize, ConvergencePoint)> = jobs
        .into_par_iter()
        .with_max_len(1)
        .filter_map(|(order, case)| {
            if cancel.load(Ordering::Relaxed) {
                return None;
            }
            let point = measure(&case, length, &reference);
            finished(&point);
            Some((order, point))
        })
        .collect();
    points.sort_by_key(|(order, _)| *order);
    Ok(Convergence {
        interrupted: points.len() < all,
        digits,
        points: points.into_iter().map(|(_, point)| point).collect(),
        reference: ReferenceInfo {
            error_estimate: reference.error_estimate(),
            steps: reference.steps(),
            gamma_final: case.grid.gamma_i.to::<S>() + length,
            t_final: initial.t + end.elapsed,
            x_final: end.x,
            t_size: end.elapsed.to_f64().abs(),
            x_size,
        },
    })
}

fn measure<S: Real>(case: &Case, length: S, reference: &ReferenceTrajectory<S>) -> ConvergencePoint {
    let intervals = case.grid.windows * (case.grid.n_gamma - 1);
    let start = Instant::now();
    let result = solve::<S>(case);
    let seconds = start.elapsed().as_secs_f64();
    let (status, iterations, errors) = match &result {
        Ok(solution) => (Status::Converged, solution.iterations, Some(errors(solution, reference))),
        Err(failure) => (failure.status, failure.history.len(), None),
    };
    ConvergencePoint {
        sbp: case.scheme.sbp,
        form: case.scheme.form,
        n_gamma: intervals + 1,
        delta_gamma: length.to_f64() / intervals as f64,
        errors,
        iterations,
        seconds,
        status,
    }
}

/// Errors of a solution at its nodes and in its own quadrature.
pub fn errors<S: Real>(solution: &Solution<S>, reference: &ReferenceTrajectory<S>) -> Errors {
    let (mut t_squared, mut x_squared, mut final_errors) = (0.0, 0.0, (0.0, 0.0));
    let values = solution.time_from_start(&solution.elapsed).zip(&solution.x);
    let weights = solution.views().flat_map(|view| view.sbp.weights());
    for ((gamma, (t, &x)), weight) in solution.gamma_from_start().zip(values).zip(weights) {
        let exact = reference.at(gamma);
        let (t, x) = ((t - exact.elapsed).to_f64(), (x - exact.x).to_f64());
        let weight = weight.to_f64();
        t_squared += weight * t * t;
        x_squared += weight * x * x;
        final_errors = (t.abs(), x.abs());
    }
    let diagnostics = Diagnostics::new(solution);
    Errors {
        eps_t_final: final_errors.0,
        eps_x_final: final_errors.1,
        eps_t_l2: t_squared.sqrt(),
        eps_x_l2: x_squared.sqrt(),
        delta_q_t_last: diagnostics.measures.delta_q_t_last.to_f64(),
        delta_k_max: diagnostics.measures.max_abs_delta_k.to_f64(),
    }
}

/// The fitted slope of one quantity for one operator.
#[derive(Debug, Clone)]
pub struct Slope {
    /// Operator.
    pub sbp: SbpName,
    /// Form of the action.
    pub form: Form,
    /// What was fitted.
    pub quantity: Quantity,
    /// The fit; none with fewer than two points above the rounding plateau.
    pub fit: Option<Fit>,
    /// Smallest and largest N of the fit; none without points.
    pub n_range: Option<(usize, usize)>,
    /// Number of points of the fit.
    pub points: usize,
    /// First N on the rounding plateau, if the sweep reaches it.
    pub plateau_from: Option<usize>,
}

impl Slope {
    /// The operator, with the form if that is not the paper's.
    pub fn scheme(&self) -> String {
        match self.form {
            Form::Strong => self.sbp.to_string(),
            Form::Weak => format!("{} weak", self.sbp),
        }
    }

    /// A sentence if the number should not be read as an order.
    pub fn warning(&self) -> Option<String> {
        let (name, quantity) = (self.scheme(), self.quantity.as_str());
        match &self.fit {
            None if self.plateau_from.is_some() => {
                Some(format!("{name} {quantity}: no slope, the errors are at the rounding level"))
            }
            None => Some(format!("{name} {quantity}: no slope, fewer than two grids were solved in the range")),
            Some(fit) if !fit.is_asymptotic() => {
                let (low, high) = fit.local_range();
                Some(format!(
                    "{name} {quantity}: not asymptotic, the slope between neighbouring grids runs from {low:.2} to {high:.2}"
                ))
            }
            Some(_) => None,
        }
    }
}

impl<S: Real> Convergence<S> {
    /// The slopes of every operator and quantity over the grids with `n_range.0` ≤ N ≤ `n_range.1` that lie above the
    /// rounding plateau.
    pub fn slopes(&self, n_range: (usize, usize)) -> Vec<Slope> {
        let mut schemes: Vec<(SbpName, Form)> = self.points.iter().map(|point| (point.sbp, point.form)).collect();
        schemes.dedup();
        let of_scheme = |scheme| Quantity::ALL.map(|quantity| self.slope(scheme, quantity, n_range));
        schemes.into_iter().flat_map(of_scheme).collect()
    }

    fn slope(&self, (sbp, form): (SbpName, Form), quantity: Quantity, n_range: (usize, usize)) -> Slope {
        let (mut delta_gamma, mut n_gamma, mut errors) = (Vec::new(), Vec::new(), Vec::new());
        for point in self.points.iter().filter(|point| (point.sbp, point.form) == (sbp, form)) {
            let in_range = (n_range.0..=n_range.1).contains(&point.n_gamma);
            let error = point.errors.as_ref().map(|errors| quantity.of(errors));
            if let Some(error) = error.filter(|error| in_range && error.is_finite()) {
                delta_gamma.push(point.delta_gamma);
                n_gamma.push(point.n_gamma);
                errors.push(error);
            }
        }
        let size = match quantity {
            Quantity::EpsTFinal | Quantity::EpsTL2 => self.reference.t_size,
            Quantity::EpsXFinal | Quantity::EpsXL2 => self.reference.x_size,
        };
        let kept = points_above_plateau(&delta_gamma, &errors, size, self.digits);
        Slope {
            sbp,
            form,
            quantity,
            fit: Fit::new(&delta_gamma[..kept], &n_gamma[..kept], &errors[..kept]),
            n_range: n_gamma[..kept].first().copied().zip(n_gamma[..kept].last().copied()),
            points: kept,
            plateau_from: n_gamma.get(kept).copied(),
        }
    }
}
