//! The grids of a sweep, solved in parallel and measured.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use rayon::prelude::*;

use super::{Convergence, ConvergencePoint, Errors, ReferenceInfo, SweepError};
use crate::Numeric;
use crate::case::{Case, End, Form, SbpName};
use crate::diagnostics::Diagnostics;
use crate::metric::Metric;
use crate::reference::ReferenceTrajectory;
use crate::solve::{NoSolution, Solution, Status, solve};

/// A sweep that is ready to run: every grid is possible, and there is a reference.
pub struct Sweep<S = f64> {
    /// The grids, by their numbers of nodes: operators in the requested order, then N ascending.
    pub(super) nodes: Vec<usize>,
    /// Solves the grid with that index and measures its errors.
    pub(super) measure: Box<dyn Fn(usize) -> ConvergencePoint + Send + Sync>,
    pub(super) info: ReferenceInfo<S>,
    pub(super) coordinates: Vec<String>,
    pub(super) charges: Vec<String>,
    pub(super) digits: u32,
}

/// Solves `case` for every operator with its form and every number of nodes, in parallel. The order of the results does
/// not depend on which grid is finished first.
///
/// `finished` is called for every grid when it is done. Once `cancel` is true, no further grids are started.
///
/// # Errors
/// See [`Sweep::new`].
pub fn sweep<S: Numeric>(
    case: &Case,
    schemes: &[(SbpName, Form)],
    n_gamma: &[usize],
    cancel: &AtomicBool,
    finished: &(dyn Fn(&ConvergencePoint) + Sync),
) -> Result<Convergence<S>, SweepError> {
    let sweep = Sweep::new(case, schemes, n_gamma)?;
    Ok(sweep.run(cancel, &|_, point| finished(point)))
}

impl<S: Numeric> Sweep<S> {
    /// A sweep of `case` over every operator with its form and every number of nodes.
    ///
    /// A case that ends at a physical time is swept at the γ_f at which the reference reaches it.
    ///
    /// # Errors
    /// [`SweepError`] if a grid cannot exist or there is no reference. A grid without a solution is a point with its
    /// status.
    pub fn new(case: &Case, schemes: &[(SbpName, Form)], n_gamma: &[usize]) -> Result<Self, SweepError> {
        let metric: Metric<S> = case.metric();
        let initial = case.initial_data();
        let digits = case.settings().within::<S>().digits;
        let length = match case.end() {
            End::Duration(duration) => ReferenceTrajectory::length_of(&metric, &initial, 0, duration, digits)?,
            End::Length(length) => length,
        };
        let on_grid = |scheme, n| case.on_grid(scheme, n, length).map_err(SweepError::Grid);
        let mut cases: Vec<Case> = grids(schemes, n_gamma, on_grid)?;
        // Different numbers of nodes can round to the same number of spectral elements.
        cases.dedup_by(|a, b| (a.scheme, &a.grid) == (b.scheme, &b.grid));
        let reference = ReferenceTrajectory::new(&metric, &initial, length, digits)?;
        let end = reference.at(length);
        let samples = samples(n_gamma);
        let x_size = (0..samples)
            .map(|k| reference.at(length * S::from(k as f64 / (samples - 1) as f64)).x.to_f64().abs())
            .fold(f64::MIN_POSITIVE, f64::max);
        let info = ReferenceInfo {
            error_estimate: reference.error_estimate(),
            steps: reference.steps(),
            gamma_final: case.grid.gamma_i.to::<S>() + length,
            end: vec![initial.t + end.elapsed, end.x],
            sizes: vec![end.elapsed.to_f64().abs(), x_size],
        };
        let coordinates = ["t", "x"].map(str::to_owned).to_vec();
        let nodes = cases.iter().map(|case| case.grid.n_gamma * case.grid.windows).collect();
        let measure = move |grid: usize| measure(&cases[grid], length, &reference);
        let charges = coordinates[..1].to_vec();
        Ok(Self { nodes, measure: Box::new(measure), info, coordinates, charges, digits })
    }

    /// Number of grids.
    pub fn grids(&self) -> usize {
        self.nodes.len()
    }

