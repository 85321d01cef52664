//! How much memory a run takes, estimated before it starts.

use super::setup::{Setup, System};
use super::space::Space;
use crate::action::Form;
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

/// What a run keeps.
#[derive(Debug, Clone, Copy)]
pub struct Kept {
    /// Numbers for every node: the solution, its diagnostics, and what writing the tables needs.
    pub numbers_of_node: f64,
    /// Numbers for every window: its end, its multipliers, and what is measured there.
    pub numbers_of_window: f64,
    /// Numbers for every sample.
    pub numbers_of_sample: f64,
    /// Lists for every sample.
    pub lists_of_sample: f64,
    /// Number of coordinates.
    pub coordinates: f64,
    /// Number of fields of the physical limit.
    pub fields: f64,
}

/// About how many bytes solving `setup` and writing its tables takes, with `samples` samples, in the memory of one
/// window if `one_window` says so. The constants come from runs of a hundred thousand nodes, whose memory the estimate
/// meets within a third. With an accuracy asked for, the nodes are not known beforehand and do not count.
pub fn bytes_needed<S: Real, G: Space<S>>(setup: &Setup<S, G>, one_window: bool, samples: usize) -> f64 {
    let (number, samples, kept) = (size_of::<S>() as f64, samples as f64, setup.place.geometry.kept());
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
