//! Sweeps of scenes.

use super::sweep::{grids, point, samples};
use super::{ConvergencePoint, Errors, ReferenceInfo, Sweep, SweepError};
use crate::Numeric;
use crate::case::scene::{SceneCase, on_grid};
use crate::case::{Form, SbpName};
use crate::diagnostics::scene::SceneDiagnostics;
use crate::geometry::Geometry;
use crate::norm::larger;
use crate::reference::ReferenceTrajectory;
use crate::solve::{Setup, WorldLine, solve};
use crate::study::scene_length::length_of;

impl<S: Numeric> Sweep<S> {
    /// A sweep of a scene over every operator with its form and every number of nodes.
    ///
    /// A scene that ends where a coordinate has a value, or where a formula changes its sign, is swept at the γ_f at
    /// which the reference gets there.
    ///
    /// # Errors
    /// As [`Sweep::new`].
    pub fn of_scene(case: &SceneCase, schemes: &[(SbpName, Form)], n_gamma: &[usize]) -> Result<Self, SweepError> {
        let setup: Setup<S> = case.setup();
        let length = length_of(&setup)?;
        let grid_of = |scheme, n| on_grid(&setup, scheme, n, length).map_err(SweepError::Grid);
        let mut setups: Vec<Setup<S>> = grids(schemes, n_gamma, grid_of)?;
        // Different numbers of nodes can round to the same number of spectral elements.
        let grid = |setup: &Setup<S>| {
            (setup.settings.sbp, setup.settings.form, setup.settings.n_gamma, setup.settings.windows)
        };
        setups.dedup_by(|a, b| grid(a) == grid(b));
        let (geometry, start) = (&*setup.place.geometry, &*setup.place.start);
        let reference = ReferenceTrajectory::new(geometry, start, length, setup.settings.digits)?;
        let samples = samples(n_gamma);
        let mut sizes = vec![f64::MIN_POSITIVE; geometry.dimension()];
        for k in 0..samples {
            let point = reference.at(length * S::from(k as f64 / (samples - 1) as f64));
            for (a, size) in sizes.iter_mut().enumerate() {
                let origin = if geometry.active().contains(&a) { S::ZERO } else { start.q[a] };
                *size = larger(*size, (point.q[a] - origin).to_f64().abs());
            }
        }
        let sizes = geometry.shared(&start.q, &sizes);
        let info = ReferenceInfo {
            error_estimate: reference.error_estimate(),
            steps: reference.steps(),
            gamma_final: setup.gamma_i + length,
            end: reference.at(length).q,
            sizes,
        };
        let coordinates = geometry.names().to_vec();
        let charges = geometry.ignorable().map(|a| coordinates[a].clone()).collect();
        let (nodes, digits) = (
            setups.iter().map(|setup| setup.settings.n_gamma * setup.settings.windows).collect(),
            setup.settings.digits,
        );
        let measure = move |grid: usize| measure(&setups[grid], length, &reference);
        Ok(Self { nodes, measure: Box::new(measure), info, coordinates, charges, digits })
    }
}

fn measure<S: Numeric>(
    setup: &Setup<S>,
    length: S,
    reference: &ReferenceTrajectory<S, Geometry<S>>,
) -> ConvergencePoint {
    let intervals = setup.settings.windows * (setup.settings.n_gamma - 1);
    let errors = |line: &WorldLine<S>| (line.iterations.count, errors(line, reference));
    point((setup.settings.sbp, setup.settings.form), intervals, length.to_f64(), || solve(setup), errors)
}

/// The errors of a world-line at its nodes. The L2 norms use the quadratures of its operators.
fn errors<S: Numeric>(line: &WorldLine<S>, reference: &ReferenceTrajectory<S, Geometry<S>>) -> Errors {
    let n = line.geometry().dimension();
    let rows: Vec<Vec<S>> = (0..n).map(|a| line.q(a).collect()).collect();
    let (mut at_end, mut squared) = (vec![0.0; n], vec![0.0; n]);
    for grid in line.grids() {
        for ((k, node), weight) in grid.nodes().enumerate().zip(grid.sbp().weights()) {
            let (exact, weight) = (reference.at(grid.gamma_at(k)), weight.to_f64());
            for a in 0..n {
                let error = (rows[a][node] - exact.q[a]).to_f64();
                at_end[a] = error.abs();
                squared[a] += weight * error * error;
            }
        }
    }
    let diagnostics = SceneDiagnostics::new(line, &[], &mut [], false);
    Errors {
        at_end,
        l2: squared.into_iter().map(f64::sqrt).collect(),
        charges_last: diagnostics.charges.iter().map(|charge| charge.max_last.to_f64()).collect(),
        delta_k_max: diagnostics.norm.max_interior.to_f64(),
    }
}