    /// Solves all grids. `finished` is called for each when it is done, with its index in the order. Once `cancel` is
    /// true, no further grids are started.
    pub fn run(&self, cancel: &AtomicBool, finished: &(dyn Fn(usize, &ConvergencePoint) + Sync)) -> Convergence<S> {
        // The largest grids are started first, so that no core is still busy with one when the others have finished.
        let mut jobs: Vec<usize> = (0..self.grids()).collect();
        jobs.sort_by_key(|&place| std::cmp::Reverse(self.nodes[place]));
        let points = jobs.into_par_iter().with_max_len(1).filter_map(|place| {
            if cancel.load(Ordering::Relaxed) {
                return None;
            }
            let point = (self.measure)(place);
            finished(place, &point);
            Some((place, point))
        });
        self.gathered(points.collect())
    }

    /// The sweep with these points, each given with its index in the order.
    pub fn gathered(&self, mut points: Vec<(usize, ConvergencePoint)>) -> Convergence<S> {
        points.sort_by_key(|(place, _)| *place);
        Convergence {
            interrupted: points.len() < self.nodes.len(),
            digits: self.digits,
            points: points.into_iter().map(|(_, point)| point).collect(),
            reference: self.info.clone(),
            coordinates: self.coordinates.clone(),
            charges: self.charges.clone(),
        }
    }
}

/// A grid for each operator with its form and each number of nodes, every scheme once and with ascending numbers.
pub(super) fn grids<G>(
    schemes: &[(SbpName, Form)],
    n_gamma: &[usize],
    on_grid: impl Fn((SbpName, Form), usize) -> Result<G, SweepError>,
) -> Result<Vec<G>, SweepError> {
    let mut n_gamma = n_gamma.to_vec();
    n_gamma.sort_unstable();
    n_gamma.dedup();
    let mut grids = Vec::new();
    for (place, &scheme) in schemes.iter().enumerate() {
        if !schemes[..place].contains(&scheme) {
            for &n in &n_gamma {
                grids.push(on_grid(scheme, n)?);
            }
        }
    }
    Ok(grids)
}

/// Number of points at which the sizes of coordinates are looked for.
pub(super) fn samples(n_gamma: &[usize]) -> usize {
    n_gamma.iter().max().copied().unwrap_or(2).clamp(2, 4096)
}

fn measure<S: Numeric>(case: &Case, length: S, reference: &ReferenceTrajectory<S>) -> ConvergencePoint {
    let intervals = case.grid.windows * (case.grid.n_gamma - 1);
    let errors = |solution: &Solution<S>| (solution.iterations.count, errors(solution, reference));
    point((case.scheme.sbp, case.scheme.form), intervals, length.to_f64(), || solve::<S, _>(case), errors)
}

/// A point of a sweep, on a grid of so many intervals. `solve` is on the clock, and what it returns has the iterations
/// and errors that `measure` finds.
pub(super) fn point<R>(
    (sbp, form): (SbpName, Form),
    intervals: usize,
    length: f64,
    solve: impl FnOnce() -> Result<R, NoSolution>,
    measure: impl FnOnce(&R) -> (usize, Errors),
) -> ConvergencePoint {
    let start = Instant::now();
    let result = solve();
    let seconds = start.elapsed().as_secs_f64();
    let (status, (iterations, errors)) = match &result {
        Ok(run) => {
            let (iterations, errors) = measure(run);
            (Status::Converged, (iterations, Some(errors)))
        }
        Err(failure) => (failure.status, (failure.iterations.history.len(), None)),
    };
    let delta_gamma = length / intervals as f64;
    ConvergencePoint { sbp, form, n_gamma: intervals + 1, delta_gamma, errors, iterations, seconds, status }
}

/// The errors of a solution at its nodes. The L2 norms use the quadrature of its operator.
pub fn errors<S: Numeric>(solution: &Solution<S>, reference: &ReferenceTrajectory<S>) -> Errors {
    let (mut t_squared, mut x_squared, mut final_errors) = (0.0, 0.0, (0.0, 0.0));
    let values = solution.from_origin(0, solution.elapsed()).zip(solution.x());
    let weights = solution.grids().flat_map(|grid| grid.sbp().weights());
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
        at_end: vec![final_errors.0, final_errors.1],
        l2: vec![t_squared.sqrt(), x_squared.sqrt()],
        charges_last: vec![diagnostics.measures.delta_q_t_last.to_f64()],
        delta_k_max: diagnostics.measures.max_abs_delta_k.to_f64(),
    }
}
