//! How much memory a run takes, estimated before it starts.

use super::setup::{Setup, System};
use crate::action::Form;
use crate::geometry::Lagrangian;
use crate::metric::Metric;
use crate::sbp::SbpName;
use crate::scalar::Real;

/// Numbers kept for every node: the solution, its diagnostics, and what writing the tables needs.
const NUMBERS: f64 = 17.0;
/// Numbers kept for every sample.
const SAMPLE_NUMBERS: f64 = 6.0;
/// Numbers kept for every node of a scene, for each coordinate. Each row of its structure is one more.
const NUMBERS_OF_COORDINATE: f64 = 10.0;
/// Numbers kept for every window of a scene, for each coordinate: its end, its multipliers, and what is measured there.
const NUMBERS_OF_WINDOW: f64 = 30.0;
/// Bytes per node of the banded systems of the physical limit with two fields, always in `f64`: a fixed part, and one
/// for every order. They grow with the square of the number of fields.
const BANDED: [f64; 2] = [45.0, 18.0];
/// The same for the sparse factors of the doubled system with two coordinates, and with its square.
const DOUBLED: [f64; 2] = [200.0, 950.0];
/// Bytes of a list without its elements.
const LIST: f64 = 24.0;
/// The program itself.
const PROGRAM: f64 = 6e6;

/// About how many bytes solving `setup` and writing its tables takes, with `samples` samples, in the memory of one
/// window if `one_window` says so. The constants come from runs of a hundred thousand nodes, whose memory the estimate
/// meets within a third. With an accuracy asked for, the nodes are not known beforehand and do not count.
pub fn bytes_needed<S: Real>(setup: &Setup<S, Metric<S>>, one_window: bool, samples: usize) -> f64 {
    let number = size_of::<S>() as f64;
    let window = setup.settings.n_gamma as f64;
    let nodes = if one_window { window } else { window * setup.settings.windows as f64 };
    let solver = window * bytes_of_solver((setup.settings.system, setup.settings.form, setup.settings.sbp), 2.0, 2.0);
    PROGRAM + number * (NUMBERS * nodes + SAMPLE_NUMBERS * samples as f64) + solver
}

/// The same for a scene, whose run is kept as a whole.
pub fn scene_bytes_needed<S: Real>(setup: &Setup<S>, samples: usize) -> f64 {
    let (number, geometry) = (size_of::<S>() as f64, &setup.place.geometry);
    let (window, windows) = (setup.settings.n_gamma as f64, setup.settings.windows as f64);
    let coordinates = geometry.dimension() as f64;
    let fields = 2.0 * geometry.active().len() as f64;
    let structure = geometry.structure();
    let rows = NUMBERS_OF_COORDINATE * coordinates + (structure.rows + structure.force_rows) as f64;
    let solver =
        window * bytes_of_solver((setup.settings.system, setup.settings.form, setup.settings.sbp), coordinates, fields);
    let samples = samples as f64 * (number * (1.0 + 3.0 * coordinates) + 3.0 * LIST);
    PROGRAM + number * windows * (rows * window + NUMBERS_OF_WINDOW * coordinates) + solver + samples
}

/// Bytes per node of a window for the linear systems.
fn bytes_of_solver((system, form, sbp): (System, Form, SbpName), coordinates: f64, fields: f64) -> f64 {
    let order = sbp.coefficients().map_or(0, |table| table.interior_order) as f64;
    let factors = |[constant, by_order]: [f64; 2], size: f64| (size / 2.0).powi(2) * (constant + by_order * order);
    match (system, form) {
        (System::Doubled, _) => factors(DOUBLED, coordinates),
        // Two-step leapfrog is explicit.
        (System::PhysicalLimit, Form::Strong) if order == 2.0 => 0.0,
        (System::PhysicalLimit, _) => factors(BANDED, fields),
    }
}
