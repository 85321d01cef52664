//! The memory that a run takes, estimated before it starts.

use super::setup::{Setup, System};
use crate::action::Form;
use crate::geometry::Geometry;
use crate::number::Real;
use crate::sbp::SbpName;

/// Bytes per node of the banded systems of the physical limit with two fields, always in `f64`: a fixed part, and one
/// for every order. They grow with the square of the number of fields.
const BANDED: [f64; 2] = [45.0, 18.0];
/// The same for the factors of the doubled system with two coordinates, all of which grow with the order.
const DOUBLED: [f64; 2] = [0.0, 440.0];
/// Bytes of a list without its elements.
const LIST: f64 = 24.0;
/// The program itself.
const PROGRAM: f64 = 6e6;

/// The numbers that a run keeps.
struct Kept {
    /// Numbers for every node: the solution, its diagnostics, and what writing the tables needs.
    numbers_of_node: f64,
    /// Numbers for every window: its end, its multipliers, and what is measured there.
    numbers_of_window: f64,
    /// Numbers for every sample.
    numbers_of_sample: f64,
    /// Lists for every sample.
    lists_of_sample: f64,
    /// Number of coordinates.
    coordinates: f64,
    /// Number of fields of the physical limit.
    fields: f64,
}

impl Kept {
    /// Each row of the structure is one number of a node more.
    fn of<S: Real>(geometry: &Geometry<S>) -> Self {
        let (structure, coordinates) = (geometry.structure(), geometry.dimension() as f64);
        Self {
            numbers_of_node: 10.0 * coordinates + (structure.rows + structure.force_rows) as f64,
            numbers_of_window: 30.0 * coordinates,
            numbers_of_sample: 1.0 + 3.0 * coordinates,
            lists_of_sample: 3.0,
            coordinates,
            fields: 2.0 * geometry.active().len() as f64,
        }
    }
}

/// About how many bytes solving `setup` and writing its tables takes, with `samples` samples, in the memory of one
/// window if `one_window` says so. The constants come from runs of a hundred thousand nodes, whose memory the estimate
/// meets within a third. With an accuracy asked for, the nodes are not known beforehand and do not count.
pub fn bytes_needed<S: Real>(setup: &Setup<S>, one_window: bool, samples: usize) -> f64 {
    let (number, samples, kept) = (size_of::<S>() as f64, samples as f64, Kept::of(&setup.place.geometry));
    let nodes = setup.settings.n_gamma as f64;
    let windows = if one_window { 1.0 } else { setup.settings.windows as f64 };
    let numbers = windows * (kept.numbers_of_node * nodes + kept.numbers_of_window) + kept.numbers_of_sample * samples;
    let scheme = (setup.settings.system, setup.settings.form, setup.settings.sbp);
    PROGRAM + number * numbers + LIST * kept.lists_of_sample * samples + nodes * bytes_of_solver(scheme, kept)
}

/// Bytes per node of a window for the linear systems.
fn bytes_of_solver((system, form, sbp): (System, Form, SbpName), Kept { coordinates, fields, .. }: Kept) -> f64 {
    let order = sbp.coefficients().map_or(0, |table| table.interior_order) as f64;
    let factors = |[constant, by_order]: [f64; 2], size: f64| (size / 2.0).powi(2) * (constant + by_order * order);
    match (system, form) {
        (System::Doubled, _) => factors(DOUBLED, coordinates),
        // Two-step leapfrog is explicit.
        (System::PhysicalLimit, Form::Strong) if order == 2.0 => 0.0,
        (System::PhysicalLimit, _) => factors(BANDED, fields),
    }
}
