//! The grids of a sweep, solved in parallel and measured.

use std::collections::BTreeSet;

use rayon::prelude::*;

use super::{Convergence, ConvergencePoint, Errors, ReferenceInfo, SweepError};
use crate::case::{Form, SbpName, on_grid};
use crate::diagnostics::Diagnostics;
use crate::number::Real;
use crate::reference::ReferenceTrajectory;
use crate::solve::{Settings, Setup, Status, WorldLine, solve};
use crate::study::subject::{length_of, rows, sizes, timed};

/// A sweep that is ready to run: every grid is possible, and there is a reference.
pub struct Sweep<S: Real = f64> {
    /// The grids: operators in the requested order, then N ascending.
    setups: Vec<Setup<S>>,
    length: S,
    reference: ReferenceTrajectory<S>,
    /// What is known before a grid is solved.
    empty: Convergence<S>,
}

impl<S: Real> Sweep<S> {
    /// A sweep of what a case sets up over every operator with its form and every number of nodes.
    ///
    /// A run that ends at a physical time, where a coordinate has a value, or where a formula changes its sign, is
    /// swept at the γ_f at which the reference gets there.
    ///
    /// # Errors
    /// [`SweepError`] if a grid cannot exist or there is no reference. A grid without a solution is a point with its
    /// status.
    pub fn new(setup: impl Into<Setup<S>>, schemes: &[(SbpName, Form)], n_gamma: &[usize]) -> Result<Self, SweepError> {
        let setup = setup.into();
        let length = length_of(&setup)?;
        let setups = grids(&setup, schemes, n_gamma, length)?;
        let (place, digits) = (&setup.place, setup.settings.digits);
        let reference = ReferenceTrajectory::new(&place.geometry, &place.start, length, digits)?;
        let coordinates = place.geometry.names().to_vec();
        let samples = n_gamma.iter().max().copied().unwrap_or(2).clamp(2, 4096);
        let point = |k: usize| reference.at(length * S::from(k as f64 / (samples - 1) as f64)).q;
        let sizes = sizes(place, (0..samples).map(point));
        let end = reference.at(length).q;
        let info = ReferenceInfo {
            error_estimate: reference.error_estimate(),
            steps: reference.steps(),
            gamma_final: setup.gamma_i + length,
            end: end.into_iter().enumerate().map(|(a, q)| setup.origin_of(a) + q).collect(),
            sizes,
        };
        let charges = place.geometry.ignorable().map(|a| coordinates[a].clone()).collect();
        let empty =
            Convergence { points: Vec::new(), reference: info, coordinates, charges, digits, interrupted: true };
        Ok(Self { setups, length, reference, empty })
    }

    /// Solves all grids in parallel. `finished` is called for each when it is done, with its index in the order.
    pub fn run(&self, finished: &(dyn Fn(usize, &ConvergencePoint) + Sync)) -> Convergence<S> {
        // The largest grids are started first, so that no core is still busy with one when the others have finished.
        let mut jobs: Vec<usize> = (0..self.setups.len()).collect();
        jobs.sort_by_key(|&place| {
            let Settings { n_gamma, windows, .. } = self.setups[place].settings;
            std::cmp::Reverse(n_gamma * windows)
        });
        let points = jobs.into_par_iter().with_max_len(1).map(|place| {
            let point = measure(&self.setups[place], self.length, &self.reference);
            finished(place, &point);
            (place, point)
        });
        self.gathered(points.collect())
    }

    /// The sweep with these points, each given with its index in the order.
    pub fn gathered(&self, mut points: Vec<(usize, ConvergencePoint)>) -> Convergence<S> {
        points.sort_by_key(|(place, _)| *place);
        let (interrupted, found) = (points.len() < self.setups.len(), points.into_iter().map(|(_, point)| point));
        Convergence { interrupted, points: found.collect(), ..self.empty.clone() }
    }
}

/// A grid for each operator with its form and each number of nodes, every scheme once and with ascending numbers.
fn grids<S: Real>(
    setup: &Setup<S>,
    schemes: &[(SbpName, Form)],
    n_gamma: &[usize],
    length: S,
) -> Result<Vec<Setup<S>>, SweepError> {
    let n_gamma: BTreeSet<usize> = n_gamma.iter().copied().collect();
    let mut grids = Vec::new();
    for (_, &scheme) in schemes.iter().enumerate().filter(|(place, scheme)| !schemes[..*place].contains(scheme)) {
        for &n in &n_gamma {
            grids.push(on_grid(setup, scheme, n, length).map_err(SweepError::Grid)?);
        }
    }
    // Different numbers of nodes can round to the same number of spectral elements.
    grids.dedup_by(|a, b| a.settings == b.settings);
    Ok(grids)
}

fn measure<S: Real>(setup: &Setup<S>, length: S, reference: &ReferenceTrajectory<S>) -> ConvergencePoint {
    let Settings { sbp, form, n_gamma, windows, .. } = setup.settings;
    let intervals = windows * (n_gamma - 1);
    let (result, seconds) = timed(|| solve(setup));
    let (status, iterations, errors) = match &result {
        Ok(line) => (Status::Converged, line.iterations.count, Some(errors(line, reference))),
        Err(failure) => (failure.status, failure.iterations.history.len(), None),
    };
    let delta_gamma = length.to_f64() / intervals as f64;
    ConvergencePoint { sbp, form, n_gamma: intervals + 1, delta_gamma, errors, iterations, seconds, status }
}

/// The errors of a world-line at its nodes. The L2 norms use the quadratures of its operators.
fn errors<S: Real>(line: &WorldLine<S>, reference: &ReferenceTrajectory<S>) -> Errors {
    let rows = rows(line);
    let (mut at_end, mut squared) = (vec![0.0; rows.len()], vec![0.0; rows.len()]);
    for grid in &line.windows {
        for ((k, node), weight) in grid.nodes().enumerate().zip(grid.sbp().weights()) {
            let (exact, weight) = (reference.at(grid.gamma_at(k)), weight.to_f64());
            for (a, row) in rows.iter().enumerate() {
                let error = (row[node] - exact.q[a]).to_f64();
                at_end[a] = error.abs();
                squared[a] += weight * error * error;
            }
        }
    }
    let Diagnostics { charges, norm, .. } = Diagnostics::new(line);
    // In one coordinate it is that of the run's last node, as the paper has it.
    let is_of_x = line.geometry().c_squared.is_some();
    let last = charges.iter().map(|charge| (if is_of_x { charge.last } else { charge.max_last }).to_f64());
    Errors {
        at_end,
        l2: squared.into_iter().map(f64::sqrt).collect(),
        charges_last: last.collect(),
        delta_k_max: norm.max_interior.to_f64(),
    }
}
