//! The memory that a run takes, estimated before it starts.

use super::setup::{Settings, Setup, System};
use crate::action::Form;
use crate::number::Real;

/// Bytes per node of the banded systems of the physical limit with two fields, always in `f64`: a fixed part, and one
/// for every order. They grow with the square of the number of fields.
const BANDED: [f64; 2] = [45.0, 18.0];
/// The same for the factors of the doubled system with two coordinates, all of which grow with the order.
const DOUBLED: [f64; 2] = [0.0, 440.0];
/// Bytes of a list without its elements.
const LIST: f64 = 24.0;
/// The program itself.
const PROGRAM: f64 = 6e6;

/// About how many bytes solving `setup` and writing its tables takes, with `samples` samples, in the memory of one
/// window if `one_window` says so. The constants come from runs of a hundred thousand nodes, whose memory the estimate
/// meets within a third. With an accuracy asked for, the nodes are not known beforehand and do not count.
pub fn bytes_needed<S: Real>(setup: &Setup<S>, one_window: bool, samples: usize) -> f64 {
    let (geometry, settings) = (&setup.place.geometry, &setup.settings);
    let (number, samples, nodes) = (size_of::<S>() as f64, samples as f64, settings.n_gamma as f64);
    let (structure, n) = (geometry.structure(), geometry.dimension() as f64);
    // A node keeps its solution, its diagnostics, and what writing the tables needs. Each row of the structure is one
    // number more.
    let of_node = 10.0 * n + (structure.rows + structure.force_rows) as f64;
    // A window keeps its end, its multipliers, and what is measured there; a sample keeps three lists of values.
    let (of_window, of_sample) = (30.0 * n, 1.0 + 3.0 * n);
    let windows = if one_window { 1.0 } else { settings.windows as f64 };
    let numbers = windows * (of_node * nodes + of_window) + of_sample * samples;
    let fields = 2.0 * geometry.active().len() as f64;
    PROGRAM + number * numbers + LIST * 3.0 * samples + nodes * bytes_of_solver(settings, n, fields)
}

/// Bytes per node of a window for the linear systems of so many coordinates, or fields of the physical limit.
fn bytes_of_solver(settings: &Settings, coordinates: f64, fields: f64) -> f64 {
    let order = settings.sbp.coefficients().map_or(0, |table| table.interior_order) as f64;
    let factors = |[constant, by_order]: [f64; 2], size: f64| (size / 2.0).powi(2) * (constant + by_order * order);
    match (settings.system, settings.form) {
        (System::Doubled, _) => factors(DOUBLED, coordinates),
        // Two-step leapfrog is explicit.
        (System::PhysicalLimit, Form::Strong) if order == 2.0 => 0.0,
        (System::PhysicalLimit, _) => factors(BANDED, fields),
    }
}
